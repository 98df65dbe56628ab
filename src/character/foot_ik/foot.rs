//! One foot: planted, swinging, or stepping to correct itself.
//!
//! World space, metres, +Y up. Reads the animated sole and the ground; gives where the ankle shall be and how the foot
//! turns. A planted foot keeps its place in the ground's frame; a flying one follows the clip, its distance from the clip
//! eased from that of take-off to that of landing. Heights are the ground's under it plus the clip's over its own floor.
//! On flat ground that is the clip itself.

use bevy::prelude::*;

use super::{
    carry::Carry,
    flight::{Flight, ease},
    ground::{Footprint, Plane, Probe},
    landing::{Landing, print_at},
    legs::heel_turn,
    surroundings::{AnimatedFoot, GroundFrames, PlacedFoot, Surroundings},
    turns::{flattening, limited_align},
};
use crate::math::{
    rotation::{from_scaled_axis, heading, twist_angle, wrap_angle},
    spring::{Spring, damp, damp_quat, remaining},
};

/// Which point of the sole a planted foot turns about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub enum Pivot {
    /// Heel strike: the forefoot is still in the air.
    Heel,
    /// The whole sole, or the forefoot with the heel lifted.
    Ball,
    /// Push-off: only the toes' tip still touches.
    Tip,
}

/// Why a foot let go of the ground last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Reflect)]
pub enum Release {
    /// It never did.
    #[default]
    Never,
    /// The clip lifts it.
    ContactEnded,
    /// The body moved too far from it.
    TooFar,
    /// The body turned too far over it.
    Turned,
    /// It stood off its place while the character stands.
    Restep,
    /// It came down on an edge.
    NoRoom,
    /// The ground under it is gone.
    LostGround,
    /// The character was put elsewhere, or left the ground.
    Reset,
}

/// A foot's hold on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plant {
    /// The point of the sole that is held.
    pub pivot: Pivot,
    /// The entity that it stands on.
    pub ground: Entity,
    /// The held point in the ground entity's frame.
    pub anchor_ground: Vec3,
    /// The ground's normal in its own frame.
    pub normal_ground: Vec3,
    /// Heading of the foot, radians, as seen from the ground's own turn about +Y.
    pub yaw_ground: f32,
}

/// What a foot does.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum Mode {
    /// Follows the clip through the air.
    #[default]
    Swing,
    /// Holds the ground.
    Planted(Plant),
    /// A step of its own, to where the clip wants it.
    Stepping {
        /// Seconds since it lifted.
        elapsed: f32,
        /// Seconds that it takes.
        seconds: f32,
    },
}

/// What is carried from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct FootState {
    /// What the foot does.
    pub mode: Mode,
    /// Why it let go last.
    pub released: Release,
    /// How it left the ground, while it is in the air.
    pub(super) flight: Flight,
    /// Where it will come down, while it is in the air.
    pub(super) landing: Landing,
    /// What it keeps of its motion when its way changes.
    pub(super) carry: Carry,
    /// Metres from the sole's lowest point, in the air, down to where it will stand.
    pub(super) above: f32,
    /// Turn about +Y from the clip's foot to the placed foot, radians.
    pub(super) yaw_offset: f32,
    /// Turn from upright to the ground's normal.
    pub(super) align: Quat,
    /// How far a heel strike is flattened, 0..1, since the heel would land over an edge.
    pub(super) flatten: Spring<f32>,
    /// Radians by which the toes point down to reach a lower step.
    pub(super) toes_down: f32,
    /// How much of its weight the forefoot bears, 0..1: as far its heel may lift.
    pub(super) forefoot: f32,
    /// World height, under the ball, of the ground that carries the foot; in the air of the way to the next.
    pub(super) base: f32,
    /// Metres by which a planted foot still is over its ground.
    over: f32,
    /// Metres from where the clip wanted it to where it found room, when it came down.
    aside: f32,
    /// Where the ball was placed last, world.
    pub(super) placed_ball: Vec3,
    /// Horizontal metres from there to heel and tip.
    to_heel: Vec3,
    to_tip: Vec3,
    /// Angle in radians by which the heel is lifted so that the leg reaches.
    pub heel: f32,
    /// Whether it has run before, and whether it was in the air without ground then.
    awake: bool,
    free: bool,
}

