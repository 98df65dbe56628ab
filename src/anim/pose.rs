//! Poses: local (each joint in its parent's space) and model (each joint in model space).
//!
//! Buffers are sized once from the skeleton; nothing here allocates afterwards.

use bevy::math::{Affine3A, Quat, Vec3};

use super::{
    matrix::{JointMatrix, between, write_models},
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// One character's pose. Local transforms are written, model matrices follow from them.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    local: Vec<JointTransform>,
    model: Vec<JointMatrix>,
    before: Before,
}

/// The pose before, where frames show what lies between the two.
#[derive(Clone, Debug, Default)]
struct Before {
    /// Empty where they don't.
    model: Vec<JointMatrix>,
    /// How far the pose is shown back on the way from there, 0..1.
    back: f32,
    /// Whether the pose was begun anew since it was last kept.
    begun: bool,
}

impl Pose {
    /// The rest pose of `skeleton`.
    #[must_use]
    pub fn rest(skeleton: &Skeleton) -> Self {
        let mut pose = Self {
            local: skeleton.rest().to_vec(),
            model: vec![JointMatrix::IDENTITY; skeleton.len()],
            ..Self::default()
        };
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
        self.shown(joint.index()).into()
    }

    /// Joint by index, as it is shown.
    #[inline]
    fn shown(&self, index: usize) -> JointMatrix {
        if self.before.back > 0.0 {
            return between(&self.before.model[index], &self.model[index], 1.0 - self.before.back);
        }
        self.model[index]
    }

    /// The joint's position in model space.
    #[must_use]
    #[inline]
    pub fn position(&self, joint: JointIndex) -> Vec3 {
        if self.before.back > 0.0 {
            return self.shown(joint.index()).translation();
        }
        self.model[joint.index()].translation()
    }

    /// Positions of three joints in model space.
    #[must_use]
    #[inline]
    pub fn positions_of(&self, [a, b, c]: [JointIndex; 3]) -> [Vec3; 3] {
        [self.position(a), self.position(b), self.position(c)]
    }

    /// Where a `point` of the joint's space is in model space.
    #[must_use]
    #[inline]
    pub fn place(&self, joint: JointIndex, point: Vec3) -> Vec3 {
        if self.before.back > 0.0 {
            return self.shown(joint.index()).transform_point3(point);
        }
        self.model[joint.index()].transform_point3(point)
    }

    /// Positions of all joints in model space.
    pub fn positions(&self) -> impl Iterator<Item = Vec3> + '_ {
        (0..self.len()).map(|joint| self.shown(joint).translation())
    }

    /// All joints in model space; of a character that is shown between two ticks those of the later one, other than
    /// [`model`](Self::model), which is as shown.
    #[must_use]
    pub fn models(&self) -> &[JointMatrix] {
        &self.model
    }

    /// All joints in model space, to be written.
    pub fn models_mut(&mut self) -> &mut [JointMatrix] {
        &mut self.model
    }

    /// Model matrices of the pose before, and how far from them it is shown, 0..1, where it isn't as it is posed.
    #[inline]
    pub(super) fn between(&self) -> Option<(&[JointMatrix], f32)> {
        (self.before.back > 0.0).then_some((&self.before.model, 1.0 - self.before.back))
    }

    /// Whether it keeps the pose before.
    pub(crate) fn keeps_before(&self) -> bool {
        !self.before.model.is_empty()
    }

    /// A new pose begins: the model matrices become those of the pose before, if it is kept, and are stale until they are updated.
    pub(crate) fn begin(&mut self) {
        if self.keeps_before() {
            core::mem::swap(&mut self.before.model, &mut self.model);
            (self.before.back, self.before.begun) = (0.0, true);
        }
    }

    /// The pose is done, and is shown after the one before. `jumped`: there is no way from that to this one.
    pub(crate) fn keep_before(&mut self, jumped: bool) {
        let before = &mut self.before;
        if jumped || !core::mem::take(&mut before.begun) || before.model.len() != self.model.len() {
            before.model.clear();
            before.model.extend_from_slice(&self.model);
        }
    }

    /// The same where `before` was kept elsewhere.
    pub(crate) fn take_before(&mut self, before: Vec<JointMatrix>) {
        self.before = Before { model: before, back: 0.0, begun: true };
    }

    /// Keeps the pose before no longer; gives it.
    pub(crate) fn forget_before(&mut self) -> Vec<JointMatrix> {
        core::mem::take(&mut self.before).model
    }

    /// Shows what lies `share` of the way from the pose before, 0..=1.
    pub(crate) fn show(&mut self, share: f32) {
        self.before.back = (1.0 - share).clamp(0.0, 1.0);
    }

    /// Takes the model matrices and puts as many others in their place.
    pub(crate) fn swap_models(&mut self, models: &mut Vec<JointMatrix>) {
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
            self.model[skeleton.branch(joint)].iter_mut().for_each(|model| model.shift(offset_model));
        } else {
            self.update_model_below(skeleton, joint);
        }
    }

    /// The same, but model matrices of `joints` alone are kept up to date, parents first.
    pub fn shift_model_of(
        &mut self,
        skeleton: &Skeleton,
        joint: JointIndex,
        offset_model: Vec3,
        joints: &[JointIndex],
    ) {
        if !self.shift_local(skeleton, joint, offset_model) {
            return;
        }
        if skeleton.is_whole_branch(joint) {
            let branch = skeleton.branch(joint);
            for below in joints.iter().filter(|below| branch.contains(&below.index())) {
                self.model[below.index()].shift(offset_model);
            }
        } else {
            self.update_model_of(skeleton, joints);
        }
    }

    /// Moves `joint` by `offset_model` (model space) in its local transform alone: model matrices are stale afterwards. Gives
    /// false, and moves nothing, where that is nowhere.
    pub fn shift_local(&mut self, skeleton: &Skeleton, joint: JointIndex, offset_model: Vec3) -> bool {
        let above = match skeleton.parent(joint) {
            Some(parent) => self.model[parent.index()],
            None => skeleton.model_from_root.into(),
        };
        let translation = self.local(joint).translation + above.inverse_transform_vector3(offset_model);
        if translation.is_finite() {
            self.local[joint.index()].translation = translation;
        }
        translation.is_finite()
    }

    /// Model matrix of `joint` alone, from its local transform and its parent's matrix.
    pub fn update_joint(&mut self, skeleton: &Skeleton, joint: JointIndex) {
        self.update_models(skeleton, core::iter::once(joint.index()));
    }

    /// Turns `joint` by `rotation_model` (model space, about the joint) in place of its local rotation.
    /// Model matrices are stale afterwards.
    pub fn rotate_model(&mut self, skeleton: &Skeleton, joint: JointIndex, rotation_model: Quat) {
        let turn = match skeleton.parent(joint) {
            Some(parent) => self.shown(parent.index()).turn_back(rotation_model),
            None => JointMatrix::from(skeleton.model_from_root).turn_back(rotation_model),
        };
        let local = &mut self.local[joint.index()];
        local.rotation = (turn * local.rotation).normalize();
    }

    /// Rotation of the joint in model space; scale and mirroring taken out.
    #[must_use]
    pub fn rotation(&self, joint: JointIndex) -> Quat {
        self.shown(joint.index()).rotation()
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
        write_models(skeleton, &self.local, joints, &mut self.model);
    }
}

/// Rotation part of a matrix; the identity where an axis is squashed to nothing.
#[must_use]
pub fn rotation_of(matrix: &Affine3A) -> Quat {
    JointMatrix::from(*matrix).rotation()
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
