//! Surface nets: a field in, a closed triangle mesh out.
//!
//! Model space, metres. Cells are cubes; each cell that the surface crosses has one vertex, pulled onto the surface.

use std::collections::BTreeMap;

use glam::{IVec3, Vec3};

use crate::shape::field::normal;

/// A triangle mesh without attributes.
#[derive(Clone, Debug, Default)]
pub struct Soup {
    /// Vertex positions.
    pub points: Vec<Vec3>,
    /// Three vertex indices each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// The box to search, and how fine.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Lowest corner.
    pub low: Vec3,
    /// Highest corner.
    pub high: Vec3,
    /// Edge of a cell in metres.
    pub cell: f32,
    /// Keep only the half x ≥ 0 of a field that is even in x; the rim then lies at x = 0 exactly.
    pub half: bool,
}

struct Samples {
    size: IVec3,
    values: Vec<f32>,
}

impl Samples {
    fn at(&self, p: IVec3) -> f32 {
        self.values[((p.z * self.size.y + p.y) * self.size.x + p.x) as usize]
    }
}

/// The surface where `field` is zero.
#[must_use]
pub fn surface(field: &dyn Fn(Vec3) -> f32, grid: &Grid) -> Soup {
    // With `half` the first column of cells straddles x = 0.
    let low = if grid.half { Vec3::new(-0.5 * grid.cell, grid.low.y, grid.low.z) } else { grid.low };
    let size = ((grid.high - low) / grid.cell).ceil().as_ivec3() + IVec3::ONE;
    let place = |p: IVec3| low + p.as_vec3() * grid.cell;
    let mut samples = Samples { size, values: Vec::with_capacity((size.x * size.y * size.z) as usize) };
    for z in 0..size.z {
        for y in 0..size.y {
            samples.values.extend((0..size.x).map(|x| field(place(IVec3::new(x, y, z)))));
        }
    }
    let mut soup = Soup::default();
    let mut vertex_of = BTreeMap::new();
    for z in 0..size.z - 1 {
        for y in 0..size.y - 1 {
            for x in 0..size.x - 1 {
                let cell = IVec3::new(x, y, z);
                if let Some(crossing) = crossing(&samples, cell) {
                    let mut point = settle(field, low + crossing * grid.cell, grid.cell);
                    if grid.half && x == 0 {
                        point.x = 0.0;
                    }
                    vertex_of.insert(cell.to_array(), soup.points.len() as u32);
                    soup.points.push(point);
                }
            }
        }
    }
    for z in 1..size.z - 1 {
        for y in 1..size.y - 1 {
            for x in 0..size.x - 1 {
                faces(&samples, &vertex_of, IVec3::new(x, y, z), &mut soup.triangles);
            }
        }
    }
    soup
}

/// Mean of the crossings on a cell's twelve edges, in cells.
fn crossing(samples: &Samples, cell: IVec3) -> Option<Vec3> {
    let corner = |i: i32| cell + IVec3::new(i & 1, (i >> 1) & 1, i >> 2);
    let mut sum = Vec3::ZERO;
    let mut count = 0.0;
    for a in 0..8 {
        for axis in [1, 2, 4] {
            if a & axis == 0 {
                let (p, q) = (corner(a), corner(a | axis));
                let (v, w) = (samples.at(p), samples.at(q));
                if (v < 0.0) != (w < 0.0) {
                    sum += p.as_vec3().lerp(q.as_vec3(), v / (v - w));
                    count += 1.0;
                }
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// Moves a point onto the surface, at most half a cell.
pub fn settle(field: &dyn Fn(Vec3) -> f32, start: Vec3, cell: f32) -> Vec3 {
    let mut p = start;
    for _ in 0..4 {
        p -= normal(field, p, 0.2 * cell) * field(p).clamp(-0.3 * cell, 0.3 * cell);
    }
    start + (p - start).clamp_length_max(0.5 * cell)
}

/// Two triangles for each of the three edges that start at grid point `p` and cross the surface.
fn faces(samples: &Samples, vertex_of: &BTreeMap<[i32; 3], u32>, p: IVec3, triangles: &mut Vec<[u32; 3]>) {
    for (axis, u, v) in [(IVec3::X, IVec3::Y, IVec3::Z), (IVec3::Y, IVec3::Z, IVec3::X), (IVec3::Z, IVec3::X, IVec3::Y)]
    {
        let inside = samples.at(p) < 0.0;
        if inside == (samples.at(p + axis) < 0.0) {
            continue;
        }
        let ring = [p - u - v, p - v, p, p - u].map(|cell| vertex_of.get(&cell.to_array()).copied());
        let [Some(a), Some(b), Some(c), Some(d)] = ring else { continue };
        if inside {
            triangles.extend([[a, b, c], [a, c, d]]);
        } else {
            triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
}

/// Edges that are not seen exactly once from each side.
#[cfg(test)]
pub fn loose_edges(triangles: &[[u32; 3]]) -> usize {
    let mut edges = BTreeMap::new();
    for t in triangles {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            *edges.entry((a, b)).or_insert(0) += 1;
        }
    }
    edges.iter().filter(|((a, b), count)| **count != 1 || edges.get(&(*b, *a)) != Some(&1)).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplify::{Detail, simplify};

    fn ball() -> Soup {
        let grid = Grid { low: Vec3::splat(-0.12), high: Vec3::splat(0.12), cell: 0.01, half: false };
        surface(&|p| p.length() - 0.1, &grid)
    }

    fn loose_edges(soup: &Soup) -> usize {
        super::loose_edges(&soup.triangles)
    }

    fn farthest_from_the_sphere(soup: &Soup) -> f32 {
        soup.points.iter().map(|p| (p.length() - 0.1).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn a_ball_is_closed_faces_outward_and_lies_on_its_sphere() {
        let ball = ball();
        assert_eq!(loose_edges(&ball), 0);
        let off = farthest_from_the_sphere(&ball);
        assert!(off < 1e-5, "a vertex is {off} m off the sphere");
        let inward = ball.triangles.iter().filter(|t| {
            let [a, b, c] = t.map(|v| ball.points[v as usize]);
            (b - a).cross(c - a).dot(a) < 0.0
        });
        assert_eq!(inward.count(), 0);
    }

    #[test]
    fn a_half_ball_is_open_only_at_its_rim() {
        let grid = Grid { low: Vec3::splat(-0.12), high: Vec3::splat(0.12), cell: 0.01, half: true };
        let half = surface(&|p| p.length() - 0.1, &grid);
        let rim = half.points.iter().filter(|p| p.x == 0.0).count();
        assert!(rim > 20, "{rim} vertices at x = 0");
        assert!(half.points.iter().all(|p| p.x >= 0.0));
        assert_eq!(loose_edges(&half), rim);
    }

    #[test]
    fn a_simplified_ball_stays_closed_and_round() {
        let detail = Detail { triangles: 300, weight: &|_| 1.0, edge: &|_| 1.0 };
        let few = simplify(&ball(), &detail);
        assert!(few.triangles.len() <= 300, "{} triangles", few.triangles.len());
        assert_eq!(loose_edges(&few), 0);
        let off = farthest_from_the_sphere(&few);
        assert!(off < 0.002, "a vertex is {off} m off the sphere");
    }
}
