//! Bodies from elsewhere: without clips, in other poses, with other axes; they walk as the mannequin does.

use std::collections::BTreeMap;

use bevy::prelude::*;
use serde_json::json;
use surefoot::{
    anim::{clip::Clip, pose::Pose},
    math::rotation::from_scaled_axis,
    rig::{Rig, character::CharacterAsset, character_file::CharacterFile, humanoid::HumanoidRole as Role},
    testing::{Stage, World},
};

use crate::gltf_file::{Body, GltfFile};

fn character(text: &str, file: &GltfFile) -> CharacterAsset {
    let rig = Rig::from_slice(&file.glb(), |_| Err("no files".to_owned())).expect("the file is good");
    let file = CharacterFile::parse(text).expect("the text is good");
    CharacterAsset::resolve(file, "body.glb".into(), rig, &BTreeMap::new()).unwrap_or_else(|error| panic!("{error}"))
}

/// The mannequin's file, its clips under names that no state knows.
pub fn mannequin() -> GltfFile {
    let glb = include_bytes!("../../assets/mannequin.glb");
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().expect("four bytes")) as usize;
    let json = &glb[20..20 + word(12)];
    let mut root: serde_json::Value = serde_json::from_slice(json).expect("the mannequin's JSON is good");
    for clip in root["animations"].as_array_mut().expect("it has clips") {
        clip["name"] = json!(format!("own {}", clip["name"].as_str().expect("clips have names")));
    }
    GltfFile { root, bin: glb[28 + word(12)..].to_vec() }
}

/// Gives every joint other axes; where they are stays.
fn with_axes(mut file: GltfFile, axes: impl Fn(usize) -> Quat) -> GltfFile {
    let nodes = file.root["nodes"].as_array_mut().expect("nodes");
    let children: Vec<Vec<usize>> = nodes
        .iter()
        .map(|node| node["children"].as_array().into_iter().flatten().filter_map(serde_json::Value::as_u64))
        .map(|children| children.map(|child| child as usize).collect())
        .collect();
    for (parent, children) in children.iter().enumerate() {
        for &child in children {
            let at: Vec<f32> = nodes[child]["translation"]
                .as_array()
                .map_or(vec![0.0; 3], |at| at.iter().map(|value| value.as_f64().unwrap_or(0.0) as f32).collect());
            let at = axes(parent).inverse() * Vec3::from_slice(&at);
            let turn = axes(parent).inverse() * axes(child);
            nodes[child]["translation"] = json!(at.to_array());
            nodes[child]["rotation"] = json!(turn.to_array());
        }
    }
    // Vertices stay where they are, too.
    let skin = file.root["skins"][0].clone();
    let view = file.root["accessors"][skin["inverseBindMatrices"].as_u64().expect("it has them") as usize].clone();
    let start = file.root["bufferViews"][view["bufferView"].as_u64().expect("a view") as usize]["byteOffset"].clone();
    let start = start.as_u64().unwrap_or(0) as usize;
    for (slot, node) in skin["joints"].as_array().expect("joints").iter().enumerate() {
        let bytes = &mut file.bin[start + 64 * slot..start + 64 * (slot + 1)];
        let old: Vec<f32> =
            bytes.chunks_exact(4).map(|raw| f32::from_le_bytes(raw.try_into().expect("four"))).collect();
        let turned = Mat4::from_quat(axes(node.as_u64().expect("an index") as usize).inverse());
        let new = turned * Mat4::from_cols_slice(&old);
        for (raw, value) in bytes.chunks_exact_mut(4).zip(new.to_cols_array()) {
            raw.copy_from_slice(&value.to_le_bytes());
        }
    }
    file.root.as_object_mut().expect("an object").remove("animations");
    file
}

