//! Layer 3: what tells good motion from bad, in numbers: drift, skate, penetration, float, knees, pops, pelvis, reach, starts.
//!
//! [`record`] reads the final pose and the true colliders once a frame; [`summary`] turns the [`frame`]s into figures;
//! [`bars`] says how far each may go.

pub mod bars;
pub mod frame;
mod pelvis;
pub mod record;
pub mod seen;
mod start;
pub mod summary;
pub mod table;

pub use crate::anim::peak::Peak;
