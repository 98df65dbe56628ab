//! Parts told from names, and from what hangs between and below the named ones.

use bevy::math::Vec3;

use super::{
    Means, Parts,
    shape::{self, LegShape},
    tree::Tree,
};
use crate::{
    anim::skeleton::{JointIndex, Skeleton},
    rig::{
        humanoid::HumanoidRole as Role,
        names::{JointName, Side},
    },
};

/// Roles with a side: left, right, and the names tools give them, best first.
///
/// `leg` and `arm` stand for the lower or the upper one, whichever has no name of its own.
const SIDED: [(Role, Role, &[&str]); 8] = [
    (
        Role::LeftLowerLeg,
        Role::RightLowerLeg,
        &["lowerleg", "lowleg", "leglower", "calf", "shin", "shank", "knee", "leg"],
    ),
    (Role::LeftUpperLeg, Role::RightUpperLeg, &["upperleg", "upleg", "legupper", "thigh", "thighbend", "hip", "leg"]),
    (Role::LeftFoot, Role::RightFoot, &["foot", "ankle"]),
    (Role::LeftToes, Role::RightToes, &["toes", "toe", "toebase", "ball", "toe1", ""]),
    (Role::LeftLowerArm, Role::RightLowerArm, &["lowerarm", "lowarm", "armlower", "forearm", "forearmbend", "elbow"]),
    (Role::LeftUpperArm, Role::RightUpperArm, &["upperarm", "uparm", "armupper", "shldrbend", "shldr", "arm"]),
    (Role::LeftShoulder, Role::RightShoulder, &["shoulder", "clavicle", "collar", "collarbone"]),
    (Role::LeftHand, Role::RightHand, &["hand", "wrist"]),
];

/// Legs by side: upper, lower, foot, toes.
pub(super) const LEGS: [[Role; 4]; 2] = [
    [Role::LeftUpperLeg, Role::LeftLowerLeg, Role::LeftFoot, Role::LeftToes],
    [Role::RightUpperLeg, Role::RightLowerLeg, Role::RightFoot, Role::RightToes],
];

/// Arms by side: shoulder, upper, lower, hand.
pub(super) const ARMS: [[Role; 4]; 2] = [
    [Role::LeftShoulder, Role::LeftUpperArm, Role::LeftLowerArm, Role::LeftHand],
    [Role::RightShoulder, Role::RightUpperArm, Role::RightLowerArm, Role::RightHand],
];

/// Names of `joints`, taken apart.
pub(super) fn names(skeleton: &Skeleton, joints: &[JointIndex]) -> Vec<(JointIndex, JointName)> {
    joints.iter().map(|&joint| (joint, JointName::parse(skeleton.name(joint)))).collect()
}

/// Arms and legs by name.
pub(super) fn limbs(parts: &mut Parts, names: &[(JointIndex, JointName)]) {
    for (left, right, aliases) in SIDED {
        for (role, side) in [(left, Side::Left), (right, Side::Right)] {
            if parts.get(role).is_some() {
                continue;
            }
            // Rigs that count every joint call the first of a limb number one.
            let numbered = |name: &JointName, alias: &str| name.key.strip_suffix('1').is_some_and(|key| key == alias);
            let find = |fits: &dyn Fn(&JointName, &str) -> bool| {
                aliases.iter().find_map(|alias| {
                    let named = |(_, name): &&(JointIndex, JointName)| name.side == Some(side) && fits(name, alias);
                    names.iter().filter(named).map(|(joint, _)| *joint).find(|joint| !parts.has(*joint))
                })
            };
            let exactly = find(&|name, alias| name.key == alias);
            if let Some(joint) = exactly.or_else(|| find(&numbered)) {
                parts.give(role, joint, Means::Name);
            }
        }
    }
}

