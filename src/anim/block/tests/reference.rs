//! Random bodies, and their palettes by the scalar functions.

use core::{fmt, ops::Range};

use bevy::math::{Affine3A, Quat, Vec3};
use proptest::prelude::*;

use super::super::{Actor, Goal, LayerMode, LimbJoints, Play};
use crate::{
    anim::{
        bake::{ClipCurves, JointCurves},
        blend::{Accumulator, added, difference, lerp},
        clip::Clip,
        curve::{Curve, Interpolation},
        ik::two_bone::{Limb, solve},
        matrix::JointMatrix,
        pose::Pose,
        skeleton::{JointIndex, JointTransform, Skeleton},
        skin::Skin,
    },
    math::rotation::from_scaled_axis,
};

/// A skeleton, what hangs on it, four clips of it and a mask.
#[derive(Clone)]
pub(super) struct Body {
    pub(super) skeleton: Skeleton,
    pub(super) skin: Skin,
    pub(super) clips: Vec<Clip>,
    pub(super) mask: Vec<f32>,
    seed: u64,
}

impl fmt::Debug for Body {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "a body of {} joints, seed {}", self.skeleton.len(), self.seed)
    }
}

/// Bodies with so many joints, whose scales are off one by up to `unevenness` at rest and in clips.
pub(super) fn body(joints: Range<usize>, unevenness: f32) -> impl Strategy<Value = Body> {
    (joints, any::<u64>()).prop_map(move |(count, seed)| Dice(seed).body(count, unevenness))
}

/// The pose of a character by the scalar functions, before its limbs reach for their goals.
pub(super) fn posed(body: &Body, actor: &Actor) -> Pose {
    let mut pose = Pose::rest(&body.skeleton);
    for layer in actor.layers {
        let mut sum = body.skeleton.rest().to_vec();
        let mut blend = Accumulator::new(&mut sum);
        for play in layer.clips {
            blend.add(&sampled(body, *play, layer.mode), play.weight);
        }
        if !blend.finish() {
            continue;
        }
        for (index, (joint, layered)) in pose.locals_mut().iter_mut().zip(sum).enumerate() {
            let share = layer.weight * layer.mask.map_or(1.0, |_| body.mask[index]);
            *joint = match layer.mode {
                LayerMode::Override => lerp(*joint, layered, share),
                LayerMode::Add => added(*joint, layered, share),
            };
        }
    }
    pose.update_model(&body.skeleton);
    pose
}

/// The palette of a character by the scalar functions.
pub(super) fn palette(body: &Body, limbs: &[LimbJoints], actor: &Actor) -> Vec<JointMatrix> {
    let pose = posed(body, actor);
    let mut models = pose.models().iter().map(|model| model.to_affine()).collect::<Vec<_>>();
    for (joints, goal) in limbs.iter().zip(actor.goals) {
        if let Some(goal) = goal {
            reach(&body.skeleton, &pose, *joints, *goal, &mut models);
        }
    }
    let slots = body.skin.joints.iter().zip(&body.skin.inverse_bind);
    slots.map(|(joint, inverse)| (models[joint.index()] * inverse.to_affine()).into()).collect()
}

/// Turns the bones of a limb and what hangs on them.
fn reach(skeleton: &Skeleton, pose: &Pose, joints: LimbJoints, goal: Goal, models: &mut [Affine3A]) {
    let [root, middle, end] = [joints.upper, joints.lower, joints.end].map(|joint| pose.position(joint));
    let solved = solve(&Limb { root, middle, end, pole: goal.pole }, goal.target, joints.extension);
    let about = |from: Vec3, turn: Quat, to: Vec3| {
        Affine3A::from_rotation_translation(turn, to) * Affine3A::from_translation(-from)
    };
    let [upper, lower] = [(root, solved.upper_delta, root), (middle, solved.lower_delta, solved.middle)]
        .map(|(from, turn, to)| about(from, turn, to));
    for joint in skeleton.joints() {
        let is_below = |above| skeleton.is_below(joint, above);
        let old = pose.model(joint);
        models[joint.index()] = if joint == joints.end {
            about(end, goal.end_turn, solved.end) * old
        } else if let Some(parent) = skeleton.parent(joint).filter(|_| is_below(joints.end)) {
            models[parent.index()] * pose.local(joint).to_affine()
        } else if is_below(joints.lower) {
            lower * old
        } else if is_below(joints.upper) {
            upper * old
        } else {
            old
        };
    }
}

