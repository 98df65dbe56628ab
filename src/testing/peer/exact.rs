//! What a glTF file says, evaluated in double precision: no resampling, no quantising, and none of this crate's import.
//!
//! Nodes by glTF index, in the file's space. Accessors are read by the `gltf` crate.

use bevy::math::{DAffine3, DMat4, DQuat, DVec3, Mat4};
use gltf::{
    Document,
    animation::{Interpolation, Property, util::ReadOutputs},
    scene::Transform,
};

/// One channel's keys.
struct Channel {
    node: usize,
    property: Property,
    interpolation: Interpolation,
    times: Vec<f64>,
    /// One a key, three for splines; unused components are 0.
    values: Vec<[f64; 4]>,
}

/// Translation, rotation and scale of a node in its parent's space.
#[derive(Clone, Copy)]
struct Local {
    translation: DVec3,
    rotation: DQuat,
    scale: DVec3,
}

/// The nodes of a file and the curves that move them.
pub(super) struct Exact {
    /// Parents first: a node and its parent.
    order: Vec<(usize, Option<usize>)>,
    /// Rest transforms by node; a matrix stays a matrix.
    rest: Vec<Result<Local, DAffine3>>,
    clips: Vec<Vec<Channel>>,
}

impl Exact {
    /// Reads nodes and channels of a sound document. Channels of morph weights are left out.
    pub(super) fn read(document: &Document, buffers: &[Vec<u8>]) -> Self {
        let mut parents = vec![None; document.nodes().len()];
        for node in document.nodes() {
            for child in node.children() {
                parents[child.index()] = Some(node.index());
            }
        }
        let mut order: Vec<_> =
            (0..parents.len()).filter(|node| parents[*node].is_none()).map(|node| (node, None)).collect();
        let mut next = 0;
        while let Some(&(node, _)) = order.get(next) {
            order.extend(
                (0..parents.len()).filter(|child| parents[*child] == Some(node)).map(|child| (child, Some(node))),
            );
            next += 1;
        }
        let rest = document.nodes().map(|node| rest(&node.transform())).collect();
        let clips = document
            .animations()
            .map(|clip| clip.channels().filter_map(|channel| Channel::read(&channel, buffers)).collect())
            .collect();
        Self { order, rest, clips }
    }

    /// Every node in the file's space at `time` seconds of clip number `clip`; at rest without one.
    pub(super) fn sample(&self, clip: Option<usize>, time: f32) -> Vec<DAffine3> {
        let mut locals = self.rest.clone();
        for channel in clip.and_then(|clip| self.clips.get(clip)).into_iter().flatten() {
            if let Ok(local) = &mut locals[channel.node] {
                channel.apply(local, f64::from(time));
            }
        }
        let mut nodes = vec![DAffine3::IDENTITY; locals.len()];
        for &(node, parent) in &self.order {
            let parent = parent.map_or(DAffine3::IDENTITY, |parent| nodes[parent]);
            let local = locals[node]
                .map(|local| DAffine3::from_scale_rotation_translation(local.scale, local.rotation, local.translation));
            nodes[node] = parent * local.unwrap_or_else(|matrix| matrix);
        }
        nodes
    }
}

fn rest(transform: &Transform) -> Result<Local, DAffine3> {
    match transform {
        Transform::Matrix { matrix } => Err(DAffine3::from_mat4(DMat4::from_cols_array(
            &Mat4::from_cols_array_2d(matrix).to_cols_array().map(f64::from),
        ))),
        Transform::Decomposed { translation, rotation, scale } => Ok(Local {
            translation: vector(translation.map(f64::from)),
            rotation: DQuat::from_array(rotation.map(f64::from)).normalize(),
            scale: vector(scale.map(f64::from)),
        }),
    }
}

fn vector([x, y, z]: [f64; 3]) -> DVec3 {
    DVec3::new(x, y, z)
}

impl Channel {
    fn read(channel: &gltf::animation::Channel, buffers: &[Vec<u8>]) -> Option<Self> {
        let reader = channel.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let times = reader.read_inputs()?.map(f64::from).collect();
        let three = |[x, y, z]: [f32; 3]| [x, y, z, 0.0].map(f64::from);
        let values = match reader.read_outputs()? {
            ReadOutputs::Translations(values) | ReadOutputs::Scales(values) => values.map(three).collect(),
            ReadOutputs::Rotations(values) => values.into_f32().map(|value| value.map(f64::from)).collect(),
            ReadOutputs::MorphTargetWeights(_) => return None,
        };
        let target = channel.target();
        Some(Self {
            node: target.node().index(),
            property: target.property(),
            interpolation: channel.sampler().interpolation(),
            times,
            values,
        })
    }

    fn apply(&self, local: &mut Local, time: f64) {
        let [x, y, z, w] = self.at(time);
        match self.property {
            Property::Translation => local.translation = DVec3::new(x, y, z),
            Property::Scale => local.scale = DVec3::new(x, y, z),
            Property::Rotation => local.rotation = DQuat::from_xyzw(x, y, z, w).normalize(),
            Property::MorphTargetWeights => {}
        }
    }

    /// The value at `time`, held before the first and after the last key.
    fn at(&self, time: f64) -> [f64; 4] {
        let next = self.times.iter().position(|key| *key > time);
        let (from, to) = match next {
            Some(0) => return self.key(0),
            Some(next) => (next - 1, next),
            None => return self.key(self.times.len() - 1),
        };
        let span = self.times[to] - self.times[from];
        let t = (time - self.times[from]) / span;
        match self.interpolation {
            Interpolation::Step => self.key(from),
            Interpolation::Linear if self.property == Property::Rotation => {
                let [a, b] = [from, to].map(|key| DQuat::from_array(self.key(key)).normalize());
                a.slerp(b, t).to_array()
            }
            Interpolation::Linear => self.sum([(1.0 - t, from), (t, to)]),
            Interpolation::CubicSpline => {
                // glTF 2.0, appendix C.5: in-tangent, value and out-tangent of each key, tangents times the span.
                let (t2, t3) = (t * t, t * t * t);
                self.sum([
                    (2.0 * t3 - 3.0 * t2 + 1.0, 3 * from + 1),
                    (span * (t3 - 2.0 * t2 + t), 3 * from + 2),
                    (3.0 * t2 - 2.0 * t3, 3 * to + 1),
                    (span * (t3 - t2), 3 * to),
                ])
            }
        }
    }

    fn key(&self, key: usize) -> [f64; 4] {
        self.values[if self.interpolation == Interpolation::CubicSpline { 3 * key + 1 } else { key }]
    }

    /// Weighted sum of values by index.
    fn sum<const COUNT: usize>(&self, terms: [(f64, usize); COUNT]) -> [f64; 4] {
        core::array::from_fn(|axis| terms.iter().map(|(weight, value)| weight * self.values[*value][axis]).sum())
    }
}
