//! Turns hips, knees and ankles of a pose onto placed feet.
//!
//! Model space, metres. Reads and writes the local pose; model matrices are up to date before and after.

use bevy::prelude::*;

use crate::anim::{
    ik::two_bone::{self, Extension, Limb},
    pose::{Pose, rotation_of},
    skeleton::{JointIndex, Skeleton},
};

/// The joints of one leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LegJoints {
    /// Hip joint.
    pub upper: JointIndex,
    /// Knee.
    pub lower: JointIndex,
    /// Ankle.
    pub foot: JointIndex,
}

/// What became of a leg.
#[derive(Clone, Copy, Debug, Default)]
pub struct LegResult {
    /// Metres by which the ankle missed its target.
    pub missed: f32,
    /// Distance from hip to ankle over the leg's length.
    pub extension: f32,
}

/// Moves `joint` by `offset_model` (model space) and brings all model matrices up to date.
pub fn shift_joint(pose: &mut Pose, skeleton: &Skeleton, joint: JointIndex, offset_model: Vec3) {
    let above = skeleton.parent(joint).map_or(skeleton.model_from_root, |parent| pose.model(parent));
    let mut local = pose.local(joint);
    local.translation += above.inverse().transform_vector3(offset_model);
    if local.translation.is_finite() {
        pose.set_local(joint, local);
        pose.update_model_below(skeleton, joint);
    }
}

/// Turns a leg so that its ankle comes to `ankle_model` and its foot is turned by `foot_turn` from the animated rotation
/// `foot_rotation` (both model space). `forward` is where knees point when the leg is straight.
pub fn place_leg(
    pose: &mut Pose,
    skeleton: &Skeleton,
    joints: LegJoints,
    ankle_model: Vec3,
    foot_rotation: Quat,
    forward: Vec3,
    extension: Extension,
) -> LegResult {
    let limb = Limb {
        root: pose.position(joints.upper),
        middle: pose.position(joints.lower),
        end: pose.position(joints.foot),
        pole: forward,
    };
    let solution = two_bone::solve(&limb, ankle_model, extension);
    let parent = pose.parent_rotation(skeleton, joints.upper);
    let upper = solution.upper_delta * pose.rotation(joints.upper);
    let lower = solution.lower_delta * pose.rotation(joints.lower);
    set_rotation(pose, joints.upper, parent, upper);
    set_rotation(pose, joints.lower, upper_frame(skeleton, pose, joints.lower, joints.upper, upper), lower);
    set_rotation(pose, joints.foot, upper_frame(skeleton, pose, joints.foot, joints.lower, lower), foot_rotation);
    pose.update_model_below(skeleton, joints.upper);
    let length = limb.root.distance(limb.middle) + limb.middle.distance(limb.end);
    LegResult {
        missed: pose.position(joints.foot).distance(ankle_model),
        extension: if length > 0.0 { solution.end.distance(limb.root) / length } else { 0.0 },
    }
}

fn set_rotation(pose: &mut Pose, joint: JointIndex, parent_rotation: Quat, rotation_model: Quat) {
    let mut local = pose.local(joint);
    local.rotation = (parent_rotation.inverse() * rotation_model).normalize();
    if local.rotation.is_finite() {
        pose.set_local(joint, local);
    }
}

/// Rotation of `joint`'s parent once `turned` (its limb's joint above) has rotation `rotation`; twist joints between the
/// two keep their local rotations.
fn upper_frame(skeleton: &Skeleton, pose: &Pose, joint: JointIndex, turned: JointIndex, rotation: Quat) -> Quat {
    match skeleton.parent(joint) {
        Some(parent) if parent != turned => {
            let between = rotation_of(&(pose.model(turned).inverse() * pose.model(parent)));
            rotation * between
        }
        _ => rotation,
    }
}
