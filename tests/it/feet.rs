//! Feet on the ground: float, penetration, drift, reach.

use bevy::prelude::*;
use surefoot::{
    character::{Character, animator::CharacterPose, foot_ik::FootIk, sole::sole_model},
    measure::summary::Measures,
    rig::character::CharacterAsset,
    testing::{Stage, Tape, World},
};

fn play(world: &World, tape: &Tape) -> Measures {
    let mut stage = Stage::on(world);
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.5).start_recording(walker).play(walker, tape);
    let measures = stage.measures(walker);
    println!("{} / {}: {measures:#?}", world.name, tape.name);
    measures
}

fn assert_on_the_ground(measures: &Measures, case: &str) {
    let Measures { float_p95, penetration_p99, penetration_max, .. } = *measures;
    assert!(float_p95 <= 10.0, "{case}: feet float by {float_p95:.1} mm (p95)");
    assert!(penetration_p99 <= 5.0, "{case}: feet sink by {penetration_p99:.1} mm (p99)");
    assert!(penetration_max <= 15.0, "{case}: a foot sinks by {penetration_max:.1} mm");
    assert_eq!(measures.knee_hyperextended, 0, "{case}: knees bend backward");
    assert!(measures.extension_max <= 0.9951, "{case}: a leg stretches to {:.4}", measures.extension_max);
}

#[test]
fn standing_on_a_slope_of_15_degrees() {
    let measures = play(&World::slope(15.0), &Tape::stand());
    assert_on_the_ground(&measures, "standing on 15°");
    assert!(measures.drift_max <= 1.0, "a standing foot drifts by {:.1} mm", measures.drift_max);
}

#[test]
fn walking_up_a_ramp_of_15_degrees() {
    assert_on_the_ground(&play(&World::ramp(15.0), &Tape::walk()), "walking up 15°");
}

#[test]
fn walking_up_and_down_stairs() {
    assert_on_the_ground(&play(&World::stairs_up(12, 0.17, 0.29), &Tape::walk()), "stairs up");
    assert_on_the_ground(&play(&World::stairs_down(12, 0.17, 0.29), &Tape::walk()), "stairs down");
}

#[test]
fn who_walks_and_stops_always_has_a_foot_on_the_ground() {
    for hertz in [30.0, 60.0, 144.0] {
        let mut stage = Stage::on(&World::flat());
        let walker = stage.spawn_walker().expect("the mannequin loads");
        stage.set_frame_rate(hertz);
        stage.run_for(0.5);
        let tape = Tape::of("stop", 3.0, &[(0.5, Vec3::NEG_Z * 1.4), (1.5, Vec3::ZERO)]);
        for frame in 0..(tape.seconds * hertz) as usize {
            let time = frame as f32 / hertz;
            stage.intend(walker, tape.intent_at(time));
            stage.app().update();
            let feet = &stage.get::<FootIk>(walker).expect("it has feet").feet;
            assert!(feet.iter().any(|foot| foot.plant().is_some()), "{hertz} Hz: both feet are lifted at {time:.2} s");
        }
    }
}

#[test]
fn who_walks_is_borne_by_a_foot() {
    let stairs = [World::stairs_up(12, 0.17, 0.29), World::stairs_down(12, 0.17, 0.29)];
    for world in stairs.iter().chain(&[World::rubble(), World::hills(), World::ramp(30.0)]) {
        let mut stage = Stage::on(world);
        let walker = stage.spawn_walker().expect("the mannequin loads");
        stage.run_for(0.5).start_recording(walker).play(walker, &Tape::walk());
        let (mut longest, mut since) = (0.0f32, 0.0f32);
        for frame in stage.frames(walker) {
            let borne = !frame.grounded || frame.feet.iter().any(|foot| foot.stance);
            since = if borne { 0.0 } else { since + 1.0 / 60.0 };
            longest = longest.max(since);
        }
        assert!(longest < 0.1, "{}: for {longest:.2} s no foot stands while it walks", world.name);
    }
}

