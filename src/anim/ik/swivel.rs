//! Turns a whole chain about the line from its root to its end, so that its middle points toward a pole.

use bevy::math::{Vec3, ops};

use super::{
    chain::{ChainJoint, end},
    limits::Limit,
};
use crate::math::rotation::{direction_or, from_scaled_axis};

/// Parts of the distance between root and end: a middle that is this near to the line between them has no side to turn to
/// the pole, and from the second one on it turns in full.
const STRAIGHT: (f32, f32) = (0.01, 0.05);
/// Times that the turn is halved in search of the most that a limit allows.
const HALVINGS: u32 = 6;

/// Turns the first joint so that joint `middle` comes into the half plane of root, end and `pole` (chain space), as far
/// as the first joint's limit allows; the end stays where it is.
pub fn toward(joints: &mut [ChainJoint], effector: Vec3, middle: usize, pole: Vec3) {
    let (Some(first), Some(bend)) = (joints.first().copied(), joints.get(1..middle + 1)) else { return };
    if bend.is_empty() || !pole.is_finite() || matches!(first.limit, Limit::Fixed | Limit::Hinge { .. }) {
        return;
    }
    let root = first.local.translation;
    let knee = end(&joints[..middle], joints[middle].local.translation) - root;
    let way = end(joints, effector) - root;
    let axis = direction_or(way, Vec3::ZERO);
    let (from, to) = (knee.reject_from(axis), (pole - root).reject_from(axis));
    let off = from.length() / way.length();
    let share = ((off - STRAIGHT.0) / (STRAIGHT.1 - STRAIGHT.0)).clamp(0.0, 1.0);
    let angle = ops::atan2(axis.dot(from.cross(to)), from.dot(to)) * share;
    if !angle.is_finite() || axis == Vec3::ZERO {
        return;
    }
    let turned = |part: f32| {
        let mut joint = first;
        joint.local.rotation = (from_scaled_axis(axis * (angle * part)) * first.local.rotation).normalize();
        joint
    };
    let allowed = |part: f32| turned(part).excess() <= first.excess() + 1e-5;
    let mut part = if allowed(1.0) { 1.0 } else { 0.0 };
    for halving in 1..=HALVINGS {
        let further = part + ops::exp2(-(halving as f32));
        if further < 1.0 && allowed(further) {
            part = further;
        }
    }
    joints[0] = turned(part);
}
