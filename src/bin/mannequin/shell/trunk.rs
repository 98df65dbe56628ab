//! Plates of chest, belly, back and pelvis.

use super::{GRAPHITE, ORANGE, Outline, PLAIN, PLATE, Panel, SHADE, band};
use crate::mesh::Material;

/// A row of the belly.
const BELLY_ROW: Panel = Panel {
    cells: [6, 2],
    outline: Outline::Rounded(0.009),
    color: SHADE,
    lines: &[(0, 0.5)],
    mirrored: false,
    ..PLATE
};

/// Angles from the front toward the left, heights in metres.
pub const PLATES: &[Panel] = &[
    // Breastplate.
    Panel {
        joint: "upperChest",
        left: &[-44.0, -60.0, -64.0],
        right: &[44.0, 60.0, 64.0],
        bottom: &[1.262, 1.240, 1.250, 1.240, 1.262],
        top: &[1.408, 1.442, 1.426, 1.442, 1.408],
        cells: [12, 5],
        height: 0.009,
        outline: Outline::Rounded(0.026),
        lines: &[(0, 0.5), (1, 0.62)],
        mirrored: false,
        ..PLATE
    },
    Panel {
        joint: "upperChest",
        left: &[-7.5],
        right: &[7.5],
        bottom: &[1.318],
        top: &[1.348],
        cells: [6, 6],
        height: 0.0125,
        bevel: 0.002,
        outline: Outline::Oval,
        color: ORANGE,
        mirrored: false,
        ..PLATE
    },
    Panel {
        joint: "upperChest",
        left: &[-4.6],
        right: &[4.6],
        bottom: &[1.324],
        top: &[1.342],
        cells: [4, 4],
        height: 0.0145,
        bevel: 0.001,
        outline: Outline::Oval,
        material: Material::Glow,
        mirrored: false,
        ..PLATE
    },
    // Belly, three rows.
    Panel {
        joint: "chest",
        left: &[-38.0, -44.0],
        right: &[38.0, 44.0],
        bottom: &[1.192, 1.180, 1.192],
        top: &[1.232, 1.226, 1.232],
        ..BELLY_ROW
    },
    Panel {
        joint: "spine",
        left: &[-36.0, -38.0],
        right: &[36.0, 38.0],
        bottom: &[1.128, 1.114, 1.128],
        top: &[1.176, 1.164, 1.176],
        ..BELLY_ROW
    },
    Panel {
        joint: "spine",
        left: &[-31.0, -36.0],
        right: &[31.0, 36.0],
        bottom: &[1.066, 1.052, 1.066],
        top: &[1.112, 1.098, 1.112],
        ..BELLY_ROW
    },
    // Back, and two rows below it.
    Panel {
        joint: "upperChest",
        left: &[136.0, 122.0, 118.0],
        right: &[224.0, 238.0, 242.0],
        bottom: &[1.244, 1.218, 1.208, 1.218, 1.244],
        top: &[1.412, 1.452, 1.458, 1.452, 1.412],
        cells: [8, 6],
        height: 0.009,
        outline: Outline::Rounded(0.026),
        lines: &[(1, 0.62)],
        bands: &[band(0, 0.455, 0.545)],
        mirrored: false,
        ..PLATE
    },
    // Pack on the back, with two lights.
    Panel {
        joint: "upperChest",
        left: &[163.0, 158.0, 160.0],
        right: &[197.0, 202.0, 200.0],
        bottom: &[1.282, 1.270, 1.282],
        top: &[1.408, 1.414, 1.408],
        cells: [5, 4],
        height: 0.026,
        dome: 0.006,
        bevel: 0.006,
        outline: Outline::Rounded(0.014),
        lines: &[(1, 0.26)],
        bands: &[band(0, 0.40, 0.60)],
        color: SHADE,
        mirrored: false,
        ..PLATE
    },
    Panel {
        joint: "upperChest",
        left: &[168.0, 166.0],
        right: &[172.0, 171.0],
        bottom: &[1.335],
        top: &[1.385],
        cells: [2, 4],
        height: 0.0315,
        bevel: 0.001,
        outline: Outline::Oval,
        material: Material::Glow,
        ..PLATE
    },
    Panel {
        joint: "chest",
        left: &[152.0, 146.0],
        right: &[208.0, 214.0],
        bottom: &[1.150, 1.138, 1.150],
        top: &[1.205, 1.188, 1.205],
        cells: [4, 2],
        outline: Outline::Rounded(0.011),
        color: SHADE,
        mirrored: false,
        ..PLATE
    },
    Panel {
        joint: "spine",
        left: &[152.0, 152.0],
        right: &[208.0, 208.0],
        bottom: &[1.066, 1.054, 1.066],
        top: &[1.134, 1.122, 1.134],
        cells: [4, 2],
        outline: Outline::Rounded(0.011),
        color: SHADE,
        mirrored: false,
        ..PLATE
    },
    // Collar.
    Panel {
        joint: "neck",
        left: &[0.0],
        right: &[360.0],
        bottom: &[1.494, 1.526, 1.536, 1.526, 1.494],
        top: &[1.508, 1.542, 1.554, 1.542, 1.508],
        cells: [14, 1],
        height: 0.005,
        outline: Outline::Ring,
        color: ORANGE,
        mirrored: false,
        ..PLATE
    },
    // Belt and buckle.
    Panel {
        left: &[0.0],
        right: &[360.0],
        bottom: &[0.988],
        top: &[1.022],
        cells: [22, 1],
        height: 0.006,
        outline: Outline::Ring,
        color: GRAPHITE,
        mirrored: false,
        ..PLATE
    },
    Panel {
        left: &[-15.0],
        right: &[15.0],
        bottom: &[0.986],
        top: &[1.026],
        cells: [4, 3],
        height: 0.011,
        color: PLAIN,
        bands: &[band(0, 0.38, 0.62)],
        mirrored: false,
        ..PLATE
    },
    // Groin, hips, seat.
    Panel {
        left: &[-11.0, -17.0, -24.0],
        right: &[11.0, 17.0, 24.0],
        bottom: &[0.888, 0.876, 0.888],
        top: &[0.980],
        cells: [4, 4],
        height: 0.006,
        color: SHADE,
        mirrored: false,
        ..PLATE
    },
    Panel {
        left: &[74.0, 58.0, 50.0],
        right: &[112.0, 128.0, 134.0],
        bottom: &[0.934, 0.920, 0.928],
        top: &[0.981],
        cells: [6, 4],
        height: 0.008,
        outline: Outline::Rounded(0.020),
        ..PLATE
    },
    Panel {
        left: &[164.0, 150.0, 144.0],
        right: &[196.0, 210.0, 216.0],
        bottom: &[0.930, 0.916, 0.930],
        top: &[0.981],
        cells: [6, 3],
        color: SHADE,
        mirrored: false,
        ..PLATE
    },
];
