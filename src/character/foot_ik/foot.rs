//! One foot: planted, swinging, or stepping to correct itself.
//!
//! World space, metres, +Y up. Reads the animated sole and the ground; gives where the ankle shall be and how the foot
//! turns. A planted foot keeps its place in the ground's frame; a flying one follows the clip, its distance from the clip
//! eased from that of take-off to that of landing. Heights are the ground's under it plus the clip's over its own floor.
//! On flat ground that is the clip itself.

use bevy::prelude::*;

use super::{
    body::Body,
    carry::Carry,
    flight::{Flight, ease},
    ground::{Plane, Probe},
    landing::Landing,
    pace::Pace,
    soften::Soften,
    surroundings::{AnimatedFoot, GroundFrames, PlacedFoot, Surroundings},
    turns::{flattening, limited_align},
};
use crate::{
    anim::{leg::Leg, pose::Pose},
    character::{legs::heel_turn, sole::sole_model},
    math::{
        rotation::{heading, twist_angle, wrap_angle, yaw},
        spring::Spring,
    },
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

impl Plant {
    /// Turn about +Y from the clip's foot to the held one, radians.
    pub(super) fn yaw_offset(&self, foot: &AnimatedFoot, frames: &impl GroundFrames) -> f32 {
        let ground = frames.frame(self.ground).map_or(0.0, |frame| twist_angle(frame.rotation, Vec3::Y));
        wrap_angle(ground + self.yaw_ground - heading(foot.forward))
    }
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
    /// Metres by which an ankle that is late held the sole lower than asked, in the last frame.
    pub(super) droops: f32,
    /// How fast its leg may move.
    pub(super) pace: Pace,
    /// What it keeps of its motion.
    pub(super) soften: Soften,
    /// Metres by which the leg didn't reach where the foot was put in the last frame.
    pub(super) missed: f32,
    /// Seconds for which that was too far while it stands.
    pub(super) strained: f32,
    /// Metres by which the leg, which moves no faster than it may, was behind that.
    pub(super) behind: f32,
    /// Metres by which a leg that is late has its foot lifted over the ground.
    pub(super) lifted: f32,
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
    /// Frame of the ground that a planted foot stood on in the last frame, world.
    pub(super) ground: Isometry3d,
    /// Metres by which a planted foot still is over its ground.
    pub(super) over: f32,
    /// Metres by which the clip has a standing foot over its own floor, which aren't shown.
    pub(super) hovers: f32,
    /// Metres from where the clip wanted it to where it found room, when it came down.
    pub(super) aside: f32,
    /// Where the ball was placed last, world.
    pub(super) placed_ball: Vec3,
    /// Horizontal metres from there to heel and tip.
    pub(super) to_heel: Vec3,
    pub(super) to_tip: Vec3,
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

    /// World height of the ground that it, foot `side` of `body`, will still stand on in `seconds`; before its first frame the
    /// root's.
    pub(super) fn level(&self, body: &Body<'_>, side: usize, seconds: f32) -> Option<f32> {
        if !self.awake {
            return Some(body.root.translation.y);
        }
        let stays = self.plant().is_some() && body.locomotion.cues[side].stands_for > seconds;
        stays.then_some(self.base)
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

    /// Forgets how it moved; where it stands and where it goes holds.
    pub(super) fn forget_motion(&mut self) {
        self.carry.forget();
        self.pace = Pace::default();
        self.soften.forget();
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
        self.carry.note(placed.ankle, placed.sole[2], around.dt);
        placed
    }

    /// How much of its time in the air has passed, eased, 0..1; 0 on the ground.
    pub(super) fn share_of_flight(&self) -> f32 {
        if self.mode == Mode::Swing { ease(self.flight.share()) } else { 0.0 }
    }

    /// Whether it was in the air without ground in the last frame.
    pub(super) fn flies_free(&self) -> bool {
        self.free
    }

    /// Notes by how much the sole of a leg that is late hangs lower than asked.
    pub(super) fn note_droop(&mut self, pose: &Pose, leg: &Leg, placed: &PlacedFoot) {
        self.droops = 0.0;
        if self.pace.is_late() || self.soften.eases() {
            let lowest = |points: [Vec3; 3]| points[0].y.min(points[1].y).min(points[2].y);
            let asked = lowest(placed.sole) - placed.ankle.y;
            let made = lowest(sole_model(pose, leg)) - pose.position(leg.foot).y;
            self.droops = (asked - made).max(0.0);
        }
    }

    /// In the air it goes another way from here.
    pub(super) fn change_way(&mut self, foot: &AnimatedFoot) {
        self.landing = Landing::default();
        self.flight = Flight::from(self, foot);
        self.carry.begin();
    }

    /// One frame in the air, without ground: the foot is where the clip has it.
    pub(super) fn fly_free(&mut self, foot: &AnimatedFoot, dt: f32) {
        let (carry, soften) = (self.carry, core::mem::take(&mut self.soften));
        self.reset();
        (self.carry, self.soften) = (carry, soften);
        self.carry.note(foot.clip_ankle, foot.tip, dt);
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
            self.above = (foot.floor + foot.lowest() - height).max(0.0);
            self.base = height;
            self.placed_ball = foot.ball;
            self.flight = Flight::from(self, foot);
            if foot.contact > 0.5 || around.halts {
                self.finish_step(foot, 0.0, around.size);
            } else {
                self.carry.begin();
            }
            return;
        }
        self.base = height;
        self.placed_ball = foot.ball.with_y(height);
        self.align = hit.map_or(Quat::IDENTITY, |hit| limited_align(hit.normal, foot.forward, around.config));
        if foot.contact >= 0.5 || around.halts {
            // Whoever appears standing appears on ground that carries the whole sole.
            self.landing.plan(foot.ball, foot.forward, height, around);
            let place = self.landing.place;
            self.base = place.y;
            self.placed_ball = place;
        }
        self.flight = Flight::from(self, foot);
    }

    /// Metres that the clip has the foot over its floor, but for what is no step's; blended clips may sink into it.
    pub(super) fn height(&self, foot: &AnimatedFoot) -> f32 {
        (foot.lowest().max(0.0) - self.hovers).max(0.0)
    }

    /// Turns the foot to the plane and sets its lowest point as high over it as the clip has it over its floor.
    pub(super) fn place(&mut self, foot: &AnimatedFoot, held: Option<(Pivot, Vec3)>, plane: Plane) -> PlacedFoot {
        let turn =
            (self.align * yaw(self.yaw_offset) * flattening(foot, self.flatten.value.clamp(0.0, 1.0))).normalize();
        let [heel, ball, tip] = [foot.heel, foot.ball, foot.tip].map(|point| turn * (point - foot.ankle));
        // Reaching down the heel stays up; toes lie flat.
        let heel =
            if self.toes_down > 0.0 { ball + heel_turn(ball - heel, self.toes_down) * (heel - ball) } else { heel };
        let place = match held {
            Some((Pivot::Heel, anchor)) => anchor - heel,
            Some((Pivot::Ball, anchor)) => anchor - ball,
            Some((Pivot::Tip, anchor)) => anchor - tip,
            None => self.flight.ball - ball,
        };
        let needed = [heel, ball, tip]
            .into_iter()
            .map(|offset| plane.height(place + offset) - offset.y)
            .fold(f32::MIN, f32::max);
        let lift = if held.is_none() { self.flight.lift } else { 0.0 };
        let ankle = place.with_y(needed + self.height(foot) + lift);
        self.placed_ball = ankle + ball;
        (self.to_heel, self.to_tip) = (flat(heel - ball), flat(tip - ball));
        PlacedFoot {
            ankle,
            turn,
            sole: [heel, ball, tip].map(|offset| ankle + offset),
            plane,
            takeoff: self.placed_ball.with_y(self.base),
            landing: None,
        }
    }
}

/// Share of the time in the air in which a foot that is left behind still lifts its heel to reach; as long again it less
/// and less does.
const REACHES_BACK: f32 = 0.4;

/// Where the plant is held, world; `None` once its ground is gone.
pub(super) fn anchor_world(plant: &Plant, frames: &impl GroundFrames) -> Option<Vec3> {
    frames.frame(plant.ground).map(|frame| frame * plant.anchor_ground)
}

pub(super) fn flat(vector: Vec3) -> Vec3 {
    vector.with_y(0.0)
}
