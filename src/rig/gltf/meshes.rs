//! Vertices, as far as motion needs them: who moves them, how far they reach from their joints.
//!
//! Positions in mesh space; what comes out is in joint space.

use bevy::math::{Vec3, Vec3A, bounding::Aabb3d};
use gltf::json::{
    accessor::Type,
    mesh::{Primitive, Semantic},
    validation::Checked,
};
use serde::Deserialize;

use super::{accessor::Source, error::RigError, influences, nodes::Nodes};
use crate::{
    anim::skin::Skin,
    rig::{Influences, MeshBinding},
};

/// What the vertices say about joints, by joint.
pub(super) struct Vertices {
    /// Box around all vertices that the joint has a hand in.
    pub(super) bounds: Vec<Option<Aabb3d>>,
    /// Vertices that the joint moves most.
    pub(super) dominated: Vec<Vec<Vec3>>,
}

/// Reads the vertices of every node with a mesh.
///
/// A skin gets one more slot for a node whose mesh has vertices without weights: they ride on the node.
pub(super) fn read(
    source: &Source,
    nodes: &Nodes,
    skins: &mut [Skin],
    notes: &mut Vec<String>,
) -> Result<(Vec<MeshBinding>, Vertices), RigError> {
    let count = nodes.skeleton.len();
    let mut vertices = Vertices { bounds: vec![None; count], dominated: vec![Vec::new(); count] };
    let mut bindings = Vec::new();
    for (node_index, node) in source.json.nodes.iter().enumerate() {
        let Some(mesh) = node.mesh.map(|mesh| mesh.value()) else { continue };
        let (Some(joint), Some(it)) = (nodes.joints[node_index], source.json.meshes.get(mesh)) else { continue };
        let skin = node.skin.map(|skin| skin.value()).filter(|&skin| skin < skins.len());
        let mut binding = MeshBinding {
            mesh,
            skin,
            joint,
            morph_weights: morph_weights(it, node.weights.as_ref()),
            morph_names: morph_names(it),
            influences: Vec::new(),
        };
        for (index, primitive) in it.primitives.iter().enumerate() {
            let place = Place { source, mesh, index, primitive };
            let positions = place.positions()?;
            let reach = place.morph_reach(positions.len())?;
            match skin {
                None => {
                    for (vertex, &position) in positions.iter().enumerate() {
                        vertices.grow(joint.index(), position, reach.get(vertex));
                        vertices.dominated[joint.index()].push(position);
                    }
                }
                Some(skin) => {
                    let influences = influences::read(&place, positions.len(), &mut skins[skin], joint, notes)?;
                    vertices.add(&skins[skin], &positions, &reach, &influences);
                    binding.influences.push(influences);
                }
            }
        }
        bindings.push(binding);
    }
    Ok((bindings, vertices))
}

fn target_count(mesh: &gltf::json::Mesh) -> usize {
    mesh.primitives.first().and_then(|primitive| primitive.targets.as_ref()).map_or(0, Vec::len)
}

fn morph_weights(mesh: &gltf::json::Mesh, own: Option<&Vec<f32>>) -> Vec<f32> {
    let mut weights = own.or(mesh.weights.as_ref()).cloned().unwrap_or_default();
    weights.resize(target_count(mesh), 0.0);
    weights.iter_mut().filter(|weight| !weight.is_finite()).for_each(|weight| *weight = 0.0);
    weights
}

/// What tools put beside a mesh.
#[derive(Default, Deserialize)]
struct Extras {
    #[serde(default, rename = "targetNames")]
    target_names: Vec<String>,
}

fn morph_names(mesh: &gltf::json::Mesh) -> Vec<String> {
    let extras = mesh.extras.as_ref().and_then(|extras| serde_json::from_str::<Extras>(extras.get()).ok());
    let mut names = extras.unwrap_or_default().target_names;
    names.truncate(target_count(mesh));
    names.extend((names.len()..target_count(mesh)).map(|target| target.to_string()));
    names
}