/// What is missing of a leg or arm of which some joints are known.
pub(super) fn fill_limbs(parts: &mut Parts, tree: &Tree, up: Vec3) {
    for roles in LEGS {
        let [upper, lower, foot, _] = roles.map(|role| parts.get(role));
        let Some(top) = upper.or_else(|| tree.skeleton.parent(lower?)) else { continue };
        let found = match foot.filter(|&foot| tree.skeleton.is_below(foot, top)) {
            Some(foot) => {
                let path = tree.path(top, foot);
                let toes = shape::toes(tree, foot, tree.length(&path), up);
                shape::middle(tree, &path).map(|lower| LegShape { upper: top, lower, foot, toes })
            }
            None => shape::leg(tree, &tree.path_to_end(top, |end| -tree.at(end).dot(up)), up),
        };
        let Some(found) = found else { continue };
        if lower.is_some_and(|lower| lower != found.lower && !tree.skeleton.is_below(found.foot, lower)) {
            continue;
        }
        for (role, joint) in roles.into_iter().zip([Some(top), Some(found.lower), Some(found.foot), found.toes]) {
            if let Some(joint) = joint {
                parts.give(role, joint, Means::Hierarchy);
            }
        }
    }
    for [_, _, lower, hand] in ARMS {
        // The wrist carries more than a twist joint beside it.
        let carried = |joint: JointIndex| {
            let below = |other: &JointIndex| tree.skeleton.is_below(*other, joint);
            tree.skeleton.joints().filter(below).count()
        };
        let Some(elbow) = parts.get(lower).filter(|_| parts.get(hand).is_none()) else { continue };
        if let Some(&wrist) = tree.children(elbow).iter().max_by_key(|&&joint| carried(joint)) {
            parts.give(hand, wrist, Means::Hierarchy);
        }
    }
}

/// Hips above the legs, the spine up to the arms, neck and head.
pub(super) fn trunk(parts: &mut Parts, skeleton: &Skeleton, names: &[(JointIndex, JointName)]) {
    let middle = |aliases: &[&str]| {
        let named = |alias: &&str| names.iter().find(|(_, name)| name.side.is_none() && name.key == **alias);
        aliases.iter().find_map(named).map(|(joint, _)| *joint)
    };
    if let (None, Some(left), Some(right)) =
        (parts.get(Role::Hips), parts.get(Role::LeftUpperLeg), parts.get(Role::RightUpperLeg))
    {
        let carries = |hips: &JointIndex| skeleton.is_below(left, *hips) && skeleton.is_below(right, *hips);
        // Some rigs name a joint beside the legs `hips`; what carries both legs counts.
        if let Some(hips) = middle(&["hips", "hip", "pelvis"]).filter(carries) {
            parts.give(Role::Hips, hips, Means::Name);
        } else if let Some(hips) = meeting(skeleton, left, right) {
            parts.give(Role::Hips, hips, Means::Hierarchy);
        }
    }
    for (role, aliases) in [(Role::Head, ["head", "head1"]), (Role::Neck, ["neck", "neck1"])] {
        if let (None, Some(joint)) = (parts.get(role), middle(&aliases)) {
            parts.give(role, joint, Means::Name);
        }
    }
}

/// The joints from the hips, without them, to where the arms or the neck begin, shared out among the spine's roles.
pub(super) fn spine(parts: &mut Parts, skeleton: &Skeleton) {
    let Some(hips) = parts.get(Role::Hips) else { return };
    let shoulder = |side: [Role; 4]| side[..2].iter().find_map(|&role| parts.get(role));
    let top = match ARMS.map(shoulder) {
        [Some(left), Some(right)] => meeting(skeleton, left, right),
        _ => parts.get(Role::Neck).or_else(|| parts.get(Role::Head)).and_then(|joint| skeleton.parent(joint)),
    };
    let mut spine = Vec::new();
    let mut walk = top;
    while let Some(joint) = walk.filter(|&joint| joint != hips && skeleton.is_below(joint, hips)) {
        spine.insert(0, joint);
        walk = skeleton.parent(joint);
    }
    let roles: &[(Role, usize)] = match spine.len() {
        0 => &[],
        1 => &[(Role::Spine, 0)],
        2 => &[(Role::Spine, 0), (Role::Chest, 1)],
        3 => &[(Role::Spine, 0), (Role::Chest, 1), (Role::UpperChest, 2)],
        count => &[(Role::Spine, 0), (Role::Chest, count / 2), (Role::UpperChest, count - 1)],
    };
    for &(role, place) in roles {
        parts.give(role, spine[place], Means::Hierarchy);
    }
}

/// The lowest joint above both.
pub(super) fn meeting(skeleton: &Skeleton, a: JointIndex, b: JointIndex) -> Option<JointIndex> {
    let mut walk = skeleton.parent(a);
    while let Some(joint) = walk.filter(|&joint| !skeleton.is_below(b, joint)) {
        walk = skeleton.parent(joint);
    }
    walk
}
