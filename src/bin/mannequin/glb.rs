//! The file: skeleton, skin, mesh, morph targets and animations as one binary glTF 2.0.
//!
//! Little endian; every accessor starts at a multiple of 4. The same input gives the same bytes.

use glam::{Quat, Vec3};
use serde_json::{Value, json};

use crate::{
    clip::Clip,
    mesh::{MATERIALS, Material, Mesh},
    morphs::{self, MORPHS},
    skeleton::JOINTS,
};

const FLOAT: u32 = 5126;
const SHORT: u32 = 5123;
const BYTE: u32 = 5121;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// The binary chunk and the accessors into it.
#[derive(Default)]
struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Buffer {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    fn accessor(&mut self, view: usize, kind: &str, component: u32, count: usize) -> usize {
        self.accessors.push(json!({"bufferView": view, "componentType": component, "count": count, "type": kind}));
        self.accessors.len() - 1
    }

    fn floats(&mut self, rows: &[f32], kind: &str, count: usize, target: Option<u32>) -> usize {
        let bytes: Vec<u8> = rows.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, target);
        self.accessor(view, kind, FLOAT, count)
    }

    fn vectors(&mut self, rows: &[Vec3], target: Option<u32>) -> usize {
        let flat: Vec<f32> = rows.iter().flat_map(Vec3::to_array).collect();
        self.floats(&flat, "VEC3", rows.len(), target)
    }

    /// Notes the lowest and highest value, which positions and key times must have.
    fn bounds(&mut self, accessor: usize, rows: &[Vec3], axes: usize) {
        let low = rows.iter().fold(Vec3::MAX, |a, b| a.min(*b)).to_array();
        let high = rows.iter().fold(Vec3::MIN, |a, b| a.max(*b)).to_array();
        self.accessors[accessor]["min"] = json!(low[..axes]);
        self.accessors[accessor]["max"] = json!(high[..axes]);
    }

    fn positions(&mut self, rows: &[Vec3]) -> usize {
        let accessor = self.vectors(rows, Some(VERTICES));
        self.bounds(accessor, rows, 3);
        accessor
    }
}

/// The whole file.
#[must_use]
pub fn write(meshes: &[(Material, Mesh)], clips: &[Clip]) -> Vec<u8> {
    let mut buffer = Buffer::default();
    let primitives: Vec<Value> =
        meshes.iter().map(|(material, mesh)| primitive(&mut buffer, *material, mesh)).collect();
    let inverse_binds: Vec<f32> =
        JOINTS.iter().flat_map(|joint| glam::Mat4::from_translation(-joint.position).to_cols_array()).collect();
    let inverse_binds = buffer.floats(&inverse_binds, "MAT4", JOINTS.len(), None);
    let animations: Vec<Value> = clips.iter().map(|clip| animation(&mut buffer, clip)).collect();
    let mut document = json!({
        "asset": {"version": "2.0", "generator": "surefoot mannequin baker"},
        "scene": 0,
        "scenes": [{"name": "mannequin", "nodes": [0, JOINTS.len()]}],
        "nodes": nodes(),
        "meshes": [{
            "name": "mannequin",
            "primitives": primitives,
            "weights": vec![0.0; MORPHS],
            "extras": {"targetNames": morphs::NAMES},
        }],
        "skins": [{
            "name": "mannequin",
            "skeleton": 0,
            "joints": (0..JOINTS.len()).collect::<Vec<_>>(),
            "inverseBindMatrices": inverse_binds,
        }],
        "materials": MATERIALS.map(material),
        "buffers": [{"byteLength": buffer.bytes.len()}],
        "bufferViews": buffer.views,
        "accessors": buffer.accessors,
    });
    if !animations.is_empty() {
        document["animations"] = json!(animations);
    }
    container(&document, &buffer.bytes)
}

/// Joints in the table's order, then the node that carries the mesh.
fn nodes() -> Vec<Value> {
    let mut nodes: Vec<Value> = JOINTS
        .iter()
        .map(|joint| {
            let parent = JOINTS.iter().find(|other| Some(other.name) == joint.parent);
            let offset = joint.position - parent.map_or(Vec3::ZERO, |parent| parent.position);
            let children: Vec<usize> = (0..JOINTS.len()).filter(|i| JOINTS[*i].parent == Some(joint.name)).collect();
            let mut node = json!({"name": joint.name});
            if offset != Vec3::ZERO {
                node["translation"] = json!(offset.to_array());
            }
            if !children.is_empty() {
                node["children"] = json!(children);
            }
            node
        })
        .collect();
    nodes.push(json!({"name": "mannequin", "mesh": 0, "skin": 0}));
    nodes
}

