//! Finds a body in a rig: which joint plays which part, where up and forward are, how long its legs are.
//!
//! Parts come, in this order, from the character's file, from the map that a VRM model brings, from names, from what hangs
//! between and below named joints, and, where names fail, from where joints are at rest: the longest pair of mirrored limbs
//! that reach the ground are legs, what carries both is the pelvis, what rises from it the spine, the pair that leaves it
//! sideways the arms. [`BindingReport`] tells all of it in words.

mod named;
mod report;
mod shape;
mod tree;

use std::collections::BTreeMap;

use bevy::math::Vec3;

pub(super) use report::stature;
pub use report::{BindingReport, BodyReport, LegReport, RoleReport};

use self::{
    named::{ARMS, LEGS},
    tree::{Legs, Tree},
};
use super::{
    Rig,
    character_file::Roles,
    frame::{self, Frame},
    humanoid::{Humanoid, HumanoidError, HumanoidRole as Role},
    legs::{self, Body},
    names::{listed, suggestion},
};
use crate::anim::{
    leg::Leg,
    skeleton::{JointIndex, Skeleton},
};

/// How a part was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Means {
    /// The character's file names it.
    File,
    /// The model's VRM extension names it.
    Vrm,
    /// Its name says so.
    Name,
    /// It hangs between, above or below joints that are known.
    Hierarchy,
    /// It is where such a part is at rest.
    Geometry,
}

/// Who hangs below whom, where both are there.
const CHAINS: [[Role; 2]; 14] = [
    [Role::Hips, Role::LeftUpperLeg],
    [Role::LeftUpperLeg, Role::LeftLowerLeg],
    [Role::LeftLowerLeg, Role::LeftFoot],
    [Role::LeftFoot, Role::LeftToes],
    [Role::Hips, Role::RightUpperLeg],
    [Role::RightUpperLeg, Role::RightLowerLeg],
    [Role::RightLowerLeg, Role::RightFoot],
    [Role::RightFoot, Role::RightToes],
    [Role::LeftUpperArm, Role::LeftLowerArm],
    [Role::LeftLowerArm, Role::LeftHand],
    [Role::RightUpperArm, Role::RightLowerArm],
    [Role::RightLowerArm, Role::RightHand],
    [Role::Hips, Role::Spine],
    [Role::Neck, Role::Head],
];

/// A body, found.
#[derive(Clone, Debug)]
pub(super) struct Binding {
    pub(super) humanoid: Humanoid,
    pub(super) frame: Frame,
    /// Lengths and points in model space, once `frame` is the skeleton's.
    pub(super) legs: [Leg; 2],
}

/// Joints by the part they play.
#[derive(Clone, Debug, Default)]
struct Parts {
    joints: BTreeMap<Role, (JointIndex, Means)>,
}

impl Parts {
    fn get(&self, role: Role) -> Option<JointIndex> {
        self.joints.get(&role).map(|part| part.0)
    }

    fn has(&self, joint: JointIndex) -> bool {
        self.joints.values().any(|part| part.0 == joint)
    }

    /// Gives `joint` the part unless either is taken.
    fn give(&mut self, role: Role, joint: JointIndex, means: Means) {
        if !self.has(joint) {
            self.joints.entry(role).or_insert((joint, means));
        }
    }

    /// Forgets what no one spelt out of `roles`.
    fn forget(&mut self, roles: &[Role]) {
        self.joints.retain(|role, part| !roles.contains(role) || matches!(part.1, Means::File | Means::Vrm));
    }

    fn swap_sides(&mut self) {
        self.joints = self.joints.iter().map(|(role, part)| (role.mirrored(), *part)).collect();
    }

    fn humanoid(&self) -> Humanoid {
        Humanoid::new(self.joints.iter().map(|(role, part)| (*role, part.0)))
    }

    fn are_needed_there(&self) -> bool {
        Role::ALL.iter().all(|role| !role.is_needed() || self.get(*role).is_some())
    }

