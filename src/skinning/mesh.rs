//! Meshes for the skinning shader: four slots and four weights per vertex in 16 bytes.
//!
//! Reads the engine's glTF meshes (the file's space); positions stay as they are.

use bevy::{
    mesh::{Mesh, MeshVertexAttribute, VertexAttributeValues, VertexFormat},
    prelude::*,
};

use super::bounds::SlotBox;
use crate::anim::skin::{Influences, quantized_weights};

/// Palette slots of a vertex. Not the engine's joint attribute, which would select the engine's own skinning.
pub const ATTRIBUTE_SKIN_SLOTS: MeshVertexAttribute =
    MeshVertexAttribute::new("Surefoot_SkinSlots", 0x5f1e_f007_51c7_0001, VertexFormat::Uint16x4);

/// Weights of a vertex, in shares of 65,535 that sum to 65,535.
pub const ATTRIBUTE_SKIN_WEIGHTS: MeshVertexAttribute =
    MeshVertexAttribute::new("Surefoot_SkinWeights", 0x5f1e_f007_51c7_0002, VertexFormat::Unorm16x4);

/// Why a mesh cannot be skinned.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
pub enum SkinMeshError {
    /// Its data went to the GPU and are no longer here.
    #[error("the mesh has left main memory; load it with `RenderAssetUsages::MAIN_WORLD`")]
    Unreadable,
    /// It has no such attribute.
    #[error("the mesh has no `{0}`; a skinned mesh needs positions, joint indices and joint weights")]
    Missing(&'static str),
    /// An attribute has another format.
    #[error("`{attribute}` is {found}; it must be {wanted}")]
    Format {
        /// Its name.
        attribute: &'static str,
        /// What it is.
        found: String,
        /// What it should be.
        wanted: &'static str,
    },
    /// Attributes of different length.
    #[error("`{attribute}` has {found} values for {vertices} vertices")]
    Length {
        /// The attribute's name.
        attribute: &'static str,
        /// Its values.
        found: usize,
        /// Positions of the mesh.
        vertices: usize,
    },
    /// A vertex names a joint that its skin does not have.
    #[error("vertex {vertex} is moved by joint {slot} of its skin, which has only {slot_count} (0 to {})", slot_count.saturating_sub(1))]
    Slot {
        /// Index of the vertex.
        vertex: usize,
        /// What it names.
        slot: u16,
        /// How many there are.
        slot_count: usize,
    },
}

/// `mesh` with attributes for the skinning shader in place of the engine's joint attributes.
///
/// Weights are scaled to sum to one and quantised. A vertex without weights rides on `unweighted`.
/// `slot_count` is the number of joints in the mesh's skin.
///
/// # Errors
/// When an attribute is missing or odd, or a weighted slot is beyond `slot_count`.
pub fn skin_mesh(mesh: &Mesh, slot_count: usize, unweighted: u16) -> Result<Mesh, SkinMeshError> {
    let slots = match values(mesh, Mesh::ATTRIBUTE_JOINT_INDEX)? {
        VertexAttributeValues::Uint16x4(slots) => slots,
        other => return Err(wrong(Mesh::ATTRIBUTE_JOINT_INDEX, other, "Uint16x4")),
    };
    let weights = match values(mesh, Mesh::ATTRIBUTE_JOINT_WEIGHT)? {
        VertexAttributeValues::Float32x4(weights) => weights,
        other => return Err(wrong(Mesh::ATTRIBUTE_JOINT_WEIGHT, other, "Float32x4")),
    };
    skin_mesh_by(mesh, slots, weights, slot_count, unweighted)
}

/// As [`skin_mesh`], with `slots` and `weights` by vertex in place of the mesh's own.
///
/// # Errors
/// As [`skin_mesh`]; also when there are not as many as vertices.
pub fn skin_mesh_by(
    mesh: &Mesh,
    slots: &[[u16; 4]],
    weights: &[[f32; 4]],
    slot_count: usize,
    unweighted: u16,
) -> Result<Mesh, SkinMeshError> {
    let vertices = positions(mesh)?.len();
    for (attribute, found) in
        [(Mesh::ATTRIBUTE_JOINT_INDEX, slots.len()), (Mesh::ATTRIBUTE_JOINT_WEIGHT, weights.len())]
    {
        if found != vertices {
            return Err(SkinMeshError::Length { attribute: attribute.name, found, vertices });
        }
    }
    let mut own_slots = Vec::with_capacity(vertices);
    let mut own_weights = Vec::with_capacity(vertices);
    for (vertex, (slots, weights)) in slots.iter().zip(weights).enumerate() {
        let influences = influences(*slots, *weights, unweighted);
        if let Some(slot) = influences.slots.into_iter().find(|slot| usize::from(*slot) >= slot_count) {
            return Err(SkinMeshError::Slot { vertex, slot, slot_count });
        }
        own_slots.push(influences.slots);
        own_weights.push(influences.weights);
    }
    let mut skinned = rigid_mesh(mesh);
    skinned.insert_attribute(ATTRIBUTE_SKIN_SLOTS, VertexAttributeValues::Uint16x4(own_slots));
    skinned.insert_attribute(ATTRIBUTE_SKIN_WEIGHTS, VertexAttributeValues::Unorm16x4(own_weights));
    Ok(skinned)
}

/// `mesh` without the engine's joint attributes: all of it rides on the first slot of its palette.
#[must_use]
pub fn rigid_mesh(mesh: &Mesh) -> Mesh {
    let mut rigid = mesh.clone();
    rigid.remove_attribute(Mesh::ATTRIBUTE_JOINT_INDEX);
    rigid.remove_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT);
    rigid
}

