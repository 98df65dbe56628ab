//! What a foot is given in a frame, and what it gives back. World space, metres.

use bevy::prelude::*;

use super::{
    foot::Pivot,
    ground::{Plane, Reach, SoleShape},
};
use crate::rig::tuning::foot_ik::FootIkConfig;

/// The sole as the clip has it, in world space on the character's own floor plane.
#[derive(Clone, Copy, Debug)]
pub struct AnimatedFoot {
    /// Ankle joint, its stride warped to the ground speed.
    pub ankle: Vec3,
    /// Ankle joint as the clip has it.
    pub clip_ankle: Vec3,
    /// Under the heel.
    pub heel: Vec3,
    /// Under the ball.
    pub ball: Vec3,
    /// Under the toes' tip.
    pub tip: Vec3,
    /// The floor plane's height.
    pub floor: f32,
    /// Direction that the foot points to.
    pub forward: Vec3,
    /// How surely the clip has this foot on the ground, 0..1.
    pub contact: f32,
    /// Seconds until it lands, while it swings.
    pub time_to_contact: f32,
    /// Share of its swing that has passed, 0..1; 1 on the ground.
    pub swing: f32,
    /// Where its ball lands if the body keeps its course, world; the height doesn't matter.
    pub landing: Vec3,
    /// Direction that it points to when it lands.
    pub landing_forward: Vec3,
}

impl AnimatedFoot {
    /// The point of the sole that a lock of this kind holds.
    #[must_use]
    pub fn point(&self, pivot: Pivot) -> Vec3 {
        match pivot {
            Pivot::Heel => self.heel,
            Pivot::Ball => self.ball,
            Pivot::Tip => self.tip,
        }
    }
}

impl AnimatedFoot {
    /// Metres of the sole's lowest point over the floor plane; negative where blended clips sink into it.
    #[must_use]
    pub fn lowest(&self) -> f32 {
        self.heel.y.min(self.ball.y).min(self.tip.y) - self.floor
    }
}

/// Where the ground entity is.
pub trait GroundFrames {
    /// Position and rotation of a ground entity; `None` once it is gone.
    fn frame(&self, entity: Entity) -> Option<Isometry3d>;
}

/// What surrounds one foot in one frame.
pub struct Surroundings<'a, P, G> {
    /// Casts into the ground.
    pub probe: &'a P,
    /// Frames of what moves.
    pub frames: &'a G,
    /// Heights to look between.
    pub reach: Reach,
    /// The sole's shape.
    pub sole: SoleShape,
    /// Tuning, already scaled to the leg.
    pub config: &'a FootIkConfig,
    /// Length of the leg as a factor on the mannequin's: all lengths go with it.
    pub size: f32,
    /// Seconds since the last frame.
    pub dt: f32,
    /// By what the other foot holds the ground; `None` while it is in the air.
    pub other: Option<Pivot>,
    /// World height of the ground that the other foot stands on, if it still does when this one lands.
    pub level: Option<f32>,
    /// Whether what plays from now on doesn't step: feet in the air come down by themselves.
    pub halts: bool,
    /// Whether the character stands, so that the foot may correct its place.
    pub may_restep: bool,
}

/// Where the foot shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedFoot {
    /// Ankle joint, world.
    pub ankle: Vec3,
    /// Turn of the foot joint's animated world rotation: `new = turn * animated`.
    pub turn: Quat,
    /// Heel, ball and tip of the placed sole, world.
    pub sole: [Vec3; 3],
    /// The plane that it is placed on.
    pub plane: Plane,
    /// Where the ball stands on the ground, or stood when it left.
    pub takeoff: Vec3,
    /// Where the ball will land, world, and in how many seconds, while the foot is in the air.
    pub landing: Option<(Vec3, f32)>,
}
