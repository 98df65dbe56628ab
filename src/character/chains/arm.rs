//! A human arm as a chain.

use bevy::math::Vec3;

use super::{ChainJointSetup, IkChain, RestLimit};
use crate::{
    anim::leg::LEFT,
    rig::humanoid::HumanoidRole::{
        self, LeftHand, LeftLowerArm, LeftUpperArm, RightHand, RightLowerArm, RightUpperArm,
    },
};

/// Radians between an upper arm and where it points in a T-pose: 115°; arms reach down, forward and some way across.
const SHOULDER_SWING: f32 = 2.0;
/// Radians that an upper arm turns about itself, either way: 90°.
const SHOULDER_TWIST: f32 = 1.6;
/// Greatest bend of an elbow in radians: 145°.
const ELBOW: f32 = 2.53;

impl IkChain {
    /// A human arm, from upper arm to hand, by cyclic coordinate descent: a shoulder within its cone, an elbow that bends
    /// forward only. `side` is [`LEFT`] or [`RIGHT`](crate::anim::leg::RIGHT); limits are those of a rig at rest in a
    /// T-pose.
    #[must_use]
    pub fn arm(side: usize) -> Self {
        let ([upper, lower, hand], outward): ([HumanoidRole; 3], _) = if side == LEFT {
            ([LeftUpperArm, LeftLowerArm, LeftHand], -1.0)
        } else {
            ([RightUpperArm, RightLowerArm, RightHand], 1.0)
        };
        let shoulder = RestLimit::Cone { swing: SHOULDER_SWING, twist: [-SHOULDER_TWIST, SHOULDER_TWIST] };
        let elbow = RestLimit::Hinge { axis: Vec3::Y * outward, min: 0.0, max: ELBOW };
        Self::ccd(upper, hand)
            .with_joint(ChainJointSetup::new(upper, shoulder))
            .with_joint(ChainJointSetup::new(lower, elbow))
    }
}
