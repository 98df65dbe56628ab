//! Arm and head point where a character aims, whatever its legs do.

use bevy::prelude::*;
use surefoot::{
    anim::{leg::Leg, matrix::JointMatrix},
    character::{aim::Aiming, animator::CharacterPose, intent::MoveIntent},
    rig::{
        humanoid::HumanoidRole::{
            self, Head, LeftHand, LeftUpperArm, RightHand, RightLowerArm, RightShoulder, RightUpperArm, UpperChest,
        },
        tuning::aim::AimingArms,
    },
    testing::{Stage, World},
};

use crate::support::assert_no_pop;

const FRAME: f32 = 1.0 / 60.0;

/// A walker who has stood for half a second.
fn walker() -> (Stage, Entity) {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.5);
    (stage, walker)
}

/// World direction of this yaw to the left and pitch up, degrees.
fn way(yaw: f32, pitch: f32) -> Vec3 {
    Quat::from_rotation_y(yaw.to_radians()) * Quat::from_rotation_x(pitch.to_radians()) * Vec3::NEG_Z
}

/// Faces -Z, goes at `velocity` and aims along `aim`.
fn aim(velocity: Vec3, aim: Option<Vec3>) -> MoveIntent {
    MoveIntent { velocity, facing: Some(Vec3::NEG_Z), aim, ..default() }
}

fn joint(stage: &Stage, walker: Entity, role: HumanoidRole) -> (Vec3, Quat) {
    let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
    let joint = stage.asset(walker).expect("loaded").humanoid.get(role).expect("the mannequin has it");
    (pose.position(joint), pose.rotation(joint))
}

/// Angle in degrees between the arm, from shoulder to wrist, and a direction in model space.
fn arm_off(stage: &Stage, walker: Entity, [shoulder, hand]: [HumanoidRole; 2], way: Vec3) -> f32 {
    let [shoulder, hand] = [shoulder, hand].map(|role| joint(stage, walker, role).0);
    (hand - shoulder).angle_between(way).to_degrees()
}

const RIGHT: [HumanoidRole; 2] = [RightUpperArm, RightHand];
const LEFT: [HumanoidRole; 2] = [LeftUpperArm, LeftHand];

#[test]
fn the_arm_points_where_it_aims_while_the_legs_go_any_way() {
    let (mut stage, walker) = walker();
    for velocity in [Vec3::ZERO, Vec3::NEG_Z * 1.4, Vec3::X * 1.2, Vec3::NEG_X * 1.2, Vec3::Z * 1.1, Vec3::NEG_Z * 3.5]
    {
        for (yaw, pitch) in [(0.0, 0.0), (30.0, 20.0), (-50.0, -40.0), (20.0, 55.0)] {
            stage.intend(walker, aim(velocity, Some(way(yaw, pitch)))).run_for(0.8);
            for _ in 0..30 {
                stage.run_for(FRAME);
                let root = stage.get::<Transform>(walker).expect("spawned").rotation;
                let off = arm_off(&stage, walker, RIGHT, root.inverse() * way(yaw, pitch));
                assert!(off < 1.0, "going {velocity} the arm is {off:.2}° off an aim {yaw}° aside and {pitch}° up");
            }
        }
    }
}

#[test]
fn the_hand_goes_on_where_the_arm_points_and_the_other_arm_hangs() {
    let (mut stage, walker) = walker();
    stage.intend(walker, aim(Vec3::ZERO, Some(way(0.0, 0.0)))).run_for(1.0);
    // The mannequin's hand points along its own X at rest, to the character's right.
    let pose = surefoot::anim::pose::Pose::rest(&stage.asset(walker).expect("loaded").skeleton);
    let hand = stage.asset(walker).expect("loaded").humanoid.get(RightHand).expect("the mannequin has it");
    let turn = joint(&stage, walker, RightHand).1 * pose.rotation(hand).inverse();
    let off = (turn * Vec3::X).angle_between(Vec3::NEG_Z).to_degrees();
    assert!(off < 3.0, "the hand points {off:.1}° off the aim");
    let thumb = (turn * Vec3::NEG_Z).dot(Vec3::Y);
    assert!(thumb > 0.3, "the thumb's side points up by {thumb:.2}");
    let hangs = arm_off(&stage, walker, LEFT, Vec3::NEG_Y);
    assert!(hangs < 30.0, "the left arm hangs {hangs:.0}° off the plumb line");
}

#[test]
fn the_file_says_which_arms_aim() {
    for (arms, [left, right]) in
        [(AimingArms::Left, [true, false]), (AimingArms::Right, [false, true]), (AimingArms::Both, [true, true])]
    {
        let (mut stage, walker) = walker();
        stage.tune(walker, |file| file.aim.arms = arms);
        stage.intend(walker, aim(Vec3::ZERO, Some(way(0.0, 10.0)))).run_for(0.8);
        for (side, wanted) in [(LEFT, left), (RIGHT, right)] {
            let off = arm_off(&stage, walker, side, way(0.0, 10.0));
            assert_eq!(off < 1.0, wanted, "{arms:?}: {side:?} is {off:.1}° off the aim");
        }
    }
}

