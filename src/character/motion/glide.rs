//! Going on as before without looking: what a body that nobody watches closely does between two looks.
//!
//! A tick that looks sees whether the way ahead is free and where its ground ends; the ticks after it follow that line as long
//! as nothing else is asked for. World space, metres.

use bevy::prelude::*;

use super::{
    MotionState,
    body::{MotionBody, Written},
    report::{follow_ground, report},
    slope::{limit_cos, walkable},
    tick::{ROUNDING, STEEPEST, Tick, Travelled},
};
use crate::{character::intent::MoveIntent, math::rotation::twist_angle};

/// For how many seconds the controller may go on without looking where it goes. 0, or no component: it looks in every tick.
///
/// In between, the body goes on at its pace over the ground that it saw ahead: other bodies that come its way meanwhile are
/// noticed late, and small bumps are cut. It looks at once when its intent changes, and in every tick where it isn't
/// moving steadily over one body that doesn't move. Level of detail sets it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component)]
pub struct Glide(pub f32);

/// The line that a body follows.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// What was asked for when it was seen.
    intent: MoveIntent,
    /// Seconds for which it was seen free.
    left: f32,
    /// Its rise over its run.
    rise: f32,
}

/// Acceleration in m/s² up to which a body goes on as it did.
const STEADY: f32 = 5.0;
/// Ways shorter than this, in metres, are none.
const STANDING: f32 = 1e-3;
/// Turn in radians by which others may have turned the root unnoticed.
const TURNED: f32 = 5e-3;

impl Tick<'_> {
    /// The line ahead for `seconds`, after a tick that looked and began with the velocity `before`; `None` where the body has to
    /// look again.
    pub(super) fn line_ahead(&self, body: &MotionBody, before: Vec3, seconds: f32) -> Option<Line> {
        let support = body.support.filter(|_| seconds > self.dt && body.checks == 0 && !self.intent.jump)?;
        let steady = body.velocity.distance(before) <= STEADY * self.dt && body.frame_velocity == Vec3::ZERO;
        if !steady || self.intent.crouch != body.crouched || !self.rests(support.collider) {
            return None;
        }
        let way = body.velocity * seconds;
        let run = way.length();
        let line = |rise: f32| Line { intent: self.intent.clone(), left: seconds, rise };
        if run < STANDING {
            return Some(line(0.0));
        }
        let up = self.shapes.step_up + run;
        let start = (body.position + way).with_y(body.level + up);
        let floor = self.view.floor(start, Dir3::NEG_Y, up + self.shapes.step_up + run)?;
        let rise = (floor.height - body.level) / run;
        let same = floor.collider == support.collider && walkable(floor.normal, limit_cos(self.config.slope_limit));
        if !same || rise.abs() > STEEPEST {
            return None;
        }
        let way = way + Vec3::Y * (rise * run);
        let met = self.view.sweep(self.shape(body), body.position, way);
        met.is_none_or(|hit| hit.safe >= way.length()).then(|| line(rise))
    }

    /// Whether the ground is there and doesn't move.
    fn rests(&self, collider: Entity) -> bool {
        self.view.body(collider, self.dt).is_some_and(|ground| ground.now == ground.next && !ground.dynamic)
    }

    /// Goes on along the line that was seen, if that may be done; else gives false and does nothing.
    pub(super) fn glides(&self, body: &mut MotionBody, state: &mut MotionState) -> bool {
        if body.checks > 0 {
            return false;
        }
        let Some(line) = body.line.as_mut().filter(|line| line.left >= self.dt && line.intent == self.intent) else {
            return false;
        };
        let (Some(written), Some(mut support)) = (body.written, body.support) else { return false };
        let moved = self.transform.translation.distance(written.translation);
        let turned = (twist_angle(self.transform.rotation, Vec3::Y) - written.yaw).abs();
        // Also where either isn't a number.
        if !(moved <= ROUNDING && turned <= TURNED && self.rests(support.collider)) {
            return false;
        }
        line.left -= self.dt;
        let rise = line.rise;
        body.pushes.clear();
        body.jumped_place = false;
        self.turn(body, state);
        let way = body.velocity * self.dt;
        let whole = way + Vec3::Y * (rise * way.length());
        body.position += whole;
        support.height += whole.y;
        support.level += whole.y;
        support.point += whole;
        let travelled = Travelled { before: body.support.replace(support), way };
        state.stepped += follow_ground(body, travelled, self.config, self.dt);
        if let Some(anchor) = &mut body.anchor {
            anchor.local = anchor.expected.local(body.position);
        }
        report(body, state, self.dt);
        body.written = Some(Written { translation: body.root(), yaw: body.yaw.value });
        true
    }
}
