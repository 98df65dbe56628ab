//! Intents in, the right clips out.

mod aim;
mod air;
mod layers;
mod pops;

use bevy::prelude::*;
use surefoot::{
    character::{Character, animator::CharacterPose, intent::MoveIntent, locomotion::Locomotion, motion::MotionState},
    measure::summary::Measures,
    rig::{character::CharacterAsset, tuning::locomotion::TransitionBlend},
    testing::{Piece, Stage, Tape, World},
};

/// A walker on `ground`, half a second old.
fn walker_on(ground: &World) -> (Stage, Entity) {
    let mut stage = Stage::on(ground);
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.5);
    (stage, walker)
}

fn asset(stage: &Stage, walker: Entity) -> &CharacterAsset {
    stage.asset(walker).expect("the mannequin is loaded")
}

/// Weight of a clip, whatever state plays it.
fn clip_weight(stage: &Stage, walker: Entity, clip: &str) -> f32 {
    stage.get::<Locomotion>(walker).expect("bound").weight_of_clip(asset(stage, walker), clip)
}

fn state(stage: &Stage, walker: Entity) -> String {
    stage.get::<Locomotion>(walker).expect("the walker is bound").state().to_owned()
}

fn weight(stage: &Stage, walker: Entity, name: &str) -> f32 {
    stage.get::<Locomotion>(walker).expect("the walker is bound").weight_of(name)
}

#[test]
fn intents_lead_from_idle_over_walk_and_run_to_sprint_and_back() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    for (speed, name) in
        [(0.0, "idle"), (1.4, "walk"), (3.5, "run"), (6.0, "sprint"), (3.5, "run"), (1.4, "walk"), (0.0, "idle")]
    {
        stage.walk(walker, Vec3::NEG_Z * speed).run_for(1.5);
        assert_eq!(state(&stage, walker), name, "after 1.5 s at {speed} m/s");
        let weight = weight(&stage, walker, name);
        assert!(weight > 0.999, "{name} weighs {weight} after 1.5 s at {speed} m/s");
    }
}

#[test]
fn a_fade_takes_between_a_tenth_and_three_tenths_of_a_second() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.5).walk(walker, Vec3::NEG_Z * 1.4);
    let (mut first, mut last) = (None, None);
    for frame in 0..60 {
        stage.run_for(1.0 / 60.0);
        let weight = weight(&stage, walker, "walk");
        if weight > 0.01 {
            first = first.or(Some(frame));
        }
        if weight > 0.99 {
            last = last.or(Some(frame));
        }
    }
    let (first, last) = (first.expect("walking begins"), last.expect("walking is reached"));
    let seconds = (last - first) as f32 / 60.0;
    assert!((0.08..=0.3).contains(&seconds), "the fade took {seconds:.2} s");
}

#[test]
fn the_file_says_whether_changes_cross_fade_or_are_inertialized() {
    for (blend, fades) in [(TransitionBlend::CrossFade, true), (TransitionBlend::Inertialize, false)] {
        let mut stage = Stage::on(&World::flat());
        let mut mannequin = stage.load_character("mannequin.character.ron").expect("the repository's mannequin");
        for change in mannequin.file.locomotion.transitions.iter_mut().flatten() {
            change.blend = blend;
        }
        let walker = stage.spawn_loaded(mannequin, &[Transform::IDENTITY])[0];
        stage.walk(walker, Vec3::NEG_Z * 1.4).start_recording(walker);
        while state(&stage, walker) == "idle" {
            stage.run_for(1.0 / 60.0);
        }
        stage.run_for(2.0 / 60.0);
        let idle = weight(&stage, walker, "idle");
        assert_eq!(idle > 0.1, fades, "{blend:?}: three frames into the walk idle weighs {idle}");
        stage.run_for(1.0);
        let Measures { pop_speed, pop_jump, .. } = stage.measures(walker);
        // Without any blend the first frame of the walk pops by far more.
        assert!(
            pop_speed < 3.0 && pop_jump < 3.0,
            "{blend:?}: pops of {pop_speed:.2} and {pop_jump:.2} times the clips'"
        );
    }
}

#[test]
fn walk_and_run_keep_the_phase_of_the_feet() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(2.0).walk(walker, Vec3::NEG_Z * 3.5);
    let mut last = stage.get::<Locomotion>(walker).expect("bound").machine.phase();
    for _ in 0..90 {
        stage.run_for(1.0 / 60.0);
        let phase = stage.get::<Locomotion>(walker).expect("bound").machine.phase();
        let moved = (phase - last).rem_euclid(1.0);
        assert!(moved < 0.05, "the phase jumped by {moved:.3} of a stride in one frame");
        last = phase;
    }
    assert_eq!(state(&stage, walker), "run");
}

#[test]
fn nan_in_an_intent_is_harmless() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    let nonsense =
        MoveIntent { velocity: Vec3::new(f32::NAN, f32::INFINITY, 1.0), facing: Some(Vec3::NAN), ..default() };
    stage.intend(walker, nonsense).run_for(0.5);
    let root = stage.root(walker);
    assert!(root.is_finite(), "the root went to {root}");
    stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(1.0);
    assert!(stage.root(walker).z < root.z - 0.8, "it walks no more: {}", stage.root(walker));
}

#[test]
fn the_first_pose_change_comes_within_two_frames() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(1.0);
    let before = stage.root(walker);
    stage.walk(walker, Vec3::NEG_Z * 1.4).run_for(2.0 / 60.0);
    let moved = stage.root(walker).distance(before);
    assert!(moved > 1e-4, "moved {moved} m within two frames");
}

