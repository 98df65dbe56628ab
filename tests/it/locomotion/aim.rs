//! Facing one way: sidesteps, walking backward, turns on the spot.

use bevy::prelude::*;
use surefoot::{
    character::intent::MoveIntent,
    testing::{Stage, World},
};

use super::{clip_weight, head_top, state, walker_on};

fn aim(velocity: Vec3, facing: Vec3) -> MoveIntent {
    MoveIntent { velocity, facing: Some(facing), ..default() }
}

fn yaw(stage: &Stage, walker: Entity) -> f32 {
    stage.get::<Transform>(walker).expect("spawned").rotation.to_euler(EulerRot::YXZ).0.to_degrees()
}

#[test]
fn who_aims_sidesteps_and_walks_backward() {
    let (mut stage, walker) = walker_on(&World::flat());
    for (velocity, clip) in [
        (Vec3::NEG_X * 1.2, "strafe_left"),
        (Vec3::X * 1.2, "strafe_right"),
        (Vec3::Z * 1.1, "walk_back"),
        (Vec3::NEG_Z * 1.4, "walk"),
        (Vec3::NEG_Z * 3.5, "run"),
    ] {
        stage.intend(walker, aim(velocity, Vec3::NEG_Z)).run_for(1.5);
        assert_eq!(state(&stage, walker), "strafe", "going {velocity}");
        let weight = clip_weight(&stage, walker, clip);
        assert!(weight > 0.99, "going {velocity} {clip} weighs {weight}");
        let yaw = yaw(&stage, walker);
        assert!(yaw.abs() < 0.1, "it turned by {yaw}° while going {velocity}");
    }
}

#[test]
fn who_aims_in_a_crouch_sidesteps_and_backs_off_low() {
    let (mut stage, walker) = walker_on(&World::flat());
    for (velocity, clip) in
        [(Vec3::NEG_X * 1.2, "crouch_left"), (Vec3::X * 1.2, "crouch_right"), (Vec3::Z * 1.1, "crouch_back")]
    {
        stage.intend(walker, MoveIntent { crouch: true, ..aim(velocity, Vec3::NEG_Z) }).run_for(1.5);
        assert_eq!(state(&stage, walker), "crouch_strafe", "going {velocity}");
        let weight = clip_weight(&stage, walker, clip);
        assert!(weight > 0.99, "going {velocity} {clip} weighs {weight}");
        let top = head_top(&stage, walker);
        assert!(top < 1.4, "going {velocity} the crown is {top:.2} m up");
    }
}

#[test]
fn feet_hold_still_whichever_way_it_goes() {
    let (mut stage, walker) = walker_on(&World::flat());
    for degrees in [0.0f32, 30.0, 60.0, 90.0, 135.0, 180.0, 300.0] {
        let way = Quat::from_rotation_y(degrees.to_radians()) * Vec3::NEG_Z;
        stage.intend(walker, aim(way * 1.3, Vec3::NEG_Z)).run_for(1.5).start_recording(walker).run_for(2.0);
        let measures = stage.measures(walker);
        assert!(measures.drift_max < 20.0, "going {degrees}° aside a plant drifts by {:.1} mm", measures.drift_max);
        let missed = measures.reach_max.unwrap_or(0.0);
        assert!(missed < 5.0, "going {degrees}° aside an ankle misses by {missed:.1} mm");
    }
}

#[test]
fn sidesteps_are_no_faster_than_feet_close_and_open() {
    let (mut stage, walker) = walker_on(&World::flat());
    stage.intend(walker, aim(Vec3::X * 5.0, Vec3::NEG_Z)).run_for(2.0);
    let from = stage.root(walker);
    stage.run_for(1.0);
    let speed = stage.root(walker).distance(from);
    assert!((speed - 1.8).abs() < 0.05, "sidesteps at {speed} m/s");
}

#[test]
fn a_turn_on_the_spot_steps_round() {
    for degrees in [45.0f32, 90.0, 170.0, -90.0] {
        let (mut stage, walker) = walker_on(&World::flat());
        let facing = Quat::from_rotation_y(degrees.to_radians()) * Vec3::NEG_Z;
        stage.start_recording(walker).intend(walker, aim(Vec3::ZERO, facing)).run_for(0.2);
        let turning = if degrees > 0.0 { "turn_left" } else { "turn_right" };
        assert_eq!(state(&stage, walker), turning, "turning by {degrees}°");
        stage.run_for(2.0);
        assert_eq!(state(&stage, walker), "idle", "turned by {degrees}°");
        let off = yaw(&stage, walker) - degrees;
        let off = (off + 180.0).rem_euclid(360.0) - 180.0;
        assert!(off.abs() < 1.0, "it faces {off}° off after a turn by {degrees}°");
        let measures = stage.measures(walker);
        assert!(measures.drift_max < 20.0, "turning by {degrees}° a plant drifts by {:.1} mm", measures.drift_max);
        assert!(measures.stances > 2, "turning by {degrees}° feet never step");
    }
}
