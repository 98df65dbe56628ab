//! Poses: local (each joint in its parent's space) and model (each joint in model space).
//!
//! Buffers are sized once from the skeleton; nothing here allocates afterwards.

use bevy::math::{Affine3A, Quat, Vec3, Vec3A};

use super::skeleton::{JointIndex, JointTransform, Skeleton};

/// One character's pose. Local transforms are written, model matrices follow from them.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    local: Vec<JointTransform>,
    model: Vec<Affine3A>,
}

impl Pose {
    /// The rest pose of `skeleton`.
    #[must_use]
    pub fn rest(skeleton: &Skeleton) -> Self {
        let mut pose = Self { local: skeleton.rest().to_vec(), model: vec![Affine3A::IDENTITY; skeleton.len()] };
        pose.update_model(skeleton);
        pose
    }

    /// How many joints it has.
    #[must_use]
    pub fn len(&self) -> usize {
        self.local.len()
    }

    /// Whether it has no joint.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.local.is_empty()
    }

    /// The joint in its parent's space.
    #[must_use]
    pub fn local(&self, joint: JointIndex) -> JointTransform {
        self.local[joint.index()]
    }

    /// Puts the joint in its parent's space. Model matrices are stale until [`Pose::update_model`] or
    /// [`Pose::update_model_below`].
    pub fn set_local(&mut self, joint: JointIndex, transform: JointTransform) {
        self.local[joint.index()] = transform;
    }

    /// How the joint is turned in its parent's space.
    #[must_use]
    #[inline]
    pub fn turn(&self, joint: JointIndex) -> Quat {
        self.local[joint.index()].rotation
    }

    /// Turns the joint in its parent's space. Model matrices are stale afterwards, as after [`Pose::set_local`].
    #[inline]
    pub fn set_turn(&mut self, joint: JointIndex, rotation: Quat) {
        self.local[joint.index()].rotation = rotation;
    }

    /// All local transforms.
    #[must_use]
    pub fn locals(&self) -> &[JointTransform] {
        &self.local
    }

    /// All local transforms, to be written. Model matrices are stale until [`Pose::update_model`].
    pub fn locals_mut(&mut self) -> &mut [JointTransform] {
        &mut self.local
    }

    /// The joint in model space: `model_from_joint`.
    #[must_use]
    pub fn model(&self, joint: JointIndex) -> Affine3A {
        self.model[joint.index()]
    }

    /// The joint's position in model space.
    #[must_use]
    pub fn position(&self, joint: JointIndex) -> Vec3 {
        self.model[joint.index()].translation.into()
    }

    /// All joints in model space.
    #[must_use]
    pub fn models(&self) -> &[Affine3A] {
        &self.model
    }

    /// All joints in model space, to be written.
    pub fn models_mut(&mut self) -> &mut [Affine3A] {
        &mut self.model
    }

    /// Takes the model matrices and puts as many others in their place.
    pub(crate) fn swap_models(&mut self, models: &mut Vec<Affine3A>) {
        debug_assert_eq!(models.len(), self.model.len(), "matrices of another skeleton");
        core::mem::swap(&mut self.model, models);
    }

    /// Model matrices from local transforms, all of them.
    pub fn update_model(&mut self, skeleton: &Skeleton) {
        self.update_models(skeleton, 0..skeleton.len());
    }

    /// Model matrices of `joint` and of all below it.
    pub fn update_model_below(&mut self, skeleton: &Skeleton, joint: JointIndex) {
        self.update_models(skeleton, skeleton.branch(joint));
    }

    /// Moves `joint` and all below it by `offset_model` (model space); model matrices stay up to date.
    pub fn shift_model(&mut self, skeleton: &Skeleton, joint: JointIndex, offset_model: Vec3) {
        if !self.shift_local(skeleton, joint, offset_model) {
            return;
        }
        if skeleton.is_whole_branch(joint) {
            let offset = Vec3A::from(offset_model);
            self.model[skeleton.branch(joint)].iter_mut().for_each(|model| model.translation += offset);
        } else {
            self.update_model_below(skeleton, joint);
        }
    }

    /// Moves `joint` by `offset_model` (model space) in its local transform alone: model matrices are stale afterwards. Gives
    /// false, and moves nothing, where that is nowhere.
    pub fn shift_local(&mut self, skeleton: &Skeleton, joint: JointIndex, offset_model: Vec3) -> bool {
        let above = skeleton.parent(joint).map_or(skeleton.model_from_root, |parent| self.model(parent));
        let translation = self.local(joint).translation + above.inverse().transform_vector3(offset_model);
        if translation.is_finite() {
            self.local[joint.index()].translation = translation;
        }
        translation.is_finite()
    }

    /// Model matrix of `joint` alone, from its local transform and its parent's matrix.
    pub fn update_joint(&mut self, skeleton: &Skeleton, joint: JointIndex) {
        let above = skeleton.parent(joint).map_or(skeleton.model_from_root, |parent| self.model[parent.index()]);
        self.model[joint.index()] = self.local[joint.index()].below(&above);
    }

    /// Turns `joint` by `rotation_model` (model space, about the joint) in place of its local rotation.
    /// Model matrices are stale afterwards.
    pub fn rotate_model(&mut self, skeleton: &Skeleton, joint: JointIndex, rotation_model: Quat) {
        let parent = self.parent_rotation(skeleton, joint);
        let local = &mut self.local[joint.index()];
        local.rotation = (parent.inverse() * rotation_model * parent * local.rotation).normalize();
    }

    /// Rotation of the joint in model space; scale and mirroring taken out.
    #[must_use]
    pub fn rotation(&self, joint: JointIndex) -> Quat {
        rotation_of(&self.model[joint.index()])
    }

    /// Rotation, in model space, of what `joint` hangs on.
    #[must_use]
    pub fn parent_rotation(&self, skeleton: &Skeleton, joint: JointIndex) -> Quat {
        match skeleton.parent(joint) {
            Some(parent) => self.rotation(parent),
            None => rotation_of(&skeleton.model_from_root),
        }
    }

    /// Model matrices of `joints` alone, parents first; those of others are stale.
    pub fn update_model_of(&mut self, skeleton: &Skeleton, joints: &[JointIndex]) {
        self.update_models(skeleton, joints.iter().map(|joint| joint.index()));
    }

    fn update_models(&mut self, skeleton: &Skeleton, joints: impl Iterator<Item = usize>) {
        debug_assert_eq!(self.local.len(), skeleton.len(), "a pose belongs to the skeleton it was made for");
        let parents = skeleton.parents();
        for index in joints {
            let above = parents[index].map_or(&skeleton.model_from_root, |p| &self.model[p.index()]);
            self.model[index] = self.local[index].below(above);
        }
    }
}

