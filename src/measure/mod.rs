//! Layer 3: what tells good motion from bad, in numbers: drift, skate, penetration, float, knees, pops, pelvis, reach.
//!
//! [`record`] reads the final pose and the true colliders once a frame; [`summary`] turns the frames into figures.

pub mod record;
pub mod summary;
pub mod table;