/// For each of `slot_count` slots the box of the vertices it moves, in the mesh's space, with any morph target up to weight 1.
///
/// # Errors
/// When the mesh has no readable positions.
pub fn slot_boxes(mesh: &Mesh, slot_count: usize) -> Result<Vec<SlotBox>, SkinMeshError> {
    let positions = positions(mesh)?;
    let influences = match (values(mesh, ATTRIBUTE_SKIN_SLOTS), values(mesh, ATTRIBUTE_SKIN_WEIGHTS)) {
        (Ok(VertexAttributeValues::Uint16x4(slots)), Ok(VertexAttributeValues::Unorm16x4(weights))) => {
            Some((slots, weights))
        }
        _ => None,
    };
    let morphs = mesh.get_morph_targets().unwrap_or_default();
    let mut boxes = vec![SlotBox::EMPTY; slot_count];
    for (vertex, position) in positions.iter().enumerate() {
        let position = Vec3::from(*position);
        let deltas = morphs.iter().skip(vertex).step_by(positions.len()).map(|morph| morph.position);
        let (low, high) = deltas.fold((position, position), |(low, high), delta| {
            (low + delta.min(Vec3::ZERO), high + delta.max(Vec3::ZERO))
        });
        let influences = influences.map_or(Influences::rigid(0), |(slots, weights)| Influences {
            slots: slots[vertex],
            weights: weights[vertex],
        });
        for (slot, weight) in influences.slots.into_iter().zip(influences.weights) {
            if weight > 0
                && let Some(slot_box) = boxes.get_mut(usize::from(slot))
            {
                slot_box.include(low);
                slot_box.include(high);
            }
        }
    }
    Ok(boxes)
}

/// Names of the mesh's morph targets; a target without one goes by its index.
#[must_use]
pub fn morph_names(mesh: &Mesh) -> Vec<String> {
    let values = mesh.get_morph_targets().map_or(0, <[_]>::len);
    let count = values.checked_div(mesh.count_vertices()).unwrap_or(0);
    let names = mesh.morph_target_names().unwrap_or_default();
    (0..count).map(|target| names.get(target).cloned().unwrap_or_else(|| target.to_string())).collect()
}

fn influences(slots: [u16; 4], weights: [f32; 4], unweighted: u16) -> Influences {
    match quantized_weights(weights) {
        None => Influences::rigid(unweighted),
        Some(weights) => {
            let mut slots = slots;
            // A slot without weight may name anything in a file; the shader would still read it.
            for (slot, weight) in slots.iter_mut().zip(weights) {
                *slot = if weight == 0 { 0 } else { *slot };
            }
            Influences { slots, weights }
        }
    }
}

pub(super) fn positions(mesh: &Mesh) -> Result<&[[f32; 3]], SkinMeshError> {
    match values(mesh, Mesh::ATTRIBUTE_POSITION)? {
        VertexAttributeValues::Float32x3(positions) => Ok(positions),
        other => Err(wrong(Mesh::ATTRIBUTE_POSITION, other, "Float32x3")),
    }
}

pub(super) fn values(mesh: &Mesh, attribute: MeshVertexAttribute) -> Result<&VertexAttributeValues, SkinMeshError> {
    mesh.try_attribute_option(attribute)
        .map_err(|_| SkinMeshError::Unreadable)?
        .ok_or(SkinMeshError::Missing(attribute.name))
}

