//! Layer 1: pure animation data and functions. No ECS, no handles, no time.

pub mod blend;
pub mod ik;
pub mod pose;
pub mod skeleton;
pub mod skin;
