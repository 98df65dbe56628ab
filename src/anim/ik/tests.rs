//! What every solver of chains has to hold, whatever carries the chain.

use bevy::math::{Affine3A, Quat, Vec3, ops};
use proptest::{prelude::*, test_runner::RngSeed};

use super::{
    ccd,
    chain::{
        ChainJoint, Goal, Outcome, Workspace, end, into_chain, length, places,
        samples::{chain, direction, limb, limit, posed, rotation, space},
    },
    fabrik,
    limits::Limit,
};

type Solve = fn(&mut [ChainJoint], &Goal, &mut Workspace) -> Outcome;

const SOLVERS: [(&str, Solve); 2] = [("CCD", ccd::solve), ("FABRIK", fabrik::solve)];
/// A millimetre.
const NEAR: f32 = 1e-3;
const EFFECTOR: Vec3 = Vec3::new(0.05, 0.2, 0.1);

/// A goal in model space, for a chain that `model_from_chain` carries.
fn goal(model_from_chain: &Affine3A, target_model: Vec3) -> Goal {
    let target = into_chain(model_from_chain, target_model).unwrap();
    Goal { target, effector: EFFECTOR, tolerance: 1e-4, iterations: 60, retries: 60 }
}

fn end_model(model_from_chain: &Affine3A, joints: &[ChainJoint]) -> Vec3 {
    model_from_chain.transform_point3(end(joints, EFFECTOR))
}

fn stretched(joints: &[ChainJoint]) -> (Vec3, f32) {
    let mut points = vec![Vec3::ZERO; joints.len() + 1];
    places(joints, EFFECTOR, &mut points);
    (points[0], length(&points))
}

fn turns() -> impl Strategy<Value = Vec<Quat>> {
    proptest::collection::vec(rotation(), 7)
}

proptest! {
    // No method finds the way round every limit; these find 30,000 of 30,000 at random, and the same 512 every time.
    #![proptest_config(ProptestConfig { cases: 512, rng_seed: RngSeed::Fixed(5), ..ProptestConfig::default() })]

    #[test]
    fn what_is_within_reach_and_limits_is_reached(joints in limb(), turns in turns(), space in space()) {
        let target = end_model(&space, &posed(&joints, &turns));
        for (name, solve) in SOLVERS {
            let mut joints = joints.clone();
            let outcome = solve(&mut joints, &goal(&space, target), &mut Workspace::default());
            let missed = end_model(&space, &joints).distance(target);
            prop_assert!(missed < NEAR && outcome.reached, "{name} missed by {} mm: {outcome:?}", missed * 1000.0);
        }
    }
}

proptest! {
    #[test]
    fn no_limit_is_ever_exceeded(joints in chain(limit()), target in direction(), far in 0.0f32..3.0) {
        for (name, solve) in SOLVERS {
            let mut joints = joints.clone();
            solve(&mut joints, &goal(&Affine3A::IDENTITY, target * far), &mut Workspace::default());
            for joint in &joints {
                prop_assert!(joint.excess() < 2e-3, "{name}: {} rad beyond {:?}", joint.excess(), joint.limit);
            }
        }
    }

    #[test]
    fn a_chain_points_straight_to_what_is_out_of_reach(joints in chain(Just(Limit::Free)), way in direction(), beyond in 1.001f32..5.0, space in space()) {
        let (root, length) = stretched(&joints);
        let target = space.transform_point3(root + way * (length * beyond));
        for (name, solve) in SOLVERS {
            let mut joints = joints.clone();
            let outcome = solve(&mut joints, &goal(&space, target), &mut Workspace::default());
            let stretch = end(&joints, EFFECTOR).distance(root + way * length) / length;
            prop_assert!(stretch < 1e-3, "{name}: the end is {stretch} of its length away from the straight line");
            let left = length * (beyond - 1.0);
            prop_assert!((outcome.missed - left).abs() < 2e-3 * length && !outcome.reached, "{name} says it missed by {} of {left}", outcome.missed);
        }
    }

    #[test]
    fn the_same_input_gives_the_same_pose_whatever_was_solved_before(joints in chain(limit()), targets in proptest::collection::vec(direction(), 2)) {
        for (name, solve) in SOLVERS {
            let (mut first, mut again) = (joints.clone(), joints.clone());
            let mut room = Workspace::for_joints(3);
            solve(&mut first, &goal(&Affine3A::IDENTITY, targets[0]), &mut room);
            solve(&mut joints.clone(), &goal(&Affine3A::IDENTITY, targets[1]), &mut room);
            solve(&mut again, &goal(&Affine3A::IDENTITY, targets[0]), &mut room);
            prop_assert!(first == again, "{name}");
        }
    }

    #[test]
    fn a_pose_that_is_there_already_stays(joints in chain(limit())) {
        let target = end(&joints, EFFECTOR);
        for (name, solve) in SOLVERS {
            let mut solved = joints.clone();
            solve(&mut solved, &goal(&Affine3A::IDENTITY, target), &mut Workspace::default());
            for (solved, joint) in solved.iter().zip(&joints) {
                let moved = solved.local.rotation.angle_between(joint.local.rotation);
                prop_assert!(moved < 2e-3, "{name} turned a joint by {moved} rad for nothing");
            }
        }
    }

    #[test]
    fn anything_goes_in_and_no_nan_comes_out(joints in chain(limit()), target in direction(), broken in 0u32..64) {
        let mut joints = joints;
        let count = joints.len();
        let at = |index: usize| index % count;
        if broken & 1 != 0 { joints[at(1)].local.translation = Vec3::ZERO; }
        if broken & 2 != 0 { joints[at(2)].local.scale = Vec3::new(1.0, 0.0, 1.0); }
        if broken & 4 != 0 { joints[at(3)].local.rotation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0); }
        if broken & 8 != 0 { joints[at(4)].local.translation = Vec3::NAN; }
        let target = match broken >> 4 { 0 => target, 1 => joints[0].local.translation, 2 => Vec3::splat(f32::INFINITY), _ => Vec3::ZERO };
        let goal = Goal { target, effector: Vec3::ZERO, tolerance: 1e-4, iterations: 20, retries: 4 };
        for (name, solve) in SOLVERS {
            let mut joints = joints.clone();
            let outcome = solve(&mut joints, &goal, &mut Workspace::default());
            prop_assert!(!outcome.missed.is_nan(), "{name}: {outcome:?}");
            for joint in &joints {
                prop_assert!(joint.local.rotation.is_finite(), "{name}: {joint:?}");
            }
        }
    }
}

