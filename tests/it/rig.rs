//! Import of glTF files: every quirk of the format that is read, and every fault that is told.

use bevy::math::{Quat, Vec3};
use serde_json::json;
use surefoot::{
    anim::{pose::Pose, skeleton::JointIndex},
    math::rotation::angle_between,
    rig::{Rig, gltf::error::RigError},
};

use crate::gltf_file::{Body, GltfFile, triangle};

fn no_files(uri: &str) -> Result<Vec<u8>, String> {
    Err(format!("no test has the file {uri}"))
}

fn load(file: &GltfFile) -> Result<Rig, RigError> {
    Rig::from_slice(&file.glb(), no_files)
}

fn rig(file: &GltfFile) -> Rig {
    load(file).expect("the file is good")
}

/// What the error says; the file must not load.
fn fault(file: &GltfFile) -> String {
    load(file).expect_err("the file is bad").to_string()
}

fn near(a: Vec3, b: Vec3) -> bool {
    a.distance(b) < 1e-5
}

/// A glTF file on whose node `node0` a clip plays `path`.
fn animated(path: &str, times: &[f32], values: &[f32], interpolation: Option<&str>) -> GltfFile {
    let mut file = GltfFile::new();
    file.push("nodes", json!({ "translation": [5.0, 0.0, 0.0] }));
    file.clip("move", &[(0, path, times, values)]);
    if let Some(interpolation) = interpolation {
        file.root["animations"][0]["samplers"][0]["interpolation"] = json!(interpolation);
    }
    file
}

fn translation_at(rig: &Rig, time: f32) -> Vec3 {
    let mut pose = Pose::rest(&rig.skeleton);
    rig.clips[0].sample(&rig.skeleton, time, pose.locals_mut());
    pose.local(JointIndex(0)).translation
}

mod skeletons {
    use super::*;

    #[test]
    fn parents_come_before_children_whatever_the_order_of_nodes() {
        let mut file = GltfFile::new();
        file.push("nodes", json!({ "name": "hand", "translation": [0.0, 0.0, 3.0] }));
        file.push("nodes", json!({ "name": "arm", "children": [0], "translation": [0.0, 2.0, 0.0] }));
        file.push("nodes", json!({ "name": "armature", "children": [1], "translation": [1.0, 0.0, 0.0] }));
        file.push("nodes", json!({ "name": "lamp" }));
        file.push("skins", json!({ "joints": [0, 1] }));
        let rig = rig(&file);
        assert_eq!(rig.skeleton.names(), ["armature", "arm", "hand"], "the lamp moves nothing");
        assert_eq!(rig.skins[0].joints, [JointIndex(2), JointIndex(1)]);
        let hand = Pose::rest(&rig.skeleton).position(JointIndex(2));
        assert!(near(hand, Vec3::new(-1.0, 2.0, -3.0)), "half a turn about Y: {hand}");
    }

    #[test]
    fn node_matrices_come_apart() {
        let mut file = GltfFile::new();
        // Twice as large, a quarter turn about Z, moved.
        let matrix = [0.0, 2.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 7.0, 8.0, 9.0, 1.0];
        file.push("nodes", json!({ "matrix": matrix }));
        file.push("skins", json!({ "joints": [0] }));
        let rest = rig(&file).skeleton.rest()[0];
        assert!(near(rest.translation, Vec3::new(7.0, 8.0, 9.0)), "{rest:?}");
        assert!(near(rest.scale, Vec3::splat(2.0)), "{rest:?}");
        let turn = angle_between(rest.rotation, Quat::from_rotation_z(core::f32::consts::FRAC_PI_2));
        assert!(turn < 1e-3, "off by {turn} rad");
    }

    #[test]
    fn three_hundred_joints_are_no_problem() {
        let mut file = GltfFile::new();
        for joint in 0..300 {
            let children = if joint < 299 { vec![joint + 1] } else { Vec::new() };
            let node = json!({ "translation": [0.0, 0.01, 0.0], "children": children });
            file.push("nodes", node);
        }
        file.root["nodes"][299].as_object_mut().unwrap().remove("children");
        file.push("skins", json!({ "joints": (0..300).collect::<Vec<_>>() }));
        let rig = rig(&file);
        assert_eq!((rig.skeleton.len(), rig.skins[0].joints.len()), (300, 300));
        let top = Pose::rest(&rig.skeleton).position(JointIndex(299));
        assert!((top.y - 3.0).abs() < 1e-3, "the top is at {top}");
    }

