//! Turns hips, knees and ankles of a pose onto placed feet.
//!
//! Model space, metres. Reads and writes the local pose; model matrices are up to date before and after.

use core::f32::consts::{FRAC_PI_2, TAU};

use bevy::{math::ops, prelude::*};

use crate::{
    anim::{
        ik::two_bone::{self, Extension, Limb},
        leg::Leg,
        pose::Pose,
        skeleton::{JointIndex, Skeleton},
    },
    math::rotation::{direction_or, from_scaled_axis},
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

/// Turns a leg so that its ankle comes to `ankle_model` and its foot to the rotation `foot_rotation` (both model space).
/// `forward` is where knees point when the leg is straight.
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
    place_limb(
        pose,
        skeleton,
        joints,
        &LegTurns::of(pose, skeleton, joints),
        &limb,
        (ankle_model, foot_rotation),
        extension,
    )
}

/// How a leg's joints are turned in model space. Rotations there follow the local ones: what scales may lie above is in the
/// parent's already.
#[derive(Clone, Copy, Debug)]
pub(super) struct LegTurns {
    /// What the leg hangs on.
    parent: Quat,
    upper: Quat,
    lower: Quat,
    /// The ankle.
    pub(super) foot: Quat,
    /// What twist joints turn from hip to knee and from knee to ankle.
    to_knee: Quat,
    to_ankle: Quat,
}

impl LegTurns {
    pub(super) fn of(pose: &Pose, skeleton: &Skeleton, joints: LegJoints) -> Self {
        let parent = pose.parent_rotation(skeleton, joints.upper);
        let upper = parent * pose.turn(joints.upper);
        let to_knee = turn_between(pose, skeleton, joints.upper, joints.lower);
        let to_ankle = turn_between(pose, skeleton, joints.lower, joints.foot);
        let lower = upper * to_knee * pose.turn(joints.lower);
        let foot = lower * to_ankle * pose.turn(joints.foot);
        Self { parent, upper, lower, foot, to_knee, to_ankle }
    }
}

/// [`place_leg`] for a leg that is turned as `turns` says and lies as `limb` does, onto a place and rotation of its foot.
pub(super) fn place_limb(
    pose: &mut Pose,
    skeleton: &Skeleton,
    joints: LegJoints,
    turns: &LegTurns,
    limb: &Limb,
    (ankle_model, foot_rotation): (Vec3, Quat),
    extension: Extension,
) -> LegResult {
    let solution = two_bone::solve(limb, ankle_model, extension);
    let upper = solution.upper_delta * turns.upper;
    let lower = solution.lower_delta * turns.lower;
    set_rotation(pose, joints.upper, turns.parent, upper);
    set_rotation(pose, joints.lower, upper * turns.to_knee, lower);
    set_rotation(pose, joints.foot, lower * turns.to_ankle, foot_rotation);
    pose.update_model_below(skeleton, joints.upper);
    let length = limb.root.distance(limb.middle) + limb.middle.distance(limb.end);
    LegResult {
        missed: pose.position(joints.foot).distance(ankle_model),
        extension: if length > 0.0 { solution.end.distance(limb.root) / length } else { 0.0 },
    }
}

/// How far the leg of a clip may stretch when its foot is put back.
pub const CLIP_EXTENSION: Extension = Extension { soft: 0.985, hard: 0.995 };

/// Changes the pose above its feet and sets the legs back onto them.
pub fn keeping_feet(pose: &mut Pose, skeleton: &Skeleton, legs: &[Leg; 2], change: impl FnOnce(&mut Pose)) {
    let feet = legs.map(|leg| (pose.position(leg.foot), pose.rotation(leg.foot)));
    change(pose);
    for (leg, (ankle, rotation)) in legs.iter().zip(feet) {
        let joints = LegJoints { upper: leg.upper, lower: leg.lower, foot: leg.foot };
        place_leg(pose, skeleton, joints, ankle, rotation, Vec3::NEG_Z, CLIP_EXTENSION);
    }
}

/// Bends, radians, below which no knee straightens (a leg stretched by 0.995), and from which on it resists.
const STRAIGHT: (f32, f32) = (0.2, 0.23);

/// Most that a knee bends, radians: 155°, beyond what it is asked for (see [`not_folded`]).
const MOST_BENT: f32 = 2.7;

