//! The controller alone, on real colliders.

mod air;
mod bounds;
mod ground;
mod platforms;
mod stairs;
mod walls;
