//! A tube with joints along it, and how it bends: what shaders and pictures are tested on.

use bevy::{
    asset::RenderAssetUsages,
    math::{Affine3A, ops},
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    prelude::*,
};

/// A tube along +Y, 2 m long, whose joints are evenly spaced; the engine's own joint attributes, up to four per vertex.
pub(crate) fn tube(rings: usize, sides: usize, joint_count: usize) -> Mesh {
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let (mut positions, mut normals, mut uvs, mut slots, mut weights) = (vec![], vec![], vec![], vec![], vec![]);
    for ring in 0..=rings {
        let along = ring as f32 / rings as f32;
        let at = along * (joint_count - 1) as f32;
        let low = (at.floor() as usize).min(joint_count - 2);
        let part = at - low as f32;
        let first = low.saturating_sub(1);
        let last = (low + 2).min(joint_count - 1);
        let shares = [0.2 * (1.0 - part), 0.8 * (1.0 - part) + 0.1, 0.8 * part + 0.1, 0.2 * part];
        let total: f32 = shares.iter().sum();
        for side in 0..=sides {
            let angle = side as f32 / sides as f32 * core::f32::consts::TAU;
            let out = Vec3::new(ops::cos(angle), 0.1, ops::sin(angle)).normalize();
            let radius = 0.25 * (1.0 - 0.6 * along);
            positions.push([out.x * radius, along * 2.0, out.z * radius]);
            normals.push(out.to_array());
            uvs.push([side as f32 / sides as f32, along]);
            slots.push([first, low, low + 1, last].map(|slot| slot as u16));
            weights.push(shares.map(|share| share / total));
        }
    }
    let mut indices = vec![];
    for ring in 0..rings {
        for side in 0..sides {
            let i = (ring * (sides + 1) + side) as u32;
            let above = i + sides as u32 + 1;
            indices.extend([i, above, i + 1, i + 1, above, above + 1]);
        }
    }
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(slots));
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    mesh.insert_indices(Indices::U32(indices));
    mesh
}

/// A palette that bends, twists and slightly swells a [`tube`]; `time` in seconds.
pub(crate) fn tube_palette(joint_count: usize, time: f32, phase: f32) -> Vec<Affine3A> {
    let step = 2.0 / (joint_count - 1) as f32;
    let mut model_from_joint = Affine3A::IDENTITY;
    (0..joint_count)
        .map(|joint| {
            let bend =
                2.2 / joint_count as f32 * ops::sin(time * 2.0 + phase + joint as f32 * 2.8 / joint_count as f32);
            let twist = 1.2 / joint_count as f32 * ops::cos(time + phase);
            let swell = Vec3::new(1.0 + 0.2 / joint_count as f32 * ops::sin(phase + joint as f32), 1.0, 1.0);
            let turn = Quat::from_euler(EulerRot::XYZ, bend * ops::cos(phase), twist, bend * ops::sin(phase));
            let place = if joint == 0 { Vec3::ZERO } else { Vec3::Y * step };
            model_from_joint *= Affine3A::from_scale_rotation_translation(swell, turn, place);
            model_from_joint * Affine3A::from_translation(Vec3::Y * (-step * joint as f32))
        })
        .collect()
}
