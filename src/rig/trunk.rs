//! The joints that a body keeps its balance by: all that is known of a pose before its feet are placed.

use super::humanoid::{Humanoid, HumanoidRole};
use crate::anim::{
    leg::Leg,
    skeleton::{JointIndex, Skeleton},
};

/// Roles besides legs that stages before the whole model pose read or turn.
const ROLES: [HumanoidRole; 6] = [
    HumanoidRole::Hips,
    HumanoidRole::Spine,
    HumanoidRole::Chest,
    HumanoidRole::UpperChest,
    HumanoidRole::Neck,
    HumanoidRole::Head,
];

/// Legs, spine, neck and head, with all joints above them; parents first.
#[must_use]
pub(super) fn trunk(skeleton: &Skeleton, humanoid: &Humanoid, legs: &[Leg; 2]) -> Vec<JointIndex> {
    let mut ends: Vec<JointIndex> = ROLES.into_iter().filter_map(|role| humanoid.get(role)).collect();
    for leg in legs {
        ends.extend(leg.joints());
        ends.extend(leg.sole().map(|point| point.joint));
        ends.extend(leg.toes);
    }
    chains(skeleton, ends)
}

/// `ends` and all joints above them; parents first.
#[must_use]
pub(super) fn chains(skeleton: &Skeleton, ends: impl IntoIterator<Item = JointIndex>) -> Vec<JointIndex> {
    let ends: Vec<JointIndex> = ends.into_iter().collect();
    skeleton.joints().filter(|&joint| ends.iter().any(|&end| skeleton.is_below(end, joint))).collect()
}
