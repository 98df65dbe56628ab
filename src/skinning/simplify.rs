//! Meshes with fewer triangles.
//!
//! A simplified mesh keeps some of the vertices of the whole one as they are, so skin weights and morph targets stay right. Lengths in
//! the mesh's space.

use avian3d::parry::{query::PointQuery, shape::TriMesh};
use bevy::{
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};
use meshopt::{
    SimplifyOptions, VertexDataAdapter, optimize_vertex_cache, simplify_scale, simplify_with_attributes_and_locks,
};

use super::mesh::{ATTRIBUTE_SKIN_SLOTS, ATTRIBUTE_SKIN_WEIGHTS, positions, values};
use crate::anim::skin::Influences;

/// Shares of the whole mesh's triangles that simplified ones aim for.
pub const SHARES: [f32; 2] = [0.35, 0.12];

/// Triangles that a mesh keeps in any case: buttons and eyes would vanish.
const LEAST: f32 = 64.0;
/// Largest error that a mesh is simplified to, as a share of its largest side: beyond, a body falls apart.
const MOST_ERROR: f32 = 0.1;
/// How much a normal that is off by its length counts, as a share of the mesh's largest side.
const NORMAL: f32 = 0.05;
/// The same for texture coordinates, and for each channel of a vertex' colour.
const TEXTURE: f32 = 0.03;
const COLOUR: f32 = 0.2;
/// How much it counts that a vertex moves with joints that are elsewhere: as much as if it were itself that far off.
const MOTION: f32 = 0.5;

/// A mesh with fewer triangles.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// The mesh.
    pub mesh: Mesh,
    /// How far a vertex of the whole mesh is from its surface at most, in the mesh's space.
    pub error: f32,
}

/// `mesh` with about `share` of its triangles.
///
/// `homes` says where the joint of each palette slot is when bound, in the mesh's space: vertices that move together stay together.
/// `None` where that gives nothing: for a mesh that isn't made of indexed triangles, has left main memory, or can't lose any.
#[must_use]
pub fn simplified(mesh: &Mesh, homes: &[Vec3], share: f32) -> Option<Simplified> {
    let (positions, indices) = triangles(mesh)?;
    let bytes = bytemuck::cast_slice(positions);
    let vertices = VertexDataAdapter::new(bytes, size_of::<[f32; 3]>(), 0).ok()?;
    let side = simplify_scale(&vertices);
    if side.is_nan() || side <= 0.0 {
        return None;
    }
    let looks = looks(mesh, positions.len(), homes, side);
    let fewer = simplify_with_attributes_and_locks(
        &indices,
        &vertices,
        looks.as_flattened(),
        &[1.0; LOOKS],
        size_of::<[f32; LOOKS]>(),
        &vec![false; positions.len()],
        (indices.len() as f32 / 3.0 * share).max(LEAST) as usize * 3,
        MOST_ERROR,
        SimplifyOptions::empty(),
        None,
    );
    if fewer.is_empty() || fewer.len() >= indices.len() {
        return None;
    }
    let fewer = optimize_vertex_cache(&fewer, positions.len());
    Some(Simplified { mesh: with_triangles(mesh, &fewer)?, error: distance(positions, &fewer)? })
}

/// How far any of these places is from these triangles at most.
fn distance(positions: &[[f32; 3]], triangles: &[u32]) -> Option<f32> {
    let places: Vec<Vec3> = positions.iter().copied().map(Vec3::from_array).collect();
    let surface = TriMesh::new(places.clone(), triangles.as_chunks().0.to_vec()).ok()?;
    let distances = places.into_iter().map(|place| surface.distance_to_local_point(place, false));
    Some(distances.fold(0.0, f32::max))
}

/// Positions and triangles, all of whose corners there are.
fn triangles(mesh: &Mesh) -> Option<(&[[f32; 3]], Vec<u32>)> {
    if mesh.primitive_topology() != PrimitiveTopology::TriangleList {
        return None;
    }
    let positions = positions(mesh).ok()?;
    let indices: Vec<u32> = match mesh.try_indices_option().ok()?? {
        Indices::U16(indices) => indices.iter().map(|index| u32::from(*index)).collect(),
        Indices::U32(indices) => indices.clone(),
    };
    let whole = indices.len().is_multiple_of(3) && indices.iter().all(|index| (*index as usize) < positions.len());
    let finite = positions.as_flattened().iter().all(|number| number.is_finite());
    (whole && finite && !indices.is_empty()).then_some((positions, indices))
}

