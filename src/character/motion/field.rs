//! Height and slope of a heightfield at a place, and its triangles, without a cast.
//!
//! World space, metres.

use avian3d::parry::shape::{HeightField, HeightFieldCellStatus};
use bevy::math::{Quat, Vec2, Vec3};

use super::heightfield::Span;

/// Cosine of the tilt below which a field counts as upright.
const UPRIGHT: f32 = 1.0 - 1e-7;

/// A heightfield that stands upright, ready to be asked.
#[derive(Clone, Copy)]
pub(in crate::character) struct UprightField<'a> {
    /// Heights at the corners and what there is of each cell, column by column.
    heights: &'a [f32],
    statuses: &'a [HeightFieldCellStatus],
    rows: usize,
    position: Vec3,
    /// World from field, if they are turned against each other at all.
    turn: Option<Quat>,
    /// How many cells there are along the field's x and z, and how many to a metre.
    cells: Vec2,
    /// Column and row of the last cell.
    last: (usize, usize),
    density: Vec2,
    /// Metres of a cell along both.
    size: Vec2,
    /// Metres of height to one of the field's.
    tall: f32,
}

impl<'a> UprightField<'a> {
    /// The field at `position`, turned by `rotation`; `None` for a tilted one.
    #[must_use]
    pub(in crate::character) fn new(field: &'a HeightField, position: Vec3, rotation: Quat) -> Option<Self> {
        let (cells, scale) = (Vec2::new(field.ncols() as f32, field.nrows() as f32), field.scale());
        let upright = (rotation * Vec3::Y).y >= UPRIGHT;
        upright.then(|| Self {
            heights: field.heights().data(),
            statuses: field.cells_statuses().data(),
            rows: field.nrows(),
            position,
            turn: (rotation != Quat::IDENTITY).then_some(rotation),
            cells,
            last: (field.ncols() - 1, field.nrows() - 1),
            density: cells / Vec2::new(scale.x, scale.z),
            size: Vec2::new(scale.x, scale.z) / cells,
            tall: scale.y,
        })
    }

