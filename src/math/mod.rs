//! Layer 0: springs, fades, rotations on plain vectors, and dice.

pub mod dice;
pub mod fade;
pub mod rotation;
pub mod spring;