impl FootState {
    /// The plant, while the foot holds the ground.
    #[must_use]
    pub fn plant(&self) -> Option<&Plant> {
        match &self.mode {
            Mode::Planted(plant) => Some(plant),
            _ => None,
        }
    }

    /// Whether it holds the ground by its forefoot, so that its heel may lift.
    #[must_use]
    pub fn stands_on_forefoot(&self) -> bool {
        self.plant().is_some_and(|plant| plant.pivot != Pivot::Heel)
    }

    /// How far its heel may lift to reach, 0..1: on its forefoot, and when it has just left the ground.
    pub(super) fn heel_may_lift(&self) -> f32 {
        match self.mode {
            Mode::Planted(plant) if plant.pivot == Pivot::Heel => 0.0,
            Mode::Planted(_) => self.forefoot,
            _ => self.forefoot * (1.0 - ease(((self.flight.share() - REACHES_BACK) / REACHES_BACK).clamp(0.0, 1.0))),
        }
    }

    /// Forgets the ground; the next frame starts from the clip.
    pub fn reset(&mut self) {
        *self = Self { released: Release::Reset, ..Self::default() };
    }

    /// One frame: decides what the foot does and where it goes.
    pub fn advance<P: Probe, G: GroundFrames>(
        &mut self,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        if !self.awake {
            self.wake(foot, around);
        }
        self.decide(foot, around);
        let placed = match self.mode {
            Mode::Planted(plant) => self.hold(&plant, foot, around),
            Mode::Swing => self.swing(foot, around),
            Mode::Stepping { elapsed, seconds } => self.step((elapsed, seconds), foot, around),
        };
        self.carry.note(placed.ankle, around.dt);
        placed
    }

    /// One frame in the air, without ground: the foot is where the clip has it.
    pub(super) fn fly_free(&mut self, foot: &AnimatedFoot, dt: f32) {
        let carry = self.carry;
        self.reset();
        self.carry = carry;
        self.carry.note(foot.clip_ankle, dt);
        self.base = foot.floor;
        self.free = true;
    }