fn primitive(buffer: &mut Buffer, material: Material, mesh: &Mesh) -> Value {
    let count = mesh.vertices.len();
    let positions: Vec<Vec3> = mesh.vertices.iter().map(|v| v.position).collect();
    let normals: Vec<Vec3> = mesh.vertices.iter().map(|v| v.normal).collect();
    let colors: Vec<u8> = mesh
        .vertices
        .iter()
        .flat_map(|v| v.color.extend(1.0).to_array())
        .flat_map(|c| ((c.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes())
        .collect();
    let joints: Vec<u8> = mesh.vertices.iter().flat_map(|v| v.influences.map(|(joint, _)| joint as u8)).collect();
    let weights: Vec<u8> = mesh
        .vertices
        .iter()
        .flat_map(|v| sixteenths(v.influences.map(|(_, w)| w)))
        .flat_map(u16::to_le_bytes)
        .collect();
    let indices: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|i| (*i as u16).to_le_bytes()).collect();
    assert!(count < 65535, "{material:?} has {count} vertices; 16-bit indices reach 65534");

    let position = buffer.positions(&positions);
    let normal = buffer.vectors(&normals, Some(VERTICES));
    let view = buffer.view(&colors, Some(VERTICES));
    let color = buffer.accessor(view, "VEC4", SHORT, count);
    buffer.accessors[color]["normalized"] = json!(true);
    let view = buffer.view(&joints, Some(VERTICES));
    let joints = buffer.accessor(view, "VEC4", BYTE, count);
    let view = buffer.view(&weights, Some(VERTICES));
    let weights = buffer.accessor(view, "VEC4", SHORT, count);
    buffer.accessors[weights]["normalized"] = json!(true);
    let view = buffer.view(&indices, Some(INDICES));
    let indices = buffer.accessor(view, "SCALAR", SHORT, mesh.triangles.len() * 3);
    let targets: Vec<Value> = (0..MORPHS)
        .map(|morph| {
            let offsets: Vec<Vec3> = mesh.vertices.iter().map(|v| morphs::offset(morph, material, v)).collect();
            json!({"POSITION": buffer.positions(&offsets)})
        })
        .collect();
    json!({
        "attributes": {"POSITION": position, "NORMAL": normal, "COLOR_0": color, "JOINTS_0": joints, "WEIGHTS_0": weights},
        "indices": indices,
        "material": MATERIALS.iter().position(|m| *m == material),
        "targets": targets,
    })
}

/// Shares as 16-bit fractions whose sum is exactly 65535.
fn sixteenths(shares: [f32; 4]) -> [u16; 4] {
    let mut parts = shares.map(|share| (share * 65535.0).round() as i32);
    // The largest comes first and takes up what rounding left.
    parts[0] += 65535 - parts.iter().sum::<i32>();
    parts.map(|part| part as u16)
}

fn material(material: Material) -> Value {
    let (name, color, metallic, roughness) = match material {
        Material::Undersuit => ("undersuit", [0.062, 0.068, 0.080], 0.0, 0.78),
        Material::Shell => ("shell", [0.80, 0.78, 0.73], 0.0, 0.42),
        Material::Visor => ("visor", [0.010, 0.012, 0.016], 0.0, 0.08),
        Material::Glow => ("glow", [0.9, 0.55, 0.25], 0.0, 0.6),
    };
    let mut value = json!({
        "name": name,
        "pbrMetallicRoughness": {
            "baseColorFactor": [color[0], color[1], color[2], 1.0],
            "metallicFactor": metallic,
            "roughnessFactor": roughness,
        },
    });
    if material == Material::Glow {
        value["emissiveFactor"] = json!([1.0, 0.52, 0.16]);
    }
    value
}

fn animation(buffer: &mut Buffer, clip: &Clip) -> Value {
    let keys: Vec<Vec3> = clip.times.iter().map(|t| Vec3::splat(*t)).collect();
    let input = buffer.floats(&clip.times, "SCALAR", clip.times.len(), None);
    buffer.bounds(input, &keys, 1);
    let mut samplers = Vec::new();
    let mut channels = Vec::new();
    let mut track = |output: usize, node: usize, path: &str| {
        channels.push(json!({"sampler": samplers.len(), "target": {"node": node, "path": path}}));
        samplers.push(json!({"input": input, "output": output, "interpolation": "LINEAR"}));
    };
    for (joint, keys) in &clip.translations {
        track(buffer.vectors(keys, None), *joint, "translation");
    }
    for (joint, keys) in &clip.rotations {
        let flat: Vec<f32> = keys.iter().flat_map(|q: &Quat| q.to_array()).collect();
        track(buffer.floats(&flat, "VEC4", keys.len(), None), *joint, "rotation");
    }
    if let Some(keys) = &clip.weights {
        let flat: Vec<f32> = keys.iter().flatten().copied().collect();
        track(buffer.floats(&flat, "SCALAR", flat.len(), None), JOINTS.len(), "weights");
    }
    json!({
        "name": clip.name,
        "channels": channels,
        "samplers": samplers,
        "extras": {"speed": clip.speed, "loop": clip.looping},
    })
}

/// Header and the two chunks, each padded to 4 bytes.
fn container(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + binary.len();
    let mut bytes = Vec::with_capacity(total);
    bytes.extend(b"glTF");
    for word in [2, total as u32, text.len() as u32] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(&text);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}
