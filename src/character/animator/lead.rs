//! Feet that lead their legs: several stages of a tick put feet somewhere, legs are set onto them once.
//!
//! Each stage moves the model matrices of ankles and toes alone; hips and knees stay as the joints above carry them, until
//! foot IK, or else the `Model` stage, turns the legs. Model space, metres.

use bevy::{math::Affine3A, prelude::*};

use super::CharacterPose;
use crate::{
    anim::{
        ik::two_bone::{Limb, soften},
        leg::Leg,
        matrix::JointMatrix,
        pose::Pose,
        skeleton::{JointIndex, Skeleton},
    },
    character::legs::{CLIP_EXTENSION, LegJoints, LegTurns, place_limb},
    rig::character::CharacterAsset,
};

impl CharacterPose {
    /// Whether model matrices of ankles and toes are where the feet shall be, and the legs aren't yet.
    pub(in crate::character) fn feet_lead(&self) -> bool {
        self.feet_lead
    }

    /// All legs are set onto their feet.
    pub(in crate::character) fn legs_follow(&mut self) {
        self.feet_lead = false;
    }

    /// Where the leg, as its joints are turned, has its ankle.
    pub(in crate::character) fn carried_ankle(&self, skeleton: &Skeleton, leg: &Leg) -> Vec3 {
        match skeleton.parent(leg.foot).filter(|_| self.feet_lead) {
            Some(above) => self.pose.models()[above.index()].transform_point3(self.pose.local(leg.foot).translation),
            None => self.pose.position(leg.foot),
        }
    }

    /// Sets the legs onto feet that lead them.
    pub(in crate::character) fn set_legs(&mut self, asset: &CharacterAsset) {
        if !self.feet_lead {
            return;
        }
        for leg in &asset.legs {
            let joints = LegJoints { upper: leg.upper, lower: leg.lower, foot: leg.foot };
            let turns = LegTurns::of(&self.pose, &asset.skeleton, joints);
            let limb = Limb {
                root: self.pose.position(leg.upper),
                middle: self.pose.position(leg.lower),
                end: self.carried_ankle(&asset.skeleton, leg),
                pole: Vec3::NEG_Z,
            };
            let goal = (self.pose.position(leg.foot), self.pose.rotation(leg.foot));
            place_limb(&mut self.pose, &asset.skeleton, joints, &turns, &limb, goal, CLIP_EXTENSION);
        }
        self.feet_lead = false;
    }

    /// Changes the pose above its feet, which stay where they are and lead their legs from now on.
    pub(in crate::character) fn keep_feet(&mut self, asset: &CharacterAsset, change: impl FnOnce(&mut Pose)) {
        let models = self.pose.models();
        let foot = |leg: &Leg| {
            let [ankle, toes] = joints(leg);
            [models[ankle.index()], models[toes.index()]]
        };
        let [left, right] = &asset.legs;
        let feet = [foot(left), foot(right)];
        change(&mut self.pose);
        for (leg, feet) in asset.legs.iter().zip(feet) {
            for (joint, model) in joints(leg).into_iter().zip(feet) {
                self.pose.models_mut()[joint.index()] = model;
            }
            self.keep_within_reach(leg);
        }
        self.feet_lead = true;
    }

    /// Turns a foot by `turn` and puts its ankle to `ankle`; it leads its leg from now on.
    pub(super) fn lead_foot(&mut self, leg: &Leg, turn: Quat, ankle: Vec3) {
        let from = self.pose.position(leg.foot);
        let placed = JointMatrix::from(Affine3A::from_rotation_translation(turn, ankle - turn * from));
        for joint in joints(leg).into_iter().take(if leg.toes.is_some() { 2 } else { 1 }) {
            let model = &mut self.pose.models_mut()[joint.index()];
            *model = placed * *model;
        }
        self.keep_within_reach(leg);
        self.feet_lead = true;
    }

    /// Brings a foot that leads so near that its leg reaches it.
    fn keep_within_reach(&mut self, leg: &Leg) {
        let out = self.pose.position(leg.foot) - self.pose.position(leg.upper);
        let (distance, length) = (out.length(), leg.length());
        if distance > CLIP_EXTENSION.soft * length {
            let back = out * (soften(distance, length, CLIP_EXTENSION) / distance - 1.0);
            for joint in leg.toes.into_iter().chain([leg.foot]) {
                self.pose.models_mut()[joint.index()].shift(back);
            }
        }
    }
}

/// Ankle and toes; the ankle again where there are no toes.
fn joints(leg: &Leg) -> [JointIndex; 2] {
    [leg.foot, leg.toes.unwrap_or(leg.foot)]
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::rig::{Rig, character_file::CharacterFile};

    fn mannequin() -> CharacterAsset {
        let bytes = include_bytes!("../../../assets/mannequin.glb");
        let rig = Rig::from_slice(bytes, |uri| Err(uri.to_owned())).expect("it needs no other file");
        let file = CharacterFile { model: "mannequin.glb".to_owned(), ..CharacterFile::default() };
        CharacterAsset::resolve(file, "mannequin.glb".into(), rig, &BTreeMap::new()).expect("it is a body")
    }

    /// Lifts the hips by `metres` with feet that stay; gives the pose before the legs follow, and after.
    fn lifted(asset: &CharacterAsset, metres: f32) -> [CharacterPose; 2] {
        let mut leading = CharacterPose::new(&asset.skeleton);
        leading.keep_feet(asset, |pose| pose.shift_model(&asset.skeleton, asset.hips, Vec3::Y * metres));
        let mut followed = leading.clone();
        followed.set_legs(asset);
        [leading, followed]
    }

    #[test]
    fn legs_follow_feet_that_stay_while_the_hips_sink() {
        let asset = mannequin();
        let rest = CharacterPose::new(&asset.skeleton);
        let [leading, followed] = lifted(&asset, -0.1);
        assert!(leading.feet_lead() && !followed.feet_lead());
        for leg in &asset.legs {
            let place = |pose: &CharacterPose| pose.pose.position(leg.foot);
            assert_eq!(place(&leading), place(&rest), "an ankle that leads");
            let off = place(&followed).distance(place(&rest));
            assert!(off < 1e-3, "the leg misses its ankle by {off} m");
            let turned = followed.pose.rotation(leg.foot).angle_between(rest.pose.rotation(leg.foot));
            assert!(turned < 1e-2, "the foot is turned by {turned}");
            let carried = leading.carried_ankle(&asset.skeleton, leg) - place(&rest);
            assert!((carried + Vec3::Y * 0.1).length() < 1e-4, "the leg has its ankle {carried} from the foot");
        }
    }

    #[test]
    fn feet_that_hips_leave_behind_come_within_reach() {
        let asset = mannequin();
        let [leading, followed] = lifted(&asset, 0.3);
        for leg in &asset.legs {
            let [led, set] = [&leading, &followed].map(|pose| pose.pose.position(leg.foot));
            let reach = led.distance(leading.pose.position(leg.upper)) / leg.length();
            assert!((0.97..CLIP_EXTENSION.hard + 1e-4).contains(&reach), "the foot is {reach} of its leg away");
            // Legs stretch softly, too: a straight one keeps four thousandths back.
            let off = led.distance(set) / leg.length();
            assert!(off < 4e-3, "the leg misses its foot by {off} of its length");
        }
    }
}
