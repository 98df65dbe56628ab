//! A limb that bends: a chain of joints in a tube, and how its numbers are written.

use core::f32::consts::TAU;

use bevy::math::ops;
use serde_json::{Value, json};

use crate::gltf_file::GltfFile;

/// Joints of a limb unless a test wants others.
pub(super) const JOINTS: usize = 4;
/// Metres from joint to joint.
pub(super) const STEP: f32 = 0.5;
/// Vertices around each ring.
const SIDES: usize = 8;
/// Rings from joint to joint.
const RINGS: usize = 4;

/// How joint indices and weights are written.
#[derive(Clone, Copy)]
pub(super) enum Written {
    /// `u8` joints, weights as floats.
    Floats,
    /// `u16` joints, weights as normalised `u8`.
    Bytes,
    /// `u8` joints, weights as normalised `u16`.
    Shorts,
}

/// Nodes of a chain up +Y, each `STEP` above the one before; returns the first one's index.
pub(super) fn chain(file: &mut GltfFile, name: &str, count: usize) -> usize {
    let first = file.root.get("nodes").and_then(Value::as_array).map_or(0, Vec::len);
    for joint in 0..count {
        let mut node = json!({
            "name": format!("{name}{joint}"),
            "translation": [0.0, if joint == 0 { 0.0 } else { STEP }, 0.0],
        });
        if joint + 1 < count {
            node["children"] = json!([first + joint + 1]);
        }
        file.push("nodes", node);
    }
    first
}

/// Inverse bind matrices of a chain whose first joint stands at the origin.
pub(super) fn inverse_binds(file: &mut GltfFile, count: usize) -> usize {
    let matrix = |joint: usize| {
        let down = -STEP * joint as f32;
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, down, 0.0, 1.0]
    };
    let matrices: Vec<f32> = (0..count).flat_map(matrix).collect();
    file.floats("MAT4", &matrices)
}

/// The index of a mesh: a tube around a chain, from 0.1 m below its first joint to above its last.
pub(super) fn tube(file: &mut GltfFile, count: usize, written: Written) -> usize {
    let (mut positions, mut normals, mut joints, mut weights) = (vec![], vec![], vec![], vec![]);
    let rings = RINGS * count;
    let radius = 0.03 * count as f32;
    for ring in 0..=rings {
        let along = ring as f32 / RINGS as f32;
        let low = (along.floor() as usize).min(count - 1);
        let high = (low + 1).min(count - 1);
        // Whole steps of 1/255, so that every way to write them says the same.
        let share = ((along - low as f32) * 255.0).round() as u8;
        for side in 0..SIDES {
            let angle = TAU * side as f32 / SIDES as f32;
            let out = [ops::cos(angle), 0.0, ops::sin(angle)];
            positions.extend([radius * out[0], along * STEP - 0.1, radius * out[2]]);
            normals.extend(out);
            joints.push([low, high, 0, 0]);
            weights.push(if low == high { [255, 0, 0, 0] } else { [255 - share, share, 0, 0] });
        }
    }
    let mut indices = vec![];
    for ring in 0..rings {
        for side in 0..SIDES {
            let [a, b] = [side, (side + 1) % SIDES].map(|side| (ring * SIDES + side) as u16);
            let (c, d) = (a + SIDES as u16, b + SIDES as u16);
            indices.extend([a, c, b, b, c, d]);
        }
    }
    let wide = |values: &[u16]| -> Vec<u8> { values.iter().flat_map(|value| value.to_le_bytes()).collect() };
    let vertices = joints.len();
    let flat = |values: &[[u8; 4]]| values.concat();
    let short_joints = joints.iter().map(|slots| slots.map(|slot| slot as u8)).collect::<Vec<_>>();
    let (joints, weights) = match written {
        Written::Floats => {
            let weights: Vec<f32> = flat(&weights).iter().map(|weight| f32::from(*weight) / 255.0).collect();
            (file.bytes4(&short_joints), file.floats("VEC4", &weights))
        }
        Written::Bytes => {
            let slots: Vec<u16> = joints.concat().iter().map(|slot| *slot as u16).collect();
            let weights = file.bytes4(&weights);
            file.root["accessors"][weights]["normalized"] = json!(true);
            (file.accessor(&wide(&slots), 5123, "VEC4", vertices), weights)
        }
        Written::Shorts => {
            let weights: Vec<u16> = flat(&weights).iter().map(|weight| u16::from(*weight) * 257).collect();
            let weights = file.accessor(&wide(&weights), 5123, "VEC4", vertices);
            file.root["accessors"][weights]["normalized"] = json!(true);
            (file.bytes4(&short_joints), weights)
        }
    };
    let (low, high) = bounds(&positions);
    let position = file.floats("VEC3", &positions);
    file.root["accessors"][position]["min"] = json!(low);
    file.root["accessors"][position]["max"] = json!(high);
    let attributes = json!({
        "POSITION": position,
        "NORMAL": file.floats("VEC3", &normals),
        "JOINTS_0": joints,
        "WEIGHTS_0": weights,
    });
    let indices = file.accessor(&wide(&indices), 5123, "SCALAR", indices.len());
    file.push("meshes", json!({ "primitives": [{ "attributes": attributes, "indices": indices }] }))
}

