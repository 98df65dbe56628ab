//! The soft parts: undersuit, gloves and boot inners, meshed from their fields.
//!
//! Model space of the file, metres.

use glam::Vec3;

use crate::{
    mesh::{Influences, Mesh, Vertex},
    shape::{body, boot, field::normal, hand},
    simplify::{Detail, simplify},
    skeleton::{JOINTS, index},
    surface::{Grid, settle, surface},
    weights,
};

/// Undersuit, gloves and boot inners of both sides.
#[must_use]
pub fn soft() -> Mesh {
    let mut mesh = undersuit().both_halves();
    for part in [glove(), boot_inner()] {
        mesh.append(&part);
        mesh.append(&part.mirrored());
    }
    mesh
}

fn undersuit() -> Mesh {
    // Below the boot's collar, beyond the glove's cuff and inside the helmet nothing is seen: cut off there.
    let field = |p: Vec3| {
        let wrist = p.x.abs() - 0.765;
        let ankle = 0.085 - p.y;
        body::undersuit(p).max(wrist).max(ankle)
    };
    let grid = Grid { low: Vec3::new(0.0, 0.07, -0.16), high: Vec3::new(0.79, 1.80, 0.16), cell: 0.007, half: true };
    let bends = ["leftLowerArm", "leftLowerLeg", "leftUpperLeg", "leftUpperArm", "leftHand", "leftFoot"]
        .map(|name| JOINTS[index(name)].position);
    let nearest = move |p: Vec3| bends.iter().map(|b| b.distance(p)).fold(f32::MAX, f32::min);
    let detail = Detail {
        triangles: 1420,
        weight: &|p| if nearest(p) < 0.10 { 3.0 } else { 1.0 },
        edge: &|p| if nearest(p) < 0.09 { 0.036 } else { 0.110 },
    };
    part(&field, &grid, &detail, &weights::undersuit)
}

fn glove() -> Mesh {
    let fingers = hand::fingers();
    let field = |p: Vec3| hand::glove(p, &fingers);
    let grid = Grid { low: Vec3::new(0.67, 1.37, -0.08), high: Vec3::new(0.96, 1.45, 0.10), cell: 0.0022, half: false };
    let detail = Detail { triangles: 680, weight: &|_| 1.0, edge: &|p| if p.x > 0.83 { 0.022 } else { 0.040 } };
    part(&field, &grid, &detail, &|p| weights::glove(p, &fingers))
}

fn boot_inner() -> Mesh {
    let field = |p: Vec3| boot::boot(p);
    let grid = Grid { low: Vec3::new(0.03, -0.01, -0.08), high: Vec3::new(0.15, 0.17, 0.21), cell: 0.005, half: false };
    let detail =
        Detail { triangles: 280, weight: &|_| 1.0, edge: &|p| if (p.z - 0.118).abs() < 0.034 { 0.020 } else { 0.060 } };
    part(&field, &grid, &detail, &weights::boot)
}

fn part(field: &dyn Fn(Vec3) -> f32, grid: &Grid, detail: &Detail, carry: &dyn Fn(Vec3) -> Influences) -> Mesh {
    let soup = simplify(&surface(field, grid), detail);
    let vertices = soup.points.iter().map(|point| {
        let mut position = settle(field, *point, 0.5 * grid.cell);
        if grid.half && point.x == 0.0 {
            position.x = 0.0;
        }
        Vertex {
            position,
            normal: normal(field, position, 0.4 * grid.cell),
            color: Vec3::ONE,
            influences: carry(position),
        }
    });
    Mesh { vertices: vertices.collect(), triangles: soup.triangles }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::loose_edges;

    #[test]
    fn every_soft_part_is_closed() {
        for (name, part) in [("undersuit", undersuit().both_halves()), ("glove", glove()), ("boot", boot_inner())] {
            let loose = loose_edges(&part.triangles);
            assert_eq!(loose, 0, "{name}: {loose} of {} edges have one side only", part.triangles.len() * 3 / 2);
        }
    }
}
