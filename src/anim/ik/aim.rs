//! Aims a chain's end: spine, neck and head look, or a chest turns a weapon, each joint taking its share.

use core::f32::consts::PI;

use bevy::math::{Vec3, ops};

use super::chain::{ChainJoint, descend};

/// Passes after which what limits left over has gone from joint to joint.
const PASSES: u32 = 8;

/// Where to aim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// The place, in chain space.
    pub target: Vec3,
    /// Where the line of sight begins, in the space of the last joint.
    pub eye: Vec3,
    /// Where it goes, in the space of the last joint.
    pub forward: Vec3,
    /// Angle in radians between it and the target that is near enough.
    pub tolerance: f32,
}

/// What became of an [`Aim`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aimed {
    /// Angle in radians that is left, measured in the last joint's space; π for input that isn't finite.
    pub missed: f32,
    /// Whether that is within the tolerance.
    pub reached: bool,
}

/// Turns the joints, each within its limit, so that the line of sight meets the target.
///
/// `shares` say how much each joint takes on of the turn, in proportion; what a limit keeps a joint from goes to the others.
/// A joint without a share takes part only where the last one can't end the turn. The same input gives the same pose.
pub fn solve(joints: &mut [ChainJoint], shares: &[f32], aim: &Aim) -> Aimed {
    for joint in joints.iter_mut() {
        joint.keep_limit();
    }
    let mut missed = off(joints, aim);
    for _ in 0..PASSES {
        if missed <= aim.tolerance || !missed.is_finite() {
            break;
        }
        pass(joints, shares, aim);
        missed = off(joints, aim);
    }
    let missed = if missed.is_finite() { missed } else { PI };
    Aimed { missed, reached: missed <= aim.tolerance }
}

fn pass(joints: &mut [ChainJoint], shares: &[f32], aim: &Aim) {
    let share = |index: usize| shares.get(index).copied().unwrap_or(1.0).max(0.0);
    let mut left: f32 = (0..joints.len()).map(share).sum();
    let mut target = aim.target;
    for index in 0..joints.len() {
        let last = index + 1 == joints.len();
        let part = if last { 1.0 } else { (share(index) / left.max(f32::EPSILON)).min(1.0) };
        left -= share(index);
        let ray = |point: Vec3| joints[index..].iter().rev().fold(point, |point, joint| joint.in_parent(point));
        let eye = ray(aim.eye);
        let (from, to) = (ray(aim.eye + aim.forward) - eye, target - eye);
        let pivot = joints[index].local.translation;
        joints[index].swing_part(pivot + from, pivot + to, part);
        target = joints[index].in_own(target);
    }
}

/// Angle between the line of sight and the target, in the last joint's space.
fn off(joints: &[ChainJoint], aim: &Aim) -> f32 {
    let way = descend(joints, aim.target) - aim.eye;
    angle(aim.forward, way)
}

fn angle(a: Vec3, b: Vec3) -> f32 {
    ops::atan2(a.cross(b).length(), a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        anim::ik::{
            chain::samples::{chain, direction, limit},
            limits::Limit,
        },
        math::rotation::{to_scaled_axis, twist_angle},
    };
    use bevy::math::Quat;
    use proptest::prelude::*;

    /// Chest, neck and head, a hand's breadth apart; the eyes look along -Z.
    fn neck(swing: f32) -> Vec<ChainJoint> {
        let mut joints = vec![ChainJoint::default(); 3];
        for joint in &mut joints {
            joint.local.translation = Vec3::Y * 0.1;
            joint.limit = Limit::Cone { axis: Vec3::Y, swing, twist: [-swing, swing] };
        }
        joints
    }

    fn look(target: Vec3) -> Aim {
        Aim { target, eye: Vec3::new(0.0, 0.1, -0.08), forward: Vec3::NEG_Z, tolerance: 1e-3 }
    }

    proptest! {
        #[test]
        fn what_limits_allow_is_looked_at(yaw in -1.2f32..1.2, pitch in -0.5f32..0.5, far in 0.8f32..20.0) {
            let mut joints = neck(0.7);
            let target = Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch) * Vec3::NEG_Z * far + Vec3::Y * 0.4;
            let aimed = solve(&mut joints, &[0.2, 0.3, 0.5], &look(target));
            prop_assert!(aimed.reached, "{} rad aside", aimed.missed);
            for joint in &joints {
                prop_assert!(joint.excess() < 2e-3, "{} rad beyond its limit", joint.excess());
            }
        }

        #[test]
        fn no_limit_is_exceeded_and_no_nan_comes_out(joints in chain(limit()), target in direction(), far in 0.0f32..3.0, forward in direction(), broken in 0u8..8) {
            let mut joints = joints;
            if broken & 1 != 0 { joints[1].local.scale = Vec3::ZERO; }
            if broken & 2 != 0 { joints[0].local.translation = Vec3::ZERO; }
            let forward = if broken & 4 != 0 { Vec3::ZERO } else { forward };
            let aimed = solve(&mut joints, &[1.0, 0.5], &Aim { target: target * far, eye: Vec3::ZERO, forward, tolerance: 1e-3 });
            prop_assert!(!aimed.missed.is_nan(), "{aimed:?}");
            for joint in &joints {
                prop_assert!(joint.local.rotation.is_finite() && joint.excess() < 2e-3, "{joint:?}");
            }
        }
    }

    #[test]
    fn joints_take_their_shares() {
        let mut joints = neck(1.5);
        let aimed = solve(&mut joints, &[0.2, 0.3, 0.5], &look(Vec3::new(-50.0, 0.4, -50.0)));
        let turned: Vec<f32> =
            joints.iter().map(|joint| to_scaled_axis(joint.turned()).length().to_degrees()).collect();
        assert!(aimed.reached, "{} rad aside", aimed.missed);
        for (turned, share) in turned.iter().zip([9.0, 13.5, 22.5]) {
            assert!((turned - share).abs() < 0.5, "turned by {turned}° instead of {share}°");
        }
    }

    #[test]
    fn who_can_turn_no_further_looks_as_far_aside_as_limits_allow() {
        let mut joints = neck(0.4);
        let aimed = solve(&mut joints, &[0.2, 0.3, 0.5], &look(Vec3::new(-5.0, 0.4, 3.0)));
        let yaw: f32 = joints.iter().map(|joint| twist_angle(joint.turned(), Vec3::Y)).sum();
        assert!(!aimed.reached && yaw > 1.1, "turned by {yaw} rad of 1.2");
    }
}