/// Lowest and highest corner, which the engine's loader asks for.
fn bounds(positions: &[f32]) -> ([f32; 3], [f32; 3]) {
    positions.chunks_exact(3).fold(([f32::MAX; 3], [f32::MIN; 3]), |(low, high), at| {
        (core::array::from_fn(|axis| low[axis].min(at[axis])), core::array::from_fn(|axis| high[axis].max(at[axis])))
    })
}

/// A chain in a tube, with inverse binds; returns the chain's first node. A scene is still to come.
pub(super) fn limb(file: &mut GltfFile, count: usize, written: Written) -> usize {
    let first = chain(file, "joint", count);
    let matrices = inverse_binds(file, count);
    let joints: Vec<usize> = (first..first + count).collect();
    let skin = file.push("skins", json!({ "joints": joints, "inverseBindMatrices": matrices }));
    let mesh = tube(file, count, written);
    file.push("nodes", json!({ "name": "skin", "mesh": mesh, "skin": skin }));
    first
}

/// One scene of all nodes that hang on nothing.
pub(super) fn scene(file: &mut GltfFile) {
    let nodes = file.root["nodes"].as_array().expect("nodes").clone();
    let children: Vec<u64> = nodes
        .iter()
        .flat_map(|node| node["children"].as_array().cloned().unwrap_or_default())
        .filter_map(|child| child.as_u64())
        .collect();
    let roots: Vec<usize> = (0..nodes.len()).filter(|node| !children.contains(&(*node as u64))).collect();
    file.push("scenes", json!({ "nodes": roots }));
}

/// A rotation about a slanted axis as (x, y, z, w).
pub(super) fn turn(radians: f32) -> [f32; 4] {
    let (sin, cos) = ops::sin_cos(0.5 * radians);
    [0.36 * sin, 0.48 * sin, 0.8 * sin, cos]
}

/// Keys that bend every joint of a chain a little, each at its own uneven times.
pub(super) fn bend(file: &mut GltfFile, first: usize, count: usize, radians: f32) {
    let keys: Vec<(Vec<f32>, Vec<f32>)> = (0..count)
        .map(|joint| {
            let times: Vec<f32> = (0..6).map(|key| 0.31 * key as f32 + 0.017 * ((joint * key) % 5) as f32).collect();
            let values = (0..6).flat_map(|key| turn(radians * [0.0, 1.0, -0.6, 0.4, -1.0, 0.2][(key + joint) % 6]));
            (times, values.collect())
        })
        .collect();
    let channels: Vec<_> = keys
        .iter()
        .enumerate()
        .map(|(joint, (times, values))| (first + joint, "rotation", times.as_slice(), values.as_slice()))
        .collect();
    file.clip("bend", &channels);
}
