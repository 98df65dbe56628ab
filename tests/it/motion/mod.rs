//! The controller alone, on real colliders.

mod air;
mod bounds;
mod contacts;
mod glide;
mod ground;
mod platforms;
mod stairs;
mod walls;