/// Largest distance, metres, between joints that play the same part, over all clips that are called alike.
fn apart(one: &CharacterAsset, other: &CharacterAsset, prefix: &str, roles: &[Role]) -> (f32, String) {
    let mut worst = (0.0, String::new());
    let (mut a, mut b) = (Pose::rest(&one.skeleton), Pose::rest(&other.skeleton));
    for clip in one.clips().iter().filter(|clip| !clip.name.starts_with("own ")) {
        let original = other.clip(&format!("{prefix}{}", clip.name)).expect("the mannequin has it");
        for step in 0..20u8 {
            let share = f32::from(step) / 20.0;
            clip.clip.sample(&one.skeleton, share * clip.clip.duration, a.locals_mut());
            original.clip.sample(&other.skeleton, share * original.clip.duration, b.locals_mut());
            a.update_model(&one.skeleton);
            b.update_model(&other.skeleton);
            for &role in roles {
                let (Some(own), Some(theirs)) = (one.humanoid.get(role), other.humanoid.get(role)) else { continue };
                let distance = a.position(own).distance(b.position(theirs));
                if distance > worst.0 {
                    worst = (distance, format!("{} in `{}` at {share}", role.spelling(), clip.name));
                }
            }
        }
    }
    worst
}

#[test]
fn the_same_body_with_other_joint_axes_moves_the_same() {
    let original = character("()", &mannequin());
    let turned =
        |node: usize| from_scaled_axis(Vec3::new(0.7 * (node % 5) as f32 - 1.4, 0.5 * (node % 7) as f32, -0.9));
    let axes = |node: usize| if node == 0 { Quat::IDENTITY } else { turned(node) };
    let other = character("()", &with_axes(mannequin(), axes));
    let (distance, place) = apart(&other, &original, "own ", &Role::ALL);
    // Soft ends of the legs' reach and baked frames cost some tenths of a millimetre.
    assert!(distance < 0.004, "{:.1} mm: {place}", 1000.0 * distance);
}

#[test]
fn a_body_plays_its_own_clips_as_they_are() {
    let glb = include_bytes!("../../assets/mannequin.glb");
    let rig = Rig::from_slice(glb, |_| Err("no files".to_owned())).expect("the mannequin is good");
    let file = CharacterFile::default();
    let asset = CharacterAsset::resolve(file, "body.glb".into(), rig.clone(), &BTreeMap::new()).expect("it walks");
    assert_eq!(asset.clips().len(), rig.clips.len(), "every clip is there, and no other");
    for own in &rig.clips {
        let played = asset.clip(&own.name).expect("its clips are there");
        let whole = if own.looping { own.without_lead() } else { Clip::clone(own) };
        assert!(*played.clip == whole, "`{}` is not as the file has it", own.name);
    }
}

#[test]
fn arms_that_hang_at_rest_swing_as_arms_held_out_do() {
    let mut hanging = mannequin();
    for node in hanging.root["nodes"].as_array_mut().expect("nodes") {
        let turn = match node["name"].as_str() {
            Some("leftUpperArm") => Quat::from_rotation_z(-0.9),
            Some("rightUpperArm") => Quat::from_rotation_z(0.9),
            _ => continue,
        };
        node["rotation"] = json!(turn.to_array());
    }
    hanging.root.as_object_mut().expect("an object").remove("animations");
    let original = character("()", &mannequin());
    let arms = [Role::LeftLowerArm, Role::LeftHand, Role::RightLowerArm, Role::RightHand];
    let (distance, place) = apart(&character("()", &hanging), &original, "own ", &arms);
    assert!(distance < 0.004, "{:.1} mm: {place}", 1000.0 * distance);
    let text = "(retarget: (align_arms: false))";
    let (distance, _) = apart(&character(text, &hanging), &original, "own ", &arms);
    assert!(distance > 0.2, "without alignment arms hang by the rest pose, not {distance} m from it");
}

