//! Frames: the turn and even scale of each joint's bind pose in model space.
//!
//! Rotations are kept between frames, `frame_parent * rotation * frame_joint⁻¹`, and so are the matrices of posed joints,
//! `model_from_joint * frame⁻¹`: at the end of a chain no inverse bind matrix is left to multiply with.

use bevy::math::{Affine3A, Mat3, Quat, Vec3};

use crate::{
    anim::{
        pose::{Pose, rotation_of},
        skeleton::{JointIndex, Skeleton},
        skin::Skin,
    },
    math::rotation::angle_between,
};

/// Frames this close to the chain of rest transforms are taken from the chain, so that joints at rest turn and scale nothing.
const SAME_FRAME: f32 = 1e-4;
/// Turn and even scale of a joint's bind pose in model space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) turn: Quat,
    pub(super) scale: f32,
}

/// Frames of all joints.
#[derive(Clone, Debug)]
pub(super) struct Frames {
    pub(super) joints: Vec<Frame>,
    /// Of what stands above the roots.
    pub(super) root: Frame,
    parents: Vec<Option<JointIndex>>,
}

impl Frame {
    fn of(matrix: &Affine3A) -> Self {
        let scale = matrix.matrix3.determinant().abs().cbrt();
        // Of a sheared matrix it isn't one long.
        let turn = rotation_of(matrix).normalize();
        Self { turn, scale: if scale.is_finite() && scale > 1e-9 { scale } else { 1.0 } }
    }

    pub(super) fn matrix(self) -> Mat3 {
        Mat3::from_quat(self.turn) * self.scale
    }

    /// Itself, or `other` if that is next to the same.
    fn or_near(self, other: Self) -> Self {
        let near =
            angle_between(self.turn, other.turn) < SAME_FRAME && (self.scale / other.scale - 1.0).abs() < SAME_FRAME;
        if near { other } else { self }
    }
}

impl Frames {
    /// Those between which rotations are what they are in their parents' spaces.
    pub(super) fn none(skeleton: &Skeleton) -> Self {
        let root = Frame { turn: Quat::IDENTITY, scale: 1.0 };
        Self { joints: vec![root; skeleton.len()], root, parents: skeleton.parents().to_vec() }
    }

    pub(super) fn new(skeleton: &Skeleton, skin: &Skin) -> Self {
        let rest = Pose::rest(skeleton);
        let mut bind = rest.models().to_vec();
        for (joint, inverse) in skin.joints.iter().zip(&skin.inverse_bind).rev() {
            let matrix = inverse.inverse();
            if matrix.is_finite() {
                bind[joint.index()] = matrix;
            }
        }
        let root = Frame::of(&skeleton.model_from_root);
        let mut frames = Self { joints: vec![], root, parents: skeleton.parents().to_vec() };
        for (joint, (bind, rest)) in bind.iter().zip(skeleton.rest()).enumerate() {
            let parent = frames.above(joint);
            let scale = rest.scale.abs().max_element();
            let chained = Frame { turn: (parent.turn * rest.rotation).normalize(), scale: parent.scale * scale };
            frames.joints.push(Frame::of(&bind.to_affine()).or_near(chained));
        }
        frames
    }

    /// Of what a joint hangs on.
    pub(super) fn above(&self, joint: usize) -> Frame {
        self.parents[joint].map_or(self.root, |parent| self.joints[parent.index()])
    }

    /// The rotation of a joint, from its parent's space to between frames.
    pub(super) fn rotation(&self, joint: JointIndex, local: Quat) -> Quat {
        self.above(joint.index()).turn * local * self.joints[joint.index()].turn.conjugate()
    }

    /// The inverse of [`Frames::rotation`].
    pub(super) fn local_rotation(&self, joint: JointIndex, rotation: Quat) -> Quat {
        self.above(joint.index()).turn.conjugate() * rotation * self.joints[joint.index()].turn
    }

    /// A turn in the joint's own axes, about those of its frame.
    pub(super) fn own_turn(&self, joint: JointIndex, local: Quat) -> Quat {
        let turn = self.joints[joint.index()].turn;
        turn * local * turn.conjugate()
    }

    /// A translation of a joint, from its parent's space to the parent's frame.
    pub(super) fn translation(&self, joint: JointIndex, local: Vec3) -> Vec3 {
        let above = self.above(joint.index());
        above.turn * local * above.scale
    }

    /// The inverse of [`Frames::translation`].
    pub(super) fn local_translation(&self, joint: JointIndex, translation: Vec3) -> Vec3 {
        let above = self.above(joint.index());
        above.turn.conjugate() * translation * (1.0 / above.scale)
    }
}