    /// The ground straight below `from`; `None` where there is none.
    #[must_use]
    #[inline]
    pub(in crate::character) fn below(&self, from: Vec3) -> Option<FieldGround<'_>> {
        self.ground(from).filter(|ground| ground.height <= from.y)
    }

    /// The ground at a horizontal place; `None` where there is none. The height of `from` doesn't matter.
    #[must_use]
    #[inline]
    pub(in crate::character) fn ground(&self, from: Vec3) -> Option<FieldGround<'_>> {
        let (height, rise) = self.surface(from)?;
        Some(FieldGround { field: self, height, rise })
    }

    /// World height of that alone.
    #[must_use]
    #[inline]
    pub(in crate::character) fn height(&self, from: Vec3) -> Option<f32> {
        self.surface(from).map(|(height, _)| height)
    }

    /// World height at a horizontal place, and what the ground rises there over a whole cell along the field's x and z.
    #[inline(always)]
    fn surface(&self, from: Vec3) -> Option<(f32, Vec2)> {
        let away = from - self.position;
        let local = self.turn.map_or(away, |turn| turn.inverse() * away);
        // In cells, from the corner of the field.
        let (x, z) = (local.x * self.density.x + 0.5 * self.cells.x, local.z * self.density.y + 0.5 * self.cells.y);
        if !(x >= 0.0 && z >= 0.0 && x <= self.cells.x && z <= self.cells.y) {
            return None;
        }
        let (column, row) = ((x as i32 as usize).min(self.last.0), (z as i32 as usize).min(self.last.1));
        let (u, v) = (x - column as i32 as f32, z - row as i32 as f32);
        let [here, behind, beside, across] = self.corners(column, row)?;
        // Each cell is two triangles: split from `here` to `across`, else from `behind` to `beside`. Which of them it is, is taken
        // in without a branch, since nobody foresees it: how far beyond the split, and how the ground bends there.
        let status = self.status(column, row);
        let zigzag = status.contains(HeightFieldCellStatus::ZIGZAG_SUBDIVISION);
        let (beyond, along, bend) = if zigzag {
            let bend = behind - here - (across - beside);
            (v - u, Vec2::new(beside - here, across - beside), Vec2::new(-bend, bend))
        } else {
            let bend = across - beside - (behind - here);
            (u + v - 1.0, Vec2::new(beside - here, behind - here), Vec2::splat(bend))
        };
        if status.intersects(HeightFieldCellStatus::CELL_REMOVED) {
            let left = if zigzag { beyond >= 0.0 } else { beyond <= 0.0 };
            let removed = [HeightFieldCellStatus::RIGHT_TRIANGLE_REMOVED, HeightFieldCellStatus::LEFT_TRIANGLE_REMOVED];
            if status.contains(removed[usize::from(left)]) {
                return None;
            }
        }
        let height = (here + u * along.x + v * along.y + beyond.max(0.0) * bend.y) * self.tall;
        let rise = along + bend * f32::from(u8::from(beyond > 0.0));
        Some((self.position.y + height, rise))
    }

    /// Heights at the corners of a cell: the first, the next along z, the next along x, and the one across.
    fn corners(&self, column: usize, row: usize) -> Option<[f32; 4]> {
        let first = row + column * (self.rows + 1);
        let pair = |at: usize| self.heights.get(at..)?.first_chunk::<2>();
        let (&[here, behind], &[beside, across]) = (pair(first)?, pair(first + self.rows + 1)?);
        Some([here, behind, beside, across])
    }

    fn status(&self, column: usize, row: usize) -> HeightFieldCellStatus {
        self.statuses.get(row + column * self.rows).copied().unwrap_or(HeightFieldCellStatus::CELL_REMOVED)
    }

    /// Calls `found` with every triangle, in the world, whose cell reaches into the span and that has a corner that is `worth` it. False,
    /// and nothing called, for a field that is turned about the vertical.
    pub(super) fn triangles_in(
        &self,
        span: Span,
        worth: impl Fn(Vec3) -> bool,
        mut found: impl FnMut([Vec3; 3]),
    ) -> bool {
        if self.turn.is_some() {
            return false;
        }
        let cell = |v: Vec3| {
            let away = v - self.position;
            Vec2::new(away.x, away.z) * self.density + 0.5 * self.cells
        };
        let (from, to) = (cell(span.least), cell(span.most));
        if !(to.x >= 0.0 && to.y >= 0.0 && from.x <= self.cells.x && from.y <= self.cells.y) {
            return true;
        }
        let first = self.position - 0.5 * Vec3::new(self.cells.x * self.size.x, 0.0, self.cells.y * self.size.y);
        let corner = |column: usize, row: usize, height: f32| {
            first + Vec3::new(column as f32 * self.size.x, height * self.tall, row as f32 * self.size.y)
        };
        // Negative numbers become 0.
        for column in from.x as usize..=(to.x as usize).min(self.last.0) {
            for row in from.y as usize..=(to.y as usize).min(self.last.1) {
                let Some([here, behind, beside, across]) = self.corners(column, row) else { continue };
                let a = corner(column, row, here);
                let b = corner(column, row + 1, behind);
                let c = corner(column + 1, row, beside);
                let d = corner(column + 1, row + 1, across);
                if a.y.min(b.y).min(c.y).min(d.y) > span.most.y || a.y.max(b.y).max(c.y).max(d.y) < span.least.y {
                    continue;
                }
                let of = [worth(a), worth(b), worth(c), worth(d)];
                if of == [false; 4] {
                    continue;
                }
                let status = self.status(column, row);
                let zigzag = status.contains(HeightFieldCellStatus::ZIGZAG_SUBDIVISION);
                // The two that lie across the split belong to both.
                let (split, left, right) = if zigzag {
                    (of[0] | of[3], ([a, b, d], of[1]), ([a, d, c], of[2]))
                } else {
                    (of[1] | of[2], ([a, b, c], of[0]), ([b, d, c], of[3]))
                };
                if (split | left.1) && !status.contains(HeightFieldCellStatus::LEFT_TRIANGLE_REMOVED) {
                    found(left.0);
                }
                if (split | right.1) && !status.contains(HeightFieldCellStatus::RIGHT_TRIANGLE_REMOVED) {
                    found(right.0);
                }
            }
        }
        true
    }
}

/// Ground of a heightfield.
#[derive(Clone, Copy)]
pub(in crate::character) struct FieldGround<'a> {
    field: &'a UprightField<'a>,
    /// World height.
    pub(in crate::character) height: f32,
    /// What it rises over a whole cell along the field's x and z.
    rise: Vec2,
}

