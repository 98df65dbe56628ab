//! The shapes a character collides with: built once, cloned by pointer, cast every tick.

use avian3d::prelude::Collider;
use bevy::prelude::*;

use crate::rig::tuning::motion::MotionConfig;

/// How much thinner the ball that looks for ground is than the capsule, as a fraction of its radius.
///
/// Thinner, so that a wall the capsule slides along is not mistaken for ground.
const FOOT_SLIMMER: f32 = 0.06;

/// The shapes of one posture. Their origin is the capsule's lowest point, the ground under an upright body.
#[derive(Clone, Debug)]
pub(super) struct Posture {
    /// The whole capsule, which others collide with and which flies.
    pub(super) whole: Collider,
    /// The capsule above step height, which walks: what it doesn't meet can be stepped on.
    pub(super) raised: Collider,
    /// Metres from the ground to the top.
    pub(super) height: f32,
}

/// All shapes of a character, and the lengths they were built from.
#[derive(Component, Clone, Debug)]
pub(super) struct MotionShapes {
    pub(super) standing: Posture,
    pub(super) crouched: Posture,
    /// The ball that looks for ground; its origin is its centre.
    pub(super) foot: Collider,
    /// The ball's radius, metres.
    pub(super) foot_radius: f32,
    /// The capsule's radius, metres.
    pub(super) radius: f32,
    /// Highest step, metres; the raised capsules begin there.
    pub(super) step_up: f32,
}

impl Default for MotionShapes {
    fn default() -> Self {
        Self::new(&MotionConfig::default())
    }
}

impl MotionShapes {
    /// The shapes for a config. Lengths that make no capsule give the nearest that do.
    pub(super) fn new(config: &MotionConfig) -> Self {
        let sane = |length: f32, fallback: f32| if length.is_finite() { length } else { fallback };
        let radius = sane(config.radius, 0.28).clamp(0.02, 10.0);
        let crouch_height = sane(config.crouch_height, 1.2).clamp(2.0 * radius, 100.0);
        let height = sane(config.height, 1.8).clamp(crouch_height, 100.0);
        let step_up = sane(config.step_up, 0.35).clamp(0.0, crouch_height - 2.0 * radius);
        let foot_radius = radius * (1.0 - FOOT_SLIMMER);
        let posture = |height: f32| Posture {
            whole: upright(radius, 0.0, height),
            raised: upright(radius, step_up, height),
            height,
        };
        Self {
            standing: posture(height),
            crouched: posture(crouch_height),
            foot: Collider::sphere(foot_radius),
            foot_radius,
            radius,
            step_up,
        }
    }

    /// The shapes of the posture.
    pub(super) fn posture(&self, crouched: bool) -> &Posture {
        if crouched { &self.crouched } else { &self.standing }
    }
}

/// A capsule from `bottom` to `top`, measured from its origin along +Y.
fn upright(radius: f32, bottom: f32, top: f32) -> Collider {
    let low = bottom + radius;
    // Two centres on one spot have no axis; a hair apart they have.
    let high = (top - radius).max(low + 1e-3);
    Collider::capsule_endpoints(radius, Vec3::Y * low, Vec3::Y * high)
}
