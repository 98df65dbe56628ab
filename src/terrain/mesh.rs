//! The ground's meshes: square chunks of a [`Heightfield`] in several levels of detail.
//!
//! World space. Fine chunks show exactly the collider's triangles. Skirts hang from every chunk's border, so that no sky shows
//! between chunks of different levels. The vertex colour holds what [`super::material::GroundMaterial`] blends: red path, green bare
//! ground, blue shade under obstacles, alpha broad patches.

use bevy::{
    asset::RenderAssetUsages,
    math::Vec3,
    mesh::{Indices, Mesh, PrimitiveTopology},
};

use super::{Heightfield, landscape::Cover};

/// Metres that skirts hang down.
const SKIRT: f32 = 1.2;

/// Which part of a heightfield a mesh shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Chunk {
    /// First cell along +X.
    pub x: usize,
    /// First cell along +Z.
    pub z: usize,
    /// Cells along one side.
    pub cells: usize,
    /// Cells per quad: 1 shows every cell, 4 every fourth grid line.
    pub stride: usize,
}

/// The ground's looks at one vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paint {
    /// What covers it.
    pub cover: Cover,
    /// How much obstacles shade it from the sky, 0..=1.
    pub shade: f32,
    /// Which patch of the meadow it belongs to, 0..=1.
    pub patch: f32,
}

/// The chunks of `cells` × `cells` cells that tile `field` in quads of `stride` cells.
pub fn chunks(field: &Heightfield, cells: usize, stride: usize) -> impl Iterator<Item = Chunk> {
    let (side, cells, stride) = (field.cells(), cells.max(1), stride.max(1));
    (0..side).step_by(cells).flat_map(move |x| (0..side).step_by(cells).map(move |z| (x, z))).map(move |(x, z)| Chunk {
        x,
        z,
        cells,
        stride,
    })
}

/// World position of a chunk's middle on the ground.
#[must_use]
pub fn centre(field: &Heightfield, chunk: Chunk) -> Vec3 {
    field.vertex(chunk.x + chunk.cells / 2, chunk.z + chunk.cells / 2)
}

/// The mesh of one chunk, relative to `origin`, painted by `paint(x, z)`.
#[must_use]
pub fn chunk_mesh(field: &Heightfield, chunk: Chunk, origin: Vec3, paint: impl Fn(f32, f32) -> Paint) -> Mesh {
    let lines = |first: usize| -> Vec<usize> {
        let last = (first + chunk.cells).min(field.cells());
        (first..last).step_by(chunk.stride).chain([last]).collect()
    };
    let (lines_x, lines_z) = (lines(chunk.x), lines(chunk.z));
    let mut build = Build { field, origin, ..Build::default_for(field) };
    for &x in &lines_x {
        for &z in &lines_z {
            build.vertex(x, z, 0.0, &paint);
        }
    }
    let side = lines_z.len() as u32;
    for x in 0..lines_x.len() as u32 - 1 {
        for z in 0..side - 1 {
            let (near, far_x) = (x * side + z, (x + 1) * side + z);
            build.indices.extend([near, near + 1, far_x, near + 1, far_x + 1, far_x]);
        }
    }
    let (first_x, last_x) = (lines_x[0], lines_x[lines_x.len() - 1]);
    let (first_z, last_z) = (lines_z[0], lines_z[lines_z.len() - 1]);
    let border = lines_x
        .iter()
        .map(|&x| (x, first_z))
        .chain(lines_z.iter().map(|&z| (last_x, z)))
        .chain(lines_x.iter().rev().map(|&x| (x, last_z)))
        .chain(lines_z.iter().rev().map(|&z| (first_x, z)));
    build.skirt(border, &paint);
    build.mesh()
}

struct Build<'a> {
    field: &'a Heightfield,
    origin: Vec3,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    colors: Vec<[f32; 4]>,
    indices: Vec<u32>,
}

impl<'a> Build<'a> {
    fn default_for(field: &'a Heightfield) -> Self {
        Self { field, origin: Vec3::ZERO, positions: vec![], normals: vec![], colors: vec![], indices: vec![] }
    }

    fn vertex(&mut self, x: usize, z: usize, down: f32, paint: &impl Fn(f32, f32) -> Paint) {
        let position = self.field.vertex(x, z);
        let Paint { cover, shade, patch } = paint(position.x, position.z);
        self.positions.push(position - Vec3::Y * down - self.origin);
        self.normals.push(self.field.smooth_normal(x, z));
        self.colors.push([cover.path, cover.bare, shade, patch]);
    }

    /// Hangs a strip from the border, which runs -Z side, +X side, +Z side, -X side: clockwise seen from below.
    fn skirt(&mut self, border: impl Iterator<Item = (usize, usize)>, paint: &impl Fn(f32, f32) -> Paint) {
        let first = self.positions.len() as u32;
        for (x, z) in border {
            self.vertex(x, z, 0.0, paint);
            self.vertex(x, z, SKIRT, paint);
        }
        let pairs = (self.positions.len() as u32 - first) / 2;
        for pair in 0..pairs.saturating_sub(1) {
            let (top, next) = (first + 2 * pair, first + 2 * pair + 2);
            self.indices.extend([top, next, top + 1, next, next + 1, top + 1]);
        }
    }

    fn mesh(self) -> Mesh {
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, self.colors)
            .with_inserted_indices(Indices::U32(self.indices))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(_: f32, _: f32) -> Paint {
        Paint { cover: Cover { path: 0.0, bare: 0.0 }, shade: 0.0, patch: 0.0 }
    }

    fn triangles(mesh: &Mesh) -> Vec<[Vec3; 3]> {
        let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION).unwrap().as_float3().unwrap();
        let indices: Vec<usize> = mesh.indices().unwrap().iter().collect();
        indices.chunks(3).map(|i| [0, 1, 2].map(|corner| Vec3::from(positions[i[corner]]))).collect()
    }

    #[test]
    fn chunks_tile_the_field_once() {
        let field = Heightfield::from_fn(10, 1.0, |x, z| x * z);
        let area: f32 = chunks(&field, 4, 1)
            .flat_map(|chunk| triangles(&chunk_mesh(&field, chunk, Vec3::ZERO, plain)))
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).y)
            .sum();
        assert!((area - 100.0).abs() < 1e-2, "chunks cover {area} m² of 100");
    }

    #[test]
    fn fine_chunks_show_the_heightfield() {
        let field = Heightfield::from_fn(8, 0.5, |x, z| 0.3 * x * z);
        for chunk in chunks(&field, 4, 1) {
            for [a, b, c] in triangles(&chunk_mesh(&field, chunk, Vec3::ZERO, plain)) {
                if (b - a).cross(c - a).y < 1e-6 {
                    continue;
                }
                let middle = (a + b + c) / 3.0;
                let height = field.height(middle.x, middle.z);
                assert!((height - middle.y).abs() < 1e-4, "mesh {} m, field {height} m", middle.y);
            }
        }
    }
}
