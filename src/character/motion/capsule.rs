//! The shapes a character collides with: built once, cloned by pointer, cast every tick.

use std::{
    ops::Deref,
    sync::{Arc, LazyLock},
};

use avian3d::prelude::Collider;
use bevy::prelude::*;

use crate::rig::tuning::motion::MotionConfig;

/// How much thinner the ball that looks for ground is than the capsule, as a fraction of its radius.
///
/// Thinner, so that a wall the capsule slides along is not mistaken for ground.
const FOOT_SLIMMER: f32 = 0.06;

/// Least height of the raised capsule above the ground, as a fraction of its radius.
const LEAST_STEP: f32 = 0.6;

/// The shapes of one posture. Their origin is the capsule's lowest point, the ground under an upright body.
#[derive(Clone, Debug)]
pub(super) struct Posture {
    /// The whole capsule, which others collide with.
    pub(super) whole: Collider,
    /// The whole capsule as thin as the ball that looks for ground, which flies: it leaves an edge just where the ball does.
    pub(super) flying: Collider,
    /// The capsule above step height, which walks: what it doesn't meet can be stepped on.
    pub(super) raised: Collider,
    /// Metres from the ground to the top.
    pub(super) height: f32,
}

/// The shapes of a character: those of all others that are tuned alike.
#[derive(Component, Clone, Debug)]
pub(super) struct MotionShapes(Arc<Shapes>);

/// All shapes of a character, and the lengths they were built from.
#[derive(Debug)]
pub(super) struct Shapes {
    /// The tuning, with what is out of range mended.
    pub(super) config: MotionConfig,
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

/// The default tuning's, which every character has for a moment.
static DEFAULT: LazyLock<MotionShapes> = LazyLock::new(|| MotionShapes::new(MotionConfig::default().mended()));

impl Default for MotionShapes {
    fn default() -> Self {
        DEFAULT.clone()
    }
}

impl Deref for MotionShapes {
    type Target = Shapes;

    fn deref(&self) -> &Shapes {
        &self.0
    }
}

/// Shapes that were made.
#[derive(Debug, Default)]
pub(super) struct KnownShapes(Vec<MotionShapes>);

impl KnownShapes {
    /// The shapes for a config, made only if nobody is tuned so.
    pub(super) fn of(&mut self, config: &MotionConfig) -> MotionShapes {
        let config = config.mended();
        if let Some(known) = self.0.iter().find(|known| known.config == config) {
            return known.clone();
        }
        self.0.retain(|known| Arc::strong_count(&known.0) > 1);
        let shapes = MotionShapes::new(config);
        self.0.push(shapes.clone());
        shapes
    }
}

impl MotionShapes {
    /// The shapes for a mended config. Lengths that make no capsule give the nearest that do.
    fn new(config: MotionConfig) -> Self {
        let radius = config.radius;
        // Less would make walls of slopes, which rise under the body by as much as it goes.
        let least = (LEAST_STEP * radius).min(config.crouch_height - 2.0 * radius);
        let step_up = config.step_up.max(least);
        let foot_radius = radius * (1.0 - FOOT_SLIMMER);
        let posture = |height: f32| Posture {
            whole: upright(radius, 0.0, height),
            flying: upright(foot_radius, 0.0, height),
            raised: upright(radius, step_up, height),
            height,
        };
        Self(Arc::new(Shapes {
            standing: posture(config.height),
            crouched: posture(config.crouch_height),
            foot: Collider::sphere(foot_radius),
            foot_radius,
            radius,
            step_up,
            config,
        }))
    }
}

impl Shapes {
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
