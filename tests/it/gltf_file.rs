//! Small glTF files built in code: a document, its one buffer, and a body of boxes that walks.

use serde_json::{Value, json};

/// A glTF document under construction.
#[derive(Clone)]
pub struct GltfFile {
    /// The JSON; change what a test wants to break.
    pub root: Value,
    /// The one buffer.
    pub bin: Vec<u8>,
}

impl GltfFile {
    /// A document with nothing in it.
    pub fn new() -> Self {
        Self { root: json!({ "asset": { "version": "2.0" } }), bin: Vec::new() }
    }

    /// Appends to a top-level list and gives the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let root = self.root.as_object_mut().expect("the document is an object");
        let list = root.entry(list).or_insert_with(|| json!([])).as_array_mut().expect("lists are arrays");
        list.push(value);
        list.len() - 1
    }

    /// A view of `bytes`, put at the buffer's end.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// An accessor of whatever component type.
    pub fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    /// An accessor of floats.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => panic!("no width known for {kind}"),
        };
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, values.len() / width)
    }

    /// An accessor of `u8` vectors of four.
    pub fn bytes4(&mut self, values: &[[u8; 4]]) -> usize {
        self.accessor(values.as_flattened(), 5121, "VEC4", values.len())
    }

    /// A clip with one channel a tuple: node, path, key times, values.
    pub fn clip(&mut self, name: &str, channels: &[(usize, &str, &[f32], &[f32])]) -> usize {
        let (mut samplers, mut list) = (Vec::new(), Vec::new());
        for (node, path, times, values) in channels {
            let kind = match *path {
                "rotation" => "VEC4",
                "weights" => "SCALAR",
                _ => "VEC3",
            };
            let (input, output) = (self.floats("SCALAR", times), self.floats(kind, values));
            list.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
            samplers.push(json!({ "input": input, "output": output }));
        }
        self.push("animations", json!({ "name": name, "samplers": samplers, "channels": list }))
    }

    /// As `.glb`.
    pub fn glb(&self) -> Vec<u8> {
        let mut root = self.root.clone();
        if !self.bin.is_empty() && root.get("buffers").is_none() {
            root["buffers"] = json!([{ "byteLength": self.bin.len() }]);
        }
        let mut text = root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let mut glb = Vec::from(*b"glTF");
        let word = |glb: &mut Vec<u8>, word: usize| glb.extend((word as u32).to_le_bytes());
        word(&mut glb, 2);
        word(&mut glb, 12 + 8 + text.len() + if bin.is_empty() { 0 } else { 8 + bin.len() });
        word(&mut glb, text.len());
        glb.extend(b"JSON");
        glb.extend(text);
        if !bin.is_empty() {
            word(&mut glb, bin.len());
            glb.extend(b"BIN\0");
            glb.extend(bin);
        }
        glb
    }

    /// As `.gltf` whose buffer lies in the file `uri`, or in whatever `uri` says.
    pub fn gltf(&self, uri: &str) -> Vec<u8> {
        let mut root = self.root.clone();
        root["buffers"] = json!([{ "byteLength": self.bin.len(), "uri": uri }]);
        root.to_string().into_bytes()
    }
}

