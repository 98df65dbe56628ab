//! Morph targets: which there are, and how far each moves a point of the rest pose.
//!
//! Model space of the file, metres.

/// How many morph targets the mesh has.
pub const MORPHS: usize = 2;

/// Names in the order of the targets, as written to the mesh's `targetNames`.
pub const NAMES: [&str; MORPHS] = ["blink", "breath"];