#[test]
fn a_chain_whose_share_is_nothing_stays_at_rest_against_its_trunk() {
    let file = with_axes(mannequin(), |_| Quat::IDENTITY);
    let bent = |text: &str| {
        let asset = character(text, &file);
        let clip = asset.clip("run").expect("the mannequin runs").clip.clone();
        let mut pose = Pose::rest(&asset.skeleton);
        let elbow = asset.humanoid.get(Role::LeftLowerArm).expect("it has elbows");
        let turns = (0..20u8).map(|step| {
            clip.sample(&asset.skeleton, f32::from(step) / 20.0 * clip.duration, pose.locals_mut());
            pose.local(elbow).rotation.angle_between(asset.skeleton.rest()[elbow.index()].rotation)
        });
        turns.fold(0.0, f32::max)
    };
    assert!(bent("()") > 1.0, "a runner's elbow bends by {} rad", bent("()"));
    assert!(bent("(retarget: (arms: 0.0))") < 1e-2, "it still bends by {} rad", bent("(retarget: (arms: 0.0))"));
}

/// A body of boxes without clips, whose joints are merely numbered; feet are `feet` times as long as a human's.
fn stranger(size: f32, feet: f32) -> GltfFile {
    let mut file = Body { size, feet, ..Body::default() }.build();
    file.root.as_object_mut().expect("an object").remove("animations");
    for (index, node) in file.root["nodes"].as_array_mut().expect("nodes").iter_mut().enumerate() {
        node["name"] = json!(format!("Bone_{index:02}"));
    }
    file
}

#[test]
fn soles_of_foreign_bodies_stand_as_the_mannequins_do() {
    for size in [0.4, 1.0, 2.5] {
        let asset = character("()", &stranger(size, 1.0));
        let walk = asset.clip("walk").expect("the mannequin walks");
        let mut pose = Pose::rest(&asset.skeleton);
        let samples = 120u8;
        let mut balls: [Option<Vec3>; 2] = [None; 2];
        let step = walk.clip.duration / f32::from(samples);
        for sample in 0..samples {
            let time = f32::from(sample) * step;
            walk.clip.sample(&asset.skeleton, time, pose.locals_mut());
            pose.update_model(&asset.skeleton);
            let phase = walk.gait.phase_at(time, walk.clip.duration);
            for (foot, leg) in asset.legs.iter().enumerate() {
                let sole = leg.sole().map(|point| point.position(&pose));
                let lowest = sole.map(|point| point.y).into_iter().fold(f32::INFINITY, f32::min);
                let stands = walk.gait.contact_weight(foot, phase) > 0.999;
                assert!(!stands || lowest.abs() < 0.003 * size, "size {size}: the sole is at {lowest} m in stance");
                // The heel comes first; from when the ball is down it stays.
                let down = (stands && sole[1].y < 0.002 * size).then_some(sole[1]);
                if let (Some(before), Some(_)) = (core::mem::replace(&mut balls[foot], down), down) {
                    let slides = ((sole[1] - before) / step + walk.gait.velocity).with_y(0.0).length();
                    assert!(slides < 0.06 * walk.gait.speed, "size {size}: it slides at {slides} m/s");
                }
            }
        }
    }
}

#[test]
fn long_feet_are_flat_when_the_mannequins_are() {
    let (original, asset) = (character("()", &mannequin()), character("()", &stranger(1.0, 2.5)));
    let highest = |asset: &CharacterAsset, clip: &str, share: f32| {
        let clip = &asset.clip(clip).expect("the mannequin has it").clip;
        let mut pose = Pose::rest(&asset.skeleton);
        clip.sample(&asset.skeleton, share * clip.duration, pose.locals_mut());
        pose.update_model(&asset.skeleton);
        asset.legs.map(|leg| leg.sole().map(|point| point.position(&pose).y).into_iter().fold(0.0, f32::max))
    };
    for name in ["idle", "crouch_idle", "walk"] {
        let mut flat = 0;
        for step in 0..60u8 {
            let share = f32::from(step) / 60.0;
            let theirs = highest(&original, &format!("own {name}"), share);
            for (own, theirs) in highest(&asset, name, share).into_iter().zip(theirs) {
                flat += u32::from(theirs < 0.001);
                assert!(theirs >= 0.001 || own < 0.002, "`{name}` at {share}: {:.1} mm up", 1000.0 * own);
            }
        }
        assert!(flat > 10, "`{name}` has flat feet {flat} times");
    }
}

