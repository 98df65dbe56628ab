//! Nodes, their tree and their places.

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
