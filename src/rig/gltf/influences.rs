//! Joint indices and weights of a primitive: the four largest of each vertex, summing to one.

use gltf::json::{accessor::Type, mesh::Semantic};

use super::{error::RigError, meshes::Place};
use crate::{
    anim::{matrix::JointMatrix, skeleton::JointIndex, skin::Skin},
    rig::Influences,
};

/// Sums farther from one than this are worth a note; rounding of 8-bit weights stays below.
const UNEVEN: f32 = 0.02;

/// Reads `count` vertices; those without weights go to a slot of `skin` that rides on `node`.
pub(super) fn read(
    place: &Place,
    count: usize,
    skin: &mut Skin,
    node: JointIndex,
    notes: &mut Vec<String>,
) -> Result<Influences, RigError> {
    let mut sets = Vec::new();
    for set in 0.. {
        let (joints, weights) = (place.accessor(Semantic::Joints(set)), place.accessor(Semantic::Weights(set)));
        let (joints, weights) = match (joints, weights) {
            (None, None) => break,
            (Some(joints), Some(weights)) => (joints, weights),
            (Some(_), None) => return Err(place.fail(format!("JOINTS_{set} has no WEIGHTS_{set}"))),
            (None, Some(_)) => return Err(place.fail(format!("WEIGHTS_{set} has no JOINTS_{set}"))),
        };
        let joints = place.whole(joints, Type::Vec4, "joint indices")?;
        let weights = place.floats::<4>(weights, Type::Vec4, "weights")?;
        if joints.len() != 4 * count || weights.len() != count {
            let (joints, weights) = (joints.len() / 4, weights.len());
            return Err(place.fail(format!("{count} vertices, but joints for {joints} and weights for {weights}")));
        }
        sets.push((joints, weights));
    }

    let joint_count = skin.joints.len();
    let mut out = Influences { joints: Vec::with_capacity(count), weights: Vec::with_capacity(count) };
    let (mut uneven, mut dropped, mut weightless) = (0usize, 0usize, 0usize);
    let mut vertex_influences: Vec<(f32, u16)> = Vec::new();
    let mut node_slot = None;
    for vertex in 0..count {
        vertex_influences.clear();
        for (joints, weights) in &sets {
            for (&joint, &weight) in joints[4 * vertex..4 * vertex + 4].iter().zip(&weights[vertex]) {
                if !weight.is_finite() || weight < 0.0 {
                    return Err(place.fail_at(vertex, format!("its weight {weight} is not a number from 0 to 1")));
                }
                if weight == 0.0 {
                    continue;
                }
                let slot = u16::try_from(joint).ok().filter(|&slot| usize::from(slot) < joint_count);
                let slot = slot.ok_or_else(|| {
                    place.fail_at(vertex, format!("it hangs on joint {joint}, but the skin has {joint_count}"))
                })?;
                vertex_influences.push((weight, slot));
            }
        }
        vertex_influences.sort_by(|a, b| b.0.total_cmp(&a.0));
        let total: f32 = vertex_influences.iter().map(|influence| influence.0).sum();
        if vertex_influences.is_empty() {
            weightless += 1;
            let slot = *node_slot.get_or_insert_with(|| ride_on(skin, node));
            vertex_influences.push((1.0, slot));
        } else if (total - 1.0).abs() > UNEVEN {
            uneven += 1;
        }
        dropped += usize::from(vertex_influences.len() > 4);
        vertex_influences.truncate(4);
        let kept: f32 = vertex_influences.iter().map(|influence| influence.0).sum();
        let (mut slots, mut weights) = ([0; 4], [0.0; 4]);
        for (place, &(weight, slot)) in vertex_influences.iter().enumerate() {
            (slots[place], weights[place]) = (slot, weight / kept);
        }
        out.joints.push(slots);
        out.weights.push(weights);
    }
    let mesh = place.mesh_name();
    for (count, what) in [
        (uneven, "had weights that don't sum to 1; they were scaled"),
        (dropped, "had more than 4 joints; the 4 largest weights were kept"),
        (weightless, "had no weights; they ride on the mesh's node"),
    ] {
        if count > 0 {
            notes.push(format!("mesh `{mesh}`: {count} vertices {what}"));
        }
    }
    Ok(out)
}

/// The skin's slot that moves with the node itself.
fn ride_on(skin: &mut Skin, node: JointIndex) -> u16 {
    let identity = |slot: &usize| skin.joints[*slot] == node && skin.inverse_bind[*slot] == JointMatrix::IDENTITY;
    let slot = (0..skin.joints.len()).find(identity).unwrap_or_else(|| {
        skin.joints.push(node);
        skin.inverse_bind.push(JointMatrix::IDENTITY);
        skin.joints.len() - 1
    });
    u16::try_from(slot).unwrap_or(u16::MAX)
}
