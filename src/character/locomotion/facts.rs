//! What the state machine is told, and whether a condition holds then. Pure.

use bevy::math::Vec2;

use crate::rig::tuning::locomotion::{Condition, TransitionBlend};

/// What the machine must know of a clip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClipFacts {
    /// Seconds.
    pub duration: f32,
    /// Whether it starts over at its end.
    pub looping: bool,
    /// Ground that one cycle covers, metres; 0 for a clip that stays in place.
    pub stride: f32,
    /// Where it goes as the body sees it, radians from straight ahead, left positive.
    pub heading: f32,
}

/// The body, as motion has it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Facts<'a> {
    /// Horizontal speed over the ground, m/s.
    pub speed: f32,
    /// The same with its direction as the body sees it: to the right and ahead, m/s.
    pub velocity: Vec2,
    /// Rise over run of the way it goes.
    pub grade: f32,
    /// Whether it stands on ground.
    pub grounded: bool,
    /// Seconds in the air.
    pub air_time: f32,
    /// Downward speed, m/s.
    pub fall_speed: f32,
    /// Speed of the last landing, m/s.
    pub landing_speed: f32,
    /// Whether a jump began since the last frame.
    pub jumped: bool,
    /// Whether it crouches.
    pub crouched: bool,
    /// Whether what it faces is given, whatever way it goes.
    pub facing_locked: bool,
    /// Angle that it still has to turn, radians, left positive.
    pub turn_ahead: f32,
    /// Angle turned over the ground since the last frame, radians, left positive.
    pub turned: f32,
    /// Trigger names pulled since the last frame.
    pub triggers: &'a [String],
}

/// A transition taken in this frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taken {
    /// The state entered.
    pub to: usize,
    /// Seconds that it takes.
    pub fade: f32,
    /// How it looks.
    pub blend: TransitionBlend,
}

/// Where the machine is: what conditions ask of the state itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stay {
    /// Seconds in the state.
    pub(super) seconds: f32,
    /// Whether its clip has played to its end.
    pub(super) finished: bool,
}

/// Whether `condition` holds.
pub(super) fn holds(condition: &Condition, facts: &Facts<'_>, stay: Stay) -> bool {
    match condition {
        Condition::SpeedAbove(speed) => facts.speed > *speed,
        Condition::SpeedBelow(speed) => facts.speed < *speed,
        Condition::Grounded => facts.grounded,
        Condition::AirborneFor(seconds) => !facts.grounded && facts.air_time > *seconds,
        Condition::FallingFaster(speed) => facts.fall_speed > *speed,
        Condition::Jumped => facts.jumped,
        Condition::LandedFaster(speed) => facts.grounded && facts.landing_speed > *speed,
        Condition::FacingLocked => facts.facing_locked,
        Condition::FacingFree => !facts.facing_locked,
        Condition::TurnLeftAbove(angle) => facts.turn_ahead > *angle,
        Condition::TurnRightAbove(angle) => -facts.turn_ahead > *angle,
        Condition::TurnBelow(angle) => facts.turn_ahead.abs() < *angle,
        Condition::InStateFor(seconds) => stay.seconds > *seconds,
        Condition::Finished => stay.finished,
        Condition::Crouched => facts.crouched,
        Condition::Upright => !facts.crouched,
        Condition::Trigger(name) => facts.triggers.contains(name),
        Condition::All(all) => all.iter().all(|condition| holds(condition, facts, stay)),
    }
}
