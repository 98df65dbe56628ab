//! Layer 2: bytes in, plain data out. glTF import, humanoid roles, character files.
//!
//! How a model of your own comes to walk: [Bring your own character](guide).

pub mod actions;
pub mod binding;
mod blink;
pub mod character;
pub mod character_file;
pub mod expressions;
pub mod frame;
pub mod gltf;
pub mod guide;
pub mod humanoid;
pub mod joint_ref;
mod legs;
pub mod loader;
mod names;
pub mod own_clips;
mod retarget;
pub mod small_joints;
mod species;
mod standard_clips;
mod straight;
mod trunk;
pub mod tuning;

use std::sync::Arc;

use bevy::{math::bounding::Aabb3d, prelude::*};

use crate::anim::{
    clip::Clip,
    skeleton::{JointIndex, Skeleton},
    skin::Skin,
};

/// What one glTF file says about motion: skeleton, skins, clips and which mesh rides on what.
///
/// Meshes, materials and textures come from bevy's own loader of the same file (`Gltf`, by mesh index).
#[derive(Asset, TypePath, Clone, Debug, Default)]
pub struct Rig {
    /// All joints of all skins, every animated node, every node with a mesh and all nodes above them; parents first.
    pub skeleton: Skeleton,
    /// By glTF node index: the joint that the node became, if it is one.
    pub node_joints: Vec<Option<JointIndex>>,
    /// The file's skins, by glTF index.
    pub skins: Vec<Skin>,
    /// One per node that carries a mesh.
    pub meshes: Vec<MeshBinding>,
    /// The file's clips, by glTF animation index.
    pub clips: Vec<Arc<Clip>>,
    /// By joint: the box, in joint space, around all vertices the joint has a hand in, morph targets included.
    ///
    /// Each box moved by its joint's pose, all united, holds the posed mesh.
    pub joint_bounds: Vec<Option<Aabb3d>>,
    /// Expressions of the face, where the file brings a list of them as VRM models do.
    pub expressions: Vec<expressions::Expression>,
    /// What was mended on import, one sentence each.
    pub notes: Vec<String>,
    /// By joint: the vertices it moves most, in joint space.
    pub(crate) dominated: Vec<Vec<Vec3>>,
    /// Parts of the body as the model's VRM extension names them.
    pub(crate) told_roles: Vec<(humanoid::HumanoidRole, JointIndex)>,
}

impl Rig {
    /// The clip named `name`.
    #[must_use]
    pub fn clip(&self, name: &str) -> Option<&Arc<Clip>> {
        self.clips.iter().find(|clip| clip.name == name)
    }

    /// Joints of the skins, by skin and slot.
    #[must_use]
    pub fn skin_joints(&self) -> Vec<JointIndex> {
        self.skins.iter().flat_map(|skin| &skin.joints).copied().collect()
    }
}

/// A node that carries a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshBinding {
    /// glTF mesh index.
    pub mesh: usize,
    /// glTF skin index; `None`: the mesh rides rigidly on `joint`.
    pub skin: Option<usize>,
    /// The node as a joint of the skeleton.
    pub joint: JointIndex,
    /// Morph weights at rest, one a target.
    pub morph_weights: Vec<f32>,
    /// Names of the morph targets; one without a name goes by its index.
    pub morph_names: Vec<String>,
    /// Of a skinned mesh, by primitive: who moves each vertex.
    ///
    /// Mended where the file needs it: the four largest weights, summing to one; vertices without weights ride on the
    /// node, for which the skin then has a slot of its own.
    pub influences: Vec<Influences>,
}

/// Joints and weights of a primitive's vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Influences {
    /// Slots of the skin, by vertex; unused ones are 0 with weight 0.
    pub joints: Vec<[u16; 4]>,
    /// Weights, largest first, summing to one.
    pub weights: Vec<[f32; 4]>,
}
