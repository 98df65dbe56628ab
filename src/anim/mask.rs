//! Masks: how far each joint takes part in a layer. And layers, laid over a pose in its place or added to it.
//!
//! Everything is in local space, each joint in its parent's. So what a mask leaves out stays bit for bit as it was, and
//! what it takes rides on what carries it: a hand waves along with a chest that walking sways. Blending rotations in
//! model space would keep the layer's own directions whatever the hips do, but it would take the sway of hips and spine
//! out of all that a mask feathers, and cost a model pose of each layer. What must point somewhere is aimed there
//! afterwards, by IK in model space.

use super::{
    blend::{added, difference, lerp},
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// How far each joint takes part in a layer, 0..=1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mask {
    /// Joints that take part at all, parents first, and how far.
    shares: Vec<(JointIndex, f32)>,
}

impl Mask {
    /// All joints, in full.
    #[must_use]
    pub fn whole(skeleton: &Skeleton) -> Self {
        Self { shares: skeleton.joints().map(|joint| (joint, 1.0)).collect() }
    }

    /// `root` and all below it, feathered over the first `feather` joints of each chain.
    ///
    /// With a feather of 3 the root takes a third of the layer, the next joints two thirds, all further ones the whole of
    /// it. 0 and 1: all take part in full.
    #[must_use]
    pub fn branch(skeleton: &Skeleton, root: JointIndex, feather: u32) -> Self {
        let mut depths = vec![None; skeleton.len()];
        let mut shares = Vec::new();
        for joint in skeleton.joints() {
            let above = skeleton.parent(joint).and_then(|parent| depths[parent.index()]);
            let depth = if joint == root { Some(1u32) } else { above.map(|depth: u32| depth.saturating_add(1)) };
            depths[joint.index()] = depth;
            if let Some(depth) = depth {
                shares.push((joint, (depth as f32 / feather.max(1) as f32).min(1.0)));
            }
        }
        Self { shares }
    }

    /// How far `joint` takes part, 0..=1.
    #[must_use]
    pub fn share(&self, joint: JointIndex) -> f32 {
        let place = self.shares.binary_search_by_key(&joint, |share| share.0);
        place.map_or(0.0, |place| self.shares[place].1)
    }

