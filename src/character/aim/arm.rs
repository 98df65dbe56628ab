//! One arm that points: shoulder, elbow and wrist, each no further than a human's goes. Model space, metres.

use bevy::{math::ops, prelude::*};

use crate::{
    anim::{
        blend::lerp,
        ik::two_bone::Extension,
        pose::Pose,
        skeleton::{JointIndex, JointTransform, Skeleton},
    },
    character::legs::{LegJoints, place_leg},
    math::rotation::{direction_or, from_scaled_axis, shortest_arc, to_scaled_axis},
    rig::{
        character::CharacterAsset,
        humanoid::HumanoidRole::{
            LeftHand, LeftLowerArm, LeftShoulder, LeftUpperArm, RightHand, RightLowerArm, RightShoulder, RightUpperArm,
        },
    },
};

/// Where elbows point, left and right: down, and a little out.
const ELBOWS: [Vec3; 2] = [Vec3::new(-0.35, -1.0, 0.0), Vec3::new(0.35, -1.0, 0.0)];
/// Furthest that a hand bends against its forearm, radians (clinical range 70–80°).
const WRIST: f32 = 1.2;

/// An arm that points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arm {
    joints: LegJoints,
    /// What carries the upper arm, if the body has it.
    shoulder: Option<JointIndex>,
    /// Where the elbow points.
    elbow: Vec3,
    /// Where the hand points when it goes on straight from the forearm, in its own space.
    forward: Vec3,
    /// Local rotations of upper arm, forearm and hand when the arm points straight ahead.
    ahead: [Quat; 3],
}

impl Arm {
    /// Left and right, as far as the body has them.
    pub(super) fn both(asset: &CharacterAsset) -> [Option<Self>; 2] {
        let rest = Pose::rest(&asset.skeleton);
        let roles = [
            [LeftUpperArm, LeftLowerArm, LeftHand, LeftShoulder],
            [RightUpperArm, RightLowerArm, RightHand, RightShoulder],
        ];
        let arm = |roles: [_; 4], elbow| {
            let [upper, lower, hand, shoulder] = roles.map(|role| asset.humanoid.get(role));
            let joints = LegJoints { upper: upper?, lower: lower?, foot: hand? };
            let along = direction_or(rest.position(joints.foot) - rest.position(joints.lower), Vec3::NEG_Y);
            let forward = rest.rotation(joints.foot).inverse() * along;
            let ahead = [Quat::IDENTITY; 3];
            let arm = Self { joints, shoulder, elbow, forward, ahead };
            let mut pose = rest.clone();
            arm.point(&mut pose, &asset.skeleton, Vec3::NEG_Z, 0.96, 1.0);
            let ahead = [joints.upper, joints.lower, joints.foot].map(|joint| pose.local(joint).rotation);
            Some(Self { ahead, ..arm })
        };
        [arm(roles[0], ELBOWS[0]), arm(roles[1], ELBOWS[1])]
    }

    /// Turns the shoulder, if there is one.
    pub(super) fn shrug(&self, pose: &mut Pose, skeleton: &Skeleton, turn_model: Quat) {
        if let Some(shoulder) = self.shoulder {
            pose.rotate_model(skeleton, shoulder, turn_model);
            pose.update_model_below(skeleton, shoulder);
        }
    }

    /// Brings the arm by `weight` to point along `way`, its wrist `reach` times its length from the shoulder.
    pub(super) fn point(&self, pose: &mut Pose, skeleton: &Skeleton, way: Vec3, reach: f32, weight: f32) {
        let LegJoints { upper, lower, foot: hand } = self.joints;
        let joints = [upper, lower, hand];
        let before = joints.map(|joint| pose.local(joint));
        let hand_from_forearm = pose.rotation(lower).inverse() * pose.rotation(hand);
        let root = pose.position(upper);
        let length = root.distance(pose.position(lower)) + pose.position(lower).distance(pose.position(hand));
        let extension = Extension { soft: reach, hard: reach.max(Extension::default().hard) };
        // An arm that hangs straight bends backward, and once it is raised downward.
        place_leg(pose, skeleton, self.joints, root + way * (length * reach), Quat::IDENTITY, Vec3::Z, extension);
        let swivel = about(way, pose.position(lower) - root, self.elbow);
        pose.rotate_model(skeleton, upper, swivel);
        pose.update_model_below(skeleton, upper);
        let carried = pose.rotation(lower) * hand_from_forearm;
        let forearm = direction_or(pose.position(hand) - pose.position(lower), way);
        let aimed = shortest_arc(carried * self.forward, bent_to(forearm, way, WRIST)) * carried;
        pose.rotate_model(skeleton, hand, aimed * pose.rotation(hand).inverse());
        for ((joint, before), ahead) in joints.into_iter().zip(before).zip(self.ahead) {
            let aimed = pose.local(joint);
            let rotation = between(before.rotation, aimed.rotation, ahead, weight);
            pose.set_local(joint, JointTransform { rotation, ..lerp(before, aimed, weight) });
        }
        pose.update_model_below(skeleton, upper);
    }
}

/// The rotation that is `weight` of the way from `from` to `to`, by way of `middle`: from behind the back to overhead there
/// are two ways round, and only one leads through what lies ahead.
fn between(from: Quat, to: Quat, middle: Quat, weight: f32) -> Quat {
    if weight >= 1.0 {
        return to;
    }
    let [from, to] = [from, to].map(|rotation| to_scaled_axis(middle.inverse() * rotation));
    (middle * from_scaled_axis(from.lerp(to, weight))).normalize()
}

/// The turn about the unit vector `axis` that brings `from` beside it where `to` is; none where either lies along it.
fn about(axis: Vec3, from: Vec3, to: Vec3) -> Quat {
    let (from, to) = (from.reject_from_normalized(axis), to.reject_from_normalized(axis));
    let angle = ops::atan2(axis.dot(from.cross(to)), from.dot(to));
    from_scaled_axis(axis * angle)
}

/// `to`, brought within `most` radians of `from`; all unit vectors.
fn bent_to(from: Vec3, to: Vec3, most: f32) -> Vec3 {
    let across = from.cross(to);
    let angle = ops::atan2(across.length(), from.dot(to));
    from_scaled_axis(direction_or(across, Vec3::ZERO) * angle.min(most)) * from
}
