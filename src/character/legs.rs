//! Turns hips, knees and ankles of a pose onto placed feet.
//!
//! Model space, metres. Reads and writes the local pose; model matrices are up to date before and after.

use bevy::prelude::*;

use crate::{
    anim::{
        ik::two_bone::{self, Extension, Limb},
        pose::{Pose, rotation_of},
        skeleton::{JointIndex, Skeleton},
    },
    math::rotation::from_scaled_axis,
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

/// Turn about the ball, in model space, by which the heel lifts so that the ankle comes within `reach` of the hip.
///
/// The identity where it is within reach already; at most 0.9 rad.
#[must_use]
pub fn heel_lift(hip: Vec3, ankle: Vec3, ball: Vec3, reach: f32) -> Quat {
    let forward = (ball - ankle).with_y(0.0);
    let side = Vec3::Y.cross(forward).normalize_or_zero();
    if side == Vec3::ZERO || hip.distance(ankle) <= reach {
        return Quat::IDENTITY;
    }
    let turn = |angle: f32| from_scaled_axis(side * angle);
    let (mut low, mut high) = (0.0f32, MOST_LIFT);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        let lifted = ball + turn(middle) * (ankle - ball);
        if hip.distance(lifted) > reach { low = middle } else { high = middle }
    }
    turn(high)
}

/// Most that a heel lifts to reach, radians: toes bend by about 50° (clinical range 70–80°).
const MOST_LIFT: f32 = 0.9;
/// Halvings of the search for a heel's lift: 0.9 rad / 2^12 is 0.01°.
const HALVINGS: usize = 12;

/// Gives `joint` this rotation in model space, whatever its parent has become.
pub fn keep_rotation(pose: &mut Pose, skeleton: &Skeleton, joint: JointIndex, rotation_model: Quat) {
    let parent = pose.parent_rotation(skeleton, joint);
    set_rotation(pose, joint, parent, rotation_model);
    pose.update_model_below(skeleton, joint);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_heel_lifts_just_as_far_as_the_hip_needs() {
        let (hip, ankle, ball) = (Vec3::Y, Vec3::new(0.0, 0.07, 0.3), Vec3::new(0.0, 0.0, 0.17));
        let lift = heel_lift(hip, ankle, ball, 0.95);
        let reach = (ball + lift * (ankle - ball)).distance(hip);
        assert!((reach - 0.95).abs() < 1e-3, "reaches to {reach} m");
        assert_eq!(heel_lift(hip, ankle, ball, 1.2), Quat::IDENTITY);
    }
}
