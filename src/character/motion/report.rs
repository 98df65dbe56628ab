//! What others see of a tick: a root that follows the ground smoothly, and [`MotionState`].

use bevy::prelude::*;

use super::{
    Ground, MotionState,
    body::MotionBody,
    slope::{rise_along, step_in},
    tick::Travelled,
};
use crate::{
    math::{rotation::wrap_angle, spring::Spring},
    rig::tuning::motion::MotionConfig,
};

/// Puts the root's level on the ground found and lets the root follow steps smoothly.
///
/// Gives the vertical way, in metres, that the root went on account of steps.
pub(super) fn follow_ground(body: &mut MotionBody, travelled: Travelled, config: &MotionConfig, dt: f32) -> f32 {
    let level = body.support.map_or(body.position.y, |support| support.level);
    let change = level - body.level;
    let step = match (travelled.before, body.support) {
        (Some(before), Some(after)) => step_in(change, before.normal, after.normal, travelled.way),
        _ => change - travelled.way.y,
    };
    body.level = level;
    if body.written.is_none() {
        return 0.0;
    }
    let most = config.step_up.max(config.step_down).max(0.0);
    let lag = (body.lag.value - step).clamp(-most, most);
    body.lag.value = lag;
    // No longer than the body takes to go its own radius, so that a sprint up the stairs isn't left a step behind.
    let pace = body.velocity.length().max(1e-3);
    body.lag.step(0.0, config.step_half_life.min(config.radius / pace), dt);
    body.lag.value - lag
}

/// Puts a body whose numbers went bad back to where it last was.
pub(super) fn refuse_nonsense(body: &mut MotionBody, me: Entity) {
    let sound = body.root().is_finite()
        && body.position.is_finite()
        && body.velocity.is_finite()
        && body.frame_velocity.is_finite()
        && body.yaw.value.is_finite()
        && body.yaw.velocity.is_finite();
    if sound {
        return;
    }
    warn_once!(
        "character {me} met numbers that are not finite and stopped; check its MotionConfig and the colliders around it"
    );
    let last = body.written.map_or(Vec3::ZERO, |written| written.translation);
    let yaw = body.written.map_or(0.0, |written| written.yaw);
    *body = MotionBody {
        position: last,
        level: last.y,
        yaw: Spring::at(yaw),
        written: body.written,
        crouched: body.crouched,
        ..default()
    };
}

/// Writes what the tick did into `state`.
pub(super) fn report(body: &MotionBody, state: &mut MotionState, dt: f32) {
    let rise = body.support.map_or(0.0, |support| rise_along(support.normal, body.velocity));
    let relative = body.velocity + Vec3::Y * rise;
    state.ground_velocity = relative;
    state.velocity = relative + body.frame_velocity;
    state.ground = body.support.map(|support| Ground {
        entity: support.collider,
        normal: support.normal,
        velocity: body.frame_velocity,
    });
    state.lands_on = body.descent.onto;
    state.air_time = if body.support.is_some() { 0.0 } else { state.air_time + dt };
    state.crouched = body.crouched;
    state.yaw_rate = match body.written {
        Some(written) if dt > 0.0 => wrap_angle(body.yaw.value - written.yaw) / dt,
        _ => 0.0,
    };
}