impl Vertices {
    fn add(&mut self, skin: &Skin, positions: &[Vec3], reach: &[(Vec3, Vec3)], influences: &Influences) {
        let of_vertices = influences.joints.iter().zip(&influences.weights);
        for (vertex, ((slots, weights), &position)) in of_vertices.zip(positions).enumerate() {
            let mut most = (0.0, None);
            for (&slot, &weight) in slots.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
                let joint_from_mesh = skin.inverse_bind[usize::from(slot)];
                let joint = skin.joints[usize::from(slot)].index();
                let at_joint = joint_from_mesh.transform_point3(position);
                if let Some(&(down, up)) = reach.get(vertex) {
                    for corner in 0..8 {
                        let pick = |axis: usize| if corner >> axis & 1 == 0 { down[axis] } else { up[axis] };
                        let moved = position + Vec3::new(pick(0), pick(1), pick(2));
                        self.grow(joint, joint_from_mesh.transform_point3(moved), None);
                    }
                }
                self.grow(joint, at_joint, None);
                if weight > most.0 {
                    most = (weight, Some((joint, at_joint)));
                }
            }
            if let Some((joint, at_joint)) = most.1 {
                self.dominated[joint].push(at_joint);
            }
        }
    }

    fn grow(&mut self, joint: usize, at: Vec3, reach: Option<&(Vec3, Vec3)>) {
        let (down, up) = reach.copied().unwrap_or_default();
        let (low, high) = (Vec3A::from(at + down), Vec3A::from(at + up));
        let bounds = self.bounds[joint].get_or_insert(Aabb3d { min: low, max: high });
        *bounds = Aabb3d { min: bounds.min.min(low), max: bounds.max.max(high) };
    }
}

/// One primitive, for reading and for saying where something is wrong.
pub(super) struct Place<'a> {
    source: &'a Source<'a>,
    mesh: usize,
    index: usize,
    primitive: &'a Primitive,
}

impl Place<'_> {
    pub(super) fn mesh_name(&self) -> String {
        let name = self.source.json.meshes.get(self.mesh).and_then(|mesh| mesh.name.clone());
        name.unwrap_or_else(|| format!("mesh{}", self.mesh))
    }

    pub(super) fn fail(&self, problem: String) -> RigError {
        RigError::Primitive { mesh: self.mesh_name(), primitive: self.index, problem }
    }

    pub(super) fn fail_at(&self, vertex: usize, problem: String) -> RigError {
        RigError::Vertex { mesh: self.mesh_name(), primitive: self.index, vertex, problem }
    }

    pub(super) fn accessor(&self, semantic: Semantic) -> Option<usize> {
        self.primitive.attributes.get(&Checked::Valid(semantic)).map(gltf::json::Index::value)
    }

    pub(super) fn floats<const WIDTH: usize>(
        &self,
        accessor: usize,
        shape: Type,
        what: &str,
    ) -> Result<Vec<[f32; WIDTH]>, RigError> {
        self.source.floats(accessor, shape, &|| self.used_by(what))
    }

    pub(super) fn whole(&self, accessor: usize, shape: Type, what: &str) -> Result<Vec<u32>, RigError> {
        self.source.whole(accessor, shape, &|| self.used_by(what))
    }

    fn used_by(&self, what: &str) -> String {
        format!("{what} of mesh `{}`, primitive {}", self.mesh_name(), self.index)
    }

    fn positions(&self) -> Result<Vec<Vec3>, RigError> {
        let Some(accessor) = self.accessor(Semantic::Positions) else { return Ok(Vec::new()) };
        let positions = self.floats::<3>(accessor, Type::Vec3, "positions")?;
        let positions: Vec<Vec3> = positions.into_iter().map(Vec3::from_array).collect();
        match positions.iter().position(|position| !position.is_finite()) {
            Some(vertex) => Err(self.fail_at(vertex, "its position is not finite".to_owned())),
            None => Ok(positions),
        }
    }

    /// How far morph targets at weights 0..=1 carry each vertex down and up along each axis; empty without targets.
    fn morph_reach(&self, count: usize) -> Result<Vec<(Vec3, Vec3)>, RigError> {
        let mut reach = Vec::new();
        for target in self.primitive.targets.iter().flatten() {
            let Some(accessor) = target.positions else { continue };
            let moves = self.floats::<3>(accessor.value(), Type::Vec3, "morph target")?;
            if moves.len() != count {
                return Err(self.fail(format!("a morph target moves {} vertices of {count}", moves.len())));
            }
            reach.resize(count, (Vec3::ZERO, Vec3::ZERO));
            for (vertex, (range, by)) in reach.iter_mut().zip(moves).enumerate() {
                let by = Vec3::from_array(by);
                if !by.is_finite() {
                    return Err(self.fail_at(vertex, "a morph target's move is not finite".to_owned()));
                }
                *range = (range.0 + by.min(Vec3::ZERO), range.1 + by.max(Vec3::ZERO));
            }
        }
        Ok(reach)
    }
}
