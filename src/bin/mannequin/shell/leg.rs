//! Plates of thigh, knee and shank, left leg.

use super::{GRAPHITE, ORANGE, Outline, PLATE, Panel, band, chart::LEG};

/// Angles from the front outward, heights in metres.
pub const PLATES: &[Panel] = &[
    Panel {
        joint: "leftUpperLeg",
        chart: LEG,
        left: &[-40.0, -58.0, -48.0],
        right: &[128.0, 146.0, 140.0],
        bottom: &[0.612, 0.578, 0.580, 0.606, 0.640],
        top: &[0.735, 0.790, 0.826, 0.836, 0.810],
        cells: [9, 5],
        height: 0.009,
        outline: Outline::Rounded(0.024),
        bands: &[band(0, 0.66, 0.75)],
        ..PLATE
    },
    Panel {
        joint: "leftLowerLeg",
        chart: LEG,
        left: &[-44.0, -58.0, -44.0],
        right: &[44.0, 58.0, 44.0],
        bottom: &[0.466, 0.453, 0.466],
        top: &[0.534, 0.544, 0.534],
        cells: [5, 4],
        height: 0.009,
        dome: 0.007,
        outline: Outline::Rounded(0.024),
        color: GRAPHITE,
        bands: &[super::Band { axis: 1, from: 0.30, to: 0.70, color: ORANGE }],
        ..PLATE
    },
    Panel {
        joint: "leftLowerLeg",
        chart: LEG,
        left: &[-82.0, -92.0, -62.0],
        right: &[82.0, 96.0, 66.0],
        bottom: &[0.186, 0.166, 0.160, 0.166, 0.186],
        top: &[0.410, 0.436, 0.444, 0.436, 0.410],
        cells: [7, 4],
        height: 0.009,
        dome: 0.003,
        outline: Outline::Rounded(0.022),
        lines: &[(1, 0.80)],
        bands: &[band(1, 0.08, 0.15)],
        ..PLATE
    },
    Panel {
        joint: "leftLowerLeg",
        chart: LEG,
        left: &[140.0, 122.0, 126.0],
        right: &[220.0, 238.0, 234.0],
        bottom: &[0.226, 0.206, 0.226],
        top: &[0.400, 0.418, 0.400],
        cells: [4, 4],
        height: 0.008,
        outline: Outline::Rounded(0.024),
        lines: &[(0, 0.5)],
        ..PLATE
    },
];