/// Plays `tape` and tells, of each frame, how high over the root the hips are, and where the ankles are in model space.
fn hips_and_ankles(world: &World, tape: &Tape, hertz: f32) -> Vec<(f32, [Vec3; 2])> {
    let mut stage = Stage::on(world);
    let walker = stage.spawn_walker().expect("the mannequin loads");
    let character = stage.get::<Character>(walker).expect("it is one").0.clone();
    let assets = stage.app().world().resource::<Assets<CharacterAsset>>();
    let asset = assets.get(&character).expect("it is loaded");
    let (hips, ankles) = (asset.hips, [asset.legs[0].foot, asset.legs[1].foot]);
    stage.set_frame_rate(hertz);
    stage.run_for(0.5);
    let frames = 0..(tape.seconds * hertz) as usize;
    frames
        .map(|frame| {
            stage.intend(walker, tape.intent_at(frame as f32 / hertz));
            stage.app().update();
            let pose = &stage.get::<CharacterPose>(walker).expect("it is posed").pose;
            (pose.position(hips).y, ankles.map(|ankle| pose.position(ankle)))
        })
        .collect()
}

#[test]
fn at_few_frames_a_second_bodies_hold_together() {
    let (flat, stairs) = (World::flat(), World::stairs_up(12, 0.17, 0.29));
    for hertz in [4.0, 10.0, 16.0, 24.0, 27.0] {
        for (world, tape) in [
            (&flat, Tape::run()),
            (&flat, Tape::jump()),
            (&flat, Tape::start_stop()),
            (&flat, Tape::pivot()),
            (&stairs, Tape::walk()),
        ] {
            for (frame, (hips, ankles)) in hips_and_ankles(world, &tape, hertz).into_iter().enumerate() {
                let case = format!("{} / {} at {hertz} Hz, frame {frame}", world.name, tape.name);
                assert!((0.4..1.15).contains(&hips), "{case}: hips are {hips:.2} m over the root");
                for ankle in ankles {
                    let aside = ankle.x.abs();
                    assert!(
                        aside < 0.65 && ankle.y < 0.8,
                        "{case}: an ankle is {aside:.2} m aside, {:.2} m up",
                        ankle.y
                    );
                }
            }
        }
    }
}

#[test]
fn standing_on_stairs() {
    let mut stage = Stage::on(&World::stairs_up(12, 0.17, 0.29));
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.5).walk(walker, Vec3::NEG_Z * 1.4).run_for(3.6).walk(walker, Vec3::ZERO).run_for(1.5);
    let root = stage.root(walker);
    assert!(root.y > 0.3, "it stands on the stairs, at {root}");
    stage.start_recording(walker).run_for(1.0);
    let measures = stage.measures(walker);
    assert_on_the_ground(&measures, "standing on stairs");
}

#[test]
fn on_level_ground_the_animated_pose_stands() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(1.0);
    let ankles = |stage: &mut Stage| {
        let handle = stage.get::<Character>(walker).expect("spawned").0.clone();
        let asset = stage.app().world().resource::<Assets<CharacterAsset>>().get(&handle).expect("loaded").clone();
        let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
        [0, 1].map(|side| sole_model(pose, &asset.legs[side]))
    };
    let with = ankles(&mut stage);
    let mut plain = Stage::on(&World::flat());
    let other = plain.spawn_walker().expect("the mannequin loads");
    plain.set_foot_ik(other, false);
    plain.run_for(1.0);
    assert_eq!(walker, other, "both stages spawn alike");
    let without = ankles(&mut plain);
    let off = with.iter().flatten().zip(without.iter().flatten()).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
    assert!(off < 1e-4, "foot IK moves the standing feet by {:.2} mm", off * 1000.0);
}

#[test]
fn ground_that_vanishes_lets_the_feet_go() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.5);
    let ground = stage.get::<FootIk>(walker).expect("bound").feet[0].plant().expect("the foot is planted").ground;
    stage.app().world_mut().despawn(ground);
    stage.run_for(0.5);
    let root = stage.root(walker);
    assert!(root.is_finite() && root.y < -0.3, "it falls, and is at {root}");
    assert!(stage.get::<FootIk>(walker).expect("bound").feet[0].plant().is_none(), "the foot holds nothing");
}
