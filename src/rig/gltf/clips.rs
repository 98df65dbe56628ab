//! Animations → exact curves per joint.

use bevy::math::{Quat, Vec3};
use gltf::json::{
    accessor::Type,
    animation::{Animation, Channel, Interpolation as GltfInterpolation, Property},
    validation::Checked,
};
use serde::Deserialize;

use super::{accessor::Source, error::RigError, nodes, nodes::Nodes};
use crate::anim::{
    bake::{ClipCurves, JointCurves, MorphCurves},
    curve::{Curve, CurveError, Interpolation},
    skeleton::JointIndex,
};

/// All clips of the file, by glTF animation index.
pub(super) fn read(source: &Source, nodes: &Nodes) -> Result<Vec<ClipCurves>, RigError> {
    source.json.animations.iter().enumerate().map(|(index, clip)| read_one(source, nodes, index, clip)).collect()
}

fn read_one(source: &Source, nodes: &Nodes, index: usize, animation: &Animation) -> Result<ClipCurves, RigError> {
    let name = animation.name.clone().unwrap_or_else(|| format!("clip{index}"));
    let told = animation.extras.as_ref().and_then(|extras| serde_json::from_str(extras.get()).ok());
    let Told { looping, ground_speed } = told.unwrap_or_default();
    let ground_speed = ground_speed.filter(|speed| speed.is_finite() && *speed >= 0.0);
    let mut clip = ClipCurves { name, looping, ground_speed, ..ClipCurves::default() };
    for channel in &animation.channels {
        let node = channel.target.node.value();
        let Some(joint) = nodes.joints.get(node).copied().flatten() else { continue };
        let reader = ChannelReader { source, clip: clip.name.clone(), node, animation, channel };
        reader.read_into(&mut clip, joint)?;
    }
    clip.joints.sort_by_key(|curves| curves.joint);
    Ok(clip)
}

/// What an animation's `extras` may say.
#[derive(Default, Deserialize)]
struct Told {
    #[serde(default, rename = "loop")]
    looping: Option<bool>,
    #[serde(default, rename = "speed")]
    ground_speed: Option<f32>,
}

struct ChannelReader<'a> {
    source: &'a Source<'a>,
    clip: String,
    node: usize,
    animation: &'a Animation,
    channel: &'a Channel,
}

impl ChannelReader<'_> {
    fn read_into(&self, clip: &mut ClipCurves, joint: JointIndex) -> Result<(), RigError> {
        let sampler = self.animation.samplers.get(self.channel.sampler.value());
        let sampler = sampler.ok_or_else(|| self.fail("its sampler does not exist".to_owned()))?;
        let Checked::Valid(interpolation) = sampler.interpolation else {
            return Err(self.fail("its interpolation is none of STEP, LINEAR and CUBICSPLINE".to_owned()));
        };
        let interpolation = match interpolation {
            GltfInterpolation::Step => Interpolation::Step,
            GltfInterpolation::Linear => Interpolation::Linear,
            GltfInterpolation::CubicSpline => Interpolation::CubicSpline,
        };
        let Checked::Valid(property) = self.channel.target.path else {
            return Err(self.fail("its path is none of translation, rotation, scale and weights".to_owned()));
        };
        let (input, output) = (sampler.input.value(), sampler.output.value());
        let used_by = || format!("clip `{}`, {} of node `{}`", self.clip, self.channel_name(), self.node_name());
        let times = self.source.floats::<1>(input, Type::Scalar, &used_by)?.into_iter().map(|[time]| time).collect();

        if property == Property::MorphTargetWeights {
            let values = self.source.floats::<1>(output, Type::Scalar, &used_by)?;
            let values = values.into_iter().map(|[value]| value).collect();
            let weights = self.weights(times, values, interpolation)?;
            if clip.morphs.iter().any(|morph| morph.node == joint) {
                return Err(self.twice());
            }
            clip.morphs.push(MorphCurves { node: joint, weights });
            return Ok(());
        }
        let entry = clip.joints.iter().position(|curves| curves.joint == joint).unwrap_or_else(|| {
            clip.joints.push(JointCurves::new(joint));
            clip.joints.len() - 1
        });
        let curves = &mut clip.joints[entry];
        let taken = match property {
            Property::Rotation => {
                let values = self.source.floats::<4>(output, Type::Vec4, &used_by)?;
                let values = values.into_iter().map(Quat::from_array).collect();
                let curve = Curve::rotation(times, values, interpolation).map_err(|error| self.bad(&error))?;
                curves.rotation.replace(curve).is_some()
            }
            Property::Translation => {
                curves.translation.replace(self.vectors(times, output, interpolation, &used_by)?).is_some()
            }
            _ => curves.scale.replace(self.vectors(times, output, interpolation, &used_by)?).is_some(),
        };
        if taken { Err(self.twice()) } else { Ok(()) }
    }

    fn vectors(
        &self,
        times: Vec<f32>,
        output: usize,
        interpolation: Interpolation,
        used_by: &dyn Fn() -> String,
    ) -> Result<Curve<Vec3>, RigError> {
        let values = self.source.floats::<3>(output, Type::Vec3, used_by)?;
        let values = values.into_iter().map(Vec3::from_array).collect();
        Curve::new(times, values, interpolation).map_err(|error| self.bad(&error))
    }

    /// One curve a morph target, from values interleaved by target.
    fn weights(
        &self,
        times: Vec<f32>,
        values: Vec<f32>,
        interpolation: Interpolation,
    ) -> Result<Vec<Curve<f32>>, RigError> {
        let mesh = self.source.json.nodes.get(self.node).and_then(|node| node.mesh);
        let mesh = mesh.and_then(|mesh| self.source.json.meshes.get(mesh.value()));
        let primitive = mesh.and_then(|mesh| mesh.primitives.first());
        let targets = primitive.and_then(|primitive| primitive.targets.as_ref()).map_or(0, Vec::len);
        if targets == 0 {
            return Err(self.fail("the node's mesh has no morph targets".to_owned()));
        }
        let per_key = targets * if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        if values.len() != times.len() * per_key {
            let error = CurveError::Count { keys: times.len(), expected: times.len() * per_key, values: values.len() };
            return Err(self.bad(&error));
        }
        let of_target = |target: usize| values.iter().skip(target).step_by(targets).copied().collect();
        (0..targets)
            .map(|target| Curve::new(times.clone(), of_target(target), interpolation))
            .collect::<Result<_, _>>()
            .map_err(|error| self.bad(&error))
    }

    fn channel_name(&self) -> &'static str {
        match self.channel.target.path {
            Checked::Valid(Property::Translation) => "translation",
            Checked::Valid(Property::Rotation) => "rotation",
            Checked::Valid(Property::Scale) => "scale",
            Checked::Valid(Property::MorphTargetWeights) => "weights",
            Checked::Invalid => "unknown channel",
        }
    }

    fn node_name(&self) -> String {
        nodes::name(self.source.json, self.node)
    }

    fn bad(&self, error: &CurveError) -> RigError {
        self.fail(error.to_string())
    }

    fn twice(&self) -> RigError {
        self.fail("two channels move it".to_owned())
    }

    fn fail(&self, problem: String) -> RigError {
        RigError::Clip { clip: self.clip.clone(), node: self.node_name(), channel: self.channel_name(), problem }
    }
}
