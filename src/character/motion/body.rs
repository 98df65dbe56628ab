//! What the controller carries from tick to tick.

use bevy::prelude::*;

use super::{descent::Descent, footing::Support, frame::Frame, glide::Line, jump::JumpMemory};
use crate::math::spring::Spring;

/// The physical body, as opposed to the root that is shown: the capsule touches the ground to the last
/// bit and climbs a stair at once, the root stands between the feet and follows smoothly.
#[derive(Component, Clone, Debug)]
pub(super) struct MotionBody {
    /// The capsule's lowest point, world.
    pub(super) position: Vec3,
    /// Height at which the root shall stand: on the ground, or at the capsule's lowest point in the air. World, metres.
    pub(super) level: f32,
    /// How far the root still is above `level`, metres.
    pub(super) lag: Spring<f32>,
    /// Heading about +Y, radians.
    pub(super) yaw: Spring<f32>,
    /// Velocity relative to `frame_velocity`, m/s; horizontal while on the ground.
    pub(super) velocity: Vec3,
    /// Velocity of the ground stood on, or last stood on, m/s.
    pub(super) frame_velocity: Vec3,
    pub(super) descent: Descent,
    /// The ground stood on.
    pub(super) support: Option<Support>,
    /// Rise over run to where the next stride may land; the same or that of the ground below, smoothed.
    pub(super) ahead: f32,
    pub(super) grade: f32,
    /// The rigid body stood on, or last stood on.
    pub(super) ground: Option<Entity>,
    /// Where on that body the character stands.
    pub(super) anchor: Option<Anchor>,
    /// The root as last written, to notice when someone else moved it; `None` before the first tick.
    pub(super) written: Option<Written>,
    /// The root as last shown on the frame clock, to notice when someone moves it between ticks.
    pub(super) shown: Option<Transform>,
    pub(super) jump: JumpMemory,
    /// Whether the character rises by a jump of its own.
    pub(super) jumping: bool,
    pub(super) crouched: bool,
    /// Whether the root is to be written.
    pub(super) moved: bool,
    /// Whether the collider that others meet has to change.
    pub(super) reshaped: bool,
    /// Whether this tick put the root elsewhere instead of moving it there.
    pub(super) jumped_place: bool,
    /// Ticks for which to look whether the capsule stands in something that doesn't move.
    pub(super) checks: u8,
    /// Seconds for which it could neither fall nor stand.
    pub(super) wedged: f32,
    /// What it may follow without looking.
    pub(super) line: Option<Line>,
    /// What this tick pushes.
    pub(super) pushes: Vec<Push>,
}

impl Default for MotionBody {
    fn default() -> Self {
        Self {
            position: Vec3::ZERO,
            level: 0.0,
            lag: Spring::at(0.0),
            yaw: Spring::at(0.0),
            velocity: Vec3::ZERO,
            frame_velocity: Vec3::ZERO,
            descent: Descent::default(),
            ahead: 0.0,
            grade: 0.0,
            support: None,
            ground: None,
            anchor: None,
            written: None,
            shown: None,
            jump: JumpMemory::default(),
            jumping: false,
            crouched: false,
            moved: false,
            reshaped: true,
            jumped_place: false,
            // The first physics step may come after the first tick; until then nothing is met.
            checks: 4,
            wedged: 0.0,
            line: None,
            pushes: Vec::new(),
        }
    }
}

impl MotionBody {
    /// The root: the ground point between the feet, as shown.
    pub(super) fn root(&self) -> Vec3 {
        Vec3::new(self.position.x, self.level + self.lag.value, self.position.z)
    }

    /// Has the root written where the body is now.
    pub(super) fn write(&mut self) {
        self.written = Some(Written { translation: self.root(), yaw: self.yaw.value });
        self.moved = true;
    }

    /// Moves everything by a world offset.
    pub(super) fn shift(&mut self, by: Vec3) {
        self.position += by;
        self.level += by.y;
    }
}

/// A place on a body, kept while standing there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    /// The rigid body.
    pub(super) body: Entity,
    /// Where the body was expected to be when the tick ended.
    pub(super) expected: Frame,
    /// The capsule's lowest point in the body's frame.
    pub(super) local: Vec3,
}

/// The root as the controller left it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Written {
    pub(super) translation: Vec3,
    pub(super) yaw: f32,
}

/// An impulse that the character gives to a dynamic body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Push {
    pub(super) body: Entity,
    /// World point of contact.
    pub(super) point: Vec3,
    /// N·s.
    pub(super) impulse: Vec3,
}