/// Bends a knee that is straighter than a leg stretches, or bent backward, and opens one that is folded further than it goes:
/// what is left of a quick motion may carry it there. The foot keeps its turn.
pub fn keep_bent(pose: &mut Pose, skeleton: &Skeleton, leg: &Leg) {
    let (least, soft) = STRAIGHT;
    let [hip, knee, ankle] = pose.positions_of(leg.joints());
    let (thigh, shin) = (knee - hip, ankle - knee);
    let hinge = pose.rotation(leg.upper) * leg.knee_axis;
    let bend = ops::atan2(thigh.cross(shin).dot(hinge), thigh.dot(shin));
    // Beyond half a turn it comes out on the other side.
    let bend = if bend < -FRAC_PI_2 { bend + TAU } else { bend };
    let kept = if bend < soft {
        least + (soft - least) * ops::exp((bend - soft) / (soft - least))
    } else {
        bend.min(MOST_BENT)
    };
    let more = kept - bend;
    if more.abs() > 0.0 {
        // All turns are about one axis, so each may be made in the frame that its joint had.
        for (joint, share) in leg.joints().into_iter().zip([-0.5, 1.0, -0.5]) {
            pose.rotate_model(skeleton, joint, from_scaled_axis(hinge * (more * share)));
        }
        pose.update_model_below(skeleton, leg.upper);
    }
}

/// Angle in radians by which the heel lifts about the ball so that the ankle comes within `reach` of the hip.
///
/// 0 where it is within reach already. Never so far that lifting stops to help: the nearer foot and hip are to one line,
/// the less is gained by a degree, so that a foot would whirl round for the last millimetres. `forward` is where the foot
/// points; its height doesn't matter.
#[must_use]
pub fn heel_lift(hip: Vec3, ankle: Vec3, ball: Vec3, forward: Vec3, reach: f32) -> f32 {
    if hip.distance_squared(ankle) <= reach * reach {
        return 0.0;
    }
    let Some(side) = lift_axis(forward) else { return 0.0 };
    let (foot, leg) = (ankle - ball, hip - ball);
    let aside = (leg - foot).dot(side);
    let (foot, leg) = (foot - side * foot.dot(side), leg - side * leg.dot(side));
    let most = ops::atan2(foot.cross(leg).dot(side), foot.dot(leg));
    let product = foot.length() * leg.length();
    if most <= 0.0 || product <= 1e-6 {
        return 0.0;
    }
    // Law of cosines, for the angle between foot and leg at which the ankle is just within reach.
    let cosine = (foot.length_squared() + leg.length_squared() + aside * aside - reach * reach) / (2.0 * product);
    let needed = most - ops::acos(cosine.clamp(-1.0, 1.0));
    needed.clamp(0.0, MOST_LIFT.min(USEFUL_LIFT * most))
}

/// Turn in model space that lifts the heel of a foot that points `forward` by `angle` radians.
#[must_use]
pub fn heel_turn(forward: Vec3, angle: f32) -> Quat {
    lift_axis(forward).map_or(Quat::IDENTITY, |side| from_scaled_axis(side * angle))
}

fn lift_axis(forward: Vec3) -> Option<Vec3> {
    Vec3::Y.cross(forward).try_normalize()
}

/// Most that a heel lifts to reach, radians: toes bend by about 50° (clinical range 70–80°).
const MOST_LIFT: f32 = 0.9;
/// Share of the way to where foot and leg are in line that a heel lifts.
const USEFUL_LIFT: f32 = 0.6;

/// Shares of a leg's length: the shortest that it folds to, a knee bent by 145° (clinical range: 135–150°), and that from
/// which on it resists.
const FOLDED: (f32, f32) = (0.3, 0.42);

/// `ankle` kept so far from `hip` that the knee folds no further than a knee does; what is further away stays.
#[must_use]
pub fn not_folded(hip: Vec3, ankle: Vec3, length: f32) -> Vec3 {
    let (least, soft) = FOLDED;
    let away = (ankle - hip) / length;
    let distance = away.length();
    if distance >= soft {
        return ankle;
    }
    let kept = least + (soft - least) * ops::exp((distance - soft) / (soft - least));
    hip + direction_or(away, Vec3::NEG_Y) * (kept * length)
}

/// Turns toes by `turn` (model space), together with a foot that is turned as `foot` and will be as `foot_then`. Their model
/// matrices are stale afterwards.
pub(super) fn turn_toes(
    pose: &mut Pose,
    skeleton: &Skeleton,
    (ankle, toes): (JointIndex, JointIndex),
    (foot, foot_then): (Quat, Quat),
    turn: Quat,
) {
    let to_toes = turn_between(pose, skeleton, ankle, toes);
    let rotation = turn * (foot * to_toes * pose.turn(toes));
    set_rotation(pose, toes, foot_then * to_toes, rotation);
}

fn set_rotation(pose: &mut Pose, joint: JointIndex, parent_rotation: Quat, rotation_model: Quat) {
    let rotation = (parent_rotation.inverse() * rotation_model).normalize();
    if rotation.is_finite() {
        pose.set_turn(joint, rotation);
    }
}