    #[test]
    fn more_joints_than_an_index_counts_are_refused() {
        let mut file = GltfFile::new();
        file.root["nodes"] = json!(vec![json!({}); 65_536]);
        file.push("skins", json!({ "joints": (0..65_536).collect::<Vec<_>>() }));
        assert_eq!(fault(&file), "65536 joints; at most 65535 are possible");
    }

    #[test]
    fn circles_and_second_parents_are_named() {
        let mut file = GltfFile::new();
        file.push("nodes", json!({ "name": "a", "children": [1] }));
        file.push("nodes", json!({ "name": "b", "children": [0] }));
        assert_eq!(fault(&file), "node `a`: it is its own ancestor: the nodes form a circle");
        let mut file = GltfFile::new();
        file.push("nodes", json!({ "name": "a", "children": [2] }));
        file.push("nodes", json!({ "name": "b", "children": [2] }));
        file.push("nodes", json!({ "name": "c" }));
        assert_eq!(fault(&file), "node `c`: it hangs below both `a` and `b`");
    }

    #[test]
    fn a_rotation_of_length_zero_is_named() {
        let mut file = GltfFile::new();
        file.push("nodes", json!({ "name": "wrist", "rotation": [0.0, 0.0, 0.0, 0.0] }));
        file.push("skins", json!({ "joints": [0] }));
        assert_eq!(fault(&file), "node `wrist`: its rotation has length zero");
    }
}

mod clips {
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
        let half =
            angle_between(pose.local(JointIndex(0)).rotation, Quat::from_rotation_y(core::f32::consts::FRAC_PI_2));
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
        let off =
            angle_between(pose.local(JointIndex(0)).rotation, Quat::from_rotation_y(core::f32::consts::FRAC_PI_2));
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
}

#[expect(clippy::float_cmp, reason = "numbers come out as they went in")]
mod vertices {
    use super::*;

    #[test]
    fn skins_without_matrices_bind_by_identity_and_boxes_hold_their_vertices() {
        let rig = rig(&triangle());
        assert!(rig.notes.is_empty(), "{:?}", rig.notes);
        assert_eq!(rig.meshes[0].influences[0].joints[1][..2], [0, 1]);
        let tip = rig.joint_bounds[1].expect("two vertices hang on the tip");
        assert_eq!((Vec3::from(tip.min), Vec3::from(tip.max)), (Vec3::ZERO, Vec3::new(1.0, 2.0, 0.0)));
    }