#[test]
fn two_runs_of_one_tape_give_the_same_poses() {
    let run = || {
        let mut stage = Stage::on(&World::hills());
        let walker = stage.spawn_walker().expect("the mannequin loads");
        stage.play(walker, &Tape::change_gait());
        let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
        pose.locals().iter().flat_map(|joint| joint.rotation.to_array()).map(f32::to_bits).collect::<Vec<u32>>()
    };
    assert!(run() == run(), "two runs of one tape end in different poses");
}

#[test]
fn who_crouches_waits_and_walks_low() {
    let (mut stage, walker) = walker_on(&World::flat());
    for (speed, crouch, name) in
        [(0.0, true, "crouch_idle"), (1.0, true, "crouch_walk"), (0.0, true, "crouch_idle"), (0.0, false, "idle")]
    {
        let intent = MoveIntent { velocity: Vec3::NEG_Z * speed, crouch, ..default() };
        stage.intend(walker, intent).run_for(1.0);
        assert_eq!(state(&stage, walker), name, "at {speed} m/s, crouch: {crouch}");
        let weight = clip_weight(&stage, walker, name);
        assert!(weight > 0.999, "{name} weighs {weight}");
    }
}

#[test]
fn under_a_low_ceiling_it_stays_low_until_there_is_room() {
    let mut ground = World::flat();
    // From z = -2 to -6, 1.4 m above the ground: less than a standing body, more than a crouched one.
    ground.pieces.push(Piece::block(Vec3::new(6.0, 1.0, 4.0), Transform::from_xyz(0.0, 1.9, -4.0)));
    let (mut stage, walker) = walker_on(&ground);
    let go = |crouch| MoveIntent { velocity: Vec3::NEG_Z, crouch, ..default() };
    stage.intend(walker, go(true)).run_for(4.0);
    stage.intend(walker, go(false)).run_for(0.5);
    let root = stage.root(walker);
    assert!(root.z < -2.5 && root.z > -6.0, "it is below the ceiling, at {root}");
    assert_eq!(state(&stage, walker), "crouch_walk", "no room to stand up");
    let top = head_top(&stage, walker);
    assert!(top < 1.4, "the head is {top:.2} m up, in the ceiling");
    stage.run_for(4.0);
    assert!(stage.root(walker).z < -6.3, "it got through, to {}", stage.root(walker));
    assert_eq!(state(&stage, walker), "walk", "there is room again");
}

/// Height of the crown over the ground.
fn head_top(stage: &Stage, walker: Entity) -> f32 {
    let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
    let asset = asset(stage, walker);
    let head = asset.skeleton.find("head").expect("the mannequin has a head");
    // The crown is 0.245 m above the head's joint.
    stage.root(walker).y + (pose.model(head).transform_point3(Vec3::Y * 0.245)).y
}

#[test]
fn a_changed_file_is_taken_over_in_mid_run() {
    let (mut stage, walker) = walker_on(&World::flat());
    stage.walk(walker, Vec3::NEG_Z * 3.5).run_for(1.5);
    let before = stage.get::<Locomotion>(walker).expect("bound").machine.phase();
    let handle = stage.get::<Character>(walker).expect("spawned").0.clone();
    let mut assets = stage.app().world_mut().resource_mut::<Assets<CharacterAsset>>();
    assets.get_mut(&handle).expect("loaded").file.locomotion.rate_range = (0.9, 1.1);
    stage.run_for(2.0 / 60.0);
    let locomotion = stage.get::<Locomotion>(walker).expect("bound");
    let moved = (locomotion.machine.phase() - before).rem_euclid(1.0);
    assert_eq!(locomotion.state(), "run", "the run goes on");
    assert!(moved < 0.1, "the phase jumped by {moved:.3} of a stride");
    assert!(locomotion.weight_of("run") > 0.999);
    stage.run_for(1.0);
    let speed = stage.get::<MotionState>(walker).expect("spawned").ground_velocity.length();
    assert!((speed - 3.5).abs() < 0.01, "it runs on at {speed} m/s");
}

#[test]
fn reversing_in_the_middle_of_fades_never_pops_the_clips() {
    for (every, speed) in [(0.1, 3.5), (0.2, 3.5), (0.2, 1.4), (0.35, 3.5), (0.5, 1.4)] {
        let way = |index: usize| if index.is_multiple_of(2) { Vec3::NEG_Z } else { Vec3::Z } * speed;
        let cues: Vec<_> = (0..(3.0 / every) as usize).map(|index| (every * index as f32, way(index))).collect();
        let (mut stage, walker) = walker_on(&World::flat());
        stage.set_foot_ik(walker, false);
        stage.start_recording(walker).play(walker, &Tape::of("reversing", 3.0, &cues));
        let Measures { pop_speed, pop_jump, .. } = stage.measures(walker);
        assert!(
            pop_speed <= 2.0 && pop_jump <= 2.0,
            "every {every} s at {speed} m/s: {pop_speed:.2} times the clips' angular speed, {pop_jump:.2} times their jump"
        );
    }
}

#[test]
fn in_a_turn_on_the_spot_one_foot_always_stands() {
    let (stage, walker) = walker_on(&World::flat());
    for name in ["turn_left", "turn_right"] {
        let gait = &asset(&stage, walker).clip(name).expect("the mannequin turns").gait;
        for foot in 0..2 {
            let stands: f32 = gait.contact[foot].iter().map(|contact| contact.end - contact.start).sum();
            assert!((0.5..0.75).contains(&stands), "{name}: foot {foot} stands {:.0} % of the time", 100.0 * stands);
        }
        for step in 0..100u8 {
            let phase = f32::from(step) / 100.0;
            let weight = [0, 1].map(|foot| gait.contact_weight(foot, phase)).into_iter().fold(0.0, f32::max);
            assert!(weight > 0.49, "{name}: both feet are off the ground at phase {phase}");
        }
    }
}
