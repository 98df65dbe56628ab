//! The hard parts: plates over the undersuit, helmet, visor, eyes and boots.
//!
//! Model space of the file, metres; the left half and the middle, the right mirrors them.

mod arm;
mod chart;
mod foot;
mod head;
mod leg;
mod panel;
mod sole;
mod trunk;

use glam::Vec3;

use crate::{
    mesh::{Material, Mesh},
    shape::{body, boot, hand, helmet},
};
use panel::{Band, Outline, Panel, build};

/// Accent paint.
const ORANGE: Vec3 = Vec3::new(1.0, 0.30, 0.035);
/// The shell's own colour.
const PLAIN: Vec3 = Vec3::ONE;
/// A shade darker, for small plates.
const SHADE: Vec3 = Vec3::new(0.72, 0.73, 0.75);
/// Dark hard parts: belt, collar, hubs.
const GRAPHITE: Vec3 = Vec3::new(0.10, 0.105, 0.12);

/// What most plates share; the tables override the rest.
const PLATE: Panel = Panel {
    joint: "hips",
    chart: chart::TRUNK,
    left: &[0.0],
    right: &[0.0],
    bottom: &[0.0],
    top: &[0.0],
    cells: [8, 6],
    height: 0.007,
    dome: 0.0,
    bevel: 0.0030,
    outline: Outline::Rounded(0.012),
    lines: &[],
    bands: &[],
    color: PLAIN,
    material: Material::Shell,
    mirrored: true,
};

const fn band(axis: usize, from: f32, to: f32) -> Band {
    Band { axis, from, to, color: ORANGE }
}

/// All hard parts, by material.
#[must_use]
pub fn hard() -> Vec<(Material, Mesh)> {
    let fingers = hand::fingers();
    let glove = |p: Vec3| hand::glove(p, &fingers);
    let groups: [(&[Panel], &dyn Fn(Vec3) -> f32); 7] = [
        (trunk::PLATES, &body::undersuit),
        (leg::PLATES, &body::undersuit),
        (arm::PLATES, &body::undersuit),
        (arm::SHOULDER, &body::shoulder),
        (arm::GLOVE, &glove),
        (head::PLATES, &helmet::helmet),
        (foot::PLATES, &boot::boot),
    ];
    let mut parts = sole::sole();
    for (panels, field) in groups {
        for panel in panels {
            let mesh = build(panel, field);
            if panel.mirrored {
                parts.push((panel.material, mesh.mirrored()));
            }
            parts.push((panel.material, mesh));
        }
    }
    parts
}
