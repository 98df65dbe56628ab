//! Layer 0: springs and rotations on plain vectors.

pub mod rotation;
pub mod spring;