    /// Whether legs, as far as they are there, hang together. A foot may hang elsewhere: it can be hung on its shin.
    fn legs_hang_together(&self, skeleton: &Skeleton) -> bool {
        LEGS.iter().all(|&[upper, lower, ..]| match (self.get(upper), self.get(lower)) {
            (Some(upper), Some(lower)) => upper != lower && skeleton.is_below(lower, upper),
            _ => true,
        })
    }
}

/// What became of a binding: as far as it went, and what stopped it.
struct Attempt {
    parts: Parts,
    outcome: Result<Binding, HumanoidError>,
}

impl Rig {
    /// Finds the body.
    ///
    /// # Errors
    /// When hips or legs aren't found, a spelt-out joint doesn't exist, a limb's joints don't hang together, or the body
    /// stands on four legs.
    pub(super) fn bind(&self, roles: &Roles) -> Result<Binding, HumanoidError> {
        attempt(self, roles).outcome
    }
}

fn attempt(rig: &Rig, roles: &Roles) -> Attempt {
    let mut parts = Parts::default();
    let outcome = take_spelt_out(&mut parts, rig, roles).and_then(|()| find(&mut parts, rig));
    Attempt { parts, outcome }
}

/// Joints of the skins, or all joints where there is no skin.
fn candidates(rig: &Rig) -> Vec<JointIndex> {
    let skinned = rig.skin_joints();
    let mut joints = if skinned.is_empty() { rig.skeleton.joints().collect() } else { skinned };
    joints.sort_unstable();
    joints.dedup();
    joints
}

fn take_spelt_out(parts: &mut Parts, rig: &Rig, roles: &Roles) -> Result<(), HumanoidError> {
    let skeleton = &rig.skeleton;
    let skinned = rig.skin_joints();
    if let Roles::Explicit(roles) = roles {
        for (role, name) in roles {
            // A joint of the skin rather than a mesh node of the same name.
            let joint = skinned.iter().copied().find(|&joint| skeleton.name(joint) == name);
            let joint = joint.or_else(|| skeleton.find(name)).ok_or_else(|| HumanoidError::Unknown {
                role: role.spelling(),
                joint: name.clone(),
                suggestion: suggestion(name, skeleton.names().iter().map(String::as_str)),
                joints: listed(skeleton.names().iter().map(String::as_str)),
            })?;
            parts.joints.insert(*role, (joint, Means::File));
        }
    }
    for &(role, joint) in &rig.told_roles {
        parts.give(role, joint, Means::Vrm);
    }
    Ok(())
}

fn find(parts: &mut Parts, rig: &Rig) -> Result<Binding, HumanoidError> {
    let skeleton = &rig.skeleton;
    let joints = candidates(rig);
    let names = named::names(skeleton, &joints);
    let tree = Tree::new(skeleton, &joints);
    let legs_spelt_out = LEGS.iter().all(|leg| parts.get(leg[0]).is_some());

    named::limbs(parts, &names);
    named::fill_limbs(parts, &tree, up(parts, &tree));
    let leg_roles: Vec<Role> = LEGS.iter().flatten().copied().chain([Role::Hips]).collect();
    if !parts.legs_hang_together(skeleton) {
        parts.forget(&leg_roles);
    }
    let legs_named = LEGS.iter().flatten().all(|&role| !role.is_needed() || parts.get(role).is_some());
    let legs = tree.legs(legs_named.then(|| up(parts, &tree)));
    if !legs_named && let Some(legs) = &legs {
        parts.forget(&leg_roles);
        find_legs(parts, &tree, legs);
    }
    named::trunk(parts, skeleton, &names);
    let four = legs.as_ref().and_then(|legs| four_legs(&tree, legs));
    if let (false, Some(error)) = (legs_spelt_out, &four) {
        // The report has one pair in the lines to write, for who stands on it nevertheless.
        return Err(error.clone());
    }
    find_trunk(parts, rig, &tree);
    named::spine(parts, skeleton);
    check(parts, skeleton, &joints)?;

    let body = Body { skeleton, dominated: &rig.dominated };
    let mut frame = frame::find(body, &parts.humanoid());
    if let Some(HumanoidError::FourLegs { hind, front }) = four {
        frame.notes.push(format!(
            "`{hind}` and `{front}` both carry limbs that reach the ground: it walks on those that are named, and the others \
             go as arms or not at all"
        ));
    }
    if frame.swapped {
        let of_legs =
            |means: Means| LEGS.iter().any(|leg| parts.joints.get(&leg[0]).is_some_and(|part| part.1 == means));
        if !of_legs(Means::Geometry) {
            let evidence = frame.evidence;
            frame
                .notes
                .push(format!("left and right are swapped in the joint names: the {evidence} point the other way"));
        }
        if !of_legs(Means::File) {
            parts.swap_sides();
        }
    }
    let humanoid = parts.humanoid();
    let mut in_model = skeleton.clone();
    in_model.model_from_root = frame.model_from_root;
    let body = Body { skeleton: &in_model, ..body };
    let legs = legs::legs(body, &humanoid)?;
    frame.stand(body, &legs);
    Ok(Binding { humanoid, frame, legs })
}

