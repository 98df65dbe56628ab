//! Turns a plate's description into a mesh: a grid laid on the figure's surface, raised, with a bevelled rim and grooves.
//!
//! Model space of the file, metres. A plate is rigid: one joint carries all of it.

use glam::{Vec2, Vec3};

use super::chart::Chart;
use crate::{
    mesh::{Material, Mesh, Vertex},
    shape::field::normal,
    skeleton::index,
};

/// Half the width of a groove.
const GROOVE: f32 = 0.0022;
/// How deep a groove is.
const GROOVE_DEPTH: f32 = 0.0016;
/// How far a rim reaches down into the surface below.
const ROOT: f32 = 0.006;

/// The shape of a plate's outline.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Outline {
    /// Four sides, corners rounded by so many metres.
    Rounded(f32),
    /// An ellipse.
    Oval,
    /// A ring around the limb: the left side meets the right.
    Ring,
}

/// A stripe across the plate in another colour, framed by two grooves.
#[derive(Clone, Copy, Debug)]
pub struct Band {
    /// 0: the stripe is a range of s (around the limb), 1: of t (along it).
    pub axis: usize,
    /// Range, 0..1.
    pub from: f32,
    /// Range, 0..1.
    pub to: f32,
    /// Linear colour, over the material's.
    pub color: Vec3,
}

/// A plate. `s` runs around (degrees), `t` along (metres or degrees), both 0..1 over its outline.
#[derive(Clone, Copy, Debug)]
pub struct Panel {
    /// Name of the joint that carries it.
    pub joint: &'static str,
    /// Where its coordinates lie in space.
    pub chart: Chart,
    /// Angle of the side s = 0, at equal steps of t.
    pub left: &'static [f32],
    /// Angle of the side s = 1, at equal steps of t.
    pub right: &'static [f32],
    /// Second coordinate of the side t = 0, at equal steps of s.
    pub bottom: &'static [f32],
    /// Second coordinate of the side t = 1, at equal steps of s.
    pub top: &'static [f32],
    /// Cells along s and t.
    pub cells: [usize; 2],
    /// Height over the surface.
    pub height: f32,
    /// How much higher the middle is.
    pub dome: f32,
    /// Width of the bevelled rim.
    pub bevel: f32,
    /// Shape of the outline.
    pub outline: Outline,
    /// Panel lines: axis as in [`Band`], and where.
    pub lines: &'static [(usize, f32)],
    /// Painted stripes.
    pub bands: &'static [Band],
    /// Linear colour, over the material's.
    pub color: Vec3,
    /// What it is made of.
    pub material: Material,
    /// Whether the right side has a mirror image of it.
    pub mirrored: bool,
}

/// A row or column of the grid.
#[derive(Clone, Copy)]
struct Stop {
    at: f32,
    groove: bool,
}

struct Point {
    place: Vec3,
    normal: Vec3,
    color: Vec3,
}

