//! Small rigs, one for each quirk of the format. The same bytes every time.

use bevy::math::ops;
use serde_json::{Value, json};

use super::limb::{JOINTS, STEP, Written, bend, chain, inverse_binds, limb, scene, tube, turn};
use crate::gltf_file::GltfFile;

/// All rigs by name.
pub(super) fn all() -> Vec<(&'static str, GltfFile)> {
    vec![
        ("steps", moved("STEP")),
        ("lines", moved("LINEAR")),
        ("splines", moved("CUBICSPLINE")),
        ("lone_keys", lone_keys()),
        ("sparse_values", sparse_values()),
        ("sparse_times", sparse_times()),
        ("byte_weights", written(Written::Bytes)),
        ("short_weights", written(Written::Shorts)),
        ("integer_keys", integer_keys()),
        ("matrices", matrices()),
        ("many_skins", many_skins()),
        ("one_skin_many_meshes", one_skin_many_meshes()),
        ("no_inverse_binds", no_inverse_binds()),
        ("outside_the_scene", outside_the_scene()),
        ("three_hundred_joints", three_hundred_joints()),
        ("shared_buffers", shared_buffers()),
        ("quantised", quantised()),
        ("twins", twins()),
        ("mirrored_centimetres", mirrored_centimetres()),
    ]
}

/// A limb whose joints are turned, moved and scaled by keys at uneven times, the first one late.
fn moved(interpolation: &str) -> GltfFile {
    let mut file = GltfFile::new();
    let first = limb(&mut file, JOINTS, Written::Floats);
    scene(&mut file);
    let times = [0.11, 0.4, 0.437, 0.83, 1.203];
    let spline = interpolation == "CUBICSPLINE";
    // Splines: in-tangent, value, out-tangent.
    let keys = |value: &dyn Fn(usize) -> Vec<f32>, tangent: &dyn Fn(usize) -> Vec<f32>| -> Vec<f32> {
        let key = |key: usize| if spline { [tangent(key), value(key), tangent(key + 7)].concat() } else { value(key) };
        (0..times.len()).flat_map(key).collect()
    };
    let wave = |key: usize, phase: f32| ops::sin(1.7 * key as f32 + phase);
    let turns = keys(&|key| turn(1.1 * wave(key, 0.3)).to_vec(), &|key| {
        [0.4, 0.9, 1.6, 0.2].map(|phase| 0.8 * wave(key, phase)).to_vec()
    });
    let moves = keys(&|key| vec![0.3 * wave(key, 1.0), STEP, 0.2 * wave(key, 2.0)], &|key| {
        vec![wave(key, 0.1), 0.5 * wave(key, 0.2), wave(key, 0.3)]
    });
    let scales = keys(&|key| vec![1.0 + 0.4 * wave(key, 0.0), 1.0 + 0.2 * wave(key, 1.0), 0.8], &|key| {
        vec![wave(key, 0.5), wave(key, 1.5), 0.3 * wave(key, 2.5)]
    });
    let last = first + JOINTS - 1;
    file.clip(
        "move",
        &[
            (first, "rotation", &times, &turns),
            (first + 1, "translation", &times, &moves),
            (first + 1, "rotation", &times, &turns),
            (first + 2, "scale", &times, &scales),
            (last, "rotation", &times, &turns),
        ],
    );
    let samplers = file.root["animations"][0]["samplers"].as_array_mut().expect("samplers");
    samplers.iter_mut().for_each(|sampler| sampler["interpolation"] = json!(interpolation));
    file
}

/// Channels of one key each.
fn lone_keys() -> GltfFile {
    let mut file = GltfFile::new();
    let first = limb(&mut file, JOINTS, Written::Floats);
    scene(&mut file);
    let spline = [[0.0; 3], [0.2, STEP, 0.1], [0.0; 3]].concat();
    file.clip(
        "hold",
        &[
            (first, "rotation", &[0.4], &turn(0.5)),
            (first + 1, "translation", &[0.9], &[0.1, STEP, 0.0]),
            (first + 2, "translation", &[0.7], &spline),
        ],
    );
    file.root["animations"][0]["samplers"][2]["interpolation"] = json!("CUBICSPLINE");
    file
}

