//! Channels that no rate of frames holds truly enough: their keys go with the clip and are evaluated as they are.
//!
//! Steps jump between frames; a turn of half a circle from frame to frame bends when its components are blended.

use bevy::math::Vec3A;

use super::{ClipCurves, JointCurves, LEVER, size};
use crate::{
    anim::{
        clip::Clip,
        curve::Curve,
        pose::Pose,
        skeleton::{JointIndex, JointTransform, Skeleton},
    },
    math::rotation::angle_between,
};

/// Checks from one frame to the next.
const CHECKS: usize = 4;
/// Weights of morph targets may be this far off.
const WEIGHT: f32 = 1e-3;

/// Keys all channels that step.
pub(super) fn key_steps(curves: &ClipCurves, clip: &mut Clip) {
    clip.frames.keyed = chosen(curves, |_| Chosen { rotation: false, translation: false, scale: false });
}

/// Keys all channels that step, and all that `clip`'s frames carry off by more than `bound` metres of the model.
pub(super) fn key(curves: &ClipCurves, skeleton: &Skeleton, clip: &mut Clip, bound: f32) {
    clip.frames.keyed.clear();
    let reach = Reach::of(skeleton);
    let times: Vec<f32> = check_times(clip).collect();
    let mut out = skeleton.rest().to_vec();
    let baked: Vec<Vec<JointTransform>> = times
        .iter()
        .map(|time| {
            clip.sample_held(skeleton, *time, &mut out);
            out.clone()
        })
        .collect();
    clip.frames.keyed = chosen(curves, |exact| {
        let joint = exact.joint;
        let mut worst = JointError::default();
        let mut local = skeleton.rest()[joint.index()];
        for (time, pose) in times.iter().zip(&baked) {
            exact.sample(*time, &mut local);
            worst = worst.max(&local, &pose[joint.index()]);
        }
        Chosen {
            rotation: worst.radians * reach.below(joint) > bound,
            translation: worst.units * reach.unit(joint) > bound,
            scale: worst.scale * reach.below(joint) > bound,
        }
    });
}

/// Largest differences of a joint's local transforms.
#[derive(Default)]
struct JointError {
    radians: f32,
    units: f32,
    scale: f32,
}

impl JointError {
    fn max(&self, a: &JointTransform, b: &JointTransform) -> Self {
        Self {
            radians: self.radians.max(angle_between(a.rotation, b.rotation)),
            units: self.units.max(a.translation.distance(b.translation)),
            scale: self.scale.max(a.scale.distance(b.scale)),
        }
    }
}

/// Which channels of a joint are to be keyed, besides those that step.
struct Chosen {
    rotation: bool,
    translation: bool,
    scale: bool,
}

fn chosen(curves: &ClipCurves, choose: impl Fn(&JointCurves) -> Chosen) -> Vec<JointCurves> {
    let keyed = curves.joints.iter().map(|exact| {
        let Chosen { rotation, translation, scale } = choose(exact);
        JointCurves {
            joint: exact.joint,
            rotation: exact.rotation.clone().filter(|curve| rotation || curve.jumps()),
            translation: exact.translation.clone().filter(|curve| translation || curve.jumps()),
            scale: exact.scale.clone().filter(|curve| scale || curve.jumps()),
        }
    });
    keyed.filter(|keyed| !keyed.is_empty()).collect()
}

/// Keys the morph weights of each node that steps or that `clip`'s frames carry off.
pub(super) fn key_morphs(curves: &ClipCurves, clip: &mut Clip) {
    clip.frames.keyed_morphs.clear();
    for morph in &curves.morphs {
        let mut baked = vec![0.0; morph.weights.len()];
        let off = check_times(clip).any(|time| {
            clip.held_morph_weights(morph.node, time, &mut baked);
            morph.weights.iter().zip(&baked).any(|(curve, baked)| (curve.sample(time) - baked).abs() > WEIGHT)
        });
        if off || morph.weights.iter().any(Curve::jumps) {
            clip.frames.keyed_morphs.push(morph.clone());
        }
    }
}

fn check_times(clip: &Clip) -> impl Iterator<Item = f32> + use<> {
    let (checks, duration) = (CHECKS * clip.frame_count().saturating_sub(1), clip.duration);
    (0..=checks).map(move |check| Clip::time_of(check, checks, duration))
}

/// How far what hangs on each joint reaches, in metres of the model at rest.
struct Reach {
    below: Vec<f32>,
    unit: Vec<f32>,
}

impl Reach {
    fn of(skeleton: &Skeleton) -> Self {
        let rest = Pose::rest(skeleton);
        let mut below = vec![LEVER * size(skeleton); skeleton.len()];
        for joint in skeleton.joints() {
            let mut above = skeleton.parent(joint);
            while let Some(ancestor) = above {
                let distance = rest.position(joint).distance(rest.position(ancestor)) + LEVER * size(skeleton);
                below[ancestor.index()] = below[ancestor.index()].max(distance);
                above = skeleton.parent(ancestor);
            }
        }
        let unit = |joint: JointIndex| {
            let above = skeleton.parent(joint).map_or(skeleton.model_from_root, |parent| rest.model(parent));
            [above.x_axis, above.y_axis, above.z_axis].into_iter().map(Vec3A::length).fold(0.0, f32::max)
        };
        Self { below, unit: skeleton.joints().map(unit).collect() }
    }

    /// Metres from the joint to the farthest below it, and a little more.
    fn below(&self, joint: JointIndex) -> f32 {
        self.below[joint.index()]
    }

    /// Metres of the model that one unit of the joint's translation is.
    fn unit(&self, joint: JointIndex) -> f32 {
        self.unit[joint.index()]
    }
}
