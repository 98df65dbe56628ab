//! Layer 1: pure animation data and functions. No ECS, no handles, no time.

pub mod bake;
pub mod blend;
pub mod block;
pub mod clip;
pub mod curve;
pub mod gait;
pub mod ik;
pub mod inertialize;
pub mod keys;
pub mod leg;
mod level;
pub mod mask;
pub mod matrix;
pub mod peak;
pub mod pose;
pub mod retarget;
pub mod skeleton;
pub mod skin;
