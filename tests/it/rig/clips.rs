//! Keys, their meaning, and what is wrong with them.

use surefoot::anim::peak::Peak;

use super::*;

#[test]
fn interpolation_left_out_is_linear_and_the_first_key_holds() {
    let rig = rig(&animated("translation", &[0.5, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0], None));
    for (time, x) in [(0.0, 0.0), (0.5, 0.0), (0.75, 0.5), (1.0, 1.0), (4.0, 1.0)] {
        let at = translation_at(&rig, time);
        assert!(near(at, Vec3::X * x), "{at} at {time} s");
    }
}

#[test]
fn steps_jump_and_splines_bend() {
    let values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0];
    let step = rig(&animated("translation", &[0.0, 1.0], &values, Some("STEP")));
    assert!(near(translation_at(&step, 0.9), Vec3::ZERO), "{}", translation_at(&step, 0.9));
    let flat = [[0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [1.0, 0.0, 0.0], [0.0; 3]].concat();
    let spline = rig(&animated("translation", &[0.0, 1.0], &flat, Some("CUBICSPLINE")));
    let quarter = translation_at(&spline, 0.25).x;
    assert!((quarter - 0.15625).abs() < 2e-3, "smoothstep of a quarter is 0.15625, not {quarter}");
}

#[test]
fn channels_that_are_not_there_stay_at_rest() {
    let turn = [0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0];
    let rig = rig(&animated("rotation", &[0.0, 1.0], &turn, None));
    assert!(near(translation_at(&rig, 0.5), Vec3::X * 5.0));
    let mut pose = Pose::rest(&rig.skeleton);
    rig.clips[0].sample(&rig.skeleton, 0.5, pose.locals_mut());
    let half = angle_between(pose.local(JointIndex(0)).rotation, Quat::from_rotation_y(core::f32::consts::FRAC_PI_2));
    assert!(half < 1e-3, "off by {half} rad");
}

#[test]
fn normalized_integers_are_rotations_too() {
    let mut file = animated("rotation", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0], None);
    let half = 23_170_i16; // sin 45° of 32,767
    let bytes: Vec<u8> = [0, 0, 0, 32_767, 0, half, 0, half].iter().flat_map(|n: &i16| n.to_le_bytes()).collect();
    let output = file.accessor(&bytes, 5122, "VEC4", 2);
    file.root["accessors"][output]["normalized"] = json!(true);
    file.root["animations"][0]["samplers"][0]["output"] = json!(output);
    let rig = rig(&file);
    let mut pose = Pose::rest(&rig.skeleton);
    rig.clips[0].sample(&rig.skeleton, 1.0, pose.locals_mut());
    let off = angle_between(pose.local(JointIndex(0)).rotation, Quat::from_rotation_y(core::f32::consts::FRAC_PI_2));
    assert!(off < 2e-3, "off by {off} rad");
}

#[test]
fn morph_weights_follow_their_keys() {
    let mut file = GltfFile::new();
    let positions = file.floats("VEC3", &[0.0; 3]);
    let raised = file.floats("VEC3", &[0.0, 2.0, 0.0]);
    let targets = json!([{ "POSITION": raised }, { "POSITION": raised }]);
    let primitives = json!([{ "attributes": { "POSITION": positions }, "targets": targets }]);
    file.push("meshes", json!({ "primitives": primitives, "weights": [0.25, 0.5] }));
    file.push("nodes", json!({ "mesh": 0 }));
    file.clip("blink", &[(0, "weights", &[0.0, 1.0], &[0.0, 1.0, 1.0, 0.0])]);
    let rig = rig(&file);
    assert_eq!(rig.meshes[0].morph_weights, [0.25, 0.5]);
    let mut weights = [0.0; 2];
    assert!(rig.clips[0].morph_weights(JointIndex(0), 0.25, &mut weights));
    assert!((weights[0] - 0.25).abs() < 1e-5 && (weights[1] - 0.75).abs() < 1e-5, "{weights:?}");
    let bounds = rig.joint_bounds[0].expect("the node has a vertex");
    assert_eq!(Vec3::from(bounds.max), Vec3::Y * 4.0, "both targets at full weight");
}

#[test]
fn a_clip_without_channels_is_the_rest_pose() {
    let mut file = triangle();
    file.push("animations", json!({ "name": "nothing", "channels": [], "samplers": [] }));
    let rig = rig(&file);
    assert_eq!((rig.clips[0].duration, rig.clips[0].frame_count()), (0.0, 1));
}

#[test]
fn bad_keys_name_clip_channel_and_node() {
    let one = [0.0; 3];
    let two = [0.0; 6];
    let bad = |times: &[f32], values: &[f32]| fault(&animated("translation", times, values, None));
    let place = "clip `move`, translation of node `node0`: ";
    assert_eq!(bad(&[0.0, f32::NAN], &two), format!("{place}key 1 is not a finite number"));
    let message = bad(&[0.5, 0.5], &two);
    assert_eq!(message, format!("{place}the time of key 1, 0.5 s, is not after the key before it, at 0.5 s"));
    assert_eq!(bad(&[0.0, 1.0], &one), format!("{place}2 keys need 2 values, but there are 1"));
    assert_eq!(bad(&[0.0], &[f32::INFINITY, 0.0, 0.0]), format!("{place}key 0 is not a finite number"));
    let zero = fault(&animated("rotation", &[0.0], &[0.0; 4], None));
    assert_eq!(zero, "clip `move`, rotation of node `node0`: the rotation of key 0 has length zero");
    let mut file = animated("translation", &[0.0], &one, None);
    let twice = file.root["animations"][0]["channels"][0].clone();
    file.root["animations"][0]["channels"].as_array_mut().unwrap().push(twice);
    assert_eq!(fault(&file), format!("{place}two channels move it"));
    let weights = fault(&animated("weights", &[0.0], &[1.0], None));
    assert_eq!(weights, "clip `move`, weights of node `node0`: the node's mesh has no morph targets");
}

#[test]
fn a_clip_of_many_hours_loads_all_the_same() {
    let begun = std::time::Instant::now();
    let zigzag = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 7.0, 0.0, 0.0];
    let rig = rig(&animated("translation", &[0.0, 0.1, 0.2, 1e6], &zigzag, None));
    assert!((rig.clips[0].duration - 1e6).abs() < 1.0, "{} s", rig.clips[0].duration);
    let peak = Peak::of(&rig.clips[0], &rig.skeleton, 1.0 / 60.0);
    assert!(peak.velocity_jump > 1.0, "the zigzag at its beginning is lively: {peak:?}");
    let seconds = begun.elapsed().as_secs_f32();
    assert!(seconds < 20.0, "it takes {seconds} s");
}

#[test]
fn what_goes_out_of_all_bounds_is_named() {
    let mut far = triangle();
    far.root["nodes"][0]["scale"] = json!([1e10, 1e10, 1e10]);
    far.root["nodes"][1]["translation"] = json!([0.0, 1e30, 0.0]);
    let message = fault(&far);
    assert!(message.starts_with("node `tip`: where it is at rest is not finite"), "{message}");
    let mut file = triangle();
    file.root["nodes"][1]["translation"] = json!([0.0, 1e3, 0.0]);
    file.clip("move", &[(0, "scale", &[0.0, 1.0], &[1.0, 1.0, 1.0, 3e38, 3e38, 3e38])]);
    let message = fault(&file);
    let named = message.starts_with("clip `move`, place of node `tip`: in frame");
    assert!(named && message.contains("not finite"), "{message}");
}
