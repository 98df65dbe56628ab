//! Helmet, visor, eyes and the hubs over the ears.

use glam::Vec3;

use super::{
    GRAPHITE, ORANGE, Outline, PLATE, Panel, SHADE, band,
    chart::{EAR, HEAD},
};
use crate::mesh::Material;

/// Angles up from straight ahead and to the left.
pub const PLATES: &[Panel] = &[
    Panel {
        joint: "head",
        chart: HEAD,
        left: &[-27.0, -31.0, -27.0],
        right: &[20.0, 29.0, 20.0],
        bottom: &[-62.0],
        top: &[62.0],
        cells: [5, 10],
        height: 0.003,
        bevel: 0.002,
        outline: Outline::Rounded(0.020),
        color: Vec3::ONE,
        material: Material::Visor,
        mirrored: false,
        ..PLATE
    },
    Panel {
        joint: "leftEye",
        chart: HEAD,
        left: &[-13.5],
        right: &[-2.5],
        bottom: &[16.0],
        top: &[23.5],
        cells: [3, 4],
        height: 0.0048,
        bevel: 0.0006,
        outline: Outline::Oval,
        color: Vec3::ONE,
        material: Material::Glow,
        ..PLATE
    },
    // Crown, from brow to nape.
    Panel {
        joint: "head",
        chart: HEAD,
        left: &[24.0, 34.0, 24.0],
        right: &[206.0, 214.0, 206.0],
        bottom: &[-60.0],
        top: &[60.0],
        cells: [11, 7],
        height: 0.007,
        outline: Outline::Rounded(0.016),
        lines: &[(0, 0.62), (1, 0.28), (1, 0.72)],
        bands: &[band(1, 0.46, 0.54)],
        mirrored: false,
        ..PLATE
    },
    // Jaw.
    Panel {
        joint: "head",
        chart: HEAD,
        left: &[-66.0, -78.0, -66.0],
        right: &[-32.0, -36.0, -32.0],
        bottom: &[-60.0],
        top: &[60.0],
        cells: [3, 9],
        height: 0.007,
        outline: Outline::Rounded(0.016),
        lines: &[(1, 0.34), (1, 0.66)],
        mirrored: false,
        ..PLATE
    },
    // Hubs.
    Panel {
        joint: "head",
        chart: EAR,
        left: &[-24.0],
        right: &[24.0],
        bottom: &[-25.0],
        top: &[25.0],
        cells: [5, 5],
        height: 0.006,
        outline: Outline::Oval,
        color: SHADE,
        ..PLATE
    },
    Panel {
        joint: "head",
        chart: EAR,
        left: &[-16.0],
        right: &[16.0],
        bottom: &[-17.0],
        top: &[17.0],
        cells: [4, 4],
        height: 0.011,
        outline: Outline::Oval,
        color: ORANGE,
        ..PLATE
    },
    Panel {
        joint: "head",
        chart: EAR,
        left: &[-10.0],
        right: &[10.0],
        bottom: &[-11.0],
        top: &[11.0],
        cells: [3, 3],
        height: 0.014,
        bevel: 0.002,
        outline: Outline::Oval,
        color: GRAPHITE,
        ..PLATE
    },
];