/// The mesh of a plate that lies on the surface of `field`.
#[must_use]
pub fn build(panel: &Panel, field: &dyn Fn(Vec3) -> f32) -> Mesh {
    let spans = panel.spans(field);
    let stops = [0, 1].map(|axis| panel.stops(axis, spans[axis]));
    let ring = panel.outline == Outline::Ring;
    let columns = stops[0].len() - usize::from(ring);
    let rows = stops[1].len();
    let mut points = Vec::with_capacity(columns * rows);
    for t in &stops[1] {
        points.extend(stops[0][..columns].iter().map(|s| panel.point(*s, *t, spans, field)));
    }
    let at = |i: usize, j: usize| (j * columns + i % columns) as u32;
    let mut mesh = Mesh::default();
    let carry = [(index(panel.joint), 1.0), (0, 0.0), (0, 0.0), (0, 0.0)];
    let vertex = |position, normal, color| Vertex { position, normal, color, influences: carry };
    mesh.vertices.extend(points.iter().map(|p| vertex(p.place, p.normal, p.color)));
    for j in 0..rows - 1 {
        for i in 0..stops[0].len() - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let across = |p: u32, q: u32| points[p as usize].place.distance_squared(points[q as usize].place);
            if across(a, c) <= across(b, d) {
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                mesh.triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    face_outward(&mut mesh, 0);
    for rim in rims(ring, stops[0].len() - 1, rows - 1, &at) {
        let first = mesh.triangles.len();
        add_rim(panel, &rim, &mut mesh);
        face_outward(&mut mesh, first);
    }
    mesh
}

/// Vertex loops around the grid, each with one neighbour further in.
fn rims(ring: bool, i: usize, j: usize, at: &dyn Fn(usize, usize) -> u32) -> Vec<Vec<(u32, u32)>> {
    let bottom = (0..i).map(|k| (at(k, 0), at(k, 1)));
    if ring {
        let top = (0..i).rev().map(|k| (at(k, j), at(k, j - 1)));
        return vec![bottom.collect(), top.collect()];
    }
    let right = (0..j).map(|k| (at(i, k), at(i - 1, k)));
    let top = (1..=i).rev().map(|k| (at(k, j), at(k, j - 1)));
    let left = (1..=j).rev().map(|k| (at(0, k), at(1, k)));
    vec![bottom.chain(right).chain(top).chain(left).collect()]
}

/// Two strips around a loop: the bevel, and the wall down into the surface.
fn add_rim(panel: &Panel, rim: &[(u32, u32)], mesh: &mut Mesh) {
    let count = rim.len();
    let base = mesh.vertices.len() as u32;
    for k in 0..count {
        let edge = mesh.vertices[rim[k].0 as usize];
        let before = mesh.vertices[rim[(k + count - 1) % count].0 as usize].position;
        let after = mesh.vertices[rim[(k + 1) % count].0 as usize].position;
        let inner = mesh.vertices[rim[k].1 as usize].position;
        let mut out = (after - before).cross(edge.normal).normalize_or(Vec3::X);
        // Corner vertices have an inner neighbour along the rim; the plate's middle decides for them.
        if out.dot(edge.position - inner) < 0.0 {
            out = -out;
        }
        let shoulder = edge.position + (out - 0.75 * edge.normal) * panel.bevel;
        let root = shoulder - edge.normal * (panel.height + panel.dome + ROOT);
        let mut low = edge;
        low.position = shoulder;
        low.normal = (out + 0.45 * edge.normal).normalize();
        mesh.vertices.push(low);
        low.position = root;
        low.normal = out;
        low.color = edge.color * 0.45;
        mesh.vertices.push(low);
    }
    for k in 0..count as u32 {
        let next = (k + 1) % count as u32;
        let (a, b) = (rim[k as usize].0, rim[next as usize].0);
        let (c, d) = (base + 2 * k, base + 2 * next);
        mesh.triangles.extend([[a, c, b], [b, c, d], [c, c + 1, d], [d, c + 1, d + 1]]);
    }
}

/// Turns the triangles from `first` on so that they face the way of their vertices' normals.
fn face_outward(mesh: &mut Mesh, first: usize) {
    let facing = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.vertices[v as usize]);
        (b.position - a.position).cross(c.position - a.position).dot(a.normal + b.normal + c.normal)
    };
    if mesh.triangles[first..].iter().map(facing).sum::<f32>() < 0.0 {
        for triangle in &mut mesh.triangles[first..] {
            triangle.swap(1, 2);
        }
    }
}

