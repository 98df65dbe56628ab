//! Plates of shoulder, arm and hand, left side.

use super::{GRAPHITE, ORANGE, Outline, PLATE, Panel, SHADE, band, chart::ARM};

/// Angles from above toward the front, distances from the middle in metres.
pub const PLATES: &[Panel] = &[
    // Yoke between neck and shoulder.
    Panel {
        joint: "leftShoulder",
        chart: ARM,
        left: &[-62.0, -50.0],
        right: &[58.0, 44.0],
        bottom: &[0.096, 0.080, 0.074, 0.080, 0.096],
        top: &[0.132, 0.138, 0.138, 0.138, 0.132],
        cells: [6, 3],
        height: 0.007,
        outline: Outline::Rounded(0.016),
        color: SHADE,
        ..PLATE
    },
    Panel {
        joint: "leftUpperArm",
        chart: ARM,
        left: &[-128.0, -138.0, -118.0],
        right: &[62.0, 74.0, 58.0],
        bottom: &[0.330, 0.308, 0.304, 0.308, 0.330],
        top: &[0.424, 0.440, 0.436, 0.432, 0.410],
        cells: [7, 3],
        height: 0.008,
        outline: Outline::Rounded(0.018),
        ..PLATE
    },
    // Elbow.
    Panel {
        joint: "leftLowerArm",
        chart: ARM,
        left: &[-128.0],
        right: &[-44.0],
        bottom: &[0.452],
        top: &[0.512],
        cells: [4, 4],
        height: 0.007,
        dome: 0.006,
        outline: Outline::Oval,
        color: GRAPHITE,
        ..PLATE
    },
    // Forearm.
    Panel {
        joint: "leftLowerArm",
        chart: ARM,
        left: &[-152.0, -152.0, -150.0],
        right: &[118.0, 140.0, 150.0],
        bottom: &[0.548, 0.530, 0.532, 0.544, 0.566],
        top: &[0.712],
        cells: [9, 4],
        height: 0.0085,
        outline: Outline::Rounded(0.016),
        bands: &[band(1, 0.74, 0.86)],
        ..PLATE
    },
];

/// Plates on the ball of the shoulder, same coordinates.
pub const SHOULDER: &[Panel] = &[Panel {
    joint: "leftUpperArm",
    chart: ARM,
    left: &[-58.0, -84.0, -76.0],
    right: &[58.0, 84.0, 76.0],
    bottom: &[0.184, 0.166, 0.152, 0.166, 0.184],
    top: &[0.266, 0.288, 0.296, 0.288, 0.266],
    cells: [8, 4],
    height: 0.009,
    dome: 0.002,
    outline: Outline::Rounded(0.026),
    bands: &[band(1, 0.70, 0.84)],
    ..PLATE
}];

/// Plates on the glove, same coordinates.
pub const GLOVE: &[Panel] = &[
    // A hoop around the wrist: it turns with the hand and hides how skin thins when the hand twists.
    Panel {
        joint: "leftHand",
        chart: ARM,
        left: &[0.0],
        right: &[360.0],
        bottom: &[0.741],
        top: &[0.758],
        cells: [12, 1],
        height: 0.003,
        bevel: 0.002,
        outline: Outline::Ring,
        color: GRAPHITE,
        ..PLATE
    },
    Panel {
        joint: "leftHand",
        chart: ARM,
        left: &[-58.0, -66.0],
        right: &[50.0, 64.0],
        bottom: &[0.782, 0.776, 0.782],
        top: &[0.830, 0.838, 0.834],
        cells: [4, 3],
        height: 0.005,
        bevel: 0.002,
        outline: Outline::Rounded(0.010),
        color: SHADE,
        bands: &[super::Band { axis: 1, from: 0.10, to: 0.26, color: ORANGE }],
        ..PLATE
    },
];
