//! Fewer triangles for the same shape: edge collapse by quadric error.
//!
//! Model space, metres. Vertices at x = 0 exactly are the rim of a half mesh and stay on that plane.

use std::{cmp::Reverse, collections::BinaryHeap};

use glam::{DMat3, DVec3, Vec3};

use crate::surface::Soup;

/// What to keep.
pub struct Detail<'a> {
    /// Triangles to stop at.
    pub triangles: usize,
    /// How much an error counts at a point; 1 is plain.
    pub weight: &'a dyn Fn(Vec3) -> f32,
    /// Longest edge allowed at a point, metres.
    pub edge: &'a dyn Fn(Vec3) -> f32,
}

#[derive(Clone, Copy)]
struct Quadric {
    squares: DMat3,
    linear: DVec3,
    constant: f64,
}

impl Quadric {
    const ZERO: Self = Self { squares: DMat3::ZERO, linear: DVec3::ZERO, constant: 0.0 };

    fn plane(normal: DVec3, offset: f64, weight: f64) -> Self {
        Self {
            squares: DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z) * weight,
            linear: normal * (offset * weight),
            constant: offset * offset * weight,
        }
    }

    fn add(&self, other: &Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            linear: self.linear + other.linear,
            constant: self.constant + other.constant,
        }
    }

    fn error(&self, p: DVec3) -> f64 {
        (p.dot(self.squares * p) + 2.0 * p.dot(self.linear) + self.constant).max(0.0)
    }
}

/// A collapse on the heap: cost in bits that sort like the number, then the vertices and their versions.
type Candidate = Reverse<(u64, u32, u32, u32, u32)>;

struct Work<'a> {
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    alive: Vec<bool>,
    fans: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    versions: Vec<u32>,
    heap: BinaryHeap<Candidate>,
    detail: &'a Detail<'a>,
}

/// Collapses edges until `detail.triangles` are left or none may go.
#[must_use]
pub fn simplify(soup: &Soup, detail: &Detail) -> Soup {
    let mut work = Work::new(soup, detail);
    let mut left = soup.triangles.len();
    while left > detail.triangles {
        let Some(Reverse((_, a, b, version_a, version_b))) = work.heap.pop() else { break };
        if work.versions[a as usize] == version_a && work.versions[b as usize] == version_b {
            left -= work.collapse(a, b);
        }
    }
    work.finish()
}

