//! Going on as before without looking: what a body that nobody watches closely does between two looks.
//!
//! A tick that looks sees whether the way ahead is free and where its ground ends; the ticks after it follow that line as long
//! as nothing else is asked for. World space, metres.

use bevy::prelude::*;

use super::{
    MotionState,
    body::MotionBody,
    heightfield::Span,
    report::{follow_ground, report},
    slope::{limit_cos, walkable},
    speed::{approach_velocity, speed_rates},
    tick::{ROUNDING, STEEPEST, Tick, Travelled},
};
use crate::{
    character::intent::MoveIntent,
    math::rotation::{from_scaled_axis, twist_angle},
};

/// How long the controller may go on without looking where it goes.
///
/// In between, the body goes on at its pace over the ground that it saw ahead: other bodies that come its way meanwhile are
/// noticed late, and small bumps are cut. It looks at once when its intent changes, and in every tick where it isn't
/// moving steadily over one body that doesn't move. Level of detail sets it.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component)]
pub struct Glide {
    /// Seconds between two looks, at most. 0, or no component: it looks in every tick. Default 0.
    pub seconds: f32,
    /// Whether the root stays behind in between and makes up for it when it looks again: for who isn't seen, since others
    /// then need not be told in every tick where it is. Default false.
    pub hops: bool,
}

/// The line that a body follows.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// What was asked for when it was seen.
    intent: MoveIntent,
    /// The velocity that it is followed with, as soon as that is reached.
    wanted: Vec3,
    /// It can't go on: it stands at once.
    waits: bool,
    /// Seconds for which it was seen free.
    left: f32,
    /// Seconds for which it was followed without moving the body.
    owed: f32,
    /// Its rise over its run.
    rise: f32,
}

/// Acceleration in m/s² up to which a body goes on as it did.
const STEADY: f32 = 5.0;
/// Difference in m/s from the velocity that it would have by itself up to which nothing hinders a body.
const UNHINDERED: f32 = 0.01;
/// Share of the time between two looks for which somebody waits whom something holds up.
const PAUSE: f32 = 0.3;
/// Metres about a line in which a look along it searches.
const AROUND: f32 = 0.2;
/// Ways shorter than this, in metres, are none.
const STANDING: f32 = 1e-3;
/// Turn in radians by which others may have turned the root unnoticed.
const TURNED: f32 = 5e-3;