/// What twist joints between `above` and `below`, a joint further down the limb, turn.
fn turn_between(pose: &Pose, skeleton: &Skeleton, above: JointIndex, below: JointIndex) -> Quat {
    let mut turn = Quat::IDENTITY;
    let mut walk = skeleton.parent(below);
    while let Some(joint) = walk.filter(|joint| *joint != above) {
        turn = pose.turn(joint) * turn;
        walk = skeleton.parent(joint);
    }
    turn
}

#[cfg(test)]
mod tests {
    use bevy::math::Affine3A;

    use super::*;
    use crate::anim::skeleton::JointTransform;

    #[test]
    fn a_knee_that_is_carried_through_its_thigh_comes_back_folded() {
        let names = ["hip", "knee", "ankle"];
        let joints = names.into_iter().enumerate().map(|(index, name)| {
            let down = if index == 0 { 0.0 } else { 0.4 };
            let rest = JointTransform { translation: Vec3::Y * -down, ..JointTransform::IDENTITY };
            (name.to_owned(), index.checked_sub(1).map(|parent| JointIndex(parent as u16)), rest)
        });
        let skeleton = Skeleton::new(joints.collect::<Vec<_>>(), Affine3A::IDENTITY).expect("parents come first");
        let [upper, lower, foot] = [0, 1, 2].map(JointIndex);
        let leg = Leg { upper, lower, foot, knee_axis: Vec3::NEG_X, ..Leg::default() };
        for degrees in [100.0f32, 150.0, 170.0, 190.0, 220.0] {
            let mut pose = Pose::rest(&skeleton);
            let rotation = Quat::from_rotation_x(-degrees.to_radians());
            pose.set_local(lower, JointTransform { rotation, ..pose.local(lower) });
            pose.update_model(&skeleton);
            keep_bent(&mut pose, &skeleton, &leg);
            let [hip, knee, ankle] = pose.positions_of(leg.joints());
            let bend = two_bone::bend_angle(hip, knee, ankle).to_degrees();
            let wanted = degrees.min(MOST_BENT.to_degrees());
            assert!((bend - wanted).abs() < 0.1, "bent by {degrees}° it comes back at {bend}°");
        }
    }

    #[test]
    fn a_heel_lifts_just_as_far_as_the_hip_needs() {
        let (hip, ankle, ball) = (Vec3::Y, Vec3::new(0.0, 0.07, 0.3), Vec3::new(0.0, 0.0, 0.17));
        let lift = heel_turn(Vec3::NEG_Z, heel_lift(hip, ankle, ball, Vec3::NEG_Z, 0.95));
        let reach = (ball + lift * (ankle - ball)).distance(hip);
        assert!((reach - 0.95).abs() < 1e-3, "reaches to {reach} m");
        let idle = heel_lift(hip, ankle, ball, Vec3::NEG_Z, 1.2);
        assert!(idle.abs() < 1e-6, "lifts by {idle} without need");
    }

    #[test]
    fn a_heel_lifts_the_same_way_when_the_ankle_has_passed_over_the_toes() {
        let hip = Vec3::new(0.0, 0.95, -0.35);
        let lift = |step: i16| {
            let lean = f32::from(step).to_radians();
            let ankle = Vec3::new(0.0, 0.15 * ops::cos(lean), -0.15 * ops::sin(lean));
            heel_lift(hip, ankle, Vec3::ZERO, Vec3::NEG_Z, 0.87).to_degrees()
        };
        for step in -20..20 {
            let change = (lift(step + 1) - lift(step)).abs();
            assert!(change < 3.0, "turned by {change}° for a degree of lean at {step}°");
        }
    }

    #[test]
    fn knees_fold_no_further_than_knees_do() {
        let (hip, way) = (Vec3::Y, Vec3::new(0.0, -0.8, 0.6));
        let distance = |asked: f32| not_folded(hip, hip + way * asked, 0.9).distance(hip);
        for step in 0..90u8 {
            let asked = 0.01 * f32::from(step);
            let (got, next) = (distance(asked), distance(asked + 0.01));
            assert!(got > 0.27 - 1e-5 && got >= asked - 1e-5, "{got} m for {asked} m");
            assert!((0.0..0.0102).contains(&(next - got)), "{} m further for 1 cm at {asked} m", next - got);
        }
        assert!((distance(0.6) - 0.6).abs() < 1e-5, "{} m for 0.6 m", distance(0.6));
    }

    #[test]
    fn a_heel_never_whirls_round_as_the_hip_goes_out_of_reach() {
        let (ankle, ball) = (Vec3::new(0.0, 0.07, 0.3), Vec3::new(0.0, 0.0, 0.17));
        let angle =
            |step: i32| heel_lift(Vec3::new(0.0, 0.9, 0.17 - 0.002 * step as f32), ankle, ball, Vec3::NEG_Z, 0.9);
        for step in 0..300 {
            let turned = (angle(step + 1) - angle(step)).abs().to_degrees();
            assert!(turned < 3.0, "{turned}° for 2 mm at step {step}");
        }
    }
}