    fn wake<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        let hit = around.reach.at(around.probe, foot.ball);
        let height = hit.map_or(foot.floor, |hit| hit.point.y);
        self.awake = true;
        if core::mem::take(&mut self.free) {
            // Out of the air it comes down from where it is.
            self.carry.land(self.base - foot.floor);
            let lowest = foot.heel.y.min(foot.ball.y).min(foot.tip.y);
            self.above = (lowest - height).max(0.0);
            self.base = height;
            self.placed_ball = foot.ball;
            self.flight = Flight::from(self, foot);
            if foot.contact > 0.5 || around.halts {
                self.finish_step(foot, 0.0);
            } else {
                self.carry.begin();
            }
            return;
        }
        self.base = height;
        self.placed_ball = foot.ball.with_y(height);
        self.align = hit.map_or(Quat::IDENTITY, |hit| limited_align(hit.normal, foot.forward, around.config));
        if foot.contact > 0.5 {
            // Whoever appears standing appears on ground that carries the whole sole.
            self.landing.plan(foot.ball, foot.forward, height, around);
            let place = self.landing.place;
            self.base = place.y;
            self.placed_ball = place;
        }
        self.flight = Flight::from(self, foot);
    }

    fn decide<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        match self.mode {
            Mode::Planted(plant) => {
                let Some(anchor) = anchor_world(&plant, around.frames) else {
                    return self.release(Release::LostGround, foot, around);
                };
                if foot.contact < 0.5 {
                    // Who stops makes the last step himself: a swing that fades would only drag the foot.
                    return if around.halts {
                        self.begin_step(Release::ContactEnded, foot, around);
                    } else {
                        self.release(Release::ContactEnded, foot, around);
                    };
                }
                let error = flat(anchor - foot.point(plant.pivot)).length();
                let turned = self.yaw_offset.abs();
                let config = around.config;
                // A gait lifts the foot soon by itself.
                let patience = if around.may_restep { 1.0 } else { PATIENCE };
                if foot.contact < 0.9 || !around.other_holds {
                    // Half lifted already, or the only foot on the ground.
                } else if error > patience * config.unplant_radius {
                    self.begin_step(Release::TooFar, foot, around);
                } else if turned > patience * config.unplant_yaw {
                    self.begin_step(Release::Turned, foot, around);
                } else if around.may_restep && (error > config.restep_distance + self.aside || turned > RESTEP_YAW) {
                    self.begin_step(Release::Restep, foot, around);
                }
            }
            Mode::Swing if foot.contact >= 0.5 || around.halts => {
                let aside = flat(self.placed_ball - self.landing.place).length();
                let off = self.above > DOWN || aside > THERE;
                let amid = if around.halts {
                    self.above > TOUCHES || aside > THERE
                } else {
                    off && self.flight.share() < NEARLY
                };
                if amid { self.finish_step(foot, aside) } else { self.lock(foot, around) }
            }
            Mode::Swing => {}
            Mode::Stepping { elapsed, seconds } => {
                if foot.contact < 0.5 && !around.halts {
                    self.mode = Mode::Swing;
                    self.landing = Landing::default();
                    self.flight = Flight::from(self, foot);
                    self.carry.begin();
                } else if elapsed >= seconds || self.touches_down() {
                    self.lock(foot, around);
                }
            }
        }
    }

    fn release<P: Probe, G: GroundFrames>(
        &mut self,
        why: Release,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) {
        let plant = self.plant().copied();
        if let Some((plant, anchor)) = plant.and_then(|plant| Some((plant, anchor_world(&plant, around.frames)?))) {
            // It takes off from where it is held now, not from where the ball was in the last frame.
            self.placed_ball = (foot.ball + flat(anchor - foot.point(plant.pivot))).with_y(self.placed_ball.y);
        }
        self.released = why;
        self.mode = Mode::Swing;
        self.landing = Landing::default();
        self.flight = Flight::from(self, foot);
        self.flight.leave(plant.map(|plant| plant.ground), around.frames);
        if self.flight.leaves_late() {
            self.carry.begin();
        }
    }

    fn begin_step<P: Probe, G: GroundFrames>(
        &mut self,
        why: Release,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) {
        self.release(why, foot, around);
        let aside = flat(self.placed_ball - foot.ball).length();
        let far = aside * UNHURRIED;
        let turned = (self.yaw_offset.abs() / RESTEP_YAW).min(1.0);
        self.flight.arc = ease((aside / FULL_ARC).min(1.0)).max(ease(turned)).max(LEAST_ARC);
        self.mode = Mode::Stepping { elapsed: 0.0, seconds: around.config.step_time.max(HURRY).max(far) };
    }

    /// The clip stands while the foot is still in the air: it comes down by a step of its own.
    fn finish_step(&mut self, foot: &AnimatedFoot, aside: f32) {
        let seconds = (SHORTEST_FINISH + UNHURRIED * aside + FALLS * self.above).min(LONGEST_FINISH);
        self.mode = Mode::Stepping { elapsed: 0.0, seconds };
        self.landing = Landing::default();
        self.flight = Flight::from(self, foot);
        self.flight.arc = ease((aside / FULL_ARC).min(1.0)) * (1.0 - self.above / FULL_ARC).max(0.0);
        self.flight.finishes = true;
        self.carry.begin();
    }

    /// A foot that finishes what its clip began is down as soon as it is there.
    fn touches_down(&self) -> bool {
        let aside = flat(self.placed_ball - self.landing.place).length();
        self.flight.finishes && self.above < TOUCHES && aside < THERE
    }

    /// Takes hold of the ground where the foot is now.
    fn lock<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        self.aside = flat(self.placed_ball - foot.ball).length();
        // After a step of its own a foot takes its weight by and by.
        self.forefoot = if matches!(self.mode, Mode::Stepping { .. }) { 0.0 } else { 1.0 };
        let heel_first = foot.heel.y < foot.ball.y - 0.004 && self.flatten.value < 0.5;
        self.plant_at(if heel_first { Pivot::Heel } else { Pivot::Ball }, foot, around);
    }

    /// Where a point of the sole was placed last, world; the height doesn't matter.
    fn placed(&self, pivot: Pivot) -> Vec3 {
        self.placed_ball
            + match pivot {
                Pivot::Heel => self.to_heel,
                Pivot::Ball => Vec3::ZERO,
                Pivot::Tip => self.to_tip,
            }
    }

    fn plant_at<P: Probe, G: GroundFrames>(
        &mut self,
        pivot: Pivot,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) {
        // The ball's ground carries the foot even while the heel touches first: one plane per stance.
        let Some(Footprint { ball: hit, normal, .. }) =
            self.landing.print_under(self.placed_ball, foot.forward, around)
        else {
            return;
        };
        let frame = around.frames.frame(hit.entity).unwrap_or(Isometry3d::IDENTITY);
        let plane = Plane { point: hit.point, normal };
        let into = frame.inverse();
        let facing = from_scaled_axis(Vec3::Y * self.yaw_offset) * foot.forward;
        let point = self.placed(pivot);
        self.over = self.base - plane.height(self.placed_ball);
        self.mode = Mode::Planted(Plant {
            pivot,
            ground: hit.entity,
            anchor_ground: into * point.with_y(plane.height(point)),
            normal_ground: into.rotation * normal,
            yaw_ground: wrap_angle(heading(facing) - twist_angle(frame.rotation, Vec3::Y)),
        });
    }

    fn hold<P: Probe, G: GroundFrames>(
        &mut self,
        plant: &Plant,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let dt = around.dt;
        let frame = around.frames.frame(plant.ground).unwrap_or(Isometry3d::IDENTITY);
        let anchor = frame * plant.anchor_ground;
        let normal = frame.rotation * plant.normal_ground;
        let held = twist_angle(frame.rotation, Vec3::Y) + plant.yaw_ground;
        self.yaw_offset = wrap_angle(held - heading(foot.forward));
        // The clip brings the forefoot down by itself.
        self.flatten.step(self.flatten.value.round(), 0.05, dt);
        self.toes_down *= remaining(HEEL_DOWN, dt);
        self.forefoot = damp(self.forefoot, 1.0, TAKES_WEIGHT, dt);
        // A landing that was foreseen wrongly sinks or rises onto its ground within a few frames.
        self.over = self.over.max(-0.002) * remaining(SETTLE, dt);
        let target = limited_align(normal, foot.forward, around.config);
        self.align = damp_quat(self.align, target, around.config.align_half_life, dt);
        let plane = Plane { point: anchor + Vec3::Y * self.over, normal };
        let placed = self.place(foot, Some((plant.pivot, anchor)), plane);
        self.base = plane.height(self.placed_ball);
        // The sole rolls from heel over ball to tip; what lies on the ground carries the lock.
        let [heel, ball, tip] = [foot.heel, foot.ball, foot.tip].map(|point| point.y - foot.floor);
        match plant.pivot {
            Pivot::Heel if ball <= ROLLED + heel.max(0.0) => {
                self.roll(Pivot::Ball, plant, plane, frame);
                self.lay_flat(foot, around);
            }
            Pivot::Ball if ball > ROLLED + tip.max(0.0) && tip < heel => self.roll(Pivot::Tip, plant, plane, frame),
            Pivot::Tip if ball <= tip => self.roll(Pivot::Ball, plant, plane, frame),
            _ => {}
        }
        PlacedFoot { base: self.base, takeoff: self.placed_ball.with_y(self.base), ..placed }
    }

    /// The forefoot is down: the ground under it carries the sole, unless that is across an edge.
    fn lay_flat<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        let found = print_at(self.placed_ball, foot.forward, around);
        if found.is_some_and(|print| (print.ball.point.y - self.base).abs() < ACROSS) {
            self.landing = Landing::default();
            self.plant_at(Pivot::Ball, foot, around);
        }
    }

    /// The same plane carries the foot on, held by another point.
    fn roll(&mut self, onto: Pivot, plant: &Plant, plane: Plane, frame: Isometry3d) {
        let point = self.placed(onto);
        let on_ground = point.with_y(plane.height(point) - self.over);
        self.mode = Mode::Planted(Plant { pivot: onto, anchor_ground: frame.inverse() * on_ground, ..*plant });
    }

    /// Turns the foot to the plane and sets its lowest point as high over it as the clip has it over its floor.
    pub(super) fn place(&mut self, foot: &AnimatedFoot, held: Option<(Pivot, Vec3)>, plane: Plane) -> PlacedFoot {
        let turn = (self.align
            * from_scaled_axis(Vec3::Y * self.yaw_offset)
            * flattening(foot, self.flatten.value.clamp(0.0, 1.0)))
        .normalize();
        let [heel, ball, tip] = [foot.heel, foot.ball, foot.tip].map(|point| turn * (point - foot.ankle));
        // Reaching down the heel stays up; toes lie flat.
        let heel = ball + heel_turn(ball - heel, self.toes_down) * (heel - ball);
        let place = match held {
            Some((Pivot::Heel, anchor)) => anchor - heel,
            Some((Pivot::Ball, anchor)) => anchor - ball,
            Some((Pivot::Tip, anchor)) => anchor - tip,
            None => self.flight.ball - ball,
        };
        let lowest = [foot.heel, foot.ball, foot.tip].into_iter().map(|p| p.y).fold(f32::MAX, f32::min) - foot.floor;
        let needed = [heel, ball, tip]
            .into_iter()
            .map(|offset| plane.height(place + offset) - offset.y)
            .fold(f32::MIN, f32::max);
        // Blended clips may sink into their own floor.
        let lift = if held.is_none() { self.flight.lift } else { 0.0 };
        let ankle = place.with_y(needed + lowest.max(0.0) + lift);
        self.placed_ball = ankle + ball;
        (self.to_heel, self.to_tip) = (flat(heel - ball), flat(tip - ball));
        PlacedFoot {
            ankle,
            turn,
            sole: [heel, ball, tip].map(|offset| ankle + offset),
            plane,
            base: self.base,
            takeoff: self.placed_ball.with_y(self.base),
            landing: None,
        }
    }
}

