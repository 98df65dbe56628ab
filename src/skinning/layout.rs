//! What `shaders/skinning.wgsl` reads, byte by byte.

use bytemuck::{Pod, Zeroable};

pub use crate::anim::matrix::JointMatrix;

/// What a mesh instance is drawn with: `Instance` of `shaders/skinning.wgsl`, 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct InstanceRecord {
    /// Where its matrices begin.
    pub first: u32,
    /// How many it has, at least 1.
    pub count: u32,
    pub(super) padding: [u32; 2],
    /// Linear RGBA that multiplies the base colour.
    pub tint: [f32; 4],
}

impl InstanceRecord {
    /// The identity matrix and no tint: what a mesh without a palette is drawn with.
    pub const PLAIN: Self = Self { first: 0, count: 1, padding: [0; 2], tint: [1.0; 4] };
}