impl FieldGround<'_> {
    /// Unit normal, world.
    #[must_use]
    pub(in crate::character) fn normal(&self) -> Vec3 {
        let rise = self.rise * self.field.density * self.field.tall;
        let normal = Vec3::new(-rise.x, 1.0, -rise.y).normalize();
        self.field.turn.map_or(normal, |turn| turn * normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use avian3d::parry::{
        bounding_volume::Aabb,
        math::{Pose, Vector},
        query::{Ray, RayCast},
        utils::Array2,
    };
    use proptest::prelude::*;

    /// A field of 4 × 3 cells with steep triangles of both splits, and one triangle missing.
    fn field() -> HeightField {
        let heights = (0..20u8).map(|index| f32::from((index * 7) % 11) * 0.1).collect();
        let mut field = HeightField::new(Array2::new(4, 5, heights), Vector::new(8.0, 1.5, 3.0));
        field.set_cell_status(1, 2, HeightFieldCellStatus::ZIGZAG_SUBDIVISION);
        field.set_cell_status(2, 0, HeightFieldCellStatus::ZIGZAG_SUBDIVISION);
        field.set_cell_status(0, 3, HeightFieldCellStatus::LEFT_TRIANGLE_REMOVED);
        field
    }

    proptest! {
        #[test]
        fn a_field_answers_as_a_ray_cast_at_it_does(x in -5.0f32..5.0, z in -5.0f32..5.0, yaw in -3.0f32..3.0) {
            let (field, position, rotation) = (field(), Vec3::new(1.0, -2.0, 0.5), Quat::from_rotation_y(yaw));
            let upright = UprightField::new(&field, position, rotation).expect("it stands upright");
            let from = Vec3::new(x, 4.0, z);
            let ray = Ray::new(Vector::new(x, 4.0, z), Vector::new(0.0, -1.0, 0.0));
            let pose = Pose::from_parts(Vector::new(1.0, -2.0, 0.5), rotation);
            let cast = field.cast_ray_and_get_normal(&pose, &ray, 20.0, false);
            let found = upright.below(from).map(|ground| (ground.height, ground.normal()));
            match (found, cast) {
                (Some((height, normal)), Some(hit)) => {
                    prop_assert!((4.0 - hit.time_of_impact - height).abs() < 1e-4, "{height} m");
                    let same = normal.dot(Vec3::new(hit.normal.x, hit.normal.y, hit.normal.z)).abs();
                    prop_assert!(same > 0.999, "normals at {same}");
                }
                (found, cast) => prop_assert_eq!(found.is_some(), cast.is_some(), "{:?}", cast),
            }
        }
    }

    proptest! {
        #[test]
        fn a_field_has_the_triangles_that_parry_finds(x in -5.0f32..5.0, y in -3.0f32..1.0, z in -5.0f32..5.0, size in 0.1f32..4.0) {
            let (field, position) = (field(), Vec3::new(1.0, -2.0, 0.5));
            let upright = UprightField::new(&field, position, Quat::IDENTITY).expect("it stands upright");
            let span = Span { least: Vec3::new(x, y, z), most: Vec3::new(x + size, y + 0.3 * size, z + size) };
            let mut sums = [Vec3::ZERO; 2];
            prop_assert!(upright.triangles_in(span, |_| true, |triangle| sums[0] += triangle.iter().sum::<Vec3>()));
            let [least, most] = [span.least, span.most].map(|v| v - position).map(|v| Vector::new(v.x, v.y, v.z));
            field.map_elements_in_local_aabb(&Aabb::new(least, most), &mut |_, triangle| {
                let corners = [triangle.a, triangle.b, triangle.c];
                sums[1] += corners.map(|v| position + Vec3::new(v.x, v.y, v.z)).iter().sum::<Vec3>();
            });
            prop_assert!(sums[0].distance(sums[1]) < 1e-3, "corners sum to {} instead of {}", sums[0], sums[1]);
        }
    }

    #[test]
    fn a_turned_field_is_left_to_others() {
        let field = field();
        let upright = UprightField::new(&field, Vec3::ZERO, Quat::from_rotation_y(0.5)).expect("it stands upright");
        let everywhere = Span { least: Vec3::splat(-9.0), most: Vec3::splat(9.0) };
        assert!(!upright.triangles_in(everywhere, |_| true, |triangle| panic!("{triangle:?}")));
    }

    #[test]
    fn a_tilted_field_is_left_to_casts_and_ground_above_is_not_below() {
        let field = field();
        assert!(UprightField::new(&field, Vec3::ZERO, Quat::from_rotation_x(0.01)).is_none());
        let upright = UprightField::new(&field, Vec3::ZERO, Quat::IDENTITY).expect("it stands upright");
        assert!(upright.below(Vec3::new(0.3, -1.0, 0.3)).is_none());
        assert!(upright.below(Vec3::NAN).is_none());
    }
}
