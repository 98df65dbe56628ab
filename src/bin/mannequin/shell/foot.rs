//! Plates of the left boot.

use super::{
    GRAPHITE, Outline, PLATE, Panel, SHADE, band,
    chart::{FOOT, LEG, TOES},
};

/// See the charts for the coordinates.
pub const PLATES: &[Panel] = &[
    // Heel and flanks.
    Panel {
        joint: "leftFoot",
        chart: LEG,
        left: &[26.0, 33.0],
        right: &[334.0, 327.0],
        bottom: &[0.021],
        top: &[0.046, 0.060, 0.086, 0.112, 0.086, 0.060, 0.046],
        cells: [12, 3],
        height: 0.0055,
        outline: Outline::Rounded(0.010),
        bands: &[band(0, 0.465, 0.535)],
        ..PLATE
    },
    // Instep.
    Panel {
        joint: "leftFoot",
        chart: FOOT,
        left: &[-42.0, -38.0],
        right: &[42.0, 38.0],
        bottom: &[0.050, 0.054, 0.050],
        top: &[0.092, 0.096, 0.092],
        cells: [4, 3],
        height: 0.006,
        lines: &[(1, 0.36), (1, 0.68)],
        color: SHADE,
        ..PLATE
    },
    // Cuff.
    Panel {
        joint: "leftLowerLeg",
        chart: LEG,
        left: &[0.0],
        right: &[360.0],
        bottom: &[0.126],
        top: &[0.148],
        cells: [14, 1],
        height: 0.0035,
        outline: Outline::Ring,
        color: GRAPHITE,
        ..PLATE
    },
    // Toe cap.
    Panel {
        joint: "leftToes",
        chart: TOES,
        left: &[2.0],
        right: &[76.0, 82.0, 76.0],
        bottom: &[-70.0],
        top: &[70.0],
        cells: [5, 7],
        height: 0.005,
        outline: Outline::Rounded(0.010),
        color: SHADE,
        ..PLATE
    },
];
