//! The glove: wrist, palm and five fingers of the left hand, palm down.

use glam::Vec3;

use super::field::{blend, bone, slab};
use crate::skeleton::{JOINTS, index};

/// One finger: its three joints, where its tip ends, and the radius at each.
pub struct Finger {
    /// Joint indices from the knuckle out.
    pub joints: [usize; 3],
    /// Joint positions, then the tip's centre.
    pub points: [Vec3; 4],
    /// Radius in metres at each point.
    pub radii: [f32; 4],
}

/// Thumb, index, middle, ring and little finger of the left hand.
#[must_use]
pub fn fingers() -> [Finger; 5] {
    [
        finger("Thumb", ["Metacarpal", "Proximal", "Distal"], 0.024, [0.0165, 0.0130, 0.0112, 0.0090]),
        finger("Index", PHALANGES, 0.018, [0.0110, 0.0096, 0.0086, 0.0072]),
        finger("Middle", PHALANGES, 0.019, [0.0112, 0.0098, 0.0088, 0.0074]),
        finger("Ring", PHALANGES, 0.018, [0.0108, 0.0093, 0.0083, 0.0070]),
        finger("Little", PHALANGES, 0.015, [0.0098, 0.0083, 0.0074, 0.0062]),
    ]
}

const PHALANGES: [&str; 3] = ["Proximal", "Intermediate", "Distal"];

fn finger(name: &str, parts: [&str; 3], beyond: f32, radii: [f32; 4]) -> Finger {
    let joints = parts.map(|part| index(&format!("left{name}{part}")));
    let [a, b, c] = joints.map(|joint| JOINTS[joint].position);
    Finger { joints, points: [a, b, c, c + (c - b).normalize() * beyond], radii }
}

/// Metres from `p` to the left glove, negative inside.
#[must_use]
pub fn glove(p: Vec3, fingers: &[Finger; 5]) -> f32 {
    let palm = slab(p, Vec3::new(0.802, 1.413, -0.012), Vec3::new(0.043, 0.0140, 0.041), 0.0135);
    let heel = bone(p, Vec3::new(0.778, 1.409, 0.008), Vec3::new(0.815, 1.405, 0.022), 0.018, 0.013);
    let edge = bone(p, Vec3::new(0.775, 1.410, -0.036), Vec3::new(0.825, 1.408, -0.045), 0.016, 0.012);
    let cuff = slab(p, Vec3::new(0.735, 1.415, -0.014), Vec3::new(0.050, 0.0245, 0.0325), 0.0240);
    let mut hand = blend(blend(palm, heel, 0.016), edge, 0.016);
    hand = blend(hand, cuff, 0.030);
    for (i, finger) in fingers.iter().enumerate() {
        let part = |k: usize| bone(p, finger.points[k], finger.points[k + 1], finger.radii[k], finger.radii[k + 1]);
        let chain = blend(blend(part(0), part(1), 0.004), part(2), 0.004);
        hand = blend(hand, chain, if i == 0 { 0.014 } else { 0.007 });
    }
    hand
}