/// Two joints, `root` and `tip` a metre above it, and a triangle skinned to them, weights in floats.
pub fn triangle() -> GltfFile {
    let mut file = GltfFile::new();
    file.push("nodes", json!({ "name": "root", "children": [1] }));
    file.push("nodes", json!({ "name": "tip", "translation": [0.0, 1.0, 0.0] }));
    file.push("nodes", json!({ "name": "body", "mesh": 0, "skin": 0 }));
    file.push("skins", json!({ "name": "bones", "joints": [0, 1] }));
    let positions = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0]);
    let joints = file.bytes4(&[[0, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0]]);
    let weights = file.floats("VEC4", &[1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    let attributes = json!({ "POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights });
    file.push("meshes", json!({ "name": "sail", "primitives": [{ "attributes": attributes }] }));
    file
}

/// How a humanoid of boxes is built.
pub struct Body {
    /// Names of hips, left and right thigh, shin, foot and toes.
    pub names: [&'static str; 9],
    /// Stature as a factor of 1.8 m.
    pub size: f32,
    /// Length of its feet as a factor.
    pub feet: f32,
    /// Whether its feet bend at the toes; else each is one piece.
    pub toes: bool,
    /// Whether it carries feet as a mesh.
    pub mesh: bool,
}

impl Default for Body {
    fn default() -> Self {
        let names = [
            "hips",
            "leftUpperLeg",
            "leftLowerLeg",
            "leftFoot",
            "leftToes",
            "rightUpperLeg",
            "rightLowerLeg",
            "rightFoot",
            "rightToes",
        ];
        Self { names, size: 1.0, feet: 1.0, toes: true, mesh: true }
    }
}

impl Body {
    /// A humanoid in glTF's axes (faces +Z, its left is +X) with clips `idle`, `walk` and `run`.
    ///
    /// Feet are boxes from 6 cm behind the ankle to 20 cm before it, times `feet`, soles at 0.
    pub fn build(&self) -> GltfFile {
        let mut file = GltfFile::new();
        let scaled = |x: f32, y: f32, z: f32| [x * self.size, y * self.size, z * self.size];
        let mut node = |name: &str, at: [f32; 3], children: &[usize]| {
            file.push("nodes", json!({ "name": name, "translation": at, "children": children }))
        };
        node("root", [0.0; 3], if self.toes { &[1] } else { &[1, 5, 9] });
        node(self.names[0], scaled(0.0, 0.95, 0.0), &[2, 6, 10]);
        for side in [1, 5] {
            let x = if side == 1 { 0.09 } else { -0.09 };
            node(self.names[side], scaled(x, 0.0, 0.0), &[side + 2]);
            node(self.names[side + 1], scaled(0.0, -0.44, 0.005), &[side + 3]);
            let (toes, below) = if self.toes { (self.names[side + 3], &[side + 4][..]) } else { ("nothing", &[][..]) };
            node(self.names[side + 2], scaled(0.0, -0.44, -0.005), below);
            node(toes, scaled(0.0, -0.05, 0.13 * self.feet), &[]);
        }
        node("head", scaled(0.0, 0.7, 0.0), &[]);
        file.root["nodes"].as_array_mut().expect("nodes").iter_mut().for_each(|node| {
            if node["children"].as_array().is_some_and(Vec::is_empty) {
                node.as_object_mut().expect("a node").remove("children");
            }
        });
        let joints: Vec<usize> = (0..11).collect();
        // Rest rotations are none, so inverse binds are plain moves.
        let places: Vec<[f32; 3]> = (0..11).map(|joint| self.rest(joint)).collect();
        let inverse: Vec<f32> = places
            .iter()
            .flat_map(|[x, y, z]| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -x, -y, -z, 1.0])
            .collect();
        let inverse = file.floats("MAT4", &inverse);
        file.push("skins", json!({ "joints": joints, "inverseBindMatrices": inverse }));
        if self.mesh {
            let (mut positions, mut slots) = (Vec::new(), Vec::new());
            for (foot, x) in [(4, 0.09), (8, -0.09)] {
                for (joint, back, front) in [(foot, -0.06, 0.13), (foot + 1, 0.13, 0.2)] {
                    for corner in 0..8 {
                        let pick = |bit: usize, a: f32, b: f32| if corner >> bit & 1 == 0 { a } else { b };
                        positions.extend(scaled(
                            x + pick(0, -0.04, 0.04),
                            pick(1, 0.0, 0.08),
                            self.feet * pick(2, back, front),
                        ));
                        slots.push([if self.toes { joint } else { foot } as u8, 0, 0, 0]);
                    }
                }
            }
            let weights: Vec<f32> = slots.iter().flat_map(|_| [1.0, 0.0, 0.0, 0.0]).collect();
            let attributes = json!({
                "POSITION": file.floats("VEC3", &positions),
                "JOINTS_0": file.bytes4(&slots),
                "WEIGHTS_0": file.floats("VEC4", &weights),
            });
            file.push("meshes", json!({ "name": "feet", "primitives": [{ "attributes": attributes }] }));
            file.push("nodes", json!({ "name": "feet", "mesh": 0, "skin": 0 }));
        }
        file.clip("idle", &[(1, "rotation", &[0.0, 2.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])]);
        self.swing(&mut file, "walk", 0.4, 1.0);
        self.swing(&mut file, "run", 0.7, 0.7);
        file
    }

    /// A gait of legs that swing by `angle` either way in `duration` seconds; the knee bends on the way forward.
    fn swing(&self, file: &mut GltfFile, name: &str, angle: f64, duration: f32) {
        let steps = 32;
        let times: Vec<f32> = (0..=steps).map(|step| duration * step as f32 / steps as f32).collect();
        let turns = |about_x: &dyn Fn(f64) -> f64| -> Vec<f32> {
            let phases = (0..=steps).map(|step| core::f64::consts::TAU * f64::from(step) / f64::from(steps));
            phases.map(|phase| 0.5 * about_x(phase)).flat_map(|h| [h.sin() as f32, 0.0, 0.0, h.cos() as f32]).collect()
        };
        let legs = [(2, 0.0), (6, core::f64::consts::PI)].map(|(hip, offset)| {
            let thigh = turns(&|phase| angle * (phase + offset).sin());
            let knee = turns(&|phase| (-2.0 * angle * (phase + offset).cos()).max(0.0));
            [(hip, thigh), (hip + 1, knee)]
        });
        let channels: Vec<_> = legs
            .iter()
            .flatten()
            .map(|(node, values)| (*node, "rotation", times.as_slice(), values.as_slice()))
            .collect();
        file.clip(name, &channels);
    }

    fn rest(&self, joint: usize) -> [f32; 3] {
        let x = match joint {
            2..=5 => 0.09,
            6..=9 => -0.09,
            _ => 0.0,
        };
        let (y, z) = match joint {
            0 => (0.0, 0.0),
            3 | 7 => (0.51, 0.005),
            4 | 8 => (0.07, 0.0),
            5 | 9 => (0.02, 0.13 * self.feet),
            10 => (1.65, 0.0),
            _ => (0.95, 0.0),
        };
        [x * self.size, y * self.size, z * self.size]
    }
}
