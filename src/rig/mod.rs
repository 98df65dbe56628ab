//! Layer 2: bytes in, plain data out. glTF import, humanoid roles, character files.

pub mod tuning;

use bevy::prelude::*;

use crate::anim::{
    skeleton::{JointIndex, Skeleton},
    skin::Skin,
};

/// What one glTF file says about motion: skeleton, skins and which mesh rides on what.
///
/// Meshes, materials and textures come from bevy's own loader of the same file (`Gltf`, by mesh index).
#[derive(Asset, TypePath, Clone, Debug)]
pub struct Rig {
    /// All joints of all skins and all nodes above them, and every animated node; parents first.
    pub skeleton: Skeleton,
    /// The file's skins, by glTF index.
    pub skins: Vec<Skin>,
    /// One per node that carries a mesh.
    pub meshes: Vec<MeshBinding>,
}

/// A node that carries a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshBinding {
    /// glTF mesh index.
    pub mesh: usize,
    /// glTF skin index; `None`: the mesh rides rigidly on `joint`.
    pub skin: Option<usize>,
    /// The node as a joint of the skeleton.
    pub joint: JointIndex,
}