/// Makes an accessor of floats sparse: what `changes` names lies apart, its own bytes hold something else there.
fn make_sparse(file: &mut GltfFile, accessor: usize, width: usize, changes: &[u16]) {
    let view = file.root["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
    let start = file.root["bufferViews"][view]["byteOffset"].as_u64().expect("an offset") as usize;
    let size = 4 * width;
    let mut values = Vec::new();
    for change in changes {
        let at = start + size * usize::from(*change);
        values.extend_from_slice(&file.bin[at..at + size]);
        file.bin[at..at + size].fill(0);
    }
    let indices: Vec<u8> = changes.iter().flat_map(|change| change.to_le_bytes()).collect();
    let (indices, values) = (file.view(&indices), file.view(&values));
    file.root["accessors"][accessor]["sparse"] = json!({
        "count": changes.len(),
        "indices": { "bufferView": indices, "componentType": 5123 },
        "values": { "bufferView": values },
    });
}

fn sampler(file: &GltfFile, sampler: usize, end: &str) -> usize {
    file.root["animations"][0]["samplers"][sampler][end].as_u64().expect("an accessor") as usize
}

fn sparse_values() -> GltfFile {
    let mut file = moved("LINEAR");
    for (channel, width) in [(0, 4), (1, 3), (3, 3)] {
        let output = sampler(&file, channel, "output");
        make_sparse(&mut file, output, width, &[1, 3]);
    }
    let positions = file.root["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().expect("positions");
    make_sparse(&mut file, positions as usize, 3, &[0, 9, 10, 40]);
    file
}

fn sparse_times() -> GltfFile {
    let mut file = moved("LINEAR");
    let input = sampler(&file, 1, "input");
    make_sparse(&mut file, input, 1, &[2, 4]);
    file
}

fn written(written: Written) -> GltfFile {
    let mut file = GltfFile::new();
    let first = limb(&mut file, JOINTS, written);
    scene(&mut file);
    bend(&mut file, first, JOINTS, 0.7);
    file
}

/// Rotations as normalised `i16` and `i8`.
fn integer_keys() -> GltfFile {
    let mut file = written(Written::Floats);
    let turns = |angles: [f32; 3]| angles.map(turn).concat();
    let shorts: Vec<u8> =
        turns([0.0, 0.9, -0.4]).iter().flat_map(|part| ((part * 32_767.0).round() as i16).to_le_bytes()).collect();
    let bytes: Vec<u8> = turns([0.3, -0.5, 0.2]).iter().map(|part| (part * 127.0).round() as i8 as u8).collect();
    file.root["animations"] = json!([]);
    file.clip("turn", &[(0, "rotation", &[0.0, 0.5, 1.1], &[0.0; 12]), (1, "rotation", &[0.0, 0.4, 1.1], &[0.0; 12])]);
    for (channel, bytes, kind) in [(0, shorts, 5122), (1, bytes, 5120)] {
        let output = file.accessor(&bytes, kind, "VEC4", 3);
        file.root["accessors"][output]["normalized"] = json!(true);
        file.root["animations"][0]["samplers"][channel]["output"] = json!(output);
    }
    file
}

/// Nodes with matrices above and between the joints: Z up, and a turn with a move and a scale.
fn matrices() -> GltfFile {
    let mut file = GltfFile::new();
    let first = limb(&mut file, JOINTS, Written::Floats);
    bend(&mut file, first + 1, JOINTS - 1, 0.7);
    let root = file.root["nodes"][first].as_object_mut().expect("a node");
    root.remove("translation");
    let matrix = [0.0, 1.5, 0.0, 0.0, -1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.5, 0.0, 0.1, 0.2, 0.3, 1.0];
    root.insert("matrix".to_owned(), json!(matrix));
    let z_up = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    file.push("nodes", json!({ "name": "armature", "matrix": z_up, "children": [first] }));
    scene(&mut file);
    file
}

/// Three limbs side by side, each with its own skin.
fn many_skins() -> GltfFile {
    let mut file = GltfFile::new();
    let mut roots = Vec::new();
    for (limb, written) in [Written::Floats, Written::Bytes, Written::Shorts].into_iter().enumerate() {
        let first = chain(&mut file, &format!("limb{limb}_"), JOINTS);
        file.root["nodes"][first]["translation"] = json!([0.6 * limb as f32, 0.0, 0.0]);
        let matrices = inverse_binds(&mut file, JOINTS);
        let joints: Vec<usize> = (first..first + JOINTS).collect();
        file.push("skins", json!({ "joints": joints, "inverseBindMatrices": matrices }));
        let mesh = tube(&mut file, JOINTS, written);
        file.push("nodes", json!({ "name": format!("skin{limb}"), "mesh": mesh, "skin": limb }));
        roots.push(first);
    }
    scene(&mut file);
    for (limb, root) in roots.into_iter().enumerate() {
        bend(&mut file, root, JOINTS, 0.4 + 0.2 * limb as f32);
    }
    // One clip that moves all.
    let all = json!({
        "name": "all",
        "channels": merged(&file, "channels"),
        "samplers": merged(&file, "samplers"),
    });
    file.root["animations"] = json!([all]);
    file
}

/// The channels or samplers of all clips in one list.
fn merged(file: &GltfFile, list: &str) -> Vec<Value> {
    let mut offset = 0;
    let mut sum = Vec::new();
    for clip in file.root["animations"].as_array().expect("clips") {
        for mut entry in clip[list].as_array().expect("a list").iter().cloned() {
            if let Some(sampler) = entry.get("sampler").and_then(Value::as_u64) {
                entry["sampler"] = json!(sampler + offset);
            }
            sum.push(entry);
        }
        offset += clip["samplers"].as_array().map_or(0, Vec::len) as u64;
    }
    sum
}

fn one_skin_many_meshes() -> GltfFile {
    let mut file = GltfFile::new();
    let first = limb(&mut file, JOINTS, Written::Floats);
    let second = tube(&mut file, JOINTS, Written::Bytes);
    // Where the node of a skinned mesh stands must not matter.
    file.push("nodes", json!({ "name": "sleeve", "mesh": second, "skin": 0, "translation": [3.0, 1.0, 0.0] }));
    file.push("nodes", json!({ "name": "again", "mesh": 0, "skin": 0, "rotation": turn(1.0) }));
    scene(&mut file);
    bend(&mut file, first, JOINTS, 0.7);
    file
}

fn no_inverse_binds() -> GltfFile {
    let mut file = written(Written::Floats);
    file.root["skins"][0].as_object_mut().expect("a skin").remove("inverseBindMatrices");
    file
}

/// A chain that no scene holds moves a mesh that one does.
fn outside_the_scene() -> GltfFile {
    let mut file = GltfFile::new();
    let first = limb(&mut file, JOINTS, Written::Floats);
    bend(&mut file, first, JOINTS, 0.7);
    let mesh = first + JOINTS;
    file.push("scenes", json!({ "nodes": [mesh] }));
    file
}

fn three_hundred_joints() -> GltfFile {
    let mut file = GltfFile::new();
    let count = 300;
    let first = limb(&mut file, count, Written::Bytes);
    scene(&mut file);
    // A scale above the chain keeps it in the picture.
    file.root["nodes"][first]["scale"] = json!([0.03, 0.03, 0.03]);
    bend(&mut file, first, count, 0.02);
    file
}

/// Interleaved vertices, one array of times for all channels, values that overlap.
fn shared_buffers() -> GltfFile {
    let mut file = written(Written::Floats);
    let times = file.floats("SCALAR", &[0.0, 0.2, 0.55, 0.9, 1.4, 1.6]);
    let values: Vec<f32> = (0..9).flat_map(|key| turn(0.6 * ops::sin(1.3 * key as f32))).collect();
    let view = file.view(&values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>());
    for joint in 0..JOINTS {
        let accessor = json!({
            "bufferView": view, "byteOffset": 16 * joint.min(3), "componentType": 5126, "type": "VEC4", "count": 6,
        });
        let values = file.push("accessors", accessor);
        let sampler = &mut file.root["animations"][0]["samplers"][joint];
        sampler["input"] = json!(times);
        sampler["output"] = json!(values);
    }
    interleave(&mut file);
    file
}

/// Puts positions and normals of the first mesh into one view, vertex by vertex.
fn interleave(file: &mut GltfFile) {
    let attributes = file.root["meshes"][0]["primitives"][0]["attributes"].clone();
    let accessors = ["POSITION", "NORMAL"].map(|name| attributes[name].as_u64().expect("an accessor") as usize);
    let count = file.root["accessors"][accessors[0]]["count"].as_u64().expect("a count") as usize;
    let starts = accessors.map(|accessor| {
        let view = file.root["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
        file.root["bufferViews"][view]["byteOffset"].as_u64().expect("an offset") as usize
    });
    let mut rows = Vec::new();
    for vertex in 0..count {
        for start in starts {
            rows.extend_from_slice(&file.bin[start + 12 * vertex..start + 12 * vertex + 12]);
        }
    }
    let view = file.view(&rows);
    file.root["bufferViews"][view]["byteStride"] = json!(24);
    for (place, accessor) in accessors.into_iter().enumerate() {
        file.root["accessors"][accessor]["bufferView"] = json!(view);
        file.root["accessors"][accessor]["byteOffset"] = json!(12 * place);
    }
}

/// Positions as `i16` of a twentieth of a millimetre and normals as `i8`, the scale on the inverse binds.
fn quantised() -> GltfFile {
    let mut file = written(Written::Bytes);
    let attributes = file.root["meshes"][0]["primitives"][0]["attributes"].clone();
    for (name, kind, unit, normalized) in [("POSITION", 5122, 20_000.0, false), ("NORMAL", 5120, 127.0, true)] {
        let accessor = attributes[name].as_u64().expect("an accessor") as usize;
        let view = file.root["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
        let start = file.root["bufferViews"][view]["byteOffset"].as_u64().expect("an offset") as usize;
        let count = file.root["accessors"][accessor]["count"].as_u64().expect("a count") as usize;
        let floats = file.bin[start..start + 12 * count].chunks_exact(4);
        let numbers: Vec<i16> = floats
            .map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four bytes")))
            .map(|value| (value * unit).round().clamp(-32_767.0, 32_767.0) as i16)
            .collect();
        let wide = kind == 5122;
        // Each element starts at a multiple of four bytes.
        let rows: Vec<u8> = numbers
            .chunks_exact(3)
            .flat_map(|row| {
                let bytes: Vec<u8> = row
                    .iter()
                    .flat_map(|part| if wide { part.to_le_bytes().to_vec() } else { vec![*part as i8 as u8] })
                    .collect();
                let padded = bytes.len().next_multiple_of(4);
                bytes.into_iter().chain(core::iter::repeat(0)).take(padded).collect::<Vec<u8>>()
            })
            .collect();
        let stride = rows.len() / count;
        let view = file.view(&rows);
        file.root["bufferViews"][view]["byteStride"] = json!(stride);
        let entry = &mut file.root["accessors"][accessor];
        entry["bufferView"] = json!(view);
        entry["componentType"] = json!(kind);
        entry["normalized"] = json!(normalized);
        if wide {
            for end in ["min", "max"] {
                let scaled: Vec<f64> = entry[end]
                    .as_array()
                    .expect("bounds")
                    .iter()
                    .map(|v| v.as_f64().unwrap_or(0.0) * 20_000.0)
                    .collect();
                entry[end] = json!(scaled.iter().map(|v| v.round()).collect::<Vec<_>>());
            }
        }
    }
    let unit = 1.0 / 20_000.0;
    let matrices: Vec<f32> = (0..JOINTS)
        .flat_map(|joint| {
            let down = -STEP * joint as f32;
            [unit, 0.0, 0.0, 0.0, 0.0, unit, 0.0, 0.0, 0.0, 0.0, unit, 0.0, 0.0, down, 0.0, 1.0]
        })
        .collect();
    let matrices = file.floats("MAT4", &matrices);
    file.root["skins"][0]["inverseBindMatrices"] = json!(matrices);
    file.root["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    file.root["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    file
}

/// Two limbs of the same names below one node.
fn twins() -> GltfFile {
    let mut file = GltfFile::new();
    let left = limb(&mut file, JOINTS, Written::Floats);
    let right = chain(&mut file, "joint", JOINTS);
    file.root["nodes"][right]["translation"] = json!([0.5, 0.0, 0.0]);
    file.push("nodes", json!({ "name": "body", "children": [left, right] }));
    scene(&mut file);
    bend(&mut file, right, JOINTS, 0.7);
    file
}

/// A limb in centimetres below a mirrored node.
fn mirrored_centimetres() -> GltfFile {
    let mut file = GltfFile::new();
    let first = limb(&mut file, JOINTS, Written::Floats);
    file.push("nodes", json!({ "name": "armature", "scale": [-0.01, 0.01, 0.01], "children": [first] }));
    file.root["nodes"][first]["scale"] = json!([100.0, 100.0, 100.0]);
    scene(&mut file);
    bend(&mut file, first, JOINTS, 0.7);
    file
}