/// Metres of height between two grounds that don't carry one sole.
const ACROSS: f32 = 0.05;
/// Metres by which one end of the sole must be over the other to count as lifted.
const ROLLED: f32 = 0.002;
/// How much more a lock endures, in place and turn, while a gait plays.
const PATIENCE: f32 = 1.5;
/// Turn in radians against a standing body from which a foot steps round: 20°.
const RESTEP_YAW: f32 = 0.35;
/// Seconds that a metre of a correcting step takes at least.
const UNHURRIED: f32 = 1.8;
/// Seconds of the shortest step.
const HURRY: f32 = 0.2;
/// Seconds of the shortest and the longest step that finishes what a clip began, and those that a metre of height takes.
const SHORTEST_FINISH: f32 = 0.1;
const LONGEST_FINISH: f32 = 0.4;
const FALLS: f32 = 1.5;
/// Metres over its ground, and aside of it, within which a foot counts as landed when its clip stands.
const TOUCHES: f32 = 0.003;
const DOWN: f32 = 0.03;
const THERE: f32 = 0.08;
/// Share of its time in the air from which on a foot counts as landed when its clip stands.
const NEARLY: f32 = 0.85;
/// Metres of a step from which on it is lifted by the whole step height.
const FULL_ARC: f32 = 0.15;
/// Share of the step height that any step is lifted by.
const LEAST_ARC: f32 = 0.3;
/// Share of the time in the air in which a foot that is left behind still lifts its heel to reach; as long again it less
/// and less does.
const REACHES_BACK: f32 = 0.4;
/// Half-lives in seconds: in which a heel comes down after a landing on the toes, and in which a foot takes its weight.
const HEEL_DOWN: f32 = 0.05;
const TAKES_WEIGHT: f32 = 0.06;
/// Half-life in seconds in which a foot that came down over or under its ground settles onto it.
const SETTLE: f32 = 0.02;

fn anchor_world(plant: &Plant, frames: &impl GroundFrames) -> Option<Vec3> {
    frames.frame(plant.ground).map(|frame| frame * plant.anchor_ground)
}

pub(super) fn flat(vector: Vec3) -> Vec3 {
    vector.with_y(0.0)
}
