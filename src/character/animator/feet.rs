//! Blends feet where they are.
//!
//! Joint angles half-way between two poses put feet somewhere else than half-way, mostly into the ground: between standing
//! and crouching by 6 cm. So feet are blended by their own place and turn in model space, and the legs set onto them.
//! Metres, +Y up, the character faces -Z.

use bevy::{math::Vec3A, prelude::*};

use crate::anim::{
    blend::Accumulator,
    leg::Leg,
    pose::{Pose, rotation_of},
    skeleton::{JointTransform, Skeleton},
};

/// Left and right ankle joint in model space.
pub(super) type Ankles = [JointTransform; 2];

/// Where both feet shall be, from all playing clips together.
#[derive(Clone, Debug, Default)]
pub(super) struct BlendedFeet {
    ankles: Ankles,
}

impl BlendedFeet {
    /// Takes what is added to the sum, feet of clips by their weights, for the feet that are wanted.
    pub(super) fn start(&mut self) -> Accumulator<'_> {
        Accumulator::new(&mut self.ankles)
    }

    /// Where they shall be: what was added.
    pub(super) fn ankles(&self) -> Ankles {
        self.ankles
    }
}

/// An ankle joint of a pose whose model matrices are up to date.
#[inline]
pub(super) fn ankle(pose: &Pose, leg: &Leg) -> JointTransform {
    JointTransform { translation: pose.position(leg.foot), rotation: pose.rotation(leg.foot), scale: Vec3::ONE }
}

/// Both ankle joints of a pose of local transforms, in model space.
pub(super) fn ankles(locals: &[JointTransform], skeleton: &Skeleton, legs: &[Leg; 2]) -> Ankles {
    let root = rotation_of(&skeleton.model_from_root);
    let ankle = |leg: &Leg| {
        let first = &locals[leg.foot.index()];
        let (mut rotation, mut translation) = (first.rotation, Vec3A::from(first.translation));
        let mut joint = skeleton.parent(leg.foot);
        while let Some(index) = joint {
            let local = &locals[index.index()];
            translation = local.rotation * (translation * Vec3A::from(local.scale)) + Vec3A::from(local.translation);
            rotation = local.rotation * rotation;
            joint = skeleton.parent(index);
        }
        let translation = skeleton.model_from_root.transform_point3a(translation).into();
        JointTransform { translation, rotation: root * rotation, scale: Vec3::ONE }
    };
    let [left, right] = legs;
    [ankle(left), ankle(right)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ankles_found_alone_are_those_of_the_whole_pose() {
        use crate::anim::skeleton::JointIndex;
        let step = |y: f32, x: f32| JointTransform { translation: Vec3::new(x, y, 0.0), ..JointTransform::IDENTITY };
        let joints = [
            ("hips".to_owned(), None, step(0.9, 0.0)),
            ("left thigh".to_owned(), Some(JointIndex(0)), step(0.0, -0.1)),
            ("left shin".to_owned(), Some(JointIndex(1)), step(-0.4, 0.0)),
            ("left foot".to_owned(), Some(JointIndex(2)), step(-0.4, 0.0)),
            ("right thigh".to_owned(), Some(JointIndex(0)), step(0.0, 0.1)),
            ("right shin".to_owned(), Some(JointIndex(4)), step(-0.4, 0.0)),
            ("right foot".to_owned(), Some(JointIndex(5)), step(-0.4, 0.0)),
        ];
        let root = bevy::math::Affine3A::from_rotation_y(1.0);
        let skeleton = Skeleton::new(joints, root).expect("parents come first");
        let leg = |first: u16| {
            let [upper, lower, foot] = [first, first + 1, first + 2].map(JointIndex);
            Leg { upper, lower, foot, ..Leg::default() }
        };
        let legs = [leg(1), leg(4)];
        let mut pose = Pose::rest(&skeleton);
        for joint in skeleton.joints() {
            pose.rotate_model(&skeleton, joint, Quat::from_rotation_x(0.1 * f32::from(joint.0)));
        }
        pose.update_model(&skeleton);
        for (found, leg) in ankles(pose.locals(), &skeleton, &legs).iter().zip(&legs) {
            let off = found.translation.distance(pose.position(leg.foot));
            assert!(off < 1e-5, "an ankle is found {off} m off");
            assert!(found.rotation.angle_between(pose.rotation(leg.foot)) < 1e-3, "a foot is found turned");
        }
    }
}
