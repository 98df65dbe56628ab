//! Ground as a grid of heights: pure data, the one source of mesh, collider and height queries.
//!
//! World space, metres, +Y up, centred on the origin. Each cell is two triangles split from its (-X, +Z) to its (+X, -Z)
//! corner, which is the diagonal that the physics engine uses.

use bevy::{math::Vec3, prelude::Resource};

use crate::math::rotation::direction_or;

/// A square grid of heights, centred on the origin.
#[derive(Resource, Clone, Debug, PartialEq)]
pub struct Heightfield {
    /// Row by row along +X, each row running along +Z.
    heights: Vec<f32>,
    cells: usize,
    cell_size: f32,
}

/// A point's cell and its place in it, 0..=1 along +X and +Z.
struct Place {
    x: usize,
    z: usize,
    along_x: f32,
    along_z: f32,
}

impl Heightfield {
    /// Samples `height(x, z)`, in metres, at the corners of `cells` × `cells` squares with sides of `cell_size` metres.
    ///
    /// At least one cell; a cell size that is not a positive number becomes 1 m, a height that is not a number 0 m.
    #[must_use]
    pub fn from_fn(cells: usize, cell_size: f32, height: impl Fn(f32, f32) -> f32) -> Self {
        let cells = cells.max(1);
        let cell_size = if cell_size.is_finite() && cell_size > 0.0 { cell_size } else { 1.0 };
        let mut field = Self { heights: Vec::with_capacity((cells + 1) * (cells + 1)), cells, cell_size };
        for x in 0..=cells {
            for z in 0..=cells {
                let height = height(field.coordinate(x), field.coordinate(z));
                field.heights.push(if height.is_finite() { height } else { 0.0 });
            }
        }
        field
    }

    /// Cells along one side; there is one more vertex than cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// Side of a cell in metres.
    #[must_use]
    pub fn cell_size(&self) -> f32 {
        self.cell_size
    }

    /// Side of the whole field in metres.
    #[must_use]
    pub fn size(&self) -> f32 {
        self.cells as f32 * self.cell_size
    }

    /// All heights in metres, row by row along +X, each row running along +Z.
    #[must_use]
    pub fn heights(&self) -> &[f32] {
        &self.heights
    }

    /// World coordinate in metres of grid line `index`, the same along X and Z.
    #[must_use]
    pub fn coordinate(&self, index: usize) -> f32 {
        (index as f32 - self.cells as f32 * 0.5) * self.cell_size
    }

    /// World position of the grid point `x` lines along +X and `z` along +Z; past the border: the border's.
    #[must_use]
    pub fn vertex(&self, x: usize, z: usize) -> Vec3 {
        let (x, z) = (x.min(self.cells), z.min(self.cells));
        Vec3::new(self.coordinate(x), self.heights[x * (self.cells + 1) + z], self.coordinate(z))
    }

    /// Height in metres of the ground at a world position; past the border: the border's.
    #[must_use]
    pub fn height(&self, x: f32, z: f32) -> f32 {
        let place = self.place(x, z);
        let [near, far_x, far_z, far] = self.corners(&place).map(|corner| corner.y);
        let (u, v) = (place.along_x, place.along_z);
        if u + v <= 1.0 {
            near + u * (far_x - near) + v * (far_z - near)
        } else {
            far + (1.0 - u) * (far_z - far) + (1.0 - v) * (far_x - far)
        }
    }

    /// Unit normal of the triangle under a world position; past the border: the border's.
    #[must_use]
    pub fn normal(&self, x: f32, z: f32) -> Vec3 {
        let place = self.place(x, z);
        let [near, far_x, far_z, far] = self.corners(&place);
        let normal = if place.along_x + place.along_z <= 1.0 {
            (far_z - near).cross(far_x - near)
        } else {
            (far_x - far).cross(far_z - far)
        };
        direction_or(normal, Vec3::Y)
    }

