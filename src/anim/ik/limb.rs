//! A chain that bends in one place, by law of cosines: arms and legs, with whatever joints lie between.

use bevy::math::Vec3;

use super::{
    chain::{ChainJoint, Goal, Outcome, descend, end},
    swivel,
    two_bone::{self, Extension, Limb},
};

/// How a limb bends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Which joint bends; the others between the first one and the end keep their rotations.
    pub middle: usize,
    /// Place toward which the middle points, in chain space; `None`: as it did before.
    pub pole: Option<Vec3>,
    /// How far the limb stretches.
    pub extension: Extension,
}

/// Turns the first joint and the middle one so that the end comes to the target, each as far as its limit allows.
pub fn solve(joints: &mut [ChainJoint], goal: &Goal, bend: Bend) -> Outcome {
    let Bend { middle, pole, extension } = bend;
    let sound = goal.target.is_finite() && goal.effector.is_finite();
    if middle == 0 || middle >= joints.len() || !sound {
        return Outcome { missed: f32::INFINITY, reached: false, iterations: 0 };
    }
    let root = joints[0].local.translation;
    let knee = |joints: &[ChainJoint]| end(&joints[..middle], joints[middle].local.translation);
    let side = |place: Vec3| pole.map_or(Vec3::ZERO, |pole| pole - place);
    let limb = Limb { root, middle: knee(joints), end: end(joints, goal.effector), pole: side(knee(joints)) };
    let solution = two_bone::solve(&limb, goal.target, extension);
    joints[0].swing(limb.middle, solution.middle);
    let foot = end(&joints[middle..], goal.effector);
    let place = descend(&joints[..middle], solution.end);
    joints[middle].swing(foot, place);
    if let Some(pole) = pole {
        swivel::toward(joints, goal.effector, middle, pole);
    }
    let missed = end(joints, goal.effector).distance(goal.target);
    let missed = if missed.is_finite() { missed } else { f32::INFINITY };
    Outcome { missed, reached: missed <= goal.tolerance, iterations: 1 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        anim::ik::{
            chain::into_chain,
            chain::samples::{direction, space},
            limits::Limit,
        },
        math::rotation::direction_or,
    };
    use proptest::prelude::*;

    /// Upper arm, a joint half-way that only carries, forearm: 0.3 and 0.28 m along X, bent a little.
    fn arm() -> Vec<ChainJoint> {
        let mut joints = vec![ChainJoint::default(); 3];
        joints[0].local.rotation = bevy::math::Quat::from_rotation_y(0.3);
        joints[1].local.translation = Vec3::X * 0.15;
        joints[1].limit = Limit::Fixed;
        joints[2].local.translation = Vec3::X * 0.15;
        joints[2].local.rotation = bevy::math::Quat::from_rotation_y(0.4);
        joints
    }

    fn reach(joints: &mut [ChainJoint], target: Vec3, pole: Option<Vec3>) -> Outcome {
        let goal = Goal { target, effector: Vec3::X * 0.28, tolerance: 1e-3, iterations: 1, retries: 0 };
        solve(joints, &goal, Bend { middle: 2, pole, extension: Extension::default() })
    }

    proptest! {
        #[test]
        fn a_target_within_reach_is_reached_and_the_elbow_points_to_the_pole(way in direction(), far in 0.1f32..0.55, pole in direction(), space in space()) {
            let target_model = space.transform_point3(way * far);
            let mut joints = arm();
            let outcome = reach(&mut joints, into_chain(&space, target_model).unwrap(), Some(pole));
            let missed = space.transform_point3(end(&joints, Vec3::X * 0.28)).distance(target_model);
            prop_assert!(outcome.reached && missed < 1e-3, "missed by {} mm", missed * 1000.0);
            let elbow = end(&joints[..2], joints[2].local.translation);
            let aside = direction_or(elbow.reject_from(way), Vec3::ZERO);
            let wanted = pole.reject_from(way);
            if elbow.reject_from(way).length() > 0.06 && wanted.length() > 0.1 {
                prop_assert!(aside.dot(wanted.normalize()) > 0.999, "the elbow points to {aside} instead of {wanted}");
            }
        }

        #[test]
        fn what_is_out_of_reach_is_pointed_at(way in direction(), far in 0.7f32..5.0) {
            let mut joints = arm();
            let outcome = reach(&mut joints, way * far, None);
            let end = end(&joints, Vec3::X * 0.28);
            prop_assert!(!outcome.reached && end.normalize().dot(way) > 0.9999, "it points to {end}, not to {way}");
            prop_assert!(end.length() / 0.58 > 0.98, "stretched to {} of its length", end.length() / 0.58);
        }
    }

    #[test]
    fn a_joint_between_keeps_its_rotation() {
        let mut joints = arm();
        reach(&mut joints, Vec3::new(0.2, 0.3, 0.1), None);
        assert_eq!(joints[1], arm()[1]);
    }

    #[test]
    fn a_limb_that_has_no_middle_or_no_length_stays() {
        let mut joints = arm();
        let outcome = solve(
            &mut joints,
            &Goal { target: Vec3::Y, effector: Vec3::X, tolerance: 1e-3, iterations: 1, retries: 0 },
            Bend { middle: 0, pole: None, extension: Extension::default() },
        );
        assert!(!outcome.reached && joints == arm());
        let mut point = vec![ChainJoint::default(); 3];
        let outcome = reach(&mut point, Vec3::Y, Some(Vec3::ZERO));
        assert!(!outcome.missed.is_nan() && point.iter().all(|joint| joint.local.rotation.is_finite()), "{outcome:?}");
    }
}