/// Difference from 1 of the square of an axis' length up to which it counts as unscaled: rounding of a long chain.
const UNSCALED: f32 = 1e-4;

/// Rotation part of a matrix; the identity where an axis is squashed to nothing.
#[must_use]
pub fn rotation_of(matrix: &Affine3A) -> Quat {
    let axes = matrix.matrix3;
    let unscaled = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| (axis.length_squared() - 1.0).abs() < UNSCALED);
    if unscaled == [true; 3] && axes.x_axis.cross(axes.y_axis).dot(axes.z_axis) > 0.0 {
        return Quat::from_mat3a(&axes).normalize();
    }
    let rotation = matrix.to_scale_rotation_translation().1;
    if rotation.is_finite() && rotation.length_squared() > 0.5 { rotation } else { Quat::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arm() -> Skeleton {
        let step = JointTransform { translation: Vec3::Y, ..JointTransform::IDENTITY };
        let joints = [
            ("shoulder".to_owned(), None, JointTransform::IDENTITY),
            ("elbow".to_owned(), Some(JointIndex(0)), step),
            ("wrist".to_owned(), Some(JointIndex(1)), step),
        ];
        Skeleton::new(joints, Affine3A::from_translation(Vec3::X)).expect("parents come first")
    }

    #[test]
    fn model_positions_follow_the_chain_and_the_root() {
        let pose = Pose::rest(&arm());
        assert_eq!(pose.position(JointIndex(2)), Vec3::new(1.0, 2.0, 0.0));
    }

    #[test]
    fn a_turn_in_model_space_swings_what_hangs_below() {
        let skeleton = arm();
        let mut pose = Pose::rest(&skeleton);
        pose.rotate_model(&skeleton, JointIndex(1), Quat::from_rotation_z(core::f32::consts::FRAC_PI_2));
        pose.update_model_below(&skeleton, JointIndex(1));
        let wrist = pose.position(JointIndex(2));
        assert!(wrist.distance(Vec3::new(0.0, 1.0, 0.0)) < 1e-6, "wrist at {wrist}");
    }
}
