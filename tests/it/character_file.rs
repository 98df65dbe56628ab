//! Character files: parts of bodies by name, clips of other files, errors that help, reloads that fail.

use std::{collections::BTreeMap, path::Path, time::Duration};

use bevy::{
    asset::{
        AssetApp, LoadState,
        io::{
            AssetSourceBuilder, AssetSourceId,
            memory::{Dir, MemoryAssetReader},
        },
    },
    prelude::*,
};
use surefoot::{
    anim::{gait::Gait, leg::LEFT, pose::Pose},
    rig::{
        Rig,
        character::CharacterAsset,
        character_file::CharacterFile,
        humanoid::HumanoidRole,
        loader::RigPlugin,
        tuning::actions::{self, ActionConfig},
    },
};

use crate::gltf_file::{Body, triangle};

fn rig_of(body: &Body) -> Rig {
    Rig::from_slice(&body.build().glb(), |_| Err("no files".to_owned())).expect("the body is good")
}

pub fn resolve(text: &str, body: &Body) -> Result<CharacterAsset, String> {
    let file = CharacterFile::parse(text).map_err(|error| error.to_string())?;
    CharacterAsset::resolve(file, "body.glb".into(), rig_of(body), &BTreeMap::new()).map_err(|error| error.to_string())
}

pub fn fault(text: &str) -> String {
    resolve(text, &Body::default()).err().unwrap_or_else(|| panic!("{text} should be refused"))
}

