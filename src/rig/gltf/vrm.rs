//! The map of body parts that VRM models bring: `VRMC_vrm` (1.0) and `VRM` (0.x).
//!
//! After <https://github.com/vrm-c/vrm-specification>, `humanoid.humanBones` of both.

use gltf::json::Root;
use serde_json::Value;

use super::nodes::Nodes;
use crate::{anim::skeleton::JointIndex, rig::humanoid::HumanoidRole};

/// Roles of the map whose nodes are joints; none where there is no map.
pub(super) fn roles(json: &Root, nodes: &Nodes) -> Vec<(HumanoidRole, JointIndex)> {
    let extension = |name: &str| json.extensions.as_ref().and_then(|extensions| extensions.others.get(name));
    let bones = |extension: &Value| extension.get("humanoid")?.get("humanBones").cloned();
    let pairs: Vec<(String, u64)> = match (extension("VRMC_vrm").and_then(bones), extension("VRM").and_then(bones)) {
        (Some(Value::Object(bones)), _) => {
            bones.iter().filter_map(|(bone, at)| Some((bone.clone(), at.get("node")?.as_u64()?))).collect()
        }
        (_, Some(Value::Array(bones))) => {
            let pair = |bone: &Value| Some((bone.get("bone")?.as_str()?.to_owned(), bone.get("node")?.as_u64()?));
            bones.iter().filter_map(pair).collect()
        }
        _ => Vec::new(),
    };
    let role = |(bone, node): (String, u64)| {
        let role = HumanoidRole::ALL.into_iter().find(|role| role.spelling() == bone)?;
        let joint = nodes.joints.get(usize::try_from(node).ok()?).copied().flatten()?;
        Some((role, joint))
    };
    pairs.into_iter().filter_map(role).collect()
}