#[test]
fn the_head_follows_the_aim_as_far_as_the_neck_goes() {
    let (mut stage, walker) = walker();
    stage.intend(walker, aim(Vec3::ZERO, None)).run_for(0.5);
    let (_, before) = joint(&stage, walker, Head);
    for (yaw, pitch, least) in [(0.0, 25.0, 20.0), (0.0, -25.0, 20.0), (25.0, 0.0, 20.0)] {
        stage.intend(walker, aim(Vec3::ZERO, Some(way(yaw, pitch)))).run_for(1.0);
        let turned = joint(&stage, walker, Head).1 * before.inverse() * Vec3::NEG_Z;
        let toward = turned.angle_between(Vec3::NEG_Z).to_degrees();
        let off = turned.angle_between(way(yaw, pitch)).to_degrees();
        assert!(toward > least && off < 6.0, "aiming {yaw}° aside, {pitch}° up, the head looks {off:.1}° off");
    }
}

#[test]
fn the_arm_stays_within_its_limits_and_never_swings_round_the_back() {
    let (mut stage, walker) = walker();
    let mut last = None;
    for step in 0u16..=180 {
        let behind = way(-90.0 - f32::from(step), 0.0);
        stage.intend(walker, aim(Vec3::ZERO, Some(behind))).run_for(FRAME);
        let [shoulder, hand] = RIGHT.map(|role| joint(&stage, walker, role).0);
        let ahead = (hand - shoulder).normalize();
        if step > 40 {
            assert!(ahead.z < 0.0, "at step {step} the arm points behind: {ahead}");
            let moved = last.map_or(0.0, |last: Vec3| last.angle_between(ahead).to_degrees());
            assert!(moved < 15.0, "at step {step} the arm jumps by {moved:.0}°");
        }
        last = Some(ahead);
    }
}

#[test]
fn aiming_comes_and_goes_without_pops_and_leaves_the_feet_alone() {
    let run = |aims: bool| {
        let (mut stage, walker) = walker();
        stage.intend(walker, aim(Vec3::X * 1.2, None)).run_for(1.5).start_recording(walker);
        let mut legs = Vec::new();
        for frame in 0u16..150 {
            let aimed = aims && (20..100).contains(&frame);
            let to = way(0.3 * f32::from(frame), 20.0 - 0.4 * f32::from(frame));
            stage.intend(walker, aim(Vec3::X * 1.2, aimed.then_some(to))).run_for(FRAME);
            let asset = stage.asset(walker).expect("loaded");
            let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
            legs.extend(asset.legs.iter().flat_map(Leg::joints).map(|joint| pose.local(joint)));
        }
        let weight = stage.get::<Aiming>(walker).expect("bound").weight();
        assert!(weight <= 0.0, "the arm is still raised by {weight}");
        (stage.measures(walker), legs)
    };
    let ((with, legs), (without, plain)) = (run(true), run(false));
    assert!(legs == plain, "aiming moves the legs");
    assert_eq!(with.drift_max.to_bits(), without.drift_max.to_bits(), "a plant drifts by {} mm", with.drift_max);
    assert_no_pop("aiming", &with);
}

#[test]
fn a_nonsensical_aim_is_none() {
    let (mut stage, walker) = walker();
    for nonsense in [Vec3::ZERO, Vec3::NAN, Vec3::INFINITY] {
        stage.intend(walker, aim(Vec3::ZERO, Some(nonsense))).run_for(0.3);
        let hangs = arm_off(&stage, walker, RIGHT, Vec3::NEG_Y);
        assert!(hangs < 30.0, "{nonsense} raises the arm to {hangs:.0}°");
    }
    for steep in [Vec3::Y, Vec3::NEG_Y, Vec3::new(1e-20, 1e-20, 0.0)] {
        stage.intend(walker, aim(Vec3::ZERO, Some(steep))).run_for(0.6);
        let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
        assert!(pose.models().iter().all(JointMatrix::is_finite), "{steep} breaks the pose");
    }
}

/// A walker who goes at `velocity`, whose aim jumps from one place to the next; measured at this frame rate.
fn jumping_aim(velocity: Vec3, hertz: f32) -> (Stage, Entity) {
    let (mut stage, walker) = walker();
    stage.set_frame_rate(hertz);
    stage.intend(walker, aim(velocity, None)).run_for(1.5).start_recording(walker);
    for (yaw, pitch) in [(0.0, 0.0), (-70.0, 40.0), (60.0, -30.0), (-70.0, -55.0), (70.0, 55.0)] {
        stage.intend(walker, aim(velocity, Some(way(yaw, pitch)))).run_for(0.8);
    }
    stage.intend(walker, aim(velocity, None)).run_for(0.8);
    (stage, walker)
}

