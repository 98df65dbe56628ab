//! Weighted blends of local poses: translations and scales by their mean, rotations as quaternions on the shortest arc.

use bevy::math::{Quat, Vec3};

use super::skeleton::JointTransform;

/// Sums weighted poses into a caller's buffer. Any number of poses, in any order of weights.
///
/// Rotations are aligned to the first pose's hemisphere and normalised once at the end (normalised linear blending,
/// the weighted form of nlerp), so the order of equal weights doesn't matter and no pair is privileged.
pub struct Accumulator<'a> {
    sum: &'a mut [JointTransform],
    total: f32,
}

impl<'a> Accumulator<'a> {
    /// Starts a blend in `sum`; its old content is lost.
    pub fn new(sum: &'a mut [JointTransform]) -> Self {
        Self { sum, total: 0.0 }
    }

    /// Adds `pose` with `weight`; weights need not sum to one. A weight of zero or less adds nothing.
    pub fn add(&mut self, pose: &[JointTransform], weight: f32) {
        if weight.is_nan() || weight <= 0.0 {
            return;
        }
        if self.total <= 0.0 {
            for (sum, joint) in self.sum.iter_mut().zip(pose) {
                *sum = JointTransform {
                    translation: joint.translation * weight,
                    rotation: joint.rotation * weight,
                    scale: joint.scale * weight,
                };
            }
        } else {
            for (sum, joint) in self.sum.iter_mut().zip(pose) {
                let side = if sum.rotation.dot(joint.rotation) < 0.0 { -weight } else { weight };
                sum.translation += joint.translation * weight;
                sum.rotation += joint.rotation * side;
                sum.scale += joint.scale * weight;
            }
        }
        self.total += weight;
    }

    /// Normalises what was added. Gives false, and leaves the buffer alone, when nothing was.
    #[must_use]
    pub fn finish(self) -> bool {
        if self.total <= 0.0 {
            return false;
        }
        let scale = 1.0 / self.total;
        for joint in self.sum.iter_mut() {
            joint.translation *= scale;
            joint.scale *= scale;
            joint.rotation = normalized_or_identity(joint.rotation);
        }
        true
    }
}

/// `from` moved to `to` by `share` in 0..=1, joint by joint.
pub fn lerp_into(from: &mut [JointTransform], to: &[JointTransform], share: f32) {
    for (a, b) in from.iter_mut().zip(to) {
        *a = lerp(*a, *b, share);
    }
}

/// One joint between two transforms.
#[must_use]
pub fn lerp(a: JointTransform, b: JointTransform, share: f32) -> JointTransform {
    let side = if a.rotation.dot(b.rotation) < 0.0 { -share } else { share };
    JointTransform {
        translation: a.translation + (b.translation - a.translation) * share,
        rotation: normalized_or_identity(a.rotation * (1.0 - share) + b.rotation * side),
        scale: a.scale + (b.scale - a.scale) * share,
    }
}

/// What takes `from` to `to`, each turn in the joint's own axes: what an additive layer adds.
#[must_use]
pub fn difference(from: JointTransform, to: JointTransform) -> JointTransform {
    let scale = to.scale / from.scale;
    JointTransform {
        translation: to.translation - from.translation,
        rotation: normalized_or_identity(from.rotation.conjugate() * to.rotation),
        scale: Vec3::select(scale.is_finite_mask(), scale, Vec3::ONE),
    }
}

/// `base` with `share` of a [`difference`] on top; the shorter way round.
#[must_use]
pub fn added(base: JointTransform, difference: JointTransform, share: f32) -> JointTransform {
    let turn = lerp(JointTransform::IDENTITY, difference, share);
    JointTransform {
        translation: base.translation + turn.translation,
        rotation: normalized_or_identity(base.rotation * turn.rotation),
        scale: base.scale * turn.scale,
    }
}

fn normalized_or_identity(rotation: Quat) -> Quat {
    let squared = rotation.length_squared();
    if squared > 1e-12 && squared.is_finite() { rotation * (1.0 / squared.sqrt()) } else { Quat::IDENTITY }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rotation::{angle_between, from_scaled_axis};

    fn moved(translation: Vec3) -> JointTransform {
        JointTransform { translation, ..JointTransform::IDENTITY }
    }

    #[test]
    fn equal_weights_meet_half_way() {
        let a = [moved(Vec3::ZERO)];
        let b = [JointTransform { translation: Vec3::X, rotation: from_scaled_axis(Vec3::Y), scale: Vec3::splat(3.0) }];
        let mut out = a;
        let mut blend = Accumulator::new(&mut out);
        blend.add(&a, 0.5);
        blend.add(&b, 0.5);
        assert!(blend.finish());
        assert!(out[0].translation.distance(Vec3::X * 0.5) < 1e-6);
        assert!((out[0].scale.x - 2.0).abs() < 1e-6);
        let off = angle_between(out[0].rotation, from_scaled_axis(Vec3::Y * 0.5));
        assert!(off < 1e-4, "{off} rad off half-way");
    }

    #[test]
    fn the_sign_of_a_quaternion_does_not_matter() {
        let turn = from_scaled_axis(Vec3::new(0.3, 0.4, 0.1));
        let a = [JointTransform { rotation: turn, ..JointTransform::IDENTITY }];
        let b = [JointTransform { rotation: -turn, ..JointTransform::IDENTITY }];
        let mut out = a;
        let mut blend = Accumulator::new(&mut out);
        blend.add(&a, 0.3);
        blend.add(&b, 0.7);
        assert!(blend.finish());
        let off = angle_between(out[0].rotation, turn);
        assert!(off < 1e-3, "{off} rad off");
    }

    #[test]
    fn a_difference_added_in_full_gives_the_other_pose() {
        let turned = |axis: Vec3| JointTransform {
            translation: axis * 2.0,
            rotation: from_scaled_axis(axis),
            scale: Vec3::ONE + axis.abs(),
        };
        let (from, to) = (turned(Vec3::new(0.3, -0.9, 0.2)), turned(Vec3::new(-1.0, 0.4, 0.6)));
        let got = added(from, difference(from, to), 1.0);
        let off = angle_between(got.rotation, to.rotation);
        assert!(off < 1e-3, "{off} rad off");
        assert!(got.translation.distance(to.translation) < 1e-6 && got.scale.distance(to.scale) < 1e-6, "{got:?}");
        assert_eq!(added(from, difference(from, to), 0.0).translation, from.translation);
    }

    #[test]
    fn no_weight_leaves_the_pose_alone() {
        let mut out = [moved(Vec3::X)];
        let mut blend = Accumulator::new(&mut out);
        blend.add(&[moved(Vec3::Y)], 0.0);
        assert!(!blend.finish());
        assert_eq!(out[0].translation, Vec3::X);
    }
}
