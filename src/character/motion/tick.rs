//! One character's tick, stage by stage: where it is, where it wants to go, how it gets there, what that was.

use avian3d::prelude::Collider;
use bevy::prelude::*;

use super::{
    MotionState,
    ahead::{StrideAhead, TURNING_SPEED, stride_ahead},
    body::{Anchor, MotionBody, Push},
    capsule::MotionShapes,
    fly::{air_velocity, fly},
    footing::{Footing, Look, Support, footing},
    jump::jump_speed,
    planes::Planes,
    report::{follow_ground, refuse_nonsense, report},
    slide::Slider,
    slope::{limit_cos, rise_along, walkable},
    space::View,
    speed::{approach_velocity, slowed_by_grade, speed_rates},
    turn::{TurnRates, brakes_first, turn_toward, way_round},
    walk::walk,
};
use crate::{
    character::intent::MoveIntent,
    math::{
        rotation::{direction_or, heading, twist_angle, wrap_angle},
        spring::{Spring, damp},
    },
    rig::tuning::motion::MotionConfig,
};

/// A root moved by others less than this, in metres, was only rounded.
pub(super) const ROUNDING: f32 = 1e-3;

/// A root moved by others this far, in metres, or pushed out of geometry this far, has teleported.
const TELEPORT: f32 = 0.3;

/// A platform that jumps further than this in a tick, in metres, leaves its riders behind.
const LONGEST_RIDE: f32 = 3.0;

/// Ticks after a teleport for which the body looks whether it stands in something.
const RECHECKS: u8 = 2;

/// Half-life in seconds over which a grade slows a run.
const GRADE_HALF_LIFE: f32 = 0.15;

/// Rise over run beyond which a stride doesn't land: steep stairs have 0.9.
pub(super) const STEEPEST: f32 = 0.95;

/// All that a tick reads.
pub(super) struct Tick<'a> {
    pub(super) view: View<'a>,
    pub(super) config: &'a MotionConfig,
    pub(super) shapes: &'a MotionShapes,
    pub(super) intent: MoveIntent,
    pub(super) transform: &'a Transform,
    pub(super) dt: f32,
}