impl Tick<'_> {
    /// The line ahead for `seconds`, after a tick that looked and began with the velocity `before`; `None` where the body has to
    /// look again.
    pub(super) fn line_ahead(&self, body: &MotionBody, before: Vec3, (seconds, hops): (f32, bool)) -> Option<Line> {
        let support = body.support.filter(|_| seconds > self.dt && body.checks == 0 && !self.intent.jump)?;
        let wanted = self.wanted_ahead(body, before).filter(|_| body.frame_velocity == Vec3::ZERO)?;
        if self.intent.crouch != body.crouched || !self.rests(support.collider) {
            return None;
        }
        let way = self.way_ahead(body.velocity, wanted, seconds);
        let run = way.length();
        let line =
            |left: f32, rise: f32| Line { intent: self.intent.clone(), wanted, waits: false, left, owed: 0.0, rise };
        if run < STANDING {
            return Some(line(seconds, 0.0));
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
        // What is ahead comes nearer no sooner than at full speed.
        let free = self.view.sweep(self.shape(body), body.position, way).map_or(seconds, |hit| {
            let fastest = wanted.length().max(body.velocity.length()) * way.length() / run;
            seconds.min(hit.safe / fastest)
        });
        // Who can't go on tries again a little later; who isn't seen, after a while.
        let pause = if hops { seconds } else { seconds * PAUSE };
        let waits = || Line { wanted: Vec3::ZERO, waits: true, ..line(pause, 0.0) };
        if free > self.dt { Some(line(free, rise)) } else { (pause > self.dt).then(waits) }
    }

    /// Where the look along the line of `seconds` will probably go; the body's place alone for none.
    pub(super) fn span_ahead(&self, body: &MotionBody, seconds: f32) -> Span {
        if seconds <= self.dt {
            return Span::between(body.position, body.position);
        }
        let way = self.way_ahead(body.velocity, self.wanted_velocity(body), seconds + self.dt);
        let run = way.length() + self.shapes.step_up;
        let about = Vec3::splat(self.shapes.radius + AROUND);
        let Span { least, most } = Span::between(body.position, body.position + way);
        Span {
            least: least - about.with_y(run + about.y),
            most: most + about.with_y(run + self.shapes.standing.height),
        }
    }

    /// The velocity that the body goes toward unhindered, or goes at; `None` where it is held up.
    fn wanted_ahead(&self, body: &MotionBody, before: Vec3) -> Option<Vec3> {
        let wanted = self.wanted_velocity(body);
        let free = approach_velocity(before, wanted, speed_rates(self.config), self.dt);
        let steady = body.velocity.distance(before) <= STEADY * self.dt;
        let unhindered = body.velocity.distance(free) <= UNHINDERED;
        if unhindered { Some(wanted) } else { steady.then_some(body.velocity) }
    }

    /// The way that it goes in so many seconds.
    fn way_ahead(&self, velocity: Vec3, wanted: Vec3, seconds: f32) -> Vec3 {
        let speeding = (velocity.distance(wanted) / self.config.acceleration.max(1e-3)).min(seconds);
        let then = approach_velocity(velocity, wanted, speed_rates(self.config), speeding);
        (velocity + then) * (0.5 * speeding) + then * (seconds - speeding)
    }

    /// Whether the ground is there and doesn't move.
    fn rests(&self, collider: Entity) -> bool {
        self.view.body(collider, self.dt).is_some_and(|ground| ground.now == ground.next && !ground.dynamic)
    }

    /// Whether the body may go on along the line that it saw.
    pub(super) fn may_glide(&self, body: &MotionBody) -> bool {
        let seen = body.line.as_ref().is_some_and(|line| line.left >= self.dt && line.intent == self.intent);
        let support = body.support.filter(|_| seen && body.checks == 0 && self.is_where_it_was_put(body));
        support.is_some_and(|support| self.rests(support.collider))
    }

    /// Whether nobody else moved the root; false also where it isn't finite.
    fn is_where_it_was_put(&self, body: &MotionBody) -> bool {
        body.written.is_some_and(|written| {
            let moved = self.transform.translation.distance(written.translation);
            let turned = (twist_angle(self.transform.rotation, Vec3::Y) - written.yaw).abs();
            moved <= ROUNDING && turned <= TURNED
        })
    }

    /// Goes on along the line; `hops` leaves the way for later.
    pub(super) fn glide(&self, body: &mut MotionBody, state: &mut MotionState, hops: bool) {
        body.pushes.clear();
        body.jumped_place = false;
        let Some(line) = &mut body.line else { return };
        line.left -= self.dt;
        line.owed += self.dt;
        if !hops {
            self.make_up(body, state);
        }
    }

    /// Goes the way that the body still owes, and tells where its root is then; `None` where it owes none, and where someone else
    /// has put it elsewhere.
    pub(super) fn catch_up(&self, body: &mut MotionBody, state: &mut MotionState) -> Option<Transform> {
        body.line.as_ref().filter(|line| line.owed > 0.0)?;
        if !self.is_where_it_was_put(body) {
            return None;
        }
        self.make_up(body, state);
        let facing = from_scaled_axis(Vec3::Y * body.yaw.value);
        Some(self.transform.with_translation(body.root()).with_rotation(facing))
    }

    fn make_up(&self, body: &mut MotionBody, state: &mut MotionState) {
        let (Some(line), Some(mut support)) = (&mut body.line, body.support) else { return };
        let (dt, rise, wanted) = (core::mem::take(&mut line.owed), line.rise, line.wanted);
        if line.waits {
            body.velocity = Vec3::ZERO;
        }
        self.turn(body, state, dt);
        let way = self.way_ahead(body.velocity, wanted, dt);
        body.velocity = approach_velocity(body.velocity, wanted, speed_rates(self.config), dt);
        let whole = way + Vec3::Y * (rise * way.length());
        body.position += whole;
        support.height += whole.y;
        support.level += whole.y;
        support.point += whole;
        let travelled = Travelled { before: body.support.replace(support), way };
        state.stepped += follow_ground(body, travelled, self.config, dt);
        if let Some(anchor) = &mut body.anchor {
            anchor.local = anchor.expected.local(body.position);
        }
        report(body, state, dt);
        body.write();
    }
}