impl Panel {
    /// The two coordinates of a point of the plate.
    fn coordinates(&self, s: f32, t: f32, spans: [f32; 2]) -> Vec2 {
        let (mut x, mut y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        match self.outline {
            Outline::Rounded(radius) => {
                let half = Vec2::from_array(spans) * 0.5;
                let flat = (half - Vec2::splat(radius)).max(Vec2::ZERO);
                let beyond = (Vec2::new(x, y).abs() * half - flat).max(Vec2::ZERO);
                if beyond.min_element() > 0.0 {
                    // The corner's square becomes a quarter of a disc.
                    let rounded = flat + beyond * (beyond.max_element() / beyond.length());
                    (x, y) = ((rounded.x / half.x).copysign(x), (rounded.y / half.y).copysign(y));
                }
            }
            Outline::Oval => (x, y) = (x * (1.0 - 0.5 * y * y).sqrt(), y * (1.0 - 0.5 * x * x).sqrt()),
            Outline::Ring => {}
        }
        let (s, t) = (0.5 * x + 0.5, 0.5 * y + 0.5);
        let (left, right) = (along(self.left, t), along(self.right, t));
        let (bottom, top) = (along(self.bottom, s), along(self.top, s));
        Vec2::new(left + (right - left) * s, bottom + (top - bottom) * t)
    }

    /// Width and height in metres through the middle.
    fn spans(&self, field: &dyn Fn(Vec3) -> f32) -> [f32; 2] {
        let place = |s, t| self.chart.surface(self.coordinates(s, t, [1e6; 2]), field);
        let length = |axis: usize| {
            let path: Vec<Vec3> = (0..=8_u8)
                .map(|k| f32::from(k) / 8.0)
                .map(|k| if axis == 0 { place(k, 0.5) } else { place(0.5, k) })
                .collect();
            path.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
        };
        [length(0), length(1)]
    }

    /// Rows or columns: even steps, and three for each groove.
    fn stops(&self, axis: usize, span: f32) -> Vec<Stop> {
        let mut grooves: Vec<f32> = self.lines.iter().filter(|line| line.0 == axis).map(|line| line.1).collect();
        grooves.extend(self.bands.iter().filter(|band| band.axis == axis).flat_map(|band| [band.from, band.to]));
        let half = GROOVE / span;
        let step = 1.0 / self.cells[axis] as f32;
        let clear = |at: f32| grooves.iter().all(|groove| (at - groove).abs() > half + 0.45 * step);
        let mut even: Vec<f32> = vec![0.0, 1.0];
        if let Outline::Rounded(radius) = self.outline {
            let corner = (radius / span).min(0.5);
            even.extend([corner, 1.0 - corner].into_iter().filter(|at| clear(*at)));
        }
        for at in (1..self.cells[axis]).map(|k| k as f32 * step) {
            if clear(at) && even.iter().all(|other| (at - other).abs() > 0.65 * step) {
                even.push(at);
            }
        }
        let mut stops: Vec<Stop> = even.into_iter().map(|at| Stop { at, groove: false }).collect();
        for groove in &grooves {
            stops.extend([-half, 0.0, half].map(|offset| Stop { at: groove + offset, groove: offset == 0.0 }));
        }
        stops.sort_by(|a, b| a.at.total_cmp(&b.at));
        stops
    }

    fn point(&self, s: Stop, t: Stop, spans: [f32; 2], field: &dyn Fn(Vec3) -> f32) -> Point {
        let base = self.chart.surface(self.coordinates(s.at, t.at, spans), field);
        let normal = normal(field, base, 0.006);
        let (x, y) = (2.0 * s.at - 1.0, 2.0 * t.at - 1.0);
        let round = if self.outline == Outline::Ring { 1.0 } else { 1.0 - x * x };
        let mut height = self.height + self.dome * round * (1.0 - y * y);
        let at = [s.at, t.at];
        let band = self.bands.iter().find(|band| (band.from..=band.to).contains(&at[band.axis]));
        let mut color = band.map_or(self.color, |band| band.color);
        if s.groove || t.groove {
            height -= GROOVE_DEPTH;
            color = self.color * 0.12;
        }
        Point { place: base + normal * height, normal, color }
    }
}

/// A smooth curve through equally spaced values, at `t` of 0..1.
fn along(values: &[f32], t: f32) -> f32 {
    let last = values.len() - 1;
    if last == 0 {
        return values[0];
    }
    let position = t.clamp(0.0, 1.0) * last as f32;
    let i = (position as usize).min(last - 1);
    let f = position - i as f32;
    let (a, b) = (values[i], values[i + 1]);
    let before = if i == 0 { 2.0 * a - b } else { values[i - 1] };
    let after = if i + 2 > last { 2.0 * b - a } else { values[i + 2] };
    let (m, n) = (0.5 * (b - before), 0.5 * (after - a));
    let (f2, f3) = (f * f, f * f * f);
    (2.0 * f3 - 3.0 * f2 + 1.0) * a + (f3 - 2.0 * f2 + f) * m + (3.0 * f2 - 2.0 * f3) * b + (f3 - f2) * n
}