impl Tick<'_> {
    /// Moves the body for one tick and says what it did.
    pub(super) fn run(&self, body: &mut MotionBody, state: &mut MotionState) {
        body.pushes.clear();
        body.jumped_place = false;
        self.take_up_root(body, state);
        self.ride(body);
        self.choose_posture(body);
        self.get_unstuck(body, state);
        self.turn(body, state, self.dt);
        let travelled = self.travel(body, state);
        state.stepped += follow_ground(body, travelled, self.config, self.dt);
        self.board(body, travelled.before.is_none());
        refuse_nonsense(body, self.view.me);
        report(body, state, self.dt);
        body.ahead = self.grade_ahead(body);
        state.grade_ahead = body.ahead;
        body.write();
    }

    /// The shape that the body's next sweep is made with.
    pub(super) fn shape<'s>(&'s self, body: &MotionBody) -> &'s Collider {
        let posture = self.shapes.posture(body.crouched);
        if body.support.is_some() { &posture.raised } else { &posture.flying }
    }

    /// Notices a first tick, and a root that others moved or turned.
    fn take_up_root(&self, body: &mut MotionBody, state: &mut MotionState) {
        let translation = self.transform.translation;
        let rotation = self.transform.rotation;
        if !translation.is_finite() || !rotation.is_finite() {
            // Someone wrote nonsense; the body knows better, and overwrites it when the tick ends.
            warn_once!("the Transform of character {} is not finite; its last place is kept", self.view.me);
            return;
        }
        let yaw = twist_angle(rotation, Vec3::Y);
        let Some(written) = body.written else {
            body.position = translation;
            body.level = translation.y;
            body.yaw = Spring::at(yaw);
            return;
        };
        let moved = translation - written.translation;
        if moved.length() > ROUNDING {
            // The root is put where it was asked to be, and shall not glide there.
            body.shift(moved);
            if moved.length() > TELEPORT {
                body.position.y = translation.y;
                body.level = translation.y;
                body.lag = Spring::at(0.0);
                (body.ahead, body.grade) = (0.0, 0.0);
                body.support = None;
                body.anchor = None;
                body.checks = RECHECKS;
                body.jumped_place = true;
                state.teleports = state.teleports.wrapping_add(1);
            }
        }
        if wrap_angle(yaw - written.yaw).abs() > 5e-3 {
            body.yaw = Spring::at(yaw);
        }
    }

    /// Goes along with ground that didn't do as expected, or that was moved since.
    fn ride(&self, body: &mut MotionBody) {
        let Some(anchor) = body.anchor.take() else {
            return;
        };
        let Some(ground) = self.view.body_by_id(anchor.body, self.dt) else {
            return;
        };
        if ground.now.is_near(&anchor.expected) {
            return;
        }
        let way = ground.now.world(anchor.local) - body.position;
        if way.length() < LONGEST_RIDE {
            let way = self.clear_way(body, way, anchor.body);
            body.shift(way);
            body.yaw.value = wrap_angle(body.yaw.value + anchor.expected.yaw_to(&ground.now));
        }
    }

    /// As much of a ride's way as nothing but the ground itself is in.
    fn clear_way(&self, body: &MotionBody, way: Vec3, without: Entity) -> Vec3 {
        let length = way.length();
        match self.view.sweep_without(self.shape(body), body.position, way, without) {
            Some(hit) if length > 1e-6 => way * (hit.safe / length),
            _ => way,
        }
    }

    /// Crouches at once; stands up where there is room to.
    fn choose_posture(&self, body: &mut MotionBody) {
        if self.intent.crouch == body.crouched {
            return;
        }
        if self.intent.crouch {
            body.crouched = true;
            body.reshaped = true;
            return;
        }
        let (low, high) = (&self.shapes.crouched, &self.shapes.standing);
        let grow = Vec3::Y * (high.height - low.height);
        let blocked = self.view.sweep(&low.raised, body.position, grow).is_some_and(|hit| hit.safe < grow.y);
        body.crouched = blocked;
        body.reshaped = !blocked;
    }

    /// Gets the body out of whatever it stands in.
    fn get_unstuck(&self, body: &mut MotionBody, state: &mut MotionState) {
        let shape = self.shape(body);
        if body.checks == 0 && !self.view.is_moved_into(shape, body.position) {
            return;
        }
        let mut out = Vec3::ZERO;
        // Out of one thing may be into the next.
        for _ in 0..4 {
            let step = self.view.way_out(shape, body.position + out);
            if step == Vec3::ZERO {
                break;
            }
            out += step;
        }
        if body.checks > 0 && body.support.is_none() {
            out += self.way_up(body, out);
        }
        body.checks = body.checks.saturating_sub(1);
        if out == Vec3::ZERO {
            return;
        }
        body.shift(out);
        if out.length() > TELEPORT {
            body.lag = Spring::at(0.0);
            body.support = None;
            body.jumped_place = true;
            state.teleports = state.teleports.wrapping_add(1);
        }
    }

    /// The way up to the surface for a body that began below the ground: nothing below, something above.
    fn way_up(&self, body: &MotionBody, out: Vec3) -> Vec3 {
        const FAR: f32 = 1000.0;
        let at = body.position + out;
        let start = at + Vec3::Y * self.shapes.step_up;
        if self.view.floor(start, Dir3::NEG_Y, FAR).is_some() {
            return Vec3::ZERO;
        }
        let above = self.view.floor(start, Dir3::Y, FAR);
        above.map_or(Vec3::ZERO, |above| Vec3::Y * (above.height + 0.01 - at.y))
    }

    pub(super) fn turn(&self, body: &mut MotionBody, state: &mut MotionState, dt: f32) {
        let (intent, config) = (&self.intent, self.config);
        let wanted = intent.facing.unwrap_or(intent.velocity);
        let flat = Vec3::new(wanted.x, 0.0, wanted.z);
        let least = if intent.facing.is_some() { 1e-6 } else { TURNING_SPEED };
        let goal = if flat.length() > least { heading(flat) } else { body.yaw.value };
        let stands = body.support.is_some() && intent.velocity == Vec3::ZERO && body.velocity.length() < TURNING_SPEED;
        let most = if stands { config.turn_rate.min(config.standing_turn_rate) } else { config.turn_rate };
        let away = -body.velocity.dot(direction_or(flat, Vec3::ZERO));
        let brakes = if intent.facing.is_none() { brakes_first(away, config.walk_speed) } else { 1.0 };
        let most = most * brakes;
        let rates = TurnRates { half_life: config.turn_half_life, most, gain: config.turn_acceleration };
        let yaw = turn_toward(body.yaw, goal, rates, dt);
        state.ground_yaw_rate = wrap_angle(yaw.value - body.yaw.value) / dt;
        state.turn_ahead = way_round(yaw, goal);
        state.facing_locked = intent.facing.is_some();
        body.yaw = yaw;
    }

    /// Rise over run to where the next stride may land; 0 where it can't.
    fn grade_ahead(&self, body: &MotionBody) -> f32 {
        let Some(StrideAhead { start, reach, distance }) = stride_ahead(body, self.shapes, &self.intent) else {
            return 0.0;
        };
        let floor = self.view.floor(start, Dir3::NEG_Y, reach);
        let floor = floor.filter(|floor| walkable(floor.normal, limit_cos(self.config.slope_limit)));
        let grade = floor.map_or(0.0, |floor| (floor.height - body.level) / distance);
        if grade.abs() > STEEPEST { 0.0 } else { grade }
    }

    /// Walks, jumps or flies.
    fn travel(&self, body: &mut MotionBody, state: &mut MotionState) -> Travelled {
        let (dt, config) = (self.dt, self.config);
        let (from, before) = (body.position, body.support);
        let jumps = body.jump.jumps(self.intent.jump, before.is_some(), config, dt);
        let mut slider = Slider {
            view: &self.view,
            config,
            limit_cos: limit_cos(config.slope_limit),
            dt,
            planes: Planes::default(),
            velocity: Vec3::ZERO,
            stuck: false,
        };
        // A character spawned just above or in the ground stands on it at once.
        let walks = !jumps && (before.is_some() || body.written.is_none());
        if walks {
            self.walk(body, &mut slider);
        } else {
            self.fly(body, &mut slider, state, jumps);
        }
        if slider.stuck {
            body.checks = body.checks.max(1);
        }
        Travelled { before, way: body.position - from }
    }

    /// What it shall go at on this grade.
    pub(super) fn wanted_velocity(&self, body: &MotionBody) -> Vec3 {
        slowed_by_grade(self.intent.velocity, self.config.walk_speed, body.grade, self.config.climb_slowing)
    }

    fn walk(&self, body: &mut MotionBody, slider: &mut Slider) {
        let config = self.config;
        let rise =
            body.support.map_or(0.0, |support| rise_along(support.normal, direction_or(body.velocity, Vec3::ZERO)));
        let steeper = if rise.abs() > body.ahead.abs() { rise } else { body.ahead };
        body.grade = damp(body.grade, steeper, GRADE_HALF_LIFE, self.dt);
        let velocity = approach_velocity(body.velocity, self.wanted_velocity(body), speed_rates(config), self.dt);
        let way = (body.velocity + velocity) * 0.5 * self.dt;
        slider.velocity = velocity + body.frame_velocity;
        let walked = walk(slider, body, self.shapes, self.shapes.posture(body.crouched), way);
        let clipped = slider.planes.clip_flat(slider.velocity) - body.frame_velocity;
        body.velocity = Vec3::new(clipped.x, 0.0, clipped.z);
        body.position = walked.position;
        body.support = walked.support;
        if body.support.is_none() {
            leave_ground(body);
        }
    }

    fn fly(&self, body: &mut MotionBody, slider: &mut Slider, state: &mut MotionState, jumps: bool) {
        if body.support.take().is_some() {
            leave_ground(body);
        }
        if jumps {
            // A late jump off a ledge is as high as any.
            body.velocity.y = body.velocity.y.max(0.0) + jump_speed(self.config.jump_height, self.config.gravity);
            body.jumping = true;
            state.jumps = state.jumps.wrapping_add(1);
        }
        body.grade = damp(body.grade, 0.0, GRADE_HALF_LIFE, self.dt);
        let velocity = air_velocity(body.velocity, &self.intent, body.jumping, self.config, self.dt);
        let velocity = self.descend(body, velocity, slider.limit_cos);
        slider.velocity = velocity + body.frame_velocity;
        let flown = fly(slider, body, self.shapes, self.shapes.posture(body.crouched), velocity);
        body.velocity = flown.velocity;
        body.jumping &= flown.velocity.y > 0.0;
        body.position = flown.position;
        body.support = flown.support;
        if flown.support.is_some() {
            state.landing_speed = core::mem::take(&mut body.descent).fastest;
        }
    }

    /// The velocity of a fall whose end may be near.
    fn descend(&self, body: &mut MotionBody, velocity: Vec3, limit_cos: f32) -> Vec3 {
        let from = body.position;
        let ground = |down| match footing(
            &self.view,
            self.shapes,
            from,
            Look { up: 0.0, down, highest: f32::INFINITY, limit_cos },
        ) {
            Footing::Support(support) => Some(support.height),
            _ => None,
        };
        velocity.with_y(-body.descent.slowed(from.y, (-body.velocity.y, -velocity.y), ground, self.dt))
    }

    /// Goes along with what the ground does during this tick; velocity becomes relative to it.
    ///
    /// Who just landed has flown with the world's clock, and so is where the ground will be already.
    fn board(&self, body: &mut MotionBody, landed: bool) {
        let ground = body.support.and_then(|support| self.view.body(support.collider, self.dt));
        let boarded = ground.map(|ground| ground.entity);
        let changed = boarded != body.ground;
        body.ground = boarded;
        let Some(ground) = ground else {
            if body.support.is_some() {
                // On another character: ground that stands still.
                body.velocity = (body.velocity + body.frame_velocity).with_y(0.0);
                body.frame_velocity = Vec3::ZERO;
            }
            return;
        };
        let frame_velocity = ground.velocity_at(body.position, self.dt);
        if changed && body.checks == 0 {
            // Who was only just put there moves with the ground from the start.
            body.velocity += body.frame_velocity - frame_velocity;
        }
        body.frame_velocity = frame_velocity;
        body.velocity.y = 0.0;
        if ground.now != ground.next && !landed {
            let way = ground.next.world(ground.now.local(body.position)) - body.position;
            let way = self.clear_way(body, way, ground.entity);
            body.shift(way);
            body.yaw.value = wrap_angle(body.yaw.value + ground.now.yaw_to(&ground.next));
        }
        let local = ground.next.local(body.position);
        body.anchor = Some(Anchor { body: ground.entity, expected: ground.next, local });
        if let (true, Some(support)) = (ground.dynamic, body.support) {
            let impulse = Vec3::NEG_Y * (self.config.mass * self.config.gravity * self.dt);
            body.pushes.push(Push { body: ground.entity, point: support.point, impulse });
        }
    }
}

/// The ground's rise and fall goes with the body into the air.
fn leave_ground(body: &mut MotionBody) {
    body.velocity.y += body.frame_velocity.y;
    body.frame_velocity.y = 0.0;
}

/// What a tick's movement was, without the ground's own.
#[derive(Clone, Copy, Debug)]
pub(super) struct Travelled {
    /// The ground before.
    pub(super) before: Option<Support>,
    /// The way gone.
    pub(super) way: Vec3,
}
