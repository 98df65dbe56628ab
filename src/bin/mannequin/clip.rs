//! One animation of the mannequin, as keys ready for the file.
//!
//! Local space of each joint, seconds, metres; written with LINEAR interpolation.

use glam::{Quat, Vec3};

use crate::morphs::MORPHS;

/// A clip: one row of key times, shared by all of its tracks.
pub struct Clip {
    /// Name of the animation in the file.
    pub name: &'static str,
    /// Whether the last key meets the first.
    pub looping: bool,
    /// Ground speed in metres per second at which the feet do not slip; 0 for clips that stay in place.
    pub speed: f32,
    /// Seconds of the keys, strictly rising from 0.
    pub times: Vec<f32>,
    /// Joint index and its local rotation at every key.
    pub rotations: Vec<(usize, Vec<Quat>)>,
    /// Joint index and its local translation at every key, metres.
    pub translations: Vec<(usize, Vec<Vec3>)>,
    /// Morph weights 0..1 at every key.
    pub weights: Option<Vec<[f32; MORPHS]>>,
}
