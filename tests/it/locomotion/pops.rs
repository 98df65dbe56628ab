//! Changes of state that nobody notices as such: no joint jerks more than it does within the states themselves.
//!
//! Without foot IK, whose own steps are measured elsewhere.

use bevy::prelude::*;
use surefoot::{
    character::intent::MoveIntent,
    measure::{frame::Frame, summary::Measures},
    testing::{Cue, Stage, Tape, World},
};

use super::walker_on;

/// A walker without foot IK.
fn walker() -> (Stage, Entity) {
    let (mut stage, walker) = walker_on(&World::flat());
    stage.set_foot_ik(walker, false);
    (stage, walker)
}

fn play(stage: &mut Stage, walker: Entity, seconds: f32, intents: &[(f32, MoveIntent)]) -> Measures {
    let cues = intents.iter().map(|(at, intent)| Cue { at: *at, intent: intent.clone() }).collect();
    let tape = Tape { name: String::new(), cues, seconds };
    stage.start_recording(walker).play(walker, &tape);
    stage.measures(walker)
}

/// Largest angular speed of a joint, °/s, and largest jump of a joint's velocity in a frame, m/s.
fn liveliest(frames: &[Frame]) -> (f32, f32) {
    let largest = |of: fn(&Frame) -> f32| frames.iter().map(of).fold(0.0, f32::max);
    (largest(|frame| frame.joint_speed).to_degrees(), largest(|frame| frame.velocity_jump))
}

/// Plays the intents, each from its second on, and compares with the worst of them played for good.
fn assert_smooth(name: &str, seconds: f32, intents: &[(f32, MoveIntent)]) {
    let (mut stage, walker) = walker();
    play(&mut stage, walker, seconds, intents);
    let (got_speed, got_jump) = liveliest(stage.frames(walker));
    let (mut speed, mut jump) = (0.0f32, 0.0f32);
    for (_, intent) in intents {
        stage.intend(walker, intent.clone()).run_for(1.0);
        play(&mut stage, walker, 1.1, &[(0.0, intent.clone())]);
        let settled = liveliest(stage.frames(walker));
        (speed, jump) = (speed.max(settled.0), jump.max(settled.1));
    }
    println!("{name}: {got_speed:.0} of {speed:.0}°/s, {got_jump:.2} of {jump:.2} m/s");
    assert!(got_speed <= 2.0 * speed, "{name}: a joint turns at {got_speed:.0}°/s, within states at {speed:.0}°/s");
    assert!(
        got_jump <= 2.0 * jump,
        "{name}: a joint's velocity jumps by {got_jump:.2} m/s in a frame, within states by {jump:.2} m/s"
    );
}

fn go(speed: f32) -> MoveIntent {
    MoveIntent { velocity: Vec3::NEG_Z * speed, ..default() }
}

fn aim(velocity: Vec3) -> MoveIntent {
    MoveIntent { velocity, facing: Some(Vec3::NEG_Z), ..default() }
}

fn low(speed: f32) -> MoveIntent {
    MoveIntent { crouch: true, ..go(speed) }
}

#[test]
fn from_gait_to_gait() {
    assert_smooth(
        "walk, run, sprint and back",
        6.0,
        &[(0.2, go(1.4)), (1.5, go(3.5)), (2.5, go(6.0)), (4.0, go(1.4)), (5.0, go(0.0))],
    );
}

#[test]
fn from_standing_to_a_walk_and_back() {
    assert_smooth("start and stop", 3.0, &[(0.2, go(1.4)), (1.3, go(0.0)), (1.5, go(1.4)), (2.2, go(0.0))]);
}

#[test]
fn down_and_up_again() {
    assert_smooth(
        "crouch and rise",
        5.0,
        &[(0.2, low(0.0)), (1.0, low(1.0)), (2.5, go(1.4)), (3.5, low(0.0)), (4.2, go(0.0))],
    );
}

#[test]
fn from_side_to_side() {
    let (left, right, back) = (Vec3::NEG_X * 1.2, Vec3::X * 1.2, Vec3::Z * 1.1);
    assert_smooth(
        "sidesteps",
        6.0,
        &[
            (0.2, aim(left)),
            (1.5, aim(right)),
            (2.7, aim(back)),
            (3.9, aim(left)),
            (4.8, go(1.4)),
            (5.4, aim(Vec3::ZERO)),
        ],
    );
}

#[test]
fn off_the_ground_no_joint_spins() {
    // A run's knee turns at 1000°/s. A take-off shows at once, hence is fast.
    let jump = |speed| MoveIntent { jump: true, ..go(speed) };
    for (name, speed) in [("jump", 0.0), ("running jump", 3.5)] {
        let (mut stage, walker) = walker();
        stage.intend(walker, go(speed)).run_for(1.0);
        let got = play(&mut stage, walker, 2.0, &[(0.0, go(speed)), (0.5, jump(speed)), (0.9, go(speed))]);
        let (speed, _) = liveliest(stage.frames(walker));
        println!("{name}: {speed:.0}°/s");
        assert!(speed < 2500.0, "{name}: a joint turns at {speed:.0}°/s");
        assert_eq!(got.knee_hyperextended, 0, "{name}: knees bend backward");
    }
}