#[test]
fn foreign_bodies_of_any_size_walk_over_hills_and_stairs_on_their_feet() {
    for size in [0.6, 1.0, 1.6] {
        let asset = character("()", &stranger(size, 1.0));
        let speed = 1.3 * size.sqrt();
        for world in [World::flat(), World::hills(), World::stairs_up(8, 0.15 * size.min(1.0), 0.32)] {
            let mut stage = Stage::on(&world);
            let walker = stage.spawn_loaded(asset.clone(), &[Transform::IDENTITY])[0];
            stage.run_for(0.5).start_recording(walker).walk(walker, Vec3::NEG_Z * speed).run_for(4.0);
            let measures = stage.measures(walker);
            let case = format!("size {size} on {}", world.name);
            let way = stage.root(walker).length();
            assert!(way > 3.0 * speed, "{case}: it came {way} m far");
            assert!(measures.float_p95 <= 10.0, "{case}: feet float {} mm", measures.float_p95);
            assert!(measures.penetration_p99 <= 5.0, "{case}: feet sink in {} mm", measures.penetration_p99);
            assert!(measures.drift_p95 <= 5.0, "{case}: plants drift {} mm", measures.drift_p95);
        }
    }
}

#[test]
fn short_legs_with_long_feet_climb_stairs_made_for_them_without_sinking_in() {
    // Feet as long as the legs, as toys have them, and longer than the treads.
    let (size, feet) = (0.45, 2.6);
    let asset = character("()", &stranger(size, feet));
    let speed = 1.3 * size.sqrt();
    for tread in [0.32, 0.6] {
        let world = World::stairs_up(8, 0.17 * size, tread * size);
        let mut stage = Stage::on(&world);
        let walker = stage.spawn_loaded(asset.clone(), &[Transform::IDENTITY])[0];
        stage.run_for(0.5).start_recording(walker).walk(walker, Vec3::NEG_Z * speed).run_for(5.0);
        let measures = stage.measures(walker);
        let way = stage.root(walker).length();
        assert!(way > 4.0 * speed, "treads of {tread}: it came {way} m far");
        assert!(measures.penetration_p99 <= 5.0, "treads of {tread}: feet sink in {} mm", measures.penetration_p99);
        assert!(measures.skate <= 2.0, "treads of {tread}: feet skate {} cm/s", measures.skate);
    }
}

#[test]
fn a_clip_that_hovers_over_its_floor_stands_on_the_ground() {
    let mut rig = Rig::from_slice(include_bytes!("../../assets/mannequin.glb"), |_| Err("no files".to_owned()))
        .expect("the mannequin is good");
    let hips = rig.skeleton.find("hips").expect("it has hips");
    for clip in rig.clips.iter_mut().filter(|clip| clip.name == "walk") {
        *clip = Clip::clone(clip).moved(&rig.skeleton, hips, Vec3::Y * 0.02).into();
    }
    let asset = CharacterAsset::resolve(CharacterFile::default(), "body.glb".into(), rig, &BTreeMap::new());
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_loaded(asset.expect("it walks"), &[Transform::IDENTITY])[0];
    stage.run_for(0.5).start_recording(walker).walk(walker, Vec3::NEG_Z * 1.4).run_for(4.0);
    let measures = stage.measures(walker);
    assert!(measures.float_p95 <= 10.0, "feet float {} mm of the clip's 20", measures.float_p95);
    assert!(measures.skate <= 1.0, "feet skate {} cm/s", measures.skate);
}

/// The mannequin's file with its clips called otherwise; those without a name here are left out.
fn renamed(names: &[(&str, &str)]) -> GltfFile {
    let mut file = mannequin();
    let clips = file.root["animations"].as_array_mut().expect("it has clips");
    clips.retain_mut(|clip| {
        let name = clip["name"].as_str().expect("clips have names").trim_start_matches("own ").to_owned();
        let new = names.iter().find(|(old, _)| *old == name);
        new.inspect(|(_, new)| clip["name"] = json!(new)).is_some()
    });
    file
}

