//! How a foot turns to its ground. World space, radians.

use bevy::prelude::*;

use super::{foot::flat, surroundings::AnimatedFoot};
use crate::{
    math::rotation::{direction_or, from_scaled_axis, shortest_arc, to_scaled_axis},
    rig::tuning::foot_ik::FootIkConfig,
};

/// Takes toe-up pitch out of a foot, as far as `share` says.
pub(super) fn flattening(foot: &AnimatedFoot, share: f32) -> Quat {
    let sole = foot.ball - foot.heel;
    if share <= 0.0 || sole.y <= 0.0 {
        return Quat::IDENTITY;
    }
    from_scaled_axis(to_scaled_axis(shortest_arc(sole, flat(sole))) * share)
}

/// Turn from upright to the ground's normal, within the foot's limits of pitch and roll.
pub(super) fn limited_align(normal: Vec3, forward: Vec3, config: &FootIkConfig) -> Quat {
    let align = shortest_arc(Vec3::Y, normal);
    let forward = direction_or(flat(forward), Vec3::NEG_Z);
    let side = forward.cross(Vec3::Y);
    let turn = to_scaled_axis(align);
    let (pitch, roll) = (turn.dot(side), turn.dot(forward));
    if pitch.abs() <= config.pitch_limit && roll.abs() <= config.roll_limit {
        return align;
    }
    let pitch = pitch.clamp(-config.pitch_limit, config.pitch_limit);
    let roll = roll.clamp(-config.roll_limit, config.roll_limit);
    from_scaled_axis(side * pitch + forward * roll)
}
