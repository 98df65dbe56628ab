//! Morph targets: which there are, and how far each moves a point of the rest pose.
//!
//! Model space of the file, metres.

use glam::Vec3;

use crate::mesh::{Material, Vertex};

/// How many morph targets the mesh has.
pub const MORPHS: usize = 2;

/// Names in the order of the targets, as written to the mesh's `targetNames`.
pub const NAMES: [&str; MORPHS] = ["blink", "breath"];

/// How far target `morph` moves a vertex.
#[must_use]
pub fn offset(morph: usize, material: Material, vertex: &Vertex) -> Vec3 {
    if morph == 0 { blink(material, vertex.position) } else { breath(vertex.position) }
}

/// Height of the line on which the eyes close.
const EYES: f32 = 1.640;

/// The eyes shut to a slit.
fn blink(material: Material, p: Vec3) -> Vec3 {
    let eye = material == Material::Glow && p.y > 1.55;
    if eye { Vec3::new(0.0, 0.9 * (EYES - p.y), 0.0) } else { Vec3::ZERO }
}

/// Chest and belly swell: 11 mm in front, less at the sides and behind.
fn breath(p: Vec3) -> Vec3 {
    let bell = |value: f32, center: f32, width: f32| {
        let t = 1.0 - ((value - center) / width) * ((value - center) / width);
        t.max(0.0) * t.max(0.0)
    };
    let rise = bell(p.y, 1.290, 0.170) + 0.55 * bell(p.y, 1.110, 0.130);
    let inside = bell(p.x, 0.0, 0.260);
    let front = 0.5 + 0.5 * (p.z / 0.08).clamp(-0.6, 1.0);
    let lift = Vec3::new(0.004 * (p.x / 0.15).clamp(-1.0, 1.0), 0.003 * bell(p.y, 1.330, 0.150), 0.011 * front);
    lift * rise.min(1.0) * inside
}