    /// The joints that take part, parents first, and how far.
    pub fn shares(&self) -> impl Iterator<Item = (JointIndex, f32)> + '_ {
        self.shares.iter().copied()
    }

    /// Brings `pose` toward `layer`, by `weight` times each joint's share; rotations on the shortest arc.
    ///
    /// Where that product is 0, or not a number, joints stay bit for bit as they were; where it is 1 they become the
    /// layer's.
    pub fn blend(&self, pose: &mut [JointTransform], layer: &[JointTransform], weight: f32) {
        for (joint, share) in self.weighted(weight) {
            let (Some(pose), Some(layer)) = (pose.get_mut(joint), layer.get(joint)) else { continue };
            *pose = if share < 1.0 { lerp(*pose, *layer, share) } else { *layer };
        }
    }

    /// Adds to `pose` what lies between `reference` and `layer`, by `weight` times each joint's share.
    ///
    /// Turns are made in each joint's own axes, translations are added, scales multiplied. Added in full to `reference`
    /// itself, it gives `layer`.
    pub fn add(
        &self,
        pose: &mut [JointTransform],
        layer: &[JointTransform],
        reference: &[JointTransform],
        weight: f32,
    ) {
        for (joint, share) in self.weighted(weight) {
            let layers = (pose.get_mut(joint), layer.get(joint), reference.get(joint));
            let (Some(pose), Some(layer), Some(reference)) = layers else { continue };
            *pose = added(*pose, difference(*reference, *layer), share);
        }
    }

    /// Indices of the joints that take part, each with `weight` times its share.
    fn weighted(&self, weight: f32) -> impl Iterator<Item = (usize, f32)> + '_ {
        let weight = if weight > 0.0 { weight.min(1.0) } else { 0.0 };
        self.shares.iter().map(move |(joint, share)| (joint.index(), share * weight)).filter(|(_, share)| *share > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rotation::{angle_between, from_scaled_axis};
    use bevy::math::{Affine3A, Quat, Vec3};
    use proptest::prelude::*;

    /// Hips with a leg, three joints of spine, an arm of two and a head.
    fn body() -> Skeleton {
        let joint =
            |name: &str, parent: Option<u16>| (name.to_owned(), parent.map(JointIndex), JointTransform::IDENTITY);
        let joints = [
            joint("hips", None),
            joint("spine", Some(0)),
            joint("leg", Some(0)),
            joint("chest", Some(1)),
            joint("upper chest", Some(3)),
            joint("foot", Some(2)),
            joint("arm", Some(4)),
            joint("hand", Some(6)),
            joint("head", Some(4)),
        ];
        Skeleton::new(joints, Affine3A::IDENTITY).expect("parents come first")
    }

    const JOINTS: usize = 9;
    const SPINE: JointIndex = JointIndex(1);

    fn vector() -> impl Strategy<Value = Vec3> {
        (-2.0f32..2.0, -2.0f32..2.0, -2.0f32..2.0).prop_map(|(x, y, z)| Vec3::new(x, y, z))
    }

    fn pose() -> impl Strategy<Value = Vec<JointTransform>> {
        let joint = (vector(), vector(), vector(), any::<bool>()).prop_map(|(translation, turn, scale, other)| {
            let rotation = from_scaled_axis(turn);
            JointTransform { translation, rotation: if other { -rotation } else { rotation }, scale }
        });
        prop::collection::vec(joint, JOINTS)
    }

    fn bits(pose: &[JointTransform]) -> Vec<u32> {
        let numbers = |joint: &JointTransform| {
            let rotation = joint.rotation.to_array();
            rotation.into_iter().chain(joint.translation.to_array()).chain(joint.scale.to_array()).map(f32::to_bits)
        };
        pose.iter().flat_map(numbers).collect()
    }

    /// The largest distance, and the largest angle in radians, between joints of two poses.
    fn apart(a: &[JointTransform], b: &[JointTransform]) -> f32 {
        let off = |(a, b): (&JointTransform, &JointTransform)| {
            let moved = a.translation.distance(b.translation).max(a.scale.distance(b.scale));
            moved.max(angle_between(a.rotation, b.rotation))
        };
        a.iter().zip(b).map(off).fold(0.0, f32::max)
    }

    fn flipped(pose: &[JointTransform]) -> Vec<JointTransform> {
        pose.iter().map(|joint| JointTransform { rotation: -joint.rotation, ..*joint }).collect()
    }

    #[test]
    fn a_mask_is_feathered_from_its_root_on_and_leaves_the_rest_out() {
        let skeleton = body();
        let mask = Mask::branch(&skeleton, SPINE, 3);
        let shares: Vec<f32> = skeleton.joints().map(|joint| mask.share(joint)).collect();
        let wanted = [0.0, 1.0 / 3.0, 0.0, 2.0 / 3.0, 1.0, 0.0, 1.0, 1.0, 1.0];
        assert!(shares.iter().zip(wanted).all(|(share, wanted)| (share - wanted).abs() < 1e-6), "shares {shares:?}");
        for feather in [0, 1] {
            let mask = Mask::branch(&skeleton, SPINE, feather);
            assert!(mask.shares().all(|(_, share)| share >= 1.0) && mask.shares().count() == 6, "{mask:?}");
        }
        assert_eq!(Mask::branch(&skeleton, JointIndex(0), 0), Mask::whole(&skeleton));
    }

    proptest! {
        #[test]
        fn no_weight_leaves_every_bit_alone(base in pose(), layer in pose(), reference in pose(), weight in prop_oneof![Just(0.0f32), Just(-0.5), Just(f32::NAN)]) {
            let mut pose = base.clone();
            Mask::whole(&body()).blend(&mut pose, &layer, weight);
            Mask::whole(&body()).add(&mut pose, &layer, &reference, weight);
            prop_assert!(bits(&pose) == bits(&base), "a weight of {weight} changed the pose");
        }

        #[test]
        fn joints_outside_of_the_mask_keep_every_bit(base in pose(), layer in pose(), reference in pose(), weight in 0.0f32..=1.0) {
            let mut pose = base.clone();
            let mask = Mask::branch(&body(), SPINE, 3);
            mask.blend(&mut pose, &layer, weight);
            mask.add(&mut pose, &layer, &reference, weight);
            for outside in [0, 2, 5] {
                prop_assert!(bits(&pose[outside..=outside]) == bits(&base[outside..=outside]), "joint {outside} changed");
            }
        }

        #[test]
        fn all_weight_on_all_joints_gives_the_layer(base in pose(), layer in pose()) {
            let mut pose = base.clone();
            Mask::whole(&body()).blend(&mut pose, &layer, 1.0);
            prop_assert!(bits(&pose) == bits(&layer), "off by {}", apart(&pose, &layer));
        }

        #[test]
        fn the_signs_of_quaternions_do_not_matter(base in pose(), layer in pose(), reference in pose(), weight in 0.0f32..=1.0) {
            let mask = Mask::branch(&body(), SPINE, 3);
            // Half a turn has two shortest ways.
            let half_a_turn = |a: &[JointTransform], b: &[JointTransform]| {
                a.iter().zip(b).any(|(a, b)| angle_between(a.rotation, b.rotation) > 3.1)
            };
            prop_assume!(!half_a_turn(&base, &layer) && !half_a_turn(&layer, &reference));
            let (mut blended, mut from_flipped, mut flipped_layer) = (base.clone(), flipped(&base), base.clone());
            mask.blend(&mut blended, &layer, weight);
            mask.blend(&mut from_flipped, &layer, weight);
            mask.blend(&mut flipped_layer, &flipped(&layer), weight);
            let off = apart(&blended, &from_flipped).max(apart(&blended, &flipped_layer));
            prop_assert!(off < 5e-3, "blended, signs change the pose by {off}");
            let (mut added, mut other) = (base.clone(), base.clone());
            mask.add(&mut added, &layer, &reference, weight);
            mask.add(&mut other, &flipped(&layer), &reference, weight);
            let off = apart(&added, &other);
            prop_assert!(off < 5e-3, "added, signs change the pose by {off}");
        }

        #[test]
        fn what_is_added_in_full_to_its_reference_is_the_layer(layer in pose(), reference in pose()) {
            let mut pose = reference.clone();
            Mask::whole(&body()).add(&mut pose, &layer, &reference, 1.0);
            let off = apart(&pose, &layer);
            prop_assert!(off < 5e-3, "off by {off}");
        }

        #[test]
        fn no_nan_comes_out(base in pose(), layer in pose(), broken in 0usize..JOINTS, weight in -1.0f32..2.0) {
            let (mut layer, mut reference) = (layer, base.clone());
            layer[broken].rotation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0);
            layer[broken].scale = Vec3::ZERO;
            reference[JOINTS - 1 - broken].rotation = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0);
            let (mut blended, mut added) = (base.clone(), base);
            let mask = Mask::branch(&body(), SPINE, 3);
            mask.blend(&mut blended, &layer, weight);
            mask.add(&mut added, &layer, &reference, weight);
            for joint in blended.iter().chain(&added) {
                let sound = joint.translation.is_finite() && joint.rotation.is_finite() && joint.scale.is_finite();
                prop_assert!(sound, "{joint:?}");
            }
        }
    }
}