    /// Unit normal of the smooth surface at a grid point, for shading.
    #[must_use]
    pub fn smooth_normal(&self, x: usize, z: usize) -> Vec3 {
        let along_x = self.vertex(x + 1, z) - self.vertex(x.saturating_sub(1), z);
        let along_z = self.vertex(x, z + 1) - self.vertex(x, z.saturating_sub(1));
        direction_or(along_z.cross(along_x), Vec3::Y)
    }

    /// The point on the ground at a world position.
    #[must_use]
    pub fn point(&self, x: f32, z: f32) -> Vec3 {
        Vec3::new(x, self.height(x, z), z)
    }

    fn place(&self, x: f32, z: f32) -> Place {
        let (x, along_x) = self.cell(x);
        let (z, along_z) = self.cell(z);
        Place { x, z, along_x, along_z }
    }

    fn cell(&self, coordinate: f32) -> (usize, f32) {
        let in_cells = coordinate / self.cell_size + self.cells as f32 * 0.5;
        // A NaN clamps to NaN and casts to cell 0.
        let in_cells = in_cells.clamp(0.0, self.cells as f32);
        let cell = (in_cells as usize).min(self.cells - 1);
        let along = in_cells - cell as f32;
        (cell, if along.is_finite() { along } else { 0.0 })
    }

    /// Corners at (-X, -Z), (+X, -Z), (-X, +Z), (+X, +Z).
    fn corners(&self, place: &Place) -> [Vec3; 4] {
        let (x, z) = (place.x, place.z);
        [self.vertex(x, z), self.vertex(x + 1, z), self.vertex(x, z + 1), self.vertex(x + 1, z + 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn saddle() -> Heightfield {
        Heightfield::from_fn(8, 0.5, |x, z| 0.3 * x * z + 0.1 * x)
    }

    #[test]
    fn heights_at_vertices_are_the_sampled_ones() {
        let field = saddle();
        for x in 0..=8 {
            for z in 0..=8 {
                let vertex = field.vertex(x, z);
                let height = field.height(vertex.x, vertex.z);
                assert!((height - vertex.y).abs() < 1e-5, "{height} m at a vertex {} m high", vertex.y);
            }
        }
    }

    #[test]
    fn the_middle_of_a_cell_lies_on_the_split_diagonal() {
        let field = saddle();
        let middle = (field.vertex(5, 2) + field.vertex(4, 3)) * 0.5;
        let height = field.height(middle.x, middle.z);
        assert!((height - middle.y).abs() < 1e-5, "{height} m, the diagonal is at {} m", middle.y);
    }

    #[test]
    fn past_the_border_the_border_goes_on() {
        let field = saddle();
        let (inside, outside) = (field.height(2.0, 1.0), field.height(90.0, 1.0));
        assert!((inside - outside).abs() < 1e-5, "{outside} m past a border at {inside} m");
        assert!(field.height(f32::NAN, f32::INFINITY).is_finite());
        assert!(field.normal(f32::NAN, f32::NEG_INFINITY).is_finite());
    }

    #[test]
    fn bad_sizes_and_heights_become_a_flat_cell() {
        let field = Heightfield::from_fn(0, f32::NAN, |_, _| f32::NAN);
        assert_eq!((field.cells(), field.size(), field.height(0.2, 0.3)), (1, 1.0, 0.0));
    }

    proptest! {
        #[test]
        fn the_normal_stands_on_the_slope(x in -1.9f32..1.9, z in -1.9f32..1.9) {
            let field = saddle();
            let (normal, step) = (field.normal(x, z), 1e-3);
            let along = Vec3::new(step, field.height(x + step, z) - field.height(x, z), 0.0);
            let same_triangle = field.normal(x + step, z) == normal;
            prop_assume!(same_triangle);
            let off = normal.dot(along.normalize()).abs();
            prop_assert!(normal.y > 0.0 && off < 5e-3, "normal {normal} leans {off} into the slope");
        }
    }
}
