//! The left boot's sole: a light midsole on a dark tread, bending under the ball of the foot.
//!
//! Model space of the file, metres; the tread's bottom lies on y = 0.

use glam::Vec3;

use crate::{
    mesh::{Material, Mesh, Vertex},
    skeleton::{BALL, HEEL, TIP},
    weights,
};

/// Distance to the front, half width outward, half width inward; from heel to tip.
const OUTLINE: [[f32; 3]; 14] = [
    [HEEL.z, 0.010, 0.010],
    [-0.064, 0.022, 0.021],
    [-0.056, 0.031, 0.030],
    [-0.042, 0.036, 0.034],
    [0.000, 0.040, 0.037],
    [0.060, 0.044, 0.038],
    [0.090, 0.047, 0.043],
    [0.110, 0.0485, 0.045],
    [0.130, 0.0485, 0.045],
    [0.150, 0.046, 0.044],
    [0.170, 0.039, 0.040],
    [0.185, 0.029, 0.032],
    [0.194, 0.018, 0.021],
    [TIP.z, 0.008, 0.010],
];

/// Height, inset and colour of the rings of the tread, then of the midsole.
const TREAD: [(f32, f32, f32); 3] = [(0.0, 0.0025, 0.8), (0.003, 0.0, 1.0), (0.010, 0.0, 0.9)];
const MIDSOLE: [(f32, f32, f32); 4] =
    [(0.0095, 0.0025, 0.35), (0.0115, 0.0008, 0.95), (0.021, 0.0018, 1.0), (0.0245, 0.0070, 0.8)];

/// Tread and midsole of both feet, by material.
#[must_use]
pub fn sole() -> Vec<(Material, Mesh)> {
    let mut parts = Vec::new();
    for (material, rings) in [(Material::Undersuit, &TREAD[..]), (Material::Shell, &MIDSOLE[..])] {
        let mesh = slab(rings);
        parts.push((material, mesh.mirrored()));
        parts.push((material, mesh));
    }
    parts
}

/// Rings of vertices from below upward, closed by a strip of quads at both ends.
fn slab(rings: &[(f32, f32, f32)]) -> Mesh {
    let loops = 2 * OUTLINE.len();
    let mut mesh = Mesh::default();
    for (r, &(height, inset, shade)) in rings.iter().enumerate() {
        for k in 0..loops {
            let (position, out) = edge(k, height, inset);
            let tilt = if r == 0 {
                -1.0
            } else if r + 1 == rings.len() {
                1.2
            } else {
                0.0
            };
            let normal = (out + Vec3::Y * tilt).normalize();
            mesh.vertices.push(Vertex {
                position,
                normal,
                color: Vec3::splat(shade),
                influences: weights::boot(position),
            });
        }
    }
    let at = |ring: usize, k: usize| (ring * loops + k % loops) as u32;
    for ring in 1..rings.len() {
        for k in 0..loops {
            let [a, b, c, d] = [at(ring - 1, k), at(ring - 1, k + 1), at(ring, k + 1), at(ring, k)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    cap(&mut mesh, 0, Vec3::NEG_Y);
    cap(&mut mesh, rings.len() - 1, Vec3::Y);
    mesh
}

/// Point `k` of the outline, from the heel along the inner side to the tip and back, and its outward direction.
fn edge(k: usize, height: f32, inset: f32) -> (Vec3, Vec3) {
    let out = (outline(k + 1) - outline(k + 2 * OUTLINE.len() - 1)).cross(Vec3::Y).normalize();
    (outline(k) - out * inset + Vec3::Y * height, out)
}

fn outline(k: usize) -> Vec3 {
    let count = OUTLINE.len();
    let k = k % (2 * count);
    let inner = k < count;
    let [z, outward, inward] = OUTLINE[if inner { k } else { 2 * count - 1 - k }];
    let middle = HEEL.x + (BALL.x - HEEL.x) * ((z - HEEL.z) / (BALL.z - HEEL.z)).clamp(0.0, 1.0);
    Vec3::new(if inner { middle - inward } else { middle + outward }, 0.0, z)
}

/// A flat strip across a ring.
fn cap(mesh: &mut Mesh, ring: usize, normal: Vec3) {
    let loops = 2 * OUTLINE.len();
    let base = mesh.vertices.len() as u32;
    let rows: Vec<Vertex> = mesh.vertices[ring * loops..(ring + 1) * loops].to_vec();
    mesh.vertices.extend(rows.into_iter().map(|v| Vertex { normal, ..v }));
    for k in 0..OUTLINE.len() - 1 {
        let at = |k: usize| base + (k % loops) as u32;
        let [a, b, c, d] = [at(k), at(k + 1), at(loops - 2 - k), at(loops - 1 - k)];
        let quad = [[a, b, c], [a, c, d]];
        mesh.triangles.extend(if normal.y < 0.0 { quad.map(|t| [t[0], t[2], t[1]]) } else { quad });
    }
}
