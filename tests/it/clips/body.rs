//! Reads clips of the baked mannequin and poses its joints and soles, straight from the file's own numbers.
//!
//! Model space of the file: metres, +Y up, facing +Z, left +X. Keys are interpolated linearly, rotations by slerp.

use std::collections::HashMap;

use glam::{Quat, Vec3};
use gltf::animation::util::ReadOutputs;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/mannequin.glb");
/// Heel, ball and tip of the left sole at rest; the heel belongs to the foot, the other two to the toes.
const SOLE: [(&str, Vec3); 3] = [
    ("Foot", Vec3::new(0.088, 0.0, -0.067)),
    ("Toes", Vec3::new(0.092, 0.0, 0.123)),
    ("Toes", Vec3::new(0.092, 0.0, 0.198)),
];

pub(super) const SIDES: [&str; 2] = ["left", "right"];

/// The file's joints, parents first.
pub(super) struct Body {
    parents: Vec<Option<usize>>,
    offsets: Vec<Vec3>,
    names: HashMap<String, usize>,
    clips: HashMap<String, Clip>,
}

/// One animation of the file.
#[derive(Clone)]
pub(super) struct Clip {
    pub(super) name: String,
    pub(super) times: Vec<f32>,
    /// What the file says the feet run at, m/s.
    pub(super) speed: f32,
    rotations: Vec<(usize, Vec<Quat>)>,
    translations: Vec<(usize, Vec<Vec3>)>,
}

/// Joints in model space.
pub(super) struct Posed<'a> {
    body: &'a Body,
    positions: Vec<Vec3>,
    turns: Vec<Quat>,
}

impl Body {
    pub(super) fn load() -> Self {
        let gltf = gltf::Gltf::from_slice(&std::fs::read(FILE).unwrap()).unwrap();
        let blob = gltf.blob.as_deref().unwrap();
        let joints: Vec<gltf::Node> = gltf.skins().next().unwrap().joints().collect();
        let names: HashMap<String, usize> =
            joints.iter().enumerate().map(|(i, node)| (node.name().unwrap().to_owned(), i)).collect();
        let mut parents = vec![None; joints.len()];
        for (i, node) in joints.iter().enumerate() {
            for child in node.children() {
                parents[names[child.name().unwrap()]] = Some(i);
            }
        }
        let offsets = joints.iter().map(|node| Vec3::from(node.transform().decomposed().0)).collect();
        let clips = gltf.animations().map(|animation| clip(&animation, blob, &names)).map(|c| (c.name.clone(), c));
        Self { parents, offsets, clips: clips.collect(), names }
    }

    pub(super) fn clip(&self, name: &str) -> &Clip {
        self.clips.get(name).unwrap_or_else(|| panic!("no clip {name}; there are {:?}", self.clips.keys()))
    }

    /// The pose at a key.
    pub(super) fn key(&self, clip: &Clip, key: usize) -> Posed<'_> {
        self.at(clip, key.min(clip.last() - 1), if key < clip.last() { 0.0 } else { 1.0 })
    }

    /// The pose `part` of the way from `key` to the next.
    pub(super) fn at(&self, clip: &Clip, key: usize, part: f32) -> Posed<'_> {
        let mut turns = vec![Quat::IDENTITY; self.parents.len()];
        let mut positions = self.offsets.clone();
        for (joint, keys) in &clip.rotations {
            turns[*joint] = keys[key].slerp(keys[key + 1], part);
        }
        for (joint, keys) in &clip.translations {
            positions[*joint] = keys[key].lerp(keys[key + 1], part);
        }
        for joint in 0..self.parents.len() {
            if let Some(parent) = self.parents[joint] {
                positions[joint] = positions[parent] + turns[parent] * positions[joint];
                turns[joint] = turns[parent] * turns[joint];
            }
        }
        Posed { body: self, positions, turns }
    }

    fn rest(&self, joint: usize) -> Vec3 {
        self.offsets[joint] + self.parents[joint].map_or(Vec3::ZERO, |parent| self.rest(parent))
    }

    pub(super) fn joint_count(&self) -> usize {
        self.parents.len()
    }
}

impl Clip {
    /// Index of the last key.
    pub(super) fn last(&self) -> usize {
        self.times.len() - 1
    }

    /// Seconds between keys.
    pub(super) fn step(&self) -> f32 {
        self.times[self.last()] / self.last() as f32
    }
}

impl Posed<'_> {
    pub(super) fn joint(&self, name: &str) -> (Vec3, Quat) {
        let joint = self.body.names[name];
        (self.positions[joint], self.turns[joint])
    }

    pub(super) fn nth(&self, joint: usize) -> (Vec3, Quat) {
        (self.positions[joint], self.turns[joint])
    }

    /// Heel, ball and tip of a foot; `side` indexes [`SIDES`].
    pub(super) fn sole(&self, side: usize) -> [Vec3; 3] {
        SOLE.map(|(part, rest)| {
            let joint = self.body.names[&format!("{}{part}", SIDES[side])];
            let rest = if side == 0 { rest } else { rest * Vec3::new(-1.0, 1.0, 1.0) };
            self.positions[joint] + self.turns[joint] * (rest - self.body.rest(joint))
        })
    }

    /// Height of the lowest sole point of a foot, metres.
    pub(super) fn lowest(&self, side: usize) -> f32 {
        self.sole(side).iter().fold(f32::MAX, |low, point| low.min(point.y))
    }

    /// Distance from hip to ankle as a share of the straight leg.
    pub(super) fn leg_ratio(&self, side: usize) -> f32 {
        let [hip, knee, ankle] = ["UpperLeg", "LowerLeg", "Foot"].map(|part| format!("{}{part}", SIDES[side]));
        let length: f32 = [&knee, &ankle].map(|name| self.body.offsets[self.body.names[name]].length()).iter().sum();
        self.joint(&hip).0.distance(self.joint(&ankle).0) / length
    }

    /// Bend of a knee beyond its rest pose, degrees; negative when it bends forward.
    pub(super) fn knee(&self, side: usize) -> f32 {
        let thigh = self.joint(&format!("{}UpperLeg", SIDES[side])).1;
        let shank = self.joint(&format!("{}LowerLeg", SIDES[side])).1;
        let local = thigh.inverse() * shank;
        (2.0 * bevy::math::ops::atan2(local.x, local.w)).to_degrees()
    }
}

fn clip(animation: &gltf::Animation, blob: &[u8], names: &HashMap<String, usize>) -> Clip {
    let extras: serde_json::Value = serde_json::from_str(animation.extras().as_ref().unwrap().get()).unwrap();
    let mut clip = Clip {
        name: animation.name().unwrap().to_owned(),
        times: Vec::new(),
        speed: extras["speed"].as_f64().unwrap() as f32,
        rotations: Vec::new(),
        translations: Vec::new(),
    };
    for channel in animation.channels() {
        let reader = channel.reader(|_| Some(blob));
        clip.times = reader.read_inputs().unwrap().collect();
        let joint = names.get(channel.target().node().name().unwrap());
        match (joint, reader.read_outputs().unwrap()) {
            (Some(joint), ReadOutputs::Rotations(keys)) => {
                clip.rotations.push((*joint, keys.into_f32().map(Quat::from_array).collect()));
            }
            (Some(joint), ReadOutputs::Translations(keys)) => {
                clip.translations.push((*joint, keys.map(Vec3::from).collect()));
            }
            _ => {}
        }
    }
    clip
}