fn sampled(body: &Body, play: Play, mode: LayerMode) -> Vec<JointTransform> {
    let mut pose = body.skeleton.rest().to_vec();
    body.clips[play.clip].sample(&body.skeleton, play.time, &mut pose);
    if mode == LayerMode::Add {
        for (joint, rest) in pose.iter_mut().zip(body.skeleton.rest()) {
            *joint = difference(*rest, *joint);
        }
    }
    pose
}

/// Even numbers from a seed (`SplitMix64`, Steele and others 2014).
pub(super) struct Dice(pub(super) u64);

impl Dice {
    /// From `low` to `high`.
    pub(super) fn between(&mut self, low: f32, high: f32) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((bits >> 40) as f32 / 16_777_216.0)
    }

    pub(super) fn vector(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.between(-size, size), self.between(-size, size), self.between(-size, size))
    }

    pub(super) fn chance(&mut self, share: f32) -> bool {
        self.between(0.0, 1.0) < share
    }

    fn turn(&mut self, angle: f32) -> Quat {
        from_scaled_axis(self.vector(angle / 3.0_f32.sqrt()))
    }

    fn joint(&mut self, unevenness: f32) -> JointTransform {
        JointTransform {
            translation: self.vector(0.5),
            rotation: self.turn(3.0),
            scale: if self.chance(0.5) { Vec3::ONE } else { Vec3::ONE + self.vector(unevenness) },
        }
    }

    pub(super) fn body(&mut self, count: usize, unevenness: f32) -> Body {
        let seed = self.0;
        let joints: Vec<_> = (0..count)
            .map(|index| {
                let parent = (index > 0 && !self.chance(0.05)).then(|| {
                    let parent = self.between(0.0, index as f32) as usize;
                    JointIndex(u16::try_from(parent.min(index - 1)).unwrap())
                });
                (index.to_string(), parent, self.joint(unevenness))
            })
            .collect();
        let size = if self.chance(0.3) { 0.01 } else { 1.0 };
        let mirror = if unevenness > 0.0 && self.chance(0.2) { -size } else { size };
        let root =
            Affine3A::from_scale_rotation_translation(Vec3::new(mirror, size, size), self.turn(3.0), self.vector(1.0));
        let skeleton = Skeleton::new(joints, root).unwrap();
        let skin = self.skin(&skeleton);
        let clips = (0..4).map(|_| self.clip(&skeleton, unevenness)).collect();
        Body { mask: (0..count).map(|_| self.between(0.0, 1.0)).collect(), skin, clips, skeleton, seed }
    }

    /// Slots in some order, some joints without, some twice, some bound elsewhere than at rest.
    fn skin(&mut self, skeleton: &Skeleton) -> Skin {
        let rest = Pose::rest(skeleton);
        let mut skin = Skin::default();
        for joint in skeleton.joints().chain([JointIndex(0)]) {
            if self.chance(0.9) || joint.index() == 0 {
                let bound_elsewhere = self.chance(0.2);
                let moved = Affine3A::from_rotation_translation(self.turn(1.0), self.vector(0.2));
                let bind = rest.model(joint) * if bound_elsewhere { moved } else { Affine3A::IDENTITY };
                let place = self.between(0.0, skin.joints.len() as f32) as usize;
                skin.joints.insert(place, joint);
                skin.inverse_bind.insert(place, bind.inverse().into());
            }
        }
        skin
    }

    /// Turns stay within a radian of the rest pose: opposite ones have no mean.
    fn clip(&mut self, skeleton: &Skeleton, unevenness: f32) -> Clip {
        let times: Vec<f32> = (0..5).map(|key| key as f32 * 0.25).collect();
        let mut joints = Vec::new();
        for joint in skeleton.joints() {
            let rest = skeleton.rest()[joint.index()];
            let mut curves = JointCurves::new(joint);
            if self.chance(0.8) {
                let keys = times.iter().map(|_| rest.rotation * self.turn(1.0)).collect();
                curves.rotation = Some(Curve::rotation(times.clone(), keys, Interpolation::Linear).unwrap());
            }
            if self.chance(0.3) {
                let keys = times.iter().map(|_| rest.translation + self.vector(0.3)).collect();
                curves.translation = Some(Curve::new(times.clone(), keys, Interpolation::Linear).unwrap());
            }
            if unevenness > 0.0 && self.chance(0.3) {
                let keys = times.iter().map(|_| rest.scale + self.vector(unevenness * 0.5)).collect();
                curves.scale = Some(Curve::new(times.clone(), keys, Interpolation::Linear).unwrap());
            }
            joints.push(curves);
        }
        let looping = Some(self.chance(0.5));
        ClipCurves { joints, looping, ..ClipCurves::default() }.bake_at(skeleton, 30.0)
    }
}
