//! Actions over what else plays: a wave while walking. Legs go on as if nothing was.

use std::collections::BTreeMap;

use bevy::prelude::*;
use surefoot::{
    anim::skeleton::JointTransform,
    character::animator::{Actions, CharacterPose},
    rig::{Rig, character::CharacterAsset, character_file::CharacterFile, humanoid::HumanoidRole},
    testing::{Stage, World},
};

use crate::support::assert_no_pop;

const FRAME: f32 = 1.0 / 60.0;
/// Seconds of the mannequin's wave.
const WAVE: f32 = 2.6;

/// The mannequin with this table of actions.
fn mannequin(actions: &str) -> Result<CharacterAsset, String> {
    let bytes = include_bytes!("../../assets/mannequin.glb");
    let rig = Rig::from_slice(bytes, |_| Err("no files".to_owned())).expect("the mannequin is good");
    let file = CharacterFile::parse(&format!("(actions: {actions})")).map_err(|error| error.to_string())?;
    CharacterAsset::resolve(file, "mannequin.glb".into(), rig, &BTreeMap::new()).map_err(|error| error.to_string())
}

/// A walker with this table of actions, who has gone for a second at `speed` m/s.
fn walker(actions: &str, speed: f32) -> (Stage, Entity) {
    let mut stage = Stage::on(&World::flat());
    let asset = mannequin(actions).expect("the table is good");
    let walker = stage.spawn_loaded(asset, &[Transform::IDENTITY])[0];
    stage.walk(walker, Vec3::NEG_Z * speed).run_for(1.5);
    (stage, walker)
}

fn actions(stage: &mut Stage, walker: Entity) -> Mut<'_, Actions> {
    stage.app().world_mut().get_mut::<Actions>(walker).expect("a bound character has actions")
}

fn weight(stage: &Stage, walker: Entity, name: &str) -> f32 {
    stage.get::<Actions>(walker).expect("a bound character has actions").weight(name)
}

fn locals(stage: &Stage, walker: Entity) -> Vec<JointTransform> {
    stage.get::<CharacterPose>(walker).expect("bound").pose.locals().to_vec()
}

/// Height of a joint over that of another, metres.
fn above(stage: &Stage, walker: Entity, joint: HumanoidRole, other: HumanoidRole) -> f32 {
    let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
    let humanoid = &stage.asset(walker).expect("loaded").humanoid;
    let [joint, other] = [joint, other].map(|role| pose.position(humanoid.get(role).expect("the mannequin has it")));
    joint.y - other.y
}

fn hand_over_shoulder(stage: &Stage, walker: Entity) -> f32 {
    above(stage, walker, HumanoidRole::RightHand, HumanoidRole::RightUpperArm)
}

/// Joints, by name, that two poses have in different places.
fn changed(stage: &Stage, walker: Entity, a: &[JointTransform], b: &[JointTransform]) -> Vec<String> {
    let names = stage.asset(walker).expect("loaded").skeleton.names();
    let pairs = a.iter().zip(b).zip(names);
    pairs.filter(|((a, b), _)| a != b).map(|(_, name)| name.clone()).collect()
}

#[test]
fn who_walks_and_waves_raises_the_hand_and_sets_the_feet_as_before() {
    let [mut waving, mut plain] = [(), ()].map(|()| walker("None", 1.4));
    waving.0.start_recording(waving.1);
    plain.0.start_recording(plain.1);
    actions(&mut waving.0, waving.1).play("wave");
    let mut highest = f32::MIN;
    for frame in 0..200 {
        waving.0.run_for(FRAME);
        plain.0.run_for(FRAME);
        let (a, b) = (locals(&waving.0, waving.1), locals(&plain.0, plain.1));
        for name in changed(&waving.0, waving.1, &a, &b) {
            let of_the_arm = ["rightShoulder", "right"].iter().any(|part| name.starts_with(part));
            let of_a_leg = ["Leg", "Foot", "Toes"].iter().any(|part| name.contains(part));
            assert!(of_the_arm && !of_a_leg, "in frame {frame} the wave moves {name}");
        }
        highest = highest.max(hand_over_shoulder(&waving.0, waving.1));
        let low = hand_over_shoulder(&plain.0, plain.1);
        assert!(low < 0.0, "without a wave the hand is {low:.2} m above the shoulder");
    }
    assert!(highest > 0.15, "the hand comes to {highest:.2} m above the shoulder");
    let [with, without] = [waving, plain].map(|(stage, walker)| stage.measures(walker));
    assert!(without.stances > 4 && with.stances == without.stances, "{} stances", with.stances);
    for (what, with, without) in [
        ("a plant drifts", with.drift_max, without.drift_max),
        ("a sole sinks", with.penetration_max, without.penetration_max),
        ("an ankle misses", with.reach_max.unwrap(), without.reach_max.unwrap()),
    ] {
        assert_eq!(with.to_bits(), without.to_bits(), "{what} by {with} mm waving, by {without} mm without");
    }
}

