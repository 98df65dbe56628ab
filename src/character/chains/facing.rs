//! How a chain's tip is turned once it is there: a palm that lies on what the hand touches.

use bevy::{math::Affine3A, prelude::*};

use super::bound::Bound;
use crate::{
    anim::ik::chain::ChainJoint,
    math::rotation::{direction_or, from_scaled_axis, shortest_arc, to_scaled_axis},
};

/// Passes of turning the tip and reaching anew: what the one changes for the other shrinks about tenfold in each.
pub(super) const PASSES: usize = 4;

/// How a chain's tip is turned. The solver [`Aim`](super::Solver::Aim) turns it by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TipFacing {
    /// What of the tip faces: a direction in model space, when the character is in its rest pose. The palm of a hand held
    /// out to the side looks down.
    pub side: Vec3,
    /// Where it faces, in the world.
    pub toward: Vec3,
    /// Most that the tip is turned for it from how the chain carries it, radians.
    pub most: f32,
}

impl Bound {
    /// The tip's rotation against its parent that turns it as `facing` says on the joints as they were solved.
    /// `chain_from_world` leads into the space of the chain's first joint, `carried` is the tip's rotation as animated.
    pub(super) fn faced(&self, facing: &TipFacing, chain_from_world: &Affine3A, carried: Quat) -> Quat {
        let above = self.joints.iter().fold(Quat::IDENTITY, |above, joint: &ChainJoint| above * joint.local.rotation);
        let tip = above * carried;
        let toward = chain_from_world.transform_vector3(facing.toward);
        let turn = to_scaled_axis(shortest_arc(tip * self.side, direction_or(toward, Vec3::ZERO)));
        let turn = from_scaled_axis(turn.clamp_length_max(facing.most.max(0.0)));
        (above.inverse() * turn * tip).normalize()
    }
}
