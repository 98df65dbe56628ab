//! Morph targets follow what plays, and eyes blink: the mannequin blinks and breathes, whatever its limbs do.

use std::collections::BTreeMap;

use bevy::prelude::*;
use serde_json::json;
use surefoot::{
    character::{
        animator::{Actions, Blink, MorphScratch, MorphSources, morph_weights},
        intent::MoveIntent,
        locomotion::Locomotion,
    },
    rig::{Rig, character::CharacterAsset, character_file::CharacterFile},
    testing::{Stage, Tape, World},
};

use crate::foreign::mannequin;

/// The mannequin's targets, in the order of its file.
const BLINK: usize = 0;
const BREATH: usize = 1;

/// Weights of blink and breath as they are now; `None` when nothing that plays says anything of them.
fn weights(stage: &Stage, walker: Entity) -> Option<[f32; 2]> {
    let asset = stage.asset(walker).expect("loaded");
    let mesh = asset.rig.meshes.iter().position(|mesh| mesh.morph_names == ["blink", "breath"]);
    let sources = MorphSources {
        asset,
        locomotion: stage.get::<Locomotion>(walker).expect("bound"),
        actions: stage.get::<Actions>(walker).expect("bound"),
        blink: stage.get::<Blink>(walker).expect("bound"),
        blinks: 1.0,
    };
    let mut scratch = MorphScratch::default();
    let told = morph_weights(&sources, mesh.expect("the mannequin has targets"), &mut scratch);
    told.then(|| [scratch.weights[BLINK], scratch.weights[BREATH]])
}

/// Least and greatest weight of each target in so many seconds, and the greatest change in a frame.
fn range(stage: &mut Stage, walker: Entity, seconds: u16) -> ([f32; 2], [f32; 2], f32) {
    let (mut least, mut most, mut change) = ([f32::MAX; 2], [f32::MIN; 2], 0.0f32);
    let mut last: Option<[f32; 2]> = None;
    for _ in 0..60 * seconds {
        stage.run_for(1.0 / 60.0);
        let now = weights(stage, walker).unwrap_or_default();
        for target in [BLINK, BREATH] {
            least[target] = least[target].min(now[target]);
            most[target] = most[target].max(now[target]);
            change = change.max(last.map_or(0.0, |last| (now[target] - last[target]).abs()));
        }
        last = Some(now);
    }
    (least, most, change)
}

#[test]
fn who_stands_blinks_and_breathes() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(0.5);
    let (least, most, _) = range(&mut stage, walker, 9);
    assert!(least[BLINK] < 0.01 && most[BLINK] > 0.8, "blinks from {} to {}", least[BLINK], most[BLINK]);
    assert!(least[BREATH] < 0.1 && most[BREATH] > 0.9, "breathes from {} to {}", least[BREATH], most[BREATH]);
}

#[test]
fn whatever_it_does_a_character_blinks() {
    let ahead = Vec3::NEG_Z;
    let (aim, facing) = (Some(Vec3::X), Some(Vec3::X));
    for (what, intent) in [
        ("walks", MoveIntent { velocity: ahead * 1.4, ..default() }),
        ("runs", MoveIntent { velocity: ahead * 3.5, ..default() }),
        ("sneaks", MoveIntent { velocity: ahead, crouch: true, ..default() }),
        ("aims", MoveIntent { velocity: ahead, aim, facing, ..default() }),
    ] {
        let mut stage = Stage::on(&World::flat());
        let walker = stage.spawn_walker().expect("the mannequin loads");
        stage.intend(walker, intent).run_for(1.0);
        let (least, most, change) = range(&mut stage, walker, 15);
        assert!(least[BLINK].abs() < 1e-6, "who {what} has its eyes open by {} at most", 1.0 - least[BLINK]);
        assert!(most[BLINK] > 0.9, "who {what} shuts its eyes by {} at most in 15 s", most[BLINK]);
        assert!(change < 0.35, "who {what} has lids that jump by {change}");
    }
}

