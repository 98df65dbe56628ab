//! What is laid over the clips: leans and the gaze. Feet stay where they are.

use bevy::{math::ops, prelude::*};
use surefoot::{
    character::{
        animator::{Balance, CharacterPose},
        intent::MoveIntent,
        look::LookAt,
    },
    testing::{Stage, World},
};

use super::{asset, walker_on};

/// Where a joint's forward direction and its top point, in world space: (forward, up).
fn directions(stage: &Stage, walker: Entity, joint: &str) -> (Vec3, Vec3) {
    let root = stage.get::<Transform>(walker).expect("spawned").rotation;
    let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
    let joint = asset(stage, walker).skeleton.find(joint).expect("the mannequin has it");
    let rest = surefoot::anim::pose::Pose::rest(&asset(stage, walker).skeleton).rotation(joint);
    let turn = root * pose.rotation(joint) * rest.inverse();
    (turn * Vec3::NEG_Z, turn * Vec3::Y)
}

/// Runs with and without the lean and gives how far the chest's top goes toward `way`, both.
fn chest_toward(way: Vec3, play: impl Fn(&mut Stage, Entity)) -> [f32; 2] {
    [true, false].map(|enabled| {
        let (mut stage, walker) = walker_on(&World::flat());
        stage.tune(walker, |file| file.balance.enabled = enabled);
        play(&mut stage, walker);
        directions(&stage, walker, "upperChest").1.dot(way)
    })
}

#[test]
fn the_body_leans_into_a_start_and_a_turn() {
    let [with, without] = chest_toward(Vec3::NEG_Z, |stage, walker| {
        stage.walk(walker, Vec3::NEG_Z * 3.5).run_for(0.25);
    });
    assert!(with > without + 0.06, "starting to run the chest leans by {with:.3}, without it by {without:.3}");
    // A circle to the left, 3.5 m/s with a radius of 3.5 m, for a quarter: it goes along -X then.
    let [with, without] = chest_toward(Vec3::Z, |stage, walker| {
        stage.walk(walker, Vec3::NEG_Z * 3.5).run_for(1.0);
        for frame in 1..=94u16 {
            let way = Quat::from_rotation_y(f32::from(frame) / 60.0) * Vec3::NEG_Z;
            stage.walk(walker, way * 3.5).run_for(1.0 / 60.0);
        }
    });
    assert!(with > without + 0.1, "in the turn the chest leans inward by {with:.3}, without it by {without:.3}");
}

#[test]
fn leans_do_not_move_the_feet() {
    let [with, without] = [true, false].map(|enabled| {
        let (mut stage, walker) = walker_on(&World::flat());
        stage.tune(walker, |file| file.balance.enabled = enabled);
        stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(1.5).start_recording(walker);
        for frame in 1..=120u16 {
            let way = Quat::from_rotation_y(f32::from(frame) * 0.012) * Vec3::NEG_Z;
            stage.walk(walker, way * 1.4).run_for(1.0 / 60.0);
        }
        let leans = stage.get::<Balance>(walker).expect("bound").lean.length().to_degrees();
        assert!(leans > 2.0, "it leans by {leans:.1}°");
        stage.measures(walker)
    });
    for (what, with, without) in [
        ("a plant drifts", with.drift_max, without.drift_max),
        ("a sole sinks", with.penetration_max, without.penetration_max),
        ("an ankle misses", with.reach_max.unwrap(), without.reach_max.unwrap()),
    ] {
        assert!(with < without + 1.0, "{what} by {with:.1} mm, without leans by {without:.1} mm");
    }
}

#[test]
fn who_stands_breathes_and_shifts_weight_on_feet_that_stay() {
    let (mut stage, walker) = walker_on(&World::flat());
    let place = |stage: &Stage, joint: &str| {
        let joint = asset(stage, walker).skeleton.find(joint).expect("the mannequin has it");
        stage.get::<CharacterPose>(walker).expect("bound").pose.position(joint)
    };
    let feet = ["leftFoot", "rightFoot"];
    let stood = feet.map(|foot| place(&stage, foot));
    let (mut tilts, mut hips) = (Vec::new(), Vec::new());
    for _ in 0..100 {
        stage.run_for(0.1);
        tilts.push(ops::asin(directions(&stage, walker, "upperChest").1.dot(Vec3::NEG_Z)).to_degrees());
        hips.push(place(&stage, "hips").x * 1000.0);
        for (foot, stood) in feet.into_iter().zip(stood) {
            let moved = place(&stage, foot).distance(stood) * 1000.0;
            assert!(moved < 0.5, "{foot} moved by {moved:.2} mm");
        }
    }
    let range = |values: &[f32]| {
        values.iter().copied().fold(f32::MIN, f32::max) - values.iter().copied().fold(f32::MAX, f32::min)
    };
    let (breath, sway) = (range(&tilts), range(&hips));
    assert!((0.5..4.0).contains(&breath), "the chest rises and falls by {breath:.2}°");
    assert!((10.0..60.0).contains(&sway), "the hips go {sway:.0} mm from side to side");
}

#[test]
fn the_head_turns_before_the_body() {
    let (mut stage, walker) = walker_on(&World::flat());
    stage.intend(walker, MoveIntent { facing: Some(Vec3::NEG_X), ..default() }).run_for(0.14);
    let ahead = |stage: &Stage, joint: &str| directions(stage, walker, joint).0.dot(Vec3::NEG_X);
    let (head, chest) = (ahead(&stage, "head"), ahead(&stage, "upperChest"));
    assert!(head > chest + 0.3, "turning left the head points left by {head:.2}, the chest by {chest:.2}");
    stage.run_for(2.0);
    let (head, chest) = (ahead(&stage, "head"), ahead(&stage, "upperChest"));
    assert!(head > 0.99 && chest > 0.99, "turned, the head points left by {head:.2}, the chest by {chest:.2}");
}

#[test]
fn a_point_is_looked_at() {
    let (mut stage, walker) = walker_on(&World::flat());
    let before = directions(&stage, walker, "head").0;
    stage.app().world_mut().entity_mut(walker).insert(LookAt(Vec3::new(4.0, 1.6, -4.0)));
    stage.run_for(1.0);
    let turned = directions(&stage, walker, "head").0.angle_between(before).to_degrees();
    assert!((40.0..50.0).contains(&turned), "a point 45° to the right turned the head by {turned:.1}°");
    let feet = surefoot::testing::Tape::stand();
    stage.start_recording(walker).play(walker, &feet);
    let measures = stage.measures(walker);
    assert!(measures.drift_max < 0.1, "looking aside moved a foot by {:.2} mm", measures.drift_max);
}

#[test]
fn uphill_the_trunk_leans_to_the_slope() {
    let tilt = |degrees: f32| {
        let (mut stage, walker) = walker_on(&World::slope(degrees));
        stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(2.5);
        (0..64)
            .map(|_| {
                stage.run_for(1.0 / 60.0);
                ops::asin(directions(&stage, walker, "upperChest").1.dot(Vec3::NEG_Z)).to_degrees()
            })
            .sum::<f32>()
            / 64.0
    };
    let (level, up, down) = (tilt(0.0), tilt(15.0), tilt(-15.0));
    assert!(up > level + 4.0, "leans by {up:.1}° up 15°, {level:.1}° on the level");
    assert!(down < level - 1.0, "leans by {down:.1}° down 15°, {level:.1}° on the level");
}