#[test]
fn an_aim_that_jumps_makes_no_pop() {
    for velocity in [Vec3::ZERO, Vec3::NEG_Z * 1.4, Vec3::X * 1.2, Vec3::NEG_Z * 3.5] {
        let (stage, walker) = jumping_aim(velocity, 60.0);
        assert_no_pop(&format!("going {velocity}, an aim that jumps"), &stage.measures(walker));
    }
}

#[test]
fn an_aim_that_jumps_is_reached_alike_at_every_frame_rate() {
    let off = |hertz: f32| {
        let (mut stage, walker) = walker();
        stage.set_frame_rate(hertz);
        stage.intend(walker, aim(Vec3::ZERO, Some(way(-60.0, 0.0)))).run_for(1.0);
        stage.intend(walker, aim(Vec3::ZERO, Some(way(60.0, 0.0))));
        [0.1, 0.1, 0.1, 0.4].map(|seconds| {
            stage.run_for(seconds);
            arm_off(&stage, walker, RIGHT, way(60.0, 0.0))
        })
    };
    let [slow, usual, fast] = [30.0, 60.0, 120.0].map(off);
    for ((slow, usual), fast) in slow.into_iter().zip(usual).zip(fast) {
        assert!((slow - usual).abs() < 1.5 && (fast - usual).abs() < 1.5, "{slow}° off, {usual}° and {fast}°");
    }
    assert!(usual[0] > 60.0, "after 0.1 s the arm is only {}° off: it jumped", usual[0]);
    assert!(usual[3] < 1.5, "after 0.7 s the arm is still {}° off", usual[3]);
}

#[test]
fn elbow_and_wrist_stay_within_a_humans_range() {
    let (mut stage, walker) = walker();
    for reach in [0.3, 0.6, 0.96, 1.0] {
        stage.tune(walker, |file| file.aim.reach = reach);
        for (yaw, pitch) in [(0.0, 0.0), (-90.0, 60.0), (90.0, 60.0), (-90.0, -60.0), (90.0, -60.0), (0.0, 85.0)] {
            stage.intend(walker, aim(Vec3::ZERO, Some(way(yaw, pitch)))).run_for(0.9);
            let case = format!("aiming {yaw}° aside and {pitch}° up with a reach of {reach}");
            let [shoulder, elbow, wrist] =
                [RightUpperArm, RightLowerArm, RightHand].map(|role| joint(&stage, walker, role).0);
            let forearm = wrist - elbow;
            let bend = (elbow - shoulder).angle_between(forearm).to_degrees();
            assert!((0.0..150.0).contains(&bend), "{case} the elbow bends by {bend:.0}°");
            let line = (wrist - shoulder).normalize();
            let down = (elbow - shoulder).reject_from(line);
            assert!(down.length() < 0.02 || down.y < 0.0, "{case} the elbow points up: {down}");
            let rest = surefoot::anim::pose::Pose::rest(&stage.asset(walker).expect("loaded").skeleton);
            let hand = stage.asset(walker).expect("loaded").humanoid.get(RightHand).expect("the mannequin has it");
            let along = joint(&stage, walker, RightHand).1 * rest.rotation(hand).inverse() * Vec3::X;
            let wrist_bend = along.angle_between(forearm).to_degrees();
            assert!(wrist_bend < 80.0, "{case} the wrist bends by {wrist_bend:.0}°");
        }
    }
}

#[test]
fn spine_and_shoulder_take_part_of_a_wide_aim_and_the_head_stays_with_it() {
    let turned = |trunk: f32, shoulder: f32| {
        let (mut stage, walker) = walker();
        stage.tune(walker, |file| (file.aim.trunk, file.aim.shoulder) = (trunk, shoulder));
        stage.intend(walker, aim(Vec3::ZERO, None)).run_for(0.5);
        let before = [UpperChest, RightShoulder].map(|role| joint(&stage, walker, role).1);
        stage.intend(walker, aim(Vec3::ZERO, Some(way(70.0, 0.0)))).run_for(1.5);
        let off = arm_off(&stage, walker, RIGHT, way(70.0, 0.0));
        assert!(off < 1.0, "the arm is {off:.2}° off");
        let now = [UpperChest, RightShoulder].map(|role| joint(&stage, walker, role).1);
        let yaw = |place: usize| {
            let ahead = now[place] * before[place].inverse() * Vec3::NEG_Z;
            surefoot::math::rotation::heading(ahead).to_degrees()
        };
        let head = joint(&stage, walker, Head).1 * Vec3::NEG_Z;
        ([yaw(0), yaw(1)], head)
    };
    let ([still, _], head) = turned(0.0, 0.0);
    let ([chest, shoulder], turned_head) = turned(0.25, 0.12);
    assert!(
        (chest - still - 17.5).abs() < 2.0,
        "the chest turns by {chest:.1}°, {still:.1}° of which the head asks for"
    );
    assert!((shoulder - chest - 8.4).abs() < 2.0, "the shoulder turns by {:.1}° more", shoulder - chest);
    let apart = head.angle_between(turned_head).to_degrees();
    assert!(apart < 1.0, "the head looks {apart:.1}° elsewhere than it does without");
}