impl<'a> Work<'a> {
    fn new(soup: &Soup, detail: &'a Detail<'a>) -> Self {
        let points: Vec<DVec3> = soup.points.iter().map(|p| p.as_dvec3()).collect();
        let mut fans = vec![Vec::new(); points.len()];
        let mut quadrics = vec![Quadric::ZERO; points.len()];
        for (t, triangle) in soup.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| points[v as usize]);
            let cross = (b - a).cross(c - a);
            let normal = cross.normalize_or_zero();
            let weight = f64::from((detail.weight)(((a + b + c) / 3.0).as_vec3()));
            let plane = Quadric::plane(normal, -normal.dot(a), cross.length() * weight);
            for v in triangle {
                fans[*v as usize].push(t as u32);
                quadrics[*v as usize] = quadrics[*v as usize].add(&plane);
            }
        }
        let count = points.len();
        let mut work = Self {
            points,
            triangles: soup.triangles.clone(),
            alive: vec![true; soup.triangles.len()],
            fans,
            quadrics,
            versions: vec![0; count],
            heap: BinaryHeap::new(),
            detail,
        };
        for t in &soup.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                // An inner edge is seen from both sides: take it once. A rim edge has one side only.
                if a < b || !work.shares(b, a) {
                    work.offer(a, b);
                }
            }
        }
        work
    }

    fn shares(&self, a: u32, b: u32) -> bool {
        self.fans[a as usize].iter().any(|t| {
            let t = self.triangles[*t as usize];
            [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])].contains(&(a, b))
        })
    }

    fn rim(&self, v: u32) -> bool {
        self.points[v as usize].x == 0.0
    }

    /// Where the edge's two ends would meet, and at what cost.
    fn target(&self, a: u32, b: u32) -> (DVec3, f64) {
        let (p, q) = (self.points[a as usize], self.points[b as usize]);
        let sum = self.quadrics[a as usize].add(&self.quadrics[b as usize]);
        let length = p.distance_squared(q);
        // A slight pull to the middle keeps the solution near the edge where the surface is flat.
        let pull = 1e-3 * sum.squares.col(0).length().max(sum.squares.col(1).length()).max(1e-12);
        let middle = 0.5 * (p + q);
        let squares = sum.squares + DMat3::from_diagonal(DVec3::splat(pull));
        let mut best = squares.inverse() * (middle * pull - sum.linear);
        if !best.is_finite() || best.distance_squared(middle) > 4.0 * length {
            best = middle;
        }
        if self.rim(a) || self.rim(b) {
            best = if self.rim(a) && self.rim(b) {
                best
            } else if self.rim(a) {
                p
            } else {
                q
            };
            best.x = 0.0;
        }
        (best, sum.error(best) + 1e-7 * length * length)
    }

    fn offer(&mut self, a: u32, b: u32) {
        let (_, cost) = self.target(a, b);
        let (a, b) = (a.min(b), a.max(b));
        self.heap.push(Reverse((cost.to_bits(), a, b, self.versions[a as usize], self.versions[b as usize])));
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let mut list: Vec<u32> =
            self.fans[v as usize].iter().flat_map(|t| self.triangles[*t as usize]).filter(|w| *w != v).collect();
        list.sort_unstable();
        list.dedup();
        list
    }

    /// Collapses edge a–b into a; returns how many triangles went (0: not allowed).
    fn collapse(&mut self, a: u32, b: u32) -> usize {
        let (near_a, near_b) = (self.neighbours(a), self.neighbours(b));
        let shared: Vec<u32> = near_a.iter().copied().filter(|v| near_b.contains(v)).collect();
        let both: Vec<u32> =
            self.fans[a as usize].iter().copied().filter(|t| self.triangles[*t as usize].contains(&b)).collect();
        let on_rim = both.len() == 1;
        if shared.len() != both.len() || (self.rim(a) && self.rim(b)) != on_rim {
            return 0;
        }
        let (point, _) = self.target(a, b);
        let limit = f64::from((self.detail.edge)(point.as_vec3()));
        let too_long = |v: &u32| *v != a && *v != b && self.points[*v as usize].distance(point) > limit;
        if near_a.iter().chain(&near_b).any(too_long) || self.folds(a, b, point) || self.folds(b, a, point) {
            return 0;
        }
        for t in &both {
            self.alive[*t as usize] = false;
            for v in self.triangles[*t as usize] {
                self.fans[v as usize].retain(|other| other != t);
            }
        }
        let moved = std::mem::take(&mut self.fans[b as usize]);
        for t in &moved {
            for v in &mut self.triangles[*t as usize] {
                if *v == b {
                    *v = a;
                }
            }
        }
        self.fans[a as usize].extend(moved);
        self.quadrics[a as usize] = self.quadrics[a as usize].add(&self.quadrics[b as usize]);
        self.points[a as usize] = point;
        self.versions[a as usize] += 1;
        self.versions[b as usize] += 1;
        for v in self.neighbours(a) {
            self.offer(a, v);
        }
        both.len()
    }

    /// Whether moving `v` to `point` would turn over, or squash, a triangle that the edge to `gone` leaves.
    fn folds(&self, v: u32, gone: u32, point: DVec3) -> bool {
        self.fans[v as usize].iter().map(|t| self.triangles[*t as usize]).filter(|t| !t.contains(&gone)).any(|t| {
            let before = t.map(|w| self.points[w as usize]);
            let after = t.map(|w| if w == v { point } else { self.points[w as usize] });
            let normal = |p: [DVec3; 3]| (p[1] - p[0]).cross(p[2] - p[0]);
            let (old, new) = (normal(before), normal(after));
            let longest = (0..3).map(|i| after[i].distance_squared(after[(i + 1) % 3])).fold(0.0, f64::max);
            new.dot(old) < 0.4 * new.length() * old.length() || new.length() < 0.08 * longest
        })
    }

    fn finish(&self) -> Soup {
        let mut index = vec![u32::MAX; self.points.len()];
        let mut soup = Soup::default();
        for (t, _) in self.triangles.iter().zip(&self.alive).filter(|(_, alive)| **alive) {
            let triangle = t.map(|v| {
                let slot = &mut index[v as usize];
                if *slot == u32::MAX {
                    *slot = soup.points.len() as u32;
                    soup.points.push(self.points[v as usize].as_vec3());
                }
                *slot
            });
            soup.triangles.push(triangle);
        }
        soup
    }
}