/// Up, as far as the parts that are known tell it: from the feet to the hips.
fn up(parts: &Parts, tree: &Tree) -> Vec3 {
    let middle = |roles: [Role; 2]| {
        let [left, right] = roles.map(|role| parts.get(role).map(|joint| tree.at(joint)));
        Some(0.5 * (left? + right?))
    };
    let hips = middle([Role::LeftUpperLeg, Role::RightUpperLeg]);
    let knees = middle([Role::LeftLowerLeg, Role::RightLowerLeg]);
    let feet = middle([Role::LeftFoot, Role::RightFoot]);
    let (top, bottom) = (hips.or(knees), feet.or(knees));
    top.zip(bottom).map_or(Vec3::Y, |(top, bottom)| frame::upward(top - bottom))
}

fn four_legs(tree: &Tree, legs: &Legs) -> Option<HumanoidError> {
    let hind = legs.pairs.first()?;
    let apart = |front: &&tree::Pair| {
        let shares = |joint: &JointIndex| hind.limbs.concat().contains(joint);
        front.above != hind.above && !front.limbs.concat().iter().any(shares)
    };
    let front = legs.pairs[1..].iter().filter(apart).find(|front| shape::lies(tree, hind, front, legs.up))?;
    let name = |pair: &tree::Pair| tree.skeleton.name(pair.above).to_owned();
    Some(HumanoidError::FourLegs { hind: name(hind), front: name(front) })
}

fn find_legs(parts: &mut Parts, tree: &Tree, legs: &Legs) {
    let up = legs.up;
    let shapes = legs.pairs.iter().find_map(|pair| {
        let [a, b] = &pair.limbs;
        Some((pair, [shape::leg(tree, a, up)?, shape::leg(tree, b, up)?]))
    });
    let Some((pair, [first, second])) = shapes else { return };
    // Which of the two is the left one shows once it is known where forward is.
    let both = [first, second].map(|leg| [leg.upper, leg.lower, leg.foot].map(|joint| tree.at(joint)));
    let ahead = [first, second].map(|leg| leg.toes.map_or(Vec3::ZERO, |toes| tree.at(toes) - tree.at(leg.foot)));
    let forward = frame::forward_of_legs(both, ahead, up, pair.side);
    let first_is_right = forward.cross(up).dot(pair.side) > 0.0;
    let ordered = if first_is_right { [second, first] } else { [first, second] };
    for (roles, leg) in LEGS.into_iter().zip(ordered) {
        for (role, joint) in roles.into_iter().zip([Some(leg.upper), Some(leg.lower), Some(leg.foot), leg.toes]) {
            if let Some(joint) = joint {
                parts.give(role, joint, Means::Geometry);
            }
        }
    }
    parts.give(Role::Hips, pair.above, Means::Geometry);
}