fn wrong(attribute: MeshVertexAttribute, found: &VertexAttributeValues, wanted: &'static str) -> SkinMeshError {
    SkinMeshError::Format { attribute: attribute.name, found: format!("{:?}", VertexFormat::from(found)), wanted }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::{
        asset::RenderAssetUsages,
        mesh::{PrimitiveTopology, morph::MorphAttributes},
    };

    fn two_vertices(slots: [[u16; 4]; 2], weights: [[f32; 4]; 2]) -> Mesh {
        Mesh::new(PrimitiveTopology::PointList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vec![[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(slots.into()))
            .with_inserted_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights.to_vec())
    }

    fn attributes(mesh: &Mesh) -> (Vec<[u16; 4]>, Vec<[u16; 4]>) {
        match (mesh.attribute(ATTRIBUTE_SKIN_SLOTS), mesh.attribute(ATTRIBUTE_SKIN_WEIGHTS)) {
            (Some(VertexAttributeValues::Uint16x4(slots)), Some(VertexAttributeValues::Unorm16x4(weights))) => {
                (slots.clone(), weights.clone())
            }
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn weights_are_scaled_to_one_and_idle_slots_cleared() {
        let mesh = two_vertices([[3, 2, 9, 9], [1, 0, 0, 0]], [[1.0, 3.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0]]);
        let skinned = skin_mesh(&mesh, 4, 0).unwrap();
        let (slots, weights) = attributes(&skinned);
        assert_eq!(slots, [[3, 2, 0, 0], [1, 0, 0, 0]]);
        assert_eq!(weights, [[16_384, 49_151, 0, 0], [65_535, 0, 0, 0]]);
        assert!(!skinned.contains_attribute(Mesh::ATTRIBUTE_JOINT_INDEX), "the engine would skin it as well");
    }

    #[test]
    fn a_vertex_without_weights_rides_on_the_slot_given() {
        let mesh = two_vertices([[9, 9, 9, 9]; 2], [[0.0; 4], [f32::NAN, 0.0, 0.0, 0.0]]);
        let (slots, weights) = attributes(&skin_mesh(&mesh, 4, 2).unwrap());
        assert_eq!(slots, [[2, 0, 0, 0]; 2]);
        assert_eq!(weights, [[65_535, 0, 0, 0]; 2]);
    }

    #[test]
    fn a_joint_beyond_the_skin_is_named() {
        let mesh = two_vertices([[0; 4], [1, 4, 0, 0]], [[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]]);
        let error = skin_mesh(&mesh, 4, 0).expect_err("there is no joint 4");
        assert_eq!(error.to_string(), "vertex 1 is moved by joint 4 of its skin, which has only 4 (0 to 3)");
    }

    #[test]
    fn what_is_missing_or_odd_is_named() {
        let mut mesh = two_vertices([[0; 4]; 2], [[1.0, 0.0, 0.0, 0.0]; 2]);
        mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0; 4]; 3]);
        assert_eq!(
            skin_mesh(&mesh, 1, 0).expect_err("three weights for two vertices").to_string(),
            "`Vertex_JointWeight` has 3 values for 2 vertices"
        );
        mesh.remove_attribute(Mesh::ATTRIBUTE_JOINT_INDEX);
        assert_eq!(skin_mesh(&mesh, 1, 0).err(), Some(SkinMeshError::Missing("Vertex_JointIndex")));
    }

    #[test]
    fn boxes_hold_the_vertices_of_their_slot_and_their_morphs() {
        let mut mesh = two_vertices([[0, 0, 0, 0], [1, 0, 0, 0]], [[1.0, 0.0, 0.0, 0.0]; 2]);
        let up = MorphAttributes::new(Vec3::new(0.0, 0.5, -0.25), Vec3::ZERO, Vec3::ZERO);
        mesh.set_morph_targets(vec![MorphAttributes::default(), up]);
        let boxes = slot_boxes(&skin_mesh(&mesh, 3, 0).unwrap(), 3).unwrap();
        assert_eq!(boxes[0], SlotBox { min: Vec3::ZERO, max: Vec3::ZERO });
        assert_eq!(boxes[1], SlotBox { min: Vec3::new(0.0, 1.0, -0.25), max: Vec3::new(0.0, 1.5, 0.0) });
        assert_eq!(boxes[2], SlotBox::EMPTY);
        assert_eq!(morph_names(&mesh), ["0"]);
    }
}