/// Numbers of a vertex beside its position: normal, texture coordinates, colour, and where the joints are that it moves with.
const LOOKS: usize = 11;

/// What else counts of each vertex, in shares of the mesh's largest `side`.
fn looks(mesh: &Mesh, count: usize, homes: &[Vec3], side: f32) -> Vec<[f32; LOOKS]> {
    let mut looks = vec![[0.0; LOOKS]; count];
    if let Ok(VertexAttributeValues::Float32x3(normals)) = values(mesh, Mesh::ATTRIBUTE_NORMAL) {
        for (look, normal) in looks.iter_mut().zip(normals) {
            look[..3].copy_from_slice(&normal.map(|number| number * NORMAL));
        }
    }
    if let Ok(VertexAttributeValues::Float32x2(places)) = values(mesh, Mesh::ATTRIBUTE_UV_0) {
        for (look, place) in looks.iter_mut().zip(places) {
            look[3..5].copy_from_slice(&place.map(|number| number * TEXTURE));
        }
    }
    if let Ok(VertexAttributeValues::Float32x4(colours)) = values(mesh, Mesh::ATTRIBUTE_COLOR) {
        for (look, [red, green, blue, _]) in looks.iter_mut().zip(colours) {
            look[5..8].copy_from_slice(&[red, green, blue].map(|number| number * COLOUR));
        }
    }
    if let (Ok(VertexAttributeValues::Uint16x4(slots)), Ok(VertexAttributeValues::Unorm16x4(weights))) =
        (values(mesh, ATTRIBUTE_SKIN_SLOTS), values(mesh, ATTRIBUTE_SKIN_WEIGHTS))
    {
        for (look, (slots, weights)) in looks.iter_mut().zip(slots.iter().zip(weights)) {
            let home = home(Influences { slots: *slots, weights: *weights }, homes) * (MOTION / side);
            look[8..].copy_from_slice(&home.to_array());
        }
    }
    for number in looks.as_flattened_mut() {
        *number = if number.is_finite() { *number } else { 0.0 };
    }
    looks
}

/// The middle of the joints that move a vertex.
fn home(influences: Influences, homes: &[Vec3]) -> Vec3 {
    let parts = influences.slots.into_iter().zip(influences.weights);
    let parts = parts.filter_map(|(slot, weight)| Some((*homes.get(usize::from(slot))?, f32::from(weight))));
    parts.map(|(home, weight)| home * weight).sum::<Vec3>() / f32::from(u16::MAX)
}

/// `mesh` with these triangles alone, and only the vertices that they need, in the order in which they need them.
fn with_triangles(mesh: &Mesh, triangles: &[u32]) -> Option<Mesh> {
    let count = mesh.count_vertices();
    let mut places = vec![u32::MAX; count];
    let mut kept = Vec::new();
    for &vertex in triangles {
        let place = &mut places[vertex as usize];
        if *place == u32::MAX {
            *place = kept.len() as u32;
            kept.push(vertex);
        }
    }
    let indices = triangles.iter().map(|vertex| places[*vertex as usize]);
    let indices = if kept.len() <= usize::from(u16::MAX) {
        Indices::U16(indices.filter_map(|place| u16::try_from(place).ok()).collect())
    } else {
        Indices::U32(indices.collect())
    };
    let targets = mesh.get_morph_targets().map(|targets| {
        let of =
            |target: &[_]| kept.iter().filter_map(|vertex| target.get(*vertex as usize).copied()).collect::<Vec<_>>();
        targets.chunks(count.max(1)).flat_map(of).collect::<Vec<_>>()
    });
    let mut few = mesh.clone();
    // Vertices by the order that indices give them: the engine has that for every kind of attribute.
    few.insert_indices(Indices::U32(kept));
    few.try_duplicate_vertices().ok()?;
    few.insert_indices(indices);
    if let Some(targets) = targets {
        few.set_morph_targets(targets);
    }
    Some(few)
}
