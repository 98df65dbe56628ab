//! Feet in the air: as the clips have them; and the moment before they land, when the legs begin to bend.

use bevy::prelude::*;

use super::{FootIk, body::Body, soften::Limits, surroundings::AnimatedFoot};
use crate::character::{
    animator::CharacterPose,
    legs::{LegResult, keeping_feet},
};

impl FootIk {
    /// Leaves the pose as it is, and keeps up with it.
    pub(super) fn fly_free(&mut self, body: &Body<'_>, pose: &mut CharacterPose, animated: &[AnimatedFoot; 2]) {
        pose.set_legs(body.asset);
        self.pelvis.fly_free(body.hips(pose), body.dt);
        self.follow_clips(body, pose, animated);
    }

    /// The root slows just above `ground` (world height) and its feet with it; the body falls on, so that legs bend.
    pub(super) fn come_down(
        &mut self,
        body: &Body<'_>,
        pose: &mut CharacterPose,
        animated: &[AnimatedFoot; 2],
        ground: f32,
    ) {
        pose.set_legs(body.asset);
        let offset = self.pelvis.fall_on(body.hips(pose), ground, body.asset.leg_length, body.dt);
        let asset = body.asset;
        keeping_feet(&mut pose.pose, &asset.skeleton, &asset.legs, |pose| {
            pose.shift_model(&asset.skeleton, asset.hips, Vec3::Y * offset);
        });
        self.weight = 0.0;
        self.follow_clips(body, pose, animated);
    }

    fn follow_clips(&mut self, body: &Body<'_>, pose: &mut CharacterPose, animated: &[AnimatedFoot; 2]) {
        self.placed = [None; 2];
        self.legs = [LegResult::default(); 2];
        for ((foot, animated), leg) in self.feet.iter_mut().zip(animated).zip(&body.asset.legs) {
            foot.fly_free(animated, body.dt);
            foot.pace.note(&pose.pose, leg, body.dt);
            foot.soften.keep(&mut pose.pose, &body.asset.skeleton, leg, Limits::NONE, body.dt);
        }
    }
}
