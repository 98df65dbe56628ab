//! Jumps, falls and landings.

use bevy::prelude::*;
use surefoot::{
    character::{animator::CharacterPose, intent::MoveIntent},
    math::rotation::angle_between,
    testing::{Piece, Stage, World},
};

use super::{clip_weight, state, walker_on};

/// States passed through within `seconds`, each once, in order.
fn states(stage: &mut Stage, walker: Entity, seconds: f32) -> Vec<String> {
    let mut passed: Vec<String> = Vec::new();
    for _ in 0..(seconds * 60.0) as usize {
        stage.run_for(1.0 / 60.0);
        let now = state(stage, walker);
        if passed.last() != Some(&now) {
            passed.push(now);
        }
    }
    passed
}

fn jump(velocity: Vec3) -> MoveIntent {
    MoveIntent { velocity, jump: true, ..default() }
}

#[test]
fn a_jump_on_the_spot_is_caught_with_both_legs() {
    let (mut stage, walker) = walker_on(&World::flat());
    stage.intend(walker, jump(Vec3::ZERO));
    assert_eq!(states(&mut stage, walker, 1.1), ["jump", "fall", "land_light"]);
    assert!(clip_weight(&stage, walker, "land_light") > 0.999);
    assert_eq!(states(&mut stage, walker, 0.7).last().map(String::as_str), Some("idle"));
}

#[test]
fn a_jump_shows_within_two_frames() {
    let (mut stage, walker) = walker_on(&World::flat());
    let pose = |stage: &Stage| stage.get::<CharacterPose>(walker).expect("bound").pose.locals().to_vec();
    let before = pose(&stage);
    stage.intend(walker, jump(Vec3::ZERO)).run_for(2.0 / 60.0);
    let turned = pose(&stage)
        .iter()
        .zip(&before)
        .map(|(now, then)| angle_between(now.rotation, then.rotation).to_degrees())
        .fold(0.0, f32::max);
    // A frame shows a tick's pose by and by.
    assert!(turned > 1.5, "after two frames no joint has turned by more than {turned:.1}°");
    assert!(stage.root(walker).y > 0.05, "the root is only {} m up", stage.root(walker).y);
}

#[test]
fn a_running_jump_lands_running() {
    let (mut stage, walker) = walker_on(&World::flat());
    stage.walk(walker, Vec3::NEG_Z * 3.5).run_for(1.5);
    stage.intend(walker, jump(Vec3::NEG_Z * 3.5));
    assert_eq!(states(&mut stage, walker, 1.2), ["jump", "fall", "run"]);
}

#[test]
fn a_step_off_a_high_ledge_is_a_hard_landing() {
    let mut ground = World::flat();
    ground.pieces.push(Piece::block(Vec3::new(4.0, 3.0, 4.0), Transform::from_xyz(0.0, 1.5, 10.0)));
    let mut stage = Stage::on(&ground);
    let high = Transform::from_xyz(0.0, 3.0, 8.5);
    let walker = stage.spawn_character("mannequin.character.ron", high).expect("the mannequin loads");
    stage.run_for(0.3).walk(walker, Vec3::NEG_Z * 1.4).run_for(0.6).walk(walker, Vec3::ZERO);
    let passed = states(&mut stage, walker, 1.3);
    assert!(passed.ends_with(&["fall".to_owned(), "land_hard".to_owned()]), "passed through {passed:?}");
    assert_eq!(states(&mut stage, walker, 1.5).last().map(String::as_str), Some("idle"));
}

#[test]
fn whatever_the_height_of_a_fall_the_soles_stay_on_the_ground() {
    for height in [0.6f32, 1.5, 3.5, 8.0] {
        let mut stage = Stage::on(&World::flat());
        let high = Transform::from_xyz(0.0, height, 0.0);
        let walker = stage.spawn_character("mannequin.character.ron", high).expect("the mannequin loads");
        stage.start_recording(walker).run_for(3.0);
        let measures = stage.measures(walker);
        assert!(measures.penetration_max < 15.0, "from {height} m a sole sinks by {:.1} mm", measures.penetration_max);
        assert!(measures.drift_max < 20.0, "from {height} m a plant drifts by {:.1} mm", measures.drift_max);
        assert_eq!(measures.knee_hyperextended, 0, "from {height} m knees bend backward");
        let lowest = stage.frames(walker).iter().map(|frame| frame.pelvis).fold(f32::MAX, f32::min);
        assert!(lowest > 0.35, "from {height} m the pelvis comes down to {lowest:.2} m");
    }
}

#[test]
fn a_landing_catches_the_body_without_a_jolt() {
    let (mut stage, walker) = walker_on(&World::flat());
    stage.intend(walker, jump(Vec3::ZERO)).run_for(0.5).start_recording(walker).run_for(1.5);
    let measures = stage.measures(walker);
    assert!(measures.penetration_max < 5.0, "a sole sinks by {:.1} mm", measures.penetration_max);
    assert_eq!(measures.knee_hyperextended, 0, "knees bend backward");
    // From 5 m/s: 300 m/s² if the body stopped with the feet.
    assert!(measures.pelvis_max < 100.0, "the pelvis is jolted by {:.0} m/s²", measures.pelvis_max);
}