#[test]
fn a_wave_is_gone_when_its_clip_ends_and_leaves_no_trace() {
    let [mut waving, plain] = [(), ()].map(|()| walker("None", 1.4));
    actions(&mut waving.0, waving.1).play("wave");
    waving.0.run_for(0.26);
    let shows = weight(&waving.0, waving.1, "wave");
    assert!(shows > 0.999, "after its fade of 0.25 s it shows by {shows}");
    waving.0.run_for(WAVE - 0.35);
    let shows = weight(&waving.0, waving.1, "wave");
    assert!(shows > 0.0 && shows < 1.0, "0.1 s before its end it shows by {shows}");
    waving.0.run_for(0.15);
    assert!(waving.0.get::<Actions>(waving.1).expect("bound").playing().next().is_none(), "it still plays");
    let (mut stage, walker) = plain;
    stage.run_for(0.26).run_for(WAVE - 0.35).run_for(0.15);
    let (a, b) = (locals(&waving.0, waving.1), locals(&stage, walker));
    assert_eq!(changed(&stage, walker, &a, &b), [""; 0], "joints are elsewhere than without the wave");
}

#[test]
fn a_wave_comes_and_goes_in_the_same_time_at_every_frame_rate() {
    let shown = [30.0, 60.0, 144.0].map(|hertz| {
        let mut stage = Stage::on(&World::flat());
        let walker = stage.spawn_walker().expect("the mannequin loads");
        stage.set_frame_rate(hertz);
        // Sixths of a second are whole frames at all of these, and end within a tick.
        stage.run_for(4.0 / 6.0);
        actions(&mut stage, walker).play("wave");
        stage.run_for(1.0 / 6.0);
        let comes = weight(&stage, walker, "wave");
        stage.run_for(14.0 / 6.0);
        [comes, weight(&stage, walker, "wave")]
    });
    let [comes, goes] = shown[1];
    assert!((comes - 0.74).abs() < 0.1, "two thirds through its fade it shows by {comes}");
    assert!(goes > 0.0 && goes < 0.99, "through its end it shows by {goes}");
    assert_eq!(shown, [shown[1]; 3], "at 30, 60 and 144 frames a second");
}

#[test]
fn actions_fade_without_pops_whenever_they_begin_stop_or_begin_anew() {
    type Deed = fn(&mut Actions);
    let play: Deed = |actions| actions.play("wave");
    let stop: Deed = |actions| actions.stop("wave");
    let sink: Deed = |actions| actions.fade_to("wave", 0.4, 0.3);
    let other: Deed = |actions| actions.play("crouch_idle");
    for (what, speed, deeds) in [
        ("a wave at a walk", 1.4, &[(0.3, play)][..]),
        ("a wave at a run", 3.5, &[(0.3, play)]),
        ("a wave stopped at once and half-way", 1.4, &[(0.2, play), (0.3, stop), (0.5, play), (1.7, stop)]),
        ("a wave begun anew", 0.0, &[(0.2, play), (1.2, play), (1.3, play), (2.2, play)]),
        ("a wave that sinks", 1.4, &[(0.2, play), (1.0, sink)]),
        ("a wave below another action", 1.4, &[(0.2, play), (0.9, other), (1.8, play), (2.4, stop)]),
    ] {
        let (mut stage, walker) = walker("None", speed);
        stage.set_foot_ik(walker, false);
        stage.start_recording(walker);
        let mut deeds = deeds.iter().peekable();
        for frame in 0u16..240 {
            while let Some((_, deed)) = deeds.next_if(|(at, _)| *at <= f32::from(frame) * FRAME) {
                deed(&mut actions(&mut stage, walker));
            }
            stage.run_for(FRAME);
        }
        assert_no_pop(what, &stage.measures(walker));
    }
}

#[test]
fn any_clip_is_an_action_of_the_upper_body() {
    let [mut low, plain] = [(), ()].map(|()| walker("None", 1.4));
    actions(&mut low.0, low.1).play("crouch_idle");
    low.0.run_for(0.5);
    let (mut stage, walker) = plain;
    stage.run_for(0.5);
    let (a, b) = (locals(&low.0, low.1), locals(&stage, walker));
    let moved = changed(&stage, walker, &a, &b);
    assert!(moved.iter().any(|name| name == "spine") && moved.iter().any(|name| name == "leftLowerArm"), "{moved:?}");
    for name in moved {
        let of_a_leg = ["hips", "Leg", "Foot", "Toes"].iter().any(|part| name.contains(part));
        assert!(!of_a_leg, "{name} moves");
    }
}

