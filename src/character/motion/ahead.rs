//! Where a tick looks: around the body, and where its next stride may land. World space, metres.

use bevy::prelude::*;

use super::{body::MotionBody, capsule::MotionShapes, heightfield::Span};
use crate::character::intent::MoveIntent;

/// Speeds below this, in m/s, neither turn a body nor have a stride.
pub(super) const TURNING_SPEED: f32 = 0.1;

/// Seconds in which a stride lands: so far ahead the way is looked at.
const STRIDE_SECONDS: f32 = 0.5;

/// Metres beyond what a tick is expected to need.
const LEEWAY: f32 = 0.1;

/// Where the next stride may land, world: a ray down from `start`.
pub(super) struct StrideAhead {
    pub(super) start: Vec3,
    pub(super) reach: f32,
    /// Metres away, horizontally.
    pub(super) distance: f32,
}

/// `None` for who stands still or flies.
pub(super) fn stride_ahead(body: &MotionBody, shapes: &MotionShapes, intent: &MoveIntent) -> Option<StrideAhead> {
    let wanted = intent.velocity.with_y(0.0);
    let way = if wanted == Vec3::ZERO { body.velocity.with_y(0.0) } else { wanted };
    let speed = way.length();
    if body.support.is_none() || speed < TURNING_SPEED {
        return None;
    }
    let distance = (STRIDE_SECONDS * speed).max(shapes.radius);
    let up = (shapes.step_up + distance).min(shapes.standing.height);
    let start = body.position.with_y(body.level + up) + way * (distance / speed);
    Some(StrideAhead { start, reach: up + shapes.step_up + distance, distance })
}

/// The region in which a tick of this body usually looks for what is around.
pub(super) fn region(body: &MotionBody, shapes: &MotionShapes, intent: &MoveIntent, dt: f32) -> Span {
    let way = (body.velocity.abs() + body.frame_velocity.abs()) * dt;
    let aside = Vec3::new(shapes.radius, 0.0, shapes.radius) + way + LEEWAY;
    let down = shapes.config.step_down.max(0.0) + shapes.radius;
    let low = body.position - aside - Vec3::Y * down;
    let high = body.position + aside + Vec3::Y * (shapes.step_up + shapes.standing.height);
    let Some(ahead) = stride_ahead(body, shapes, intent) else { return Span { least: low, most: high } };
    let (far, end) = (ahead.start + way + LEEWAY, ahead.start - way - LEEWAY - Vec3::Y * ahead.reach);
    Span { least: low.min(end), most: high.max(far) }
}
