//! The controller alone, on real colliders.

mod air;
mod bounds;
mod contacts;
mod ground;
mod platforms;
mod stairs;
mod walls;
