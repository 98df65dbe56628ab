//! Linear blend skinning on the CPU: the readable reference that the GPU is held against.

use bevy::math::Affine3A;

use super::skeleton::JointIndex;

/// Which joints move a mesh, and where they were when it was skinned.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Palette slot → joint of the skeleton.
    pub joints: Vec<JointIndex>,
    /// Palette slot → `joint_from_mesh` of the bind pose.
    pub inverse_bind: Vec<Affine3A>,
}
