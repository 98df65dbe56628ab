//! A body with 67 joints, its walk and its run: what both sides of the comparison animate.

use core::f32::consts::TAU;

use bevy::math::{Affine3A, Quat, Vec3, ops};
use surefoot::anim::{
    bake::{ClipCurves, JointCurves},
    curve::{Curve, Interpolation},
    matrix::JointMatrix,
    pose::Pose,
    skeleton::{JointIndex, JointTransform, Skeleton},
    skin::Skin,
};

/// Key frames per second of both clips.
const RATE: f32 = 30.0;
/// The joint that bobs, and the one that sways, besides turning.
const MOVED: [u16; 2] = [0, 1];

/// Skeleton, skin and clips.
pub(crate) struct Body {
    pub(crate) skeleton: Skeleton,
    pub(crate) skin: Skin,
    pub(crate) walk: Keys,
    pub(crate) run: Keys,
    /// Thigh, shin and foot of both legs.
    pub(crate) legs: [[JointIndex; 3]; 2],
}

/// Keys of a clip, one of each joint a frame.
pub(crate) struct Keys {
    pub(crate) times: Vec<f32>,
    /// By joint, then by key.
    pub(crate) rotations: Vec<Vec<Quat>>,
    /// Joints that move, and where they are at each key.
    pub(crate) translations: Vec<(JointIndex, Vec<Vec3>)>,
}

impl Body {
    pub(crate) fn new() -> Self {
        let mut joints = vec![joint("root", None, Vec3::Y * 0.95), joint("hips", Some(0), Vec3::ZERO)];
        let chest = chain(&mut joints, 1, "spine", 4, Vec3::Y * 0.12);
        chain(&mut joints, chest, "head", 2, Vec3::Y * 0.15);
        for (side, out) in [("left", -1.0), ("right", 1.0)] {
            let hand = chain(&mut joints, chest, &format!("{side} arm"), 4, Vec3::new(0.2 * out, 0.0, 0.0));
            for finger in 0..5 {
                let offset = Vec3::new(0.03 * out, 0.0, 0.01 * (finger as f32 - 2.0));
                chain(&mut joints, hand, &format!("{side} finger {finger}"), 4, offset);
            }
        }
        let legs = [("left", -0.1), ("right", 0.1)].map(|(side, out)| {
            let hip = joints.len();
            joints.push(joint(&format!("{side} thigh"), Some(1), Vec3::new(out, -0.05, 0.0)));
            let foot = chain(&mut joints, hip, &format!("{side} shin"), 2, Vec3::new(0.0, -0.42, 0.0));
            chain(&mut joints, foot, &format!("{side} toe"), 2, Vec3::new(0.0, -0.03, -0.08));
            [hip, hip + 1, foot].map(index)
        });
        joints.push(joint("jaw", Some(chest), Vec3::new(0.0, 0.3, -0.05)));
        let skeleton = Skeleton::new(joints, Affine3A::IDENTITY).expect("parents come first");
        let rest = Pose::rest(&skeleton);
        let inverse_bind = rest.models().iter().map(JointMatrix::inverse).collect();
        let skin = Skin { joints: skeleton.joints().collect(), inverse_bind };
        let (walk, run) = (Keys::gait(&skeleton, &legs, 1.0, 0.45), Keys::gait(&skeleton, &legs, 0.7, 0.8));
        Self { skeleton, skin, walk, run, legs }
    }
}

impl Keys {
    /// Everything swings, each joint at its own moment; legs in opposite phases.
    fn gait(skeleton: &Skeleton, legs: &[[JointIndex; 3]; 2], period: f32, swing: f32) -> Self {
        let frames = (period * RATE).round() as usize;
        let times: Vec<f32> = (0..=frames).map(|frame| frame as f32 * period / frames as f32).collect();
        let keys = |joint: JointIndex| {
            let side = legs.iter().position(|leg| (leg[0]..=leg[2]).contains(&joint));
            let (phase, swing) = match side {
                Some(leg) => (0.5 * leg as f32, swing),
                None => (0.137 * f32::from(joint.0), 0.3 * swing),
            };
            let turn = |time: &f32| {
                let angle = TAU * (time / period + phase);
                Quat::from_rotation_x(swing * ops::sin(angle)) * Quat::from_rotation_z(0.1 * swing * ops::cos(angle))
            };
            times.iter().map(turn).collect::<Vec<_>>()
        };
        let sway = |joint: u16| {
            let rest = skeleton.rest()[usize::from(joint)].translation;
            let at = |time: &f32| rest + Vec3::new(0.01, 0.03, 0.0) * ops::sin(2.0 * TAU * time / period);
            (JointIndex(joint), times.iter().map(at).collect())
        };
        Self { rotations: skeleton.joints().map(keys).collect(), translations: MOVED.map(sway).into(), times }
    }

    pub(crate) fn duration(&self) -> f32 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// As curves of this crate.
    pub(crate) fn curves(&self, skeleton: &Skeleton) -> ClipCurves {
        let joints = skeleton.joints().zip(&self.rotations).map(|(joint, rotations)| {
            let translation = self.translations.iter().find(|(moved, _)| *moved == joint);
            let curve = |keys: &Vec<Vec3>| Curve::new(self.times.clone(), keys.clone(), Interpolation::Linear);
            JointCurves {
                rotation: Curve::rotation(self.times.clone(), rotations.clone(), Interpolation::Linear).ok(),
                translation: translation.and_then(|(_, keys)| curve(keys).ok()),
                ..JointCurves::new(joint)
            }
        });
        ClipCurves { joints: joints.collect(), looping: Some(true), ..ClipCurves::default() }
    }
}

type NamedJoint = (String, Option<JointIndex>, JointTransform);

fn index(joint: usize) -> JointIndex {
    JointIndex(u16::try_from(joint).expect("a body has few joints"))
}

fn joint(name: &str, parent: Option<usize>, translation: Vec3) -> NamedJoint {
    (name.to_owned(), parent.map(index), JointTransform { translation, ..JointTransform::IDENTITY })
}

/// `count` joints below `parent`, each `step` from the one before. Gives the last.
fn chain(joints: &mut Vec<NamedJoint>, parent: usize, name: &str, count: usize, step: Vec3) -> usize {
    let mut last = parent;
    for number in 0..count {
        joints.push(joint(&format!("{name} {number}"), Some(last), step));
        last = joints.len() - 1;
    }
    last
}