/// In which frames of `tape` each of three characters shuts its eyes.
fn blinks(tape: &Tape, tune: impl Fn(&mut Stage, Entity)) -> [Vec<usize>; 3] {
    let mut stage = Stage::on(&World::flat());
    let asset = stage.load_character("mannequin.character.ron").expect("the mannequin loads");
    let places = [-1.0, 0.0, 1.0].map(|x| Transform::from_xyz(x, 0.0, 0.0));
    let walkers: [Entity; 3] = stage.spawn_loaded(asset, &places).try_into().expect("three places");
    tune(&mut stage, walkers[0]);
    let mut shut = [const { Vec::new() }; 3];
    for frame in 0..(tape.seconds * 60.0) as usize {
        for (walker, shut) in walkers.iter().zip(&mut shut) {
            stage.intend(*walker, tape.intent_at(frame as f32 / 60.0));
            if weights(&stage, *walker).is_some_and(|weights| weights[BLINK] > 0.5) {
                shut.push(frame);
            }
        }
        stage.run_for(1.0 / 60.0);
    }
    shut
}

#[test]
fn each_character_blinks_in_a_rhythm_of_its_own_that_repeats() {
    let tape = Tape { seconds: 30.0, ..Tape::change_gait() };
    let shut = blinks(&tape, |_, _| ());
    assert_eq!(shut, blinks(&tape, |_, _| ()), "the same tape gives the same blinks");
    for (one, other) in [(0, 1), (1, 2), (0, 2)] {
        let together = shut[one].iter().filter(|frame| shut[other].contains(frame)).count();
        let of = shut[one].len();
        assert!(
            of > 0 && together * 2 < of,
            "{together} of {of} frames with eyes shut are the same for two characters"
        );
    }
}

#[test]
fn a_file_says_how_often_eyes_blink_and_whether() {
    let tape = Tape { seconds: 30.0, ..Tape::change_gait() };
    let usual = blinks(&tape, |_, _| ())[0].len();
    let nervous = blinks(&tape, |stage, walker| stage.tune(walker, |file| file.blink.interval = 0.8))[0].len();
    assert!(nervous > 2 * usual, "eyes are shut in {nervous} frames, not in {usual}");
    let off = blinks(&tape, |stage, walker| stage.tune(walker, |file| file.blink.enabled = false));
    assert!(off.iter().all(Vec::is_empty), "off, eyes are shut in {off:?}");
}

#[test]
fn eyes_of_a_vrm_model_shut_as_far_as_its_expression_says() {
    let mut file = mannequin();
    let node = file.root["nodes"].as_array().and_then(|nodes| nodes.iter().position(|node| node.get("mesh").is_some()));
    let bind = json!({ "node": node, "index": BLINK, "weight": 0.5 });
    let blink = json!({ "preset": { "blink": { "morphTargetBinds": [bind] } } });
    file.root["extensions"] = json!({ "VRMC_vrm": { "specVersion": "1.0", "expressions": blink } });
    let rig = Rig::from_slice(&file.glb(), |_| Err("no files".to_owned())).expect("the file is good");
    let asset = CharacterAsset::resolve(CharacterFile::default(), "body.vrm".into(), rig, &BTreeMap::new());
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_loaded(asset.expect("it walks"), &[Transform::IDENTITY])[0];
    // In crouching no clip moves the lids.
    stage.intend(walker, MoveIntent { velocity: Vec3::NEG_Z, crouch: true, ..default() }).run_for(1.0);
    let (least, most, _) = range(&mut stage, walker, 15);
    assert!(least[BLINK].abs() < 1e-6 && (most[BLINK] - 0.5).abs() < 0.03, "{} to {}", least[BLINK], most[BLINK]);
}

#[test]
fn a_wave_of_the_arm_leaves_the_face_alone() {
    let [mut waving, mut plain] = [(), ()].map(|()| {
        let mut stage = Stage::on(&World::flat());
        let walker = stage.spawn_walker().expect("the mannequin loads");
        stage.run_for(0.5);
        (stage, walker)
    });
    waving.0.app().world_mut().get_mut::<Actions>(waving.1).expect("bound").play("wave");
    for frame in 0..150 {
        waving.0.run_for(1.0 / 60.0);
        plain.0.run_for(1.0 / 60.0);
        let [with, without] = [&waving, &plain].map(|(stage, walker)| weights(stage, *walker));
        assert_eq!(with, without, "in frame {frame}");
    }
}

#[test]
fn weights_blend_with_the_clips_that_move_them() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.run_for(1.5);
    for speed in [1.4, 0.0, 3.5, 0.0] {
        stage.walk(walker, Vec3::NEG_Z * speed);
        let (_, _, change) = range(&mut stage, walker, 2);
        // Lids close in 0.08 s, and fastest half-way.
        assert!(change < 0.35, "at {speed} m/s a weight jumps by {change}");
    }
}
