//! Ambient occlusion, baked into the vertex colours: how much of the sky each vertex sees in the rest pose.
//!
//! Model space of the file, metres. The figure is even in x, so the right half reads the left one's values.

use glam::Vec3;

use crate::{
    mesh::{Material, Mesh},
    turn::unit,
};

/// Rays per vertex.
const RAYS: u32 = 96;
/// Beyond this distance nothing shades.
const REACH: f32 = 0.22;
/// What is left of the colour where no ray gets out.
const DARKEST: f32 = 0.34;

/// Multiplies every vertex colour by what the vertex sees. What glows stays as it is.
pub fn bake(meshes: &mut [(Material, Mesh)]) {
    let tree = Tree::new(meshes);
    for (material, mesh) in meshes.iter_mut().filter(|(material, _)| *material != Material::Glow) {
        // Fabric starts above the plates that lie on it: they would black out the triangles that reach under them.
        let lift = if *material == Material::Undersuit { 0.014 } else { 0.002 };
        for vertex in &mut mesh.vertices {
            let mirror = Vec3::new(if vertex.position.x < 0.0 { -1.0 } else { 1.0 }, 1.0, 1.0);
            let open = tree.open(vertex.position * mirror, vertex.normal * mirror, lift);
            vertex.color *= DARKEST + (1.0 - DARKEST) * open;
        }
    }
}

/// Triangles in a tree of boxes.
struct Tree {
    triangles: Vec<[Vec3; 3]>,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    low: Vec3,
    high: Vec3,
    /// First triangle of a leaf, or the second child; the first child follows its parent.
    first: usize,
    /// How many triangles a leaf has; 0 for a branch.
    count: usize,
}

impl Tree {
    fn new(meshes: &[(Material, Mesh)]) -> Self {
        let corners = |mesh: &Mesh, t: &[u32; 3]| t.map(|v| mesh.vertices[v as usize].position);
        let mut triangles: Vec<[Vec3; 3]> =
            meshes.iter().flat_map(|(_, mesh)| mesh.triangles.iter().map(|t| corners(mesh, t))).collect();
        let mut nodes = Vec::new();
        let count = triangles.len();
        grow(&mut triangles, 0, count, &mut nodes);
        Self { triangles, nodes }
    }

    /// Share of the sky above `normal` that no triangle hides, nearer ones hiding more.
    fn open(&self, position: Vec3, normal: Vec3, lift: f32) -> f32 {
        let (right, ahead) = normal.any_orthonormal_pair();
        let origin = position + normal * lift;
        let hidden: f32 = (0..RAYS)
            .map(|k| {
                // Golden-angle spiral on the disc: directions weighted by their cosine.
                let square = (k as f32 + 0.5) / RAYS as f32;
                let (cos, sin) = unit(k as f32 * 137.507_76);
                let toward = (right * cos + ahead * sin) * square.sqrt() + normal * (1.0 - square).sqrt();
                1.0 - self.nearest(origin, toward) / REACH
            })
            .sum();
        1.0 - hidden / RAYS as f32
    }

    /// Distance along a ray to the first triangle, at most [`REACH`].
    fn nearest(&self, origin: Vec3, toward: Vec3) -> f32 {
        let mut best = REACH;
        let mut stack = vec![0];
        while let Some(i) = stack.pop() {
            let node = &self.nodes[i];
            let (a, b) = ((node.low - origin) / toward, (node.high - origin) / toward);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            if leave < enter.max(0.0) || enter > best {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, i + 1]);
            }
            for triangle in &self.triangles[node.first..node.first + node.count] {
                best = best.min(hit(triangle, origin, toward));
            }
        }
        best
    }
}

/// Sorts `triangles[from..to]` into boxes of at most four.
fn grow(triangles: &mut [[Vec3; 3]], from: usize, to: usize, nodes: &mut Vec<Node>) {
    let points = triangles[from..to].iter().flatten();
    let low = points.clone().fold(Vec3::MAX, |a, b| a.min(*b));
    let high = points.fold(Vec3::MIN, |a, b| a.max(*b));
    let here = nodes.len();
    nodes.push(Node { low, high, first: from, count: to - from });
    if to - from <= 4 {
        return;
    }
    let size = high - low;
    let axis = if size.x >= size.max_element() {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    triangles[from..to].sort_by(|a, b| {
        let middle = |t: &[Vec3; 3]| t[0][axis] + t[1][axis] + t[2][axis];
        middle(a).total_cmp(&middle(b))
    });
    let half = usize::midpoint(from, to);
    grow(triangles, from, half, nodes);
    nodes[here].first = nodes.len();
    nodes[here].count = 0;
    grow(triangles, half, to, nodes);
}

/// Distance along a ray to a triangle, seen from either side; infinite if it misses.
fn hit(triangle: &[Vec3; 3], origin: Vec3, toward: Vec3) -> f32 {
    let [a, b, c] = *triangle;
    let (u, v) = (b - a, c - a);
    let p = toward.cross(v);
    let area = u.dot(p);
    if area.abs() < 1e-12 {
        return f32::MAX;
    }
    let from = origin - a;
    let s = from.dot(p) / area;
    let q = from.cross(u);
    let t = toward.dot(q) / area;
    let distance = v.dot(q) / area;
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 && distance > 0.0 { distance } else { f32::MAX }
}