#[test]
fn bodies_of_many_tools_bind_by_name() {
    let bodies: [[&'static str; 9]; 6] = [
        Body::default().names,
        [
            "mixamorig:Hips",
            "mixamorig:LeftUpLeg",
            "mixamorig:LeftLeg",
            "mixamorig:LeftFoot",
            "mixamorig:LeftToeBase",
            "mixamorig:RightUpLeg",
            "mixamorig:RightLeg",
            "mixamorig:RightFoot",
            "mixamorig:RightToeBase",
        ],
        ["pelvis", "thigh_l", "calf_l", "foot_l", "ball_l", "thigh_r", "calf_r", "foot_r", "ball_r"],
        [
            "Hips",
            "LeftUpperLeg",
            "LeftLowerLeg",
            "LeftFoot",
            "LeftToes",
            "RightUpperLeg",
            "RightLowerLeg",
            "RightFoot",
            "RightToes",
        ],
        [
            "DEF-spine",
            "DEF-thigh.L",
            "DEF-shin.L",
            "DEF-foot.L",
            "DEF-toe.L",
            "DEF-thigh.R",
            "DEF-shin.R",
            "DEF-foot.R",
            "DEF-toe.R",
        ],
        ["hips", "upperleg.l", "lowerleg.l", "foot.l", "toes.l", "upperleg.r", "lowerleg.r", "foot.r", "toes.r"],
    ];
    for names in bodies {
        let body = Body { names, ..Body::default() };
        let asset = resolve("()", &body).unwrap_or_else(|error| panic!("{}: {error}", names[1]));
        let parts = [
            HumanoidRole::Hips,
            HumanoidRole::LeftUpperLeg,
            HumanoidRole::LeftLowerLeg,
            HumanoidRole::LeftFoot,
            HumanoidRole::LeftToes,
            HumanoidRole::RightUpperLeg,
            HumanoidRole::RightLowerLeg,
            HumanoidRole::RightFoot,
            HumanoidRole::RightToes,
        ];
        let found = parts.map(|role| asset.humanoid.get(role).map_or("none", |joint| asset.skeleton.name(joint)));
        assert_eq!(found, names);
    }
}

#[test]
fn a_body_stands_in_model_space_with_its_legs_measured() {
    let asset = resolve("()", &Body::default()).expect("the body is good");
    let rest = Pose::rest(&asset.skeleton);
    let leg = asset.legs[LEFT];
    assert!((asset.leg_length - 0.88).abs() < 1e-3, "leg of {} m", asset.leg_length);
    let ankle = rest.position(leg.foot);
    assert!(ankle.distance(Vec3::new(-0.09, 0.07, 0.0)) < 1e-4, "the left ankle is on the left: {ankle}");
    for (what, point, want) in [
        ("heel", leg.heel, Vec3::new(-0.09, 0.0, 0.06)),
        ("ball", leg.ball, Vec3::new(-0.09, 0.0, -0.13)),
        ("tip", leg.tip, Vec3::new(-0.09, 0.0, -0.2)),
    ] {
        let at = point.position(&rest);
        assert!(at.distance(want) < 2e-3, "{what} at {at}, not {want}");
    }
    assert_eq!(leg.ball.joint, leg.toes.expect("the body has toes"));
    // A turn about the knee's axis takes the foot back and up.
    let mut bent = rest.clone();
    let axis = rest.rotation(leg.upper) * leg.knee_axis;
    bent.rotate_model(&asset.skeleton, leg.lower, Quat::from_axis_angle(axis, 1.0));
    bent.update_model(&asset.skeleton);
    let moved = bent.position(leg.foot) - ankle;
    assert!(moved.z > 0.2 && moved.y > 0.1, "the ankle moved by {moved}");
}

#[test]
fn soles_without_vertices_are_guessed_from_ankle_and_toes() {
    let asset = resolve("()", &Body { mesh: false, ..Body::default() }).expect("the body is good");
    let rest = Pose::rest(&asset.skeleton);
    let [heel, ball, tip] = asset.legs[LEFT].sole().map(|point| point.position(&rest));
    assert!(heel.z > 0.03 && (ball.z + 0.13).abs() < 1e-3 && tip.z < ball.z - 0.05, "{heel} {ball} {tip}");
    assert!([heel, ball, tip].iter().all(|point| point.y.abs() < 0.03), "{heel} {ball} {tip}");
}

#[test]
fn size_scales_legs_and_soles() {
    let asset = resolve("(scale: 0.5)", &Body { size: 2.0, ..Body::default() }).expect("the body is good");
    assert!((asset.leg_length - 0.88).abs() < 1e-3, "leg of {} m", asset.leg_length);
    let centimetres = resolve("()", &Body { size: 100.0, ..Body::default() }).expect("the body is good");
    assert!((centimetres.leg_length - 0.88).abs() < 1e-3, "leg of {} m", centimetres.leg_length);
}

#[test]
fn clips_bring_their_gait() {
    let text = r#"(standard_clips: false, clips: {"stroll": (clip: "walk", speed: 0.5, looping: false), "walk": (ground_speed: 2.0)})"#;
    let asset = resolve(text, &Body::default()).expect("the body is good");
    let names: Vec<_> = asset.clips().iter().map(|clip| clip.name.as_str()).collect();
    assert_eq!(names, ["idle", "run", "stroll", "walk"]);
    let stroll = asset.clip("stroll").expect("it is in the file");
    assert_eq!((stroll.clip.speed, stroll.clip.looping), (0.5, false));
    let walk = asset.clip("walk").expect("it is in the model");
    assert!(walk.clip.looping, "its last pose is its first");
    assert_eq!((walk.gait.speed, walk.gait.stride), (2.0, 2.0));
    let idle = asset.clip("idle").expect("it is in the model");
    assert_eq!((idle.gait.speed, idle.gait.contact_weight(LEFT, 0.3)), (0.0, 1.0));
    let run = asset.clip("run").expect("it is in the model");
    assert!(run.gait.speed > 1.0, "legs of 0.88 m swing by 0.7 rad in 0.7 s: {} m/s", run.gait.speed);
    assert_eq!(run.gait.strides, 1);
}

#[test]
fn clips_of_another_body_follow_its_names_or_its_parts() {
    let other = Body {
        names: ["pelvis", "thigh_l", "calf_l", "foot_l", "ball_l", "thigh_r", "calf_r", "foot_r", "ball_r"],
        size: 2.0,
        ..Body::default()
    };
    let text = r#"(clips: {"march": (file: "other.glb", clip: "walk")})"#;
    let file = CharacterFile::parse(text).expect("the text is good");
    let others = BTreeMap::from([("other.glb".to_owned(), rig_of(&other))]);
    let asset = CharacterAsset::resolve(file, "body.glb".into(), rig_of(&Body::default()), &others).expect("it walks");
    let (march, walk) = (asset.clip("march").unwrap(), asset.clip("walk").unwrap());
    let (mut a, mut b) = (Pose::rest(&asset.skeleton), Pose::rest(&asset.skeleton));
    for time in [0.1, 0.4, 0.9] {
        march.clip.sample(&asset.skeleton, time, a.locals_mut());
        walk.clip.sample(&asset.skeleton, time, b.locals_mut());
        a.update_model(&asset.skeleton);
        b.update_model(&asset.skeleton);
        let apart = a.position(asset.legs[LEFT].foot).distance(b.position(asset.legs[LEFT].foot));
        assert!(apart < 1e-3, "ankles {apart} m apart at {time} s");
    }
}

#[test]
fn wrong_names_are_errors_with_the_right_ones() {
    let state = r#"(locomotion: (states: [(name: "idle", clip: "idel")], transitions: []))"#;
    assert_eq!(
        fault(state),
        "`locomotion.states` has `idle` play the clip `idel`, which doesn't exist (did you mean `idle`?); \
         clips: `idle`, `run`, `walk`, `wave`"
    );
    assert_eq!(
        fault(r#"(clips: {"stroll": (clip: "wakl")})"#),
        "`clips[\"stroll\"]` asks for the clip `wakl` of `mannequin.glb`, which doesn't have it (did you mean `walk`?); \
         clips: `idle`, `run`, `walk`"
    );
    let field = fault("(\n  mottion: (),\n)");
    assert!(field.starts_with("line 2, column "), "{field}");
    assert!(field.contains("`mottion`") && field.contains("(did you mean `motion`?)"), "{field}");
    let transition = r#"(standard_clips: false, locomotion: (transitions: [(to: "wlak", when: SpeedAbove(1.0))]))"#;
    assert_eq!(
        fault(transition),
        "`locomotion.transitions[0].to` is `wlak`; valid is one of `idle`, `run`, `strafe`, `walk` (did you mean `walk`?)"
    );
    assert_eq!(
        fault(r#"(blink: (targets: ["blink"]))"#),
        "`blink.targets` is `blink`; valid is names of the model's morph targets: none"
    );
    let joint = fault(r#"(roles: Explicit({leftFoot: "lefFoot"}))"#);
    assert!(joint.contains("leftFoot the joint `lefFoot`") && joint.contains("did you mean `leftFoot`?"), "{joint}");
}

#[test]
fn values_out_of_range_say_what_is_valid() {
    for (text, message) in [
        ("(scale: 0.0)", "`scale` is 0; valid is 0.01 to 100"),
        (r#"(clips: {"walk": (speed: -1.0)})"#, "`clips[\"walk\"].speed` is -1; valid is 0.01 to 100"),
        ("(foot_ik: (pitch_limit: 120.0))", "`foot_ik.pitch_limit` is 120°; valid is 0 to 90°"),
        ("(foot_ik: (step_time: 0.0))", "`foot_ik.step_time` is 0 s; valid is 0.02 to 5 s"),
        ("(blink: (interval: 0.0))", "`blink.interval` is 0 s; valid is 0.5 to 600 s"),
        ("(blink: (interval: 1.0, duration: 0.5))", "`blink.duration` is 0.5 s; valid is 0.05 to 0.36 s"),
        (
            "(blink: (targets: []))",
            "`blink.targets` is empty; valid is names of morph targets, or None; `enabled: false` stops the blinks",
        ),
        ("(motion: (walk_speed: inf))", "motion.walk_speed is inf; valid is a number from 0 up"),
        (
            "(locomotion: (rate_range: (2.0, 1.0)))",
            "`locomotion.rate_range` is (2, 1); valid is a smaller and a larger number from 0.05 to 10",
        ),
    ] {
        assert_eq!(fault(text), message);
    }
}

#[test]
fn parts_that_are_missing_are_listed_with_what_was_found() {
    let rig = Rig::from_slice(&triangle().glb(), |_| Err("no files".to_owned())).expect("it is no body, but a rig");
    let file = CharacterFile::parse("()").expect("the text is good");
    let error =
        CharacterAsset::resolve(file, "sail.glb".into(), rig, &BTreeMap::new()).expect_err("a sail has no legs");
    let error = error.to_string();
    assert!(
        error.starts_with("`mannequin.glb`: no joint found for hips, leftUpperLeg, leftLowerLeg, leftFoot"),
        "{error}"
    );
    assert!(error.contains("found: nothing; joints: `root`, `tip`"), "{error}");
}

/// An app with files in memory.
struct Files {
    app: App,
    dir: Dir,
}

impl Files {
    fn new() -> Self {
        let dir = Dir::default();
        let root = dir.clone();
        let mut app = App::new();
        let source = AssetSourceBuilder::new(move || Box::new(MemoryAssetReader { root: root.clone() }));
        app.register_asset_source(AssetSourceId::Default, source);
        app.add_plugins((MinimalPlugins, AssetPlugin::default(), RigPlugin));
        Self { app, dir }
    }

    fn put(&self, path: &str, bytes: Vec<u8>) {
        self.dir.insert_asset(Path::new(path), bytes);
    }

    /// Runs until the load is over, and says why it failed, if it did.
    fn settle(&mut self, handle: &Handle<CharacterAsset>) -> Option<String> {
        for _ in 0..2000 {
            self.app.update();
            match self.app.world().resource::<AssetServer>().load_state(handle) {
                LoadState::Loaded => return None,
                LoadState::Failed(error) => return Some(error.to_string()),
                _ => std::thread::sleep(Duration::from_millis(2)),
            }
        }
        panic!("the load never ends");
    }
}

#[test]
fn a_character_loads_without_a_gpu_and_a_broken_reload_keeps_the_last_good_one() {
    let mut files = Files::new();
    files.put("people/body.glb", Body::default().build().glb());
    files.put("people/hero.character.ron", br#"(model: "body.glb", scale: 2.0)"#.to_vec());
    let handle = files.app.world().resource::<AssetServer>().load("people/hero.character.ron");
    assert_eq!(files.settle(&handle), None);
    let leg = |files: &Files| {
        let assets = files.app.world().resource::<Assets<CharacterAsset>>();
        assets.get(&handle).expect("a character is there").leg_length
    };
    assert!((leg(&files) - 1.76).abs() < 1e-3, "leg of {} m", leg(&files));

    files.put("people/hero.character.ron", br#"(model: "body.glb", scael: 1.0)"#.to_vec());
    files.app.world().resource::<AssetServer>().reload("people/hero.character.ron");
    for _ in 0..100 {
        files.app.update();
        std::thread::sleep(Duration::from_millis(2));
    }
    assert!((leg(&files) - 1.76).abs() < 1e-3, "the last good one stays: leg of {} m", leg(&files));

    files.put("people/hero.character.ron", br#"(model: "body.glb", scale: 1.0)"#.to_vec());
    files.app.world().resource::<AssetServer>().reload("people/hero.character.ron");
    for _ in 0..2000 {
        files.app.update();
        if (leg(&files) - 0.88).abs() < 1e-3 {
            return;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    panic!("the mended file never came: leg of {} m", leg(&files));
}

#[test]
fn load_errors_name_the_file_and_what_is_wrong() {
    let mut files = Files::new();
    files.put("body.glb", Body::default().build().glb()[..200].to_vec());
    for (path, text, parts) in [
        ("a.character.ron", r#"(model: "nobody.glb")"#, ["a.character.ron", "nobody.glb"]),
        ("b.character.ron", r#"(model: "body.glb")"#, ["b.character.ron", "cut off"]),
        ("c.character.ron", "(scale: 1.0, sclae: 2.0)", ["c.character.ron", "did you mean `scale`?"]),
    ] {
        files.put(path, text.as_bytes().to_vec());
        let handle = files.app.world().resource::<AssetServer>().load(path);
        let error = files.settle(&handle).expect("the file is bad");
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
}

#[test]
fn the_shipped_character_loads_with_every_field_at_its_default() {
    let text = include_str!("../../assets/mannequin.character.ron");
    let file = CharacterFile::parse(text).expect("the shipped file is good");
    let written = |file: &CharacterFile| ron::to_string(file).expect("a character file can be written");
    let mut defaults = CharacterFile::default();
    defaults.locomotion = defaults.locomotion.completed(|_| true);
    defaults.actions = Some(actions::standard());
    assert_eq!(written(&file), written(&defaults), "the file spells out the defaults");
    let action = ActionConfig::default();
    let parts: [&dyn PartialReflect; 9] = [
        &file,
        &action,
        &file.motion,
        &file.locomotion,
        &file.balance,
        &file.foot_ik,
        &file.look,
        &file.aim,
        &file.blink,
    ];
    for part in parts {
        let fields = part.reflect_ref().as_struct().expect("tuning is made of structs");
        for name in (0..fields.field_len()).filter_map(|index| fields.name_at(index)) {
            assert!(text.contains(&format!("{name}:")), "assets/mannequin.character.ron lacks the field {name}");
        }
    }
}

#[test]
fn the_mannequin_walks_at_the_speed_its_baker_meant() {
    let bytes = include_bytes!("../../assets/mannequin.glb");
    let rig = Rig::from_slice(bytes, |_| Err("no files".to_owned())).expect("the mannequin is good");
    assert_eq!(rig.notes, [""; 0]);
    let file = CharacterFile::default();
    let asset = CharacterAsset::resolve(file, "mannequin.glb".into(), rig, &BTreeMap::new()).expect("it is a humanoid");
    let rest = Pose::rest(&asset.skeleton);
    for (foot, leg) in asset.legs.iter().enumerate() {
        for point in leg.sole() {
            let height = point.position(&rest).y;
            assert!(height.abs() < 1e-3, "foot {foot} has a sole point at {height} m");
        }
    }
    for (name, speed, stance) in [("walk", 1.4, 0.59), ("run", 3.5, 0.36)] {
        let clip = asset.clip(name).unwrap_or_else(|| panic!("{name} is in the file"));
        let found = Gait::analyze(&clip.clip, &asset.skeleton, &asset.legs);
        assert!((found.speed - speed).abs() < 0.01, "{name} goes at {} m/s, not {speed}", found.speed);
        assert!(clip.clip.report.max_error < 1e-4, "{name} is off by {} m", clip.clip.report.max_error);
        for foot in 0..2 {
            let contact = clip.gait.contact[foot][0];
            assert!((contact.start - 0.5 * foot as f32).abs() < 0.02, "{name}: foot {foot} lands at {}", contact.start);
            let length = contact.end - contact.start;
            assert!((length - stance).abs() < 0.05, "{name}: foot {foot} stands for {length}, not {stance}");
        }
    }
}