    #[test]
    fn uneven_weights_are_scaled_and_said_once() {
        let mut file = triangle();
        let weights = file.floats("VEC4", &[2.0, 0.0, 0.0, 0.0, 0.3, 0.1, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        file.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        let rig = rig(&file);
        let got = &rig.meshes[0].influences[0].weights;
        assert_eq!(got[0], [1.0, 0.0, 0.0, 0.0]);
        assert!((got[1][0] - 0.75).abs() < 1e-6 && (got[1][1] - 0.25).abs() < 1e-6, "{got:?}");
        assert_eq!(rig.notes, ["mesh `sail`: 2 vertices had weights that don't sum to 1; they were scaled"]);
    }

    #[test]
    fn bytes_are_weights_too() {
        let mut file = triangle();
        let weights = file.bytes4(&[[255, 0, 0, 0], [127, 128, 0, 0], [255, 0, 0, 0]]);
        file.root["accessors"][weights]["normalized"] = json!(true);
        file.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        let rig = rig(&file);
        let got = rig.meshes[0].influences[0].weights[1];
        assert!((got[0] - 128.0 / 255.0).abs() < 1e-5, "the largest comes first: {got:?}");
        assert!(rig.notes.is_empty(), "{:?}", rig.notes);
    }

    #[test]
    fn a_vertex_without_weights_rides_on_its_node() {
        let mut file = triangle();
        let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        file.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        let rig = rig(&file);
        assert_eq!(rig.skins[0].joints.len(), 3, "the skin has a slot for the node");
        assert_eq!(rig.skeleton.name(rig.skins[0].joints[2]), "body");
        let influences = &rig.meshes[0].influences[0];
        assert_eq!((influences.joints[1][0], influences.weights[1][0]), (2, 1.0));
        assert_eq!(rig.notes, ["mesh `sail`: 1 vertices had no weights; they ride on the mesh's node"]);
    }

    #[test]
    fn of_eight_influences_the_four_largest_stay() {
        let mut file = triangle();
        let weights: Vec<f32> = [0.1, 0.1, 0.1, 0.1].repeat(3);
        let more: Vec<f32> = [0.3, 0.1, 0.1, 0.1].repeat(3);
        let (weights, more) = (file.floats("VEC4", &weights), file.floats("VEC4", &more));
        let joints = file.bytes4(&[[1, 0, 0, 0]; 3]);
        let attributes = &mut file.root["meshes"][0]["primitives"][0]["attributes"];
        attributes["WEIGHTS_0"] = json!(weights);
        attributes["WEIGHTS_1"] = json!(more);
        attributes["JOINTS_1"] = json!(joints);
        let rig = rig(&file);
        let influences = &rig.meshes[0].influences[0];
        assert_eq!(influences.joints[0][0], 1);
        assert!((influences.weights[0][0] - 0.5).abs() < 1e-6, "{:?}", influences.weights[0]);
        assert_eq!(rig.notes, ["mesh `sail`: 3 vertices had more than 4 joints; the 4 largest weights were kept"]);
    }

    #[test]
    fn bad_vertices_name_mesh_primitive_and_vertex() {
        let place = "mesh `sail`, primitive 0, vertex 1: ";
        let mut file = triangle();
        let joints = file.bytes4(&[[0; 4], [9, 1, 0, 0], [0; 4]]);
        file.root["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
        assert_eq!(fault(&file), format!("{place}it hangs on joint 9, but the skin has 2"));
        for (weight, shown) in [(-0.5, "-0.5"), (f32::NAN, "NaN")] {
            let mut file = triangle();
            let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 0.5, weight, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
            file.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
            assert_eq!(fault(&file), format!("{place}its weight {shown} is not a number from 0 to 1"));
        }
        let mut file = triangle();
        let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0, 2.0, 0.0]);
        file.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
        assert_eq!(fault(&file), format!("{place}its position is not finite"));
    }

    #[test]
    fn vertex_data_that_do_not_go_together_are_named() {
        let mut file = triangle();
        let joints = file.bytes4(&[[0; 4]; 2]);
        file.root["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(joints);
        assert_eq!(fault(&file), "mesh `sail`, primitive 0: 3 vertices, but joints for 2 and weights for 3");
        let mut file = triangle();
        file.root["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("WEIGHTS_0");
        assert_eq!(fault(&file), "mesh `sail`, primitive 0: JOINTS_0 has no WEIGHTS_0");
    }

    #[test]
    fn quantized_positions_keep_their_numbers() {
        let mut file = triangle();
        let positions: Vec<u8> = [0, 0, 0, 7, 0, 0, 0, -9, 0].iter().flat_map(|n: &i16| n.to_le_bytes()).collect();
        let positions = file.accessor(&positions, 5122, "VEC3", 3);
        file.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
        file.root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let tip = rig(&file).joint_bounds[1].expect("two vertices hang on the tip");
        assert_eq!((tip.max.x, tip.min.y), (7.0, -9.0));
    }

    #[test]
    fn sparse_values_replace_what_lies_below() {
        let mut file = triangle();
        let indices = file.view(&2u16.to_le_bytes());
        let values = file.view(&[0.0f32, 3.0, 0.0].map(f32::to_le_bytes).concat());
        let indices = json!({ "bufferView": indices, "componentType": 5123 });
        file.root["accessors"][0]["sparse"] =
            json!({ "count": 1, "indices": indices, "values": { "bufferView": values } });
        assert_eq!(rig(&file).joint_bounds[1].expect("a box").max.y, 3.0);
        // Without a view of its own everything else is zero.
        file.root["accessors"][0].as_object_mut().unwrap().remove("bufferView");
        assert_eq!(rig(&file).joint_bounds[1].expect("a box").max.x, 0.0);
        let beyond = file.view(&7u16.to_le_bytes());
        file.root["accessors"][0]["sparse"]["indices"]["bufferView"] = json!(beyond);
        assert_eq!(fault(&file), "accessor 0 (positions of mesh `sail`, primitive 0): sparse index 7 is beyond 3");
    }

    #[test]
    fn interleaved_vertices_are_told_apart() {
        let mut file = triangle();
        let row = |x: f32, y: f32| [x, y, 0.0, 8.0, 8.0].map(f32::to_le_bytes).concat();
        let view = file.view(&[row(0.0, 0.0), row(1.0, 0.0), row(0.0, 2.0)].concat());
        file.root["bufferViews"][view]["byteStride"] = json!(20);
        file.root["accessors"][0]["bufferView"] = json!(view);
        assert_eq!(rig(&file).joint_bounds, rig(&triangle()).joint_bounds);
    }
}

mod containers {
    use base64::{Engine, engine::general_purpose::STANDARD};

    use super::*;

    #[test]
    fn buffers_lie_in_the_glb_in_a_file_or_in_the_uri() {
        let file = triangle();
        let bin = file.bin.clone();
        let data = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bin));
        let beside = Rig::from_slice(&file.gltf("my%20buffer.bin"), |uri| {
            assert_eq!(uri, "my buffer.bin");
            Ok(bin.clone())
        });
        let inline = Rig::from_slice(&file.gltf(&data), no_files);
        for other in [beside, inline] {
            assert_eq!(other.expect("the buffer is found").joint_bounds, rig(&file).joint_bounds);
        }
    }

    #[test]
    fn buffers_that_are_missing_or_cut_off_are_named() {
        let file = triangle();
        let error = |bytes: &[u8], resolve: fn(&str) -> Result<Vec<u8>, String>| {
            Rig::from_slice(bytes, resolve).expect_err("the buffer is bad").to_string()
        };
        let gltf = file.gltf("legs.bin");
        assert_eq!(error(&gltf, |_| Err("not found".to_owned())), "buffer 0: `legs.bin`: not found");
        let length = file.bin.len();
        let short = format!("buffer 0: it should have {length} bytes but has 5: the file is cut off");
        assert_eq!(error(&gltf, |_| Ok(vec![0; 5])), short);
        assert_eq!(error(&file.gltf("data:,abc"), no_files), "buffer 0: its data URI is not base64");
        let mut view = file.clone();
        view.root["bufferViews"][0]["byteLength"] = json!(9999);
        let problem = format!("its view reaches beyond the {} bytes of buffer 0", length.next_multiple_of(4));
        assert_eq!(fault(&view), format!("accessor 0 (positions of mesh `sail`, primitive 0): {problem}"));
        let mut many = file;
        many.root["accessors"][0]["count"] = json!(4_000_000_000u32);
        assert!(fault(&many).contains("4000000000 elements are more than"), "{}", fault(&many));
    }

    #[test]
    fn what_is_no_gltf_is_refused() {
        let error = |bytes: &[u8]| Rig::from_slice(bytes, no_files).expect_err("no glTF").to_string();
        assert!(error(b"").starts_with("glTF JSON: "), "{}", error(b""));
        assert!(error(b"{}").contains("asset"), "{}", error(b"{}"));
        assert_eq!(error(b"glTF"), "not a whole glTF 2.0 file: the GLB header is cut off");
        assert_eq!(error(b"glTF\x01\0\0\0\0\0\0\0"), "not a whole glTF 2.0 file: GLB version 1; only 2 is known");
        let mut file = triangle();
        file.root["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]);
        assert!(fault(&file).contains("requires the extension `KHR_draco_mesh_compression`"), "{}", fault(&file));
    }

    #[test]
    fn a_wrong_index_or_type_is_named() {
        let mut file = triangle();
        file.root["skins"][0]["joints"] = json!([0, 44]);
        assert!(fault(&file).starts_with("glTF element `skins[0].joints[1]`: "), "{}", fault(&file));
        let mut file = triangle();
        file.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(77);
        assert!(fault(&file).contains("accessor 77 does not exist"), "{}", fault(&file));
        let mut file = triangle();
        file.root["accessors"][0]["type"] = json!("VEC4");
        let problem = "it holds Vec4, needed is Vec3";
        assert_eq!(fault(&file), format!("accessor 0 (positions of mesh `sail`, primitive 0): {problem}"));
        let mut file = triangle();
        let matrices = file.floats("MAT4", &[1.0; 16]);
        file.root["skins"][0]["inverseBindMatrices"] = json!(matrices);
        assert_eq!(fault(&file), "skin `bones`: 1 inverse bind matrices for 2 joints");
    }

    #[test]
    fn no_cut_and_no_flipped_byte_makes_it_panic() {
        let glb = Body::default().build().glb();
        for length in (0..glb.len()).step_by(97) {
            let _ = Rig::from_slice(&glb[..length], no_files);
        }
        // A few hundred files, each with some bytes changed by a fixed generator.
        let mut state = 0x2545_f491_u32;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            state as usize
        };
        for _ in 0..300 {
            let mut broken = glb.clone();
            for _ in 0..1 + next() % 6 {
                let at = next() % broken.len();
                broken[at] = next() as u8;
            }
            let _ = Rig::from_slice(&broken, no_files);
        }
    }
}
