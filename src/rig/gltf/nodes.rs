//! Nodes → skeleton: every joint of a skin, every animated node, every node with a mesh, and all nodes above them.

use bevy::math::{Affine3A, Mat4, Quat, Vec3};
use gltf::json::{Root, scene::Node};

use super::error::RigError;
use crate::anim::skeleton::{JointIndex, JointTransform, Skeleton, SkeletonError};

/// The skeleton and which node became which joint.
pub(super) struct Nodes {
    pub(super) skeleton: Skeleton,
    pub(super) joints: Vec<Option<JointIndex>>,
}

/// The node's name, or its index where it has none.
pub(super) fn name(json: &Root, node: usize) -> String {
    let name = json.nodes.get(node).and_then(|node| node.name.clone());
    name.unwrap_or_else(|| format!("node{node}"))
}

/// Reads the tree; `model_from_root` goes above its roots.
pub(super) fn read(json: &Root, model_from_root: Affine3A) -> Result<Nodes, RigError> {
    let parents = parents(json)?;
    let mut kept = vec![false; json.nodes.len()];
    let skinned = json.skins.iter().flat_map(|skin| &skin.joints).map(gltf::json::Index::value);
    let channels = json.animations.iter().flat_map(|clip| &clip.channels);
    let animated = channels.map(|channel| channel.target.node.value());
    let meshes = json.nodes.iter().enumerate().filter(|(_, node)| node.mesh.is_some()).map(|(index, _)| index);
    for node in skinned.chain(animated).chain(meshes) {
        let mut walk = Some(node);
        while let Some(at) = walk {
            let Some(seen) = kept.get_mut(at) else {
                let problem = format!("node {at} does not exist; there are {}", json.nodes.len());
                return Err(RigError::Element { path: "nodes".to_owned(), problem });
            };
            if core::mem::replace(seen, true) {
                break;
            }
            walk = parents[at];
        }
    }
    let count = kept.iter().filter(|kept| **kept).count();
    if count > usize::from(u16::MAX) {
        return Err(SkeletonError::TooMany(count).into());
    }

    // Depth first from each root, children in the file's order.
    let mut joints = vec![None; json.nodes.len()];
    let mut list = Vec::with_capacity(count);
    let roots = (0..json.nodes.len()).rev().filter(|&node| parents[node].is_none());
    let mut open: Vec<usize> = roots.collect();
    while let Some(node) = open.pop() {
        if !kept[node] {
            continue;
        }
        joints[node] = u16::try_from(list.len()).ok().map(JointIndex);
        let parent = parents[node].and_then(|parent| joints[parent]);
        list.push((name(json, node), parent, transform(json, node)?));
        open.extend(children(&json.nodes[node]).rev());
    }
    Ok(Nodes { skeleton: Skeleton::new(list, model_from_root)?, joints })
}

fn children(node: &Node) -> impl DoubleEndedIterator<Item = usize> + '_ {
    node.children.iter().flatten().map(gltf::json::Index::value)
}

/// Each node's parent; refuses two parents and circles.
fn parents(json: &Root) -> Result<Vec<Option<usize>>, RigError> {
    let mut parents: Vec<Option<usize>> = vec![None; json.nodes.len()];
    for (parent, node) in json.nodes.iter().enumerate() {
        for child in children(node) {
            let Some(slot) = parents.get_mut(child) else {
                let problem = format!("its child {child} does not exist; there are {} nodes", json.nodes.len());
                return Err(RigError::Node { node: name(json, parent), problem });
            };
            if let Some(first) = slot.replace(parent) {
                let problem = format!("it hangs below both `{}` and `{}`", name(json, first), name(json, parent));
                return Err(RigError::Node { node: name(json, child), problem });
            }
        }
    }
    // With one parent each, whatever no root leads to goes round in a circle.
    let mut reached = vec![false; json.nodes.len()];
    let mut open: Vec<usize> = (0..json.nodes.len()).filter(|&node| parents[node].is_none()).collect();
    while let Some(node) = open.pop() {
        reached[node] = true;
        open.extend(children(&json.nodes[node]));
    }
    match reached.iter().position(|reached| !reached) {
        Some(node) => Err(RigError::Node {
            node: name(json, node),
            problem: "it is its own ancestor: the nodes form a circle".to_owned(),
        }),
        None => Ok(parents),
    }
}

fn transform(json: &Root, node: usize) -> Result<JointTransform, RigError> {
    let it = &json.nodes[node];
    let fail = |problem: &str| RigError::Node { node: name(json, node), problem: problem.to_owned() };
    let transform = match &it.matrix {
        Some(matrix) => {
            let matrix = Mat4::from_cols_array(matrix);
            if !matrix.is_finite() {
                return Err(fail("its matrix is not finite"));
            }
            let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
            // A squashed axis leaves the rotation undefined.
            let rotation = if rotation.is_finite() { rotation } else { Quat::IDENTITY };
            JointTransform { translation, rotation, scale }
        }
        None => JointTransform {
            translation: it.translation.map_or(Vec3::ZERO, Vec3::from_array),
            rotation: it.rotation.map_or(Quat::IDENTITY, |rotation| Quat::from_array(rotation.0)),
            scale: it.scale.map_or(Vec3::ONE, Vec3::from_array),
        },
    };
    if !transform.translation.is_finite() || !transform.rotation.is_finite() || !transform.scale.is_finite() {
        return Err(fail("its translation, rotation or scale is not finite"));
    }
    let length = transform.rotation.length();
    if length < 1e-6 {
        return Err(fail("its rotation has length zero"));
    }
    // Unit within rounding stays as the file has it, so that a still track equals the rest pose bit for bit.
    let rotation = if (length - 1.0).abs() > 1e-6 { transform.rotation / length } else { transform.rotation };
    Ok(JointTransform { rotation, ..transform })
}