#[test]
fn clips_called_like_states_in_other_words_play_in_them() {
    let names = [
        ("idle", "Robot_Idle"),
        ("walk", "Robot_Walking"),
        ("run", "Robot_Jog_Fwd"),
        ("sprint", "Robot_Walking_B"),
        ("jump", "Robot_Jump"),
        ("crouch_walk", "Robot_Sneaking"),
        ("strafe_left", "Robot_Strafe Left"),
        ("walk_back", "Robot_WalkBackward"),
    ];
    let asset = character("()", &renamed(&names));
    let same = |state: &str, clip: &str| {
        let [a, b] = [state, clip].map(|name| asset.clip(name).unwrap_or_else(|| panic!("no clip `{name}`")));
        std::sync::Arc::ptr_eq(&a.clip, &b.clip)
    };
    for (state, clip) in names {
        // The plainer of two names is taken, and a jump by its own name alone.
        let taken = !["sprint", "jump"].contains(&state);
        assert_eq!(same(state, clip), taken, "`{state}` and `{clip}`");
    }
    assert!(asset.own_clips.iter().all(|own| own.refused.is_none()), "{:?}", asset.own_clips);
    let plain = character("(own_clips: false)", &renamed(&names));
    assert!(
        plain.own_clips.is_empty()
            && !std::sync::Arc::ptr_eq(
                &plain.clip("walk").expect("the mannequin's").clip,
                &plain.clip("Robot_Walking").expect("its own").clip
            )
    );
    let told = character(r#"(clips: {"walk": (clip: "Robot_Walking_B")})"#, &renamed(&names));
    let speed = told.clip("walk").expect("as the file says").gait.speed;
    assert!(speed > 5.0, "the file's own words count first: a sprint for a walk goes at {speed} m/s");
}

#[test]
fn a_clip_that_is_not_what_its_name_says_is_refused_in_words() {
    let names = [("walk", "Idle"), ("strafe_left", "Run"), ("wave", "Crouch"), ("idle", "Walk")];
    let asset = character("()", &renamed(&names));
    let remarks: Vec<String> = asset.own_clips.iter().map(ToString::to_string).collect();
    let expected = [
        "`Crouch` is called like `crouch_idle` but does not end as it begins",
        "`Idle` is called like `idle` but has feet that go at 1.4 m/s",
        "`Run` is called like `run` but has feet that don't go that way",
        "`Walk` is called like `walk` but has feet that don't go that way",
    ];
    assert_eq!(remarks, expected);
    let speed = asset.clip("walk").expect("the mannequin's").gait.speed;
    assert!((speed - 1.4).abs() < 0.05, "it walks at {speed} m/s");
}

#[test]
fn the_controller_is_brought_to_the_bodys_size() {
    for size in [0.5f32, 1.0, 2.0] {
        let asset = character("()", &stranger(size, 1.0));
        let (motion, person) = (&asset.file.motion, CharacterFile::default().motion);
        let legs = (asset.leg_length / 0.875).sqrt();
        let legs = if (legs - 1.0).abs() < 0.02 { 1.0 } else { legs };
        assert!((motion.walk_speed - legs * person.walk_speed).abs() < 0.01, "size {size}: {} m/s", motion.walk_speed);
        let tall = motion.height / asset.stature;
        assert!((0.95..1.05).contains(&tall), "size {size}: a capsule {tall} times as tall as the body");
        let own = character("(fit_motion: false, motion: (walk_speed: 1.1))", &stranger(size, 1.0));
        assert!((own.file.motion.walk_speed - 1.1).abs() < 1e-6, "as the file says");
        let walk = asset.clip("walk").expect("the mannequin's").gait.speed;
        let off = (walk / motion.walk_speed - 1.0).abs();
        assert!(off < 0.1, "size {size}: it walks at {} m/s with a clip of {walk} m/s", motion.walk_speed);
    }
}
