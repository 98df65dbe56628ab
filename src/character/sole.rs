//! Heel, ball and toe tip of a foot in a pose.

use bevy::prelude::*;

use crate::anim::{leg::Leg, pose::Pose};

/// Under the heel, under the ball, under the toes' tip: model space, metres.
#[must_use]
pub fn sole_model(pose: &Pose, leg: &Leg) -> [Vec3; 3] {
    [leg.heel.position(pose), leg.ball.position(pose), leg.tip.position(pose)]
}
