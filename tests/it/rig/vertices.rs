//! Weights, boxes, and every way to write numbers.

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
    file.root["accessors"][0]["sparse"] = json!({ "count": 1, "indices": indices, "values": { "bufferView": values } });
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
