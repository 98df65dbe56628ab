//! Polygons with colours, put together into one mesh.
//!
//! Model space, metres; corners run counter-clockwise seen from outside. The colour's fourth number is how open the place is
//! to the sky, which the course's shader darkens by.

use bevy::{
    asset::RenderAssetUsages,
    math::{Vec3, ops},
    mesh::{Indices, Mesh, PrimitiveTopology},
};

use super::palette::shaded;
use crate::math::rotation::direction_or;

/// How much of the sky the foot of a thing sees.
const FOOT_OPEN: f32 = 0.62;

/// A mesh in the making.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facets {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    colors: Vec<[f32; 4]>,
    indices: Vec<u32>,
}

impl Facets {
    /// Adds a flat convex polygon of one colour.
    pub fn polygon(&mut self, corners: &[Vec3], color: [f32; 4]) {
        self.polygon_with(corners, |_| color);
    }

    /// Adds a flat convex polygon whose colour follows the corner.
    pub fn polygon_with(&mut self, corners: &[Vec3], color: impl Fn(Vec3) -> [f32; 4]) {
        let [a, b, c, ..] = corners else { return };
        let normal = direction_or((*b - *a).cross(*c - *a), Vec3::Y);
        let first = self.positions.len() as u32;
        for corner in corners {
            self.vertex(*corner, normal, color(*corner));
        }
        for next in 1..corners.len() as u32 - 1 {
            self.indices.extend([first, first + next, first + next + 1]);
        }
    }

    /// Adds an upright wall below the edge from `left` to `right` as seen from outside, down to `floor` metres, darker there.
    pub fn wall(&mut self, left: Vec3, right: Vec3, floor: f32, color: [f32; 4]) {
        let (foot_left, foot_right) = (left.with_y(floor), right.with_y(floor));
        let paint = |corner: Vec3| shaded(color, if corner.y > floor { 1.0 } else { FOOT_OPEN });
        // An end at the floor makes the wall a triangle.
        if left.y <= floor {
            self.polygon_with(&[foot_left, foot_right, right], paint);
        } else if right.y <= floor {
            self.polygon_with(&[left, foot_left, foot_right], paint);
        } else {
            self.polygon_with(&[left, foot_left, foot_right, right], paint);
        }
    }

    /// Adds a box with edges softened by `bevel` metres, its colour darker at the foot.
    pub fn block(&mut self, centre: Vec3, size: Vec3, bevel: f32, color: [f32; 4]) {
        let half = size * 0.5;
        let bevel = bevel.min(half.min_element() * 0.5).max(0.0);
        // Each corner has three vertices, one on each face that meets there.
        let first = self.positions.len() as u32;
        for corner in 0..8u32 {
            let sign = Vec3::new(side(corner, 0), side(corner, 1), side(corner, 2));
            for axis in 0..3 {
                let mut inset = Vec3::splat(bevel);
                inset[axis] = 0.0;
                let mut normal = Vec3::ZERO;
                normal[axis] = sign[axis];
                let open = if sign.y > 0.0 { 1.0 } else { FOOT_OPEN };
                self.vertex(centre + sign * (half - inset), normal, shaded(color, open));
            }
        }
        let at = |corner: u32, axis: u32| first + corner * 3 + axis;
        for axis in 0..3u32 {
            let (one, other) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            for up in [0, 1 << axis] {
                let ring = [up, up | one, up | one | other, up | other].map(|corner| at(corner, axis));
                self.ring(&ring, up != 0);
            }
            if bevel <= 0.0 {
                continue;
            }
            // The four edges along this axis join the faces of the two other axes.
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            for corner in (0..8u32).filter(|corner| corner & (1 << axis) == 0) {
                let far = corner | (1 << axis);
                let ring = [at(corner, next), at(far, next), at(far, last), at(corner, last)];
                let outward = side(corner, next) * side(corner, last) < 0.0;
                self.ring(&ring, outward);
            }
        }
        for corner in (0..8u32).filter(|_| bevel > 0.0) {
            let outward = side(corner, 0) * side(corner, 1) * side(corner, 2) > 0.0;
            self.ring(&[at(corner, 0), at(corner, 1), at(corner, 2)], outward);
        }
    }

    /// Adds triangles, smooth where neighbours meet at less than `crease` radians.
    pub fn smooth(&mut self, points: &[Vec3], triangles: &[[u32; 3]], crease: f32, color: impl Fn(Vec3) -> [f32; 4]) {
        let corners = |triangle: &[u32; 3]| triangle.map(|index| points[index as usize]);
        let areas: Vec<Vec3> = triangles.iter().map(corners).map(|[a, b, c]| (b - a).cross(c - a)).collect();
        let mut around = vec![Vec::new(); points.len()];
        for (face, triangle) in triangles.iter().enumerate() {
            for index in triangle {
                around[*index as usize].push(face);
            }
        }
        let least = ops::cos(crease);
        for (face, triangle) in triangles.iter().enumerate() {
            let flat = direction_or(areas[face], Vec3::Y);
            let first = self.positions.len() as u32;
            for index in triangle {
                let neighbours = around[*index as usize].iter().map(|&other| areas[other]);
                let close = neighbours.filter(|area| direction_or(*area, flat).dot(flat) >= least);
                let (point, normal) = (points[*index as usize], direction_or(close.sum(), flat));
                self.vertex(point, normal, color(point));
            }
            self.indices.extend([first, first + 1, first + 2]);
        }
    }

    /// The corners of every triangle.
    pub fn triangles(&self) -> impl Iterator<Item = [Vec3; 3]> + '_ {
        let (triangles, _) = self.indices.as_chunks::<3>();
        triangles.iter().map(|triangle| triangle.map(|index| self.positions[index as usize]))
    }

    /// The finished mesh: positions, normals, colours.
    #[must_use]
    pub fn mesh(self) -> Mesh {
        Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, self.positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, self.normals)
            .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, self.colors)
            .with_inserted_indices(Indices::U32(self.indices))
    }

    fn vertex(&mut self, position: Vec3, normal: Vec3, color: [f32; 4]) {
        self.positions.push(position);
        self.normals.push(normal);
        self.colors.push(color);
    }

    /// Joins vertices into a convex polygon, turned round unless they run `outward` already.
    fn ring(&mut self, vertices: &[u32], outward: bool) {
        for next in 1..vertices.len() - 1 {
            let (second, third) = if outward { (next, next + 1) } else { (next + 1, next) };
            self.indices.extend([vertices[0], vertices[second], vertices[third]]);
        }
    }
}

/// +1 where bit `axis` of `corner` is set, else -1.
fn side(corner: u32, axis: u32) -> f32 {
    if corner & (1 << axis) == 0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volume enclosed by outward triangles, m³.
    fn volume(facets: &Facets) -> f32 {
        facets.triangles().map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
    }

    #[test]
    fn a_block_is_closed_and_faces_outward() {
        let mut facets = Facets::default();
        facets.block(Vec3::new(0.3, 1.0, -2.0), Vec3::new(1.0, 0.5, 2.0), 0.02, [1.0; 4]);
        let volume = volume(&facets);
        assert!((0.98..1.0).contains(&volume), "{volume} m³ of 1");
        for [a, b, c] in facets.triangles() {
            let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a));
            assert!((middle - Vec3::new(0.3, 1.0, -2.0)).dot(normal) > 0.0, "a triangle at {middle} faces inward");
        }
    }

    #[test]
    fn too_few_corners_add_nothing() {
        let mut facets = Facets::default();
        facets.polygon(&[Vec3::ZERO, Vec3::X], [1.0; 4]);
        assert_eq!(facets, Facets::default());
    }
}