/// Three bones of 0.3 m, straight up.
fn straight() -> Vec<ChainJoint> {
    let mut joints = vec![ChainJoint::default(); 3];
    for joint in &mut joints[1..] {
        joint.local.translation = Vec3::Y * 0.3;
    }
    joints
}

#[test]
fn a_straight_chain_folds_to_a_target_in_its_own_line() {
    for (name, solve) in SOLVERS {
        let mut joints = straight();
        let goal = Goal { target: Vec3::Y * 0.5, effector: Vec3::Y * 0.3, tolerance: 1e-4, iterations: 60, retries: 8 };
        let outcome = solve(&mut joints, &goal, &mut Workspace::default());
        assert!(outcome.reached, "{name}: {outcome:?}");
    }
}

#[test]
fn a_target_on_the_root_or_on_a_joint_is_reached() {
    for (name, solve) in SOLVERS {
        for target in [Vec3::ZERO, Vec3::Y * 0.3, Vec3::Y * 0.6] {
            let mut joints = straight();
            let goal = Goal { target, effector: Vec3::Y * 0.3, tolerance: 1e-4, iterations: 60, retries: 8 };
            let outcome = solve(&mut joints, &goal, &mut Workspace::default());
            assert!(outcome.reached, "{name} to {target}: {outcome:?}");
        }
    }
}

/// An arm like a human one: a shoulder, an elbow, a wrist; bones of 0.3, 0.28 and 0.1 m along X.
fn arm() -> Vec<ChainJoint> {
    let mut joints = straight();
    joints[0].limit = Limit::Cone { axis: Vec3::X, swing: 2.0, twist: [-1.5, 1.5] };
    joints[1].limit = Limit::Hinge { axis: Vec3::Y, min: 0.0, max: 2.6 };
    joints[2].limit = Limit::Cone { axis: Vec3::X, swing: 1.0, twist: [-1.0, 1.0] };
    joints[2].give = 0.2;
    joints[1].local.translation = Vec3::X * 0.3;
    joints[2].local.translation = Vec3::X * 0.28;
    for (joint, bend) in joints.iter_mut().zip([0.9, 0.6, 0.1]) {
        joint.local.rotation = Quat::from_rotation_y(bend);
    }
    joints
}

#[test]
fn a_target_that_moves_little_moves_the_pose_little() {
    let ball = Limit::Cone { axis: Vec3::X, swing: 2.6, twist: [-0.1, 0.1] };
    let elbows = [arm()[1].limit, ball];
    // Degrees for 2 mm, of an end of 0.1 m that alone would turn by 1.1.
    for (((name, solve), elbow), most) in SOLVERS.into_iter().zip(elbows).zip([1.5, 4.0]) {
        let mut last: Option<Vec<ChainJoint>> = None;
        let mut worst = 0.0f32;
        for step in 0..400u16 {
            let angle = f32::from(step) * 0.0157;
            let target =
                Vec3::new(0.42 + 0.1 * ops::cos(angle), 0.12 * ops::sin(angle), -0.25 + 0.05 * ops::sin(2.0 * angle));
            let goal = Goal { target, effector: Vec3::X * 0.1, tolerance: 1e-4, iterations: 60, retries: 8 };
            let mut joints = arm();
            joints[1].limit = elbow;
            let outcome = solve(&mut joints, &goal, &mut Workspace::default());
            assert!(outcome.reached, "{name} missed {target} by {} mm", outcome.missed * 1000.0);
            if let Some(last) = &last {
                for (now, before) in joints.iter().zip(last) {
                    worst = worst.max(now.local.rotation.angle_between(before.local.rotation).to_degrees());
                }
            }
            last = Some(joints);
        }
        assert!(worst < most, "{name}: a joint turned by {worst}° while the target moved by 2 mm");
    }
}