#[test]
fn what_begins_later_lies_over_what_began_earlier() {
    let table = r#"{"wave": (root: Role(rightShoulder), feather: 0), "stand": (clip: "idle", root: Role(rightShoulder), feather: 0)}"#;
    let heights = [["wave", "stand"], ["stand", "wave"]].map(|order| {
        let (mut stage, walker) = walker(table, 0.0);
        for name in order {
            actions(&mut stage, walker).play(name);
            stage.run_for(0.4);
        }
        let playing: Vec<&str> = stage.get::<Actions>(walker).expect("bound").playing().collect();
        assert_eq!(playing, order, "the lowest layer comes first");
        stage.run_for(0.4);
        hand_over_shoulder(&stage, walker)
    });
    assert!(heights[0] < -0.3, "standing over a wave the hand is {:.2} m above the shoulder", heights[0]);
    assert!(heights[1] > 0.1, "waving over standing the hand is {:.2} m above the shoulder", heights[1]);
}

#[test]
fn an_additive_action_adds_its_difference_to_what_plays() {
    let table = r#"{
        "same": (clip: "crouch_idle", additive: true, feather: 0),
        "stoop": (clip: "crouch_idle", additive: true, reference: "idle", feather: 0, looping: true, weight: 0.5),
    }"#;
    let tilt = |action: Option<&str>| {
        let (mut stage, walker) = walker(table, 0.0);
        if let Some(action) = action {
            actions(&mut stage, walker).play(action);
        }
        stage.run_for(0.5);
        let pose = &stage.get::<CharacterPose>(walker).expect("bound").pose;
        let chest = stage.asset(walker).expect("loaded").humanoid.get(HumanoidRole::UpperChest);
        (pose.model(chest.expect("the mannequin has a chest")).matrix3.y_axis.z.abs(), weight(&stage, walker, "stoop"))
    };
    let (upright, _) = tilt(None);
    let (same, _) = tilt(Some("same"));
    let (stoop, weight) = tilt(Some("stoop"));
    assert!(
        (same - upright).abs() < 0.03,
        "a clip less its own first pose tilts the chest by {same:.3} over {upright:.3}"
    );
    assert!(
        stoop > upright + 0.05,
        "a crouch less standing tilts the chest by {stoop:.3}, standing does by {upright:.3}"
    );
    assert!((weight - 0.5).abs() < 1e-6, "an action of half weight shows by {weight}");
}

#[test]
fn a_looping_action_goes_on_until_it_is_stopped() {
    let table = r#"{"wave": (root: Role(rightShoulder), feather: 1, looping: true)}"#;
    let (mut stage, walker) = walker(table, 0.0);
    actions(&mut stage, walker).play("wave");
    stage.run_for(3.0 * WAVE);
    actions(&mut stage, walker).play("wave");
    stage.run_for(FRAME);
    assert_eq!(stage.get::<Actions>(walker).expect("bound").playing().count(), 1, "asked for again it goes on alone");
    assert!(weight(&stage, walker, "wave") > 0.999, "it went by itself");
    actions(&mut stage, walker).stop("wave");
    stage.run_for(0.35);
    assert!(weight(&stage, walker, "wave") <= 0.0, "stopped, it shows by {}", weight(&stage, walker, "wave"));
}

#[test]
fn an_unknown_action_is_refused_by_name_with_those_there_are() {
    let (mut stage, walker) = walker("None", 0.0);
    let mut asked = actions(&mut stage, walker);
    asked.play("wvae");
    asked.stop("wvae");
    asked.fade_to("wvae", f32::NAN, f32::NAN);
    stage.run_for(0.1);
    assert!(stage.get::<Actions>(walker).expect("bound").playing().next().is_none(), "something plays");
    let error = stage.asset(walker).expect("loaded").action("wvae").expect_err("no such action").to_string();
    for part in ["no action `wvae`", "did you mean `wave`?", "`idle`", "`walk`"] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn mistakes_in_the_table_are_named_with_what_would_be_right() {
    for (table, parts) in [
        (r#"{"greet": (clip: "wvae")}"#, ["actions[\"greet\"]", "did you mean `wave`?"]),
        (r#"{"greet": ()}"#, ["actions[\"greet\"]", "`greet`, which doesn't exist"]),
        (r#"{"greet": (clip: "wave", reference: "idel")}"#, ["actions[\"greet\"]", "did you mean `idle`?"]),
        (r#"{"wave": (root: Name("rightShuolder"))}"#, ["actions[\"wave\"].root", "did you mean `rightShoulder`?"]),
        (r#"{"wave": (root: Role(rightShuolder))}"#, ["line 1", "did you mean `rightShoulder`?"]),
        (r#"{"wave": (weight: 1.5)}"#, ["actions[\"wave\"].weight", "0 to 1"]),
        (r#"{"wave": (fade_in: -0.1)}"#, ["actions[\"wave\"].fade_in", "0 to 10 s"]),
        (r#"{"wave": (fades: 0.1)}"#, ["line 1", "fades"]),
    ] {
        let error = mannequin(table).err().unwrap_or_else(|| panic!("{table} should be refused"));
        assert!(parts.iter().all(|part| error.contains(part)), "{table}: {error}");
    }
}
