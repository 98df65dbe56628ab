//! Layer 0: springs, fades and rotations on plain vectors.

pub mod fade;
pub mod rotation;
pub mod spring;