/// Arms, neck and head that have no names.
fn find_trunk(parts: &mut Parts, rig: &Rig, tree: &Tree) {
    let Some(hips) = parts.get(Role::Hips) else { return };
    let up = up(parts, tree);
    let legs: Vec<JointIndex> = tree
        .children(hips)
        .iter()
        .copied()
        .filter(|&child| {
            let holds = |roles: [Role; 4]| parts.get(roles[0]).is_some_and(|leg| tree.skeleton.is_below(leg, child));
            LEGS.into_iter().any(holds)
        })
        .collect();
    let trunk = shape::trunk(tree, hips, &legs, up);
    let named = |roles: [Role; 4]| roles[1..].iter().all(|&role| parts.get(role).is_some());
    if !ARMS.into_iter().all(named)
        && let Some(pair) = tree.arms(&trunk, &legs, up)
        && let [Some(first), Some(second)] = [0, 1].map(|arm| shape::arm(tree, &pair.limbs[arm], &pair, tree.at(hips)))
    {
        let to_left = LEGS.map(|roles| parts.get(roles[0]).map_or(Vec3::ZERO, |joint| tree.at(joint)));
        let first_is_left = (to_left[0] - to_left[1]).dot(pair.side) > 0.0;
        let ordered = if first_is_left { [first, second] } else { [second, first] };
        parts.forget(ARMS.as_flattened());
        for (roles, arm) in ARMS.into_iter().zip(ordered) {
            for (role, joint) in roles.into_iter().zip([arm.shoulder, Some(arm.upper), Some(arm.lower), Some(arm.hand)])
            {
                if let Some(joint) = joint {
                    parts.give(role, joint, Means::Geometry);
                }
            }
        }
    }
    let shoulders = ARMS.map(|roles| roles[..2].iter().find_map(|&role| parts.get(role)));
    let top = match shoulders {
        [Some(left), Some(right)] => named::meeting(tree.skeleton, left, right),
        _ => trunk.len().checked_sub(2).map(|place| trunk[place]),
    };
    let start = trunk.iter().position(|&joint| Some(joint) == top).map_or(0, |place| place + 1);
    let known = parts.get(Role::Head).is_some();
    let flesh = |joint: JointIndex| rig.dominated.get(joint.index()).map_or(0, Vec::len);
    if let (false, (neck, head)) = (known, shape::head(&trunk[start..], flesh)) {
        let neck = neck.map(|neck| (Role::Neck, neck));
        for (role, joint) in neck.into_iter().chain(head.map(|head| (Role::Head, head))) {
            parts.give(role, joint, Means::Hierarchy);
        }
    }
}

fn check(parts: &Parts, skeleton: &Skeleton, candidates: &[JointIndex]) -> Result<(), HumanoidError> {
    if !parts.are_needed_there() {
        let missing = Role::ALL.into_iter().filter(|role| role.is_needed() && parts.get(*role).is_none());
        let found: Vec<String> = parts
            .joints
            .iter()
            .map(|(role, part)| format!("{} = `{}`", role.spelling(), skeleton.name(part.0)))
            .collect();
        return Err(HumanoidError::Missing {
            missing: missing.map(Role::spelling).collect::<Vec<_>>().join(", "),
            found: if found.is_empty() { "nothing".to_owned() } else { found.join(", ") },
            joints: listed(candidates.iter().map(|&joint| skeleton.name(joint))),
        });
    }
    for [above_role, role] in CHAINS {
        let (Some(above), Some(joint)) = (parts.get(above_role), parts.get(role)) else { continue };
        // Feet that goals move hang elsewhere; they are hung on their shins.
        let rehung = matches!(role, Role::LeftFoot | Role::RightFoot) && !skeleton.is_below(above, joint);
        if joint == above || !skeleton.is_below(joint, above) && !rehung {
            return Err(HumanoidError::Detached {
                role: role.spelling(),
                joint: skeleton.name(joint).to_owned(),
                above_role: above_role.spelling(),
                above: skeleton.name(above).to_owned(),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
