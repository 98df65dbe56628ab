//! One foot: planted, swinging, or stepping to correct itself.
//!
//! World space, metres, +Y up. Reads the animated sole and the ground; gives where the ankle shall be and how the foot
//! turns. Horizontal places come from a lock in the ground's frame or from the clip plus a decaying offset; heights from
//! the ground under them plus the height that the clip has over its own floor. On flat ground that is the clip itself.

use bevy::prelude::*;

use super::{
    ground::{Footprint, Plane, Probe, footprint},
    surroundings::{AnimatedFoot, GroundFrames, PlacedFoot, Surroundings},
    turns::{flattening, limited_align},
};
use crate::math::{
    rotation::{from_scaled_axis, heading, wrap_angle},
    spring::{Spring, damp_quat, remaining},
};

/// Which point of the sole a planted foot turns about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Reflect)]
pub enum Pivot {
    /// Heel strike: the forefoot is still in the air.
    Heel,
    /// The whole sole, or the forefoot with the heel lifted.
    Ball,
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
    /// Heading of the foot in the ground's frame, radians.
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
        /// Where the ball lifted off, world.
        from: Vec3,
    },
}

/// What is carried from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct FootState {
    /// What the foot does.
    pub mode: Mode,
    /// Why it let go last.
    pub released: Release,
    /// Horizontal metres from the clip's ball to the placed ball, while not planted.
    pub(super) offset: Spring<Vec3>,
    /// Turn about +Y from the clip's foot to the placed foot, radians.
    pub(super) yaw_offset: f32,
    /// World height of the landing, smoothed.
    pub(super) landing_height: Spring<f32>,
    /// Height of what lies in the way over the line from take-off to landing, metres.
    pub(super) bump: Spring<f32>,
    /// Lift of a correcting step, metres.
    pub(super) lift: Spring<f32>,
    /// Take-off: world place of the ball, and ground there.
    pub(super) takeoff: Vec3,
    /// Turn from upright to the ground's normal, smoothed.
    pub(super) align: Quat,
    /// How far a heel strike is flattened, 0..1, since the heel would land over an edge.
    pub(super) flatten: Spring<f32>,
    /// Where the landing was shifted to, metres along the foot.
    pub(super) shift: f32,
    /// The landing, once it is too near to be changed, world.
    pub(super) settled: Option<Vec3>,
    /// Height of the plane under the foot, world.
    pub(super) height: f32,
    /// Where the ball was placed last, world.
    pub(super) placed_ball: Vec3,
    /// Whether it has run before.
    awake: bool,
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

    /// Whether it holds the ground by its ball, so that its heel may lift.
    #[must_use]
    pub fn stands_on_ball(&self) -> bool {
        self.plant().is_some_and(|plant| plant.pivot == Pivot::Ball)
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
        match self.mode {
            Mode::Planted(plant) => self.hold(&plant, foot, around),
            Mode::Swing => self.swing(foot, around),
            Mode::Stepping { elapsed, seconds, from } => self.step((elapsed, seconds), from, foot, around),
        }
    }

    fn wake<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        let hit = around.reach.at(around.probe, foot.ball);
        let height = hit.map_or(foot.floor, |hit| hit.point.y);
        self.awake = true;
        self.height = height;
        self.landing_height = Spring::at(height);
        self.placed_ball = foot.ball.with_y(height);
        self.takeoff = self.placed_ball;
        self.align = hit.map_or(Quat::IDENTITY, |hit| limited_align(hit.normal, foot.forward, around.config));
        if foot.contact > 0.5 {
            // Whoever appears standing appears on ground that carries the whole sole.
            if let Some((shift, print)) = self.room(foot.ball, foot.forward, around) {
                self.offset = Spring::at(foot.forward * shift);
                self.placed_ball = (foot.ball + foot.forward * shift).with_y(print.ball.point.y);
                self.height = print.ball.point.y;
            }
        }
    }

    fn decide<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        match self.mode {
            Mode::Planted(plant) => {
                let Some(anchor) = anchor_world(&plant, around.frames) else {
                    return self.release(Release::LostGround, foot);
                };
                if foot.contact < 0.5 {
                    return self.release(Release::ContactEnded, foot);
                }
                let wanted = if plant.pivot == Pivot::Heel { foot.heel } else { foot.ball };
                let error = flat(anchor - wanted).length();
                let turned = self.yaw_offset.abs();
                let limit = around.config.unplant_radius;
                if error > limit {
                    self.begin_step(Release::TooFar, foot, around.config.step_time);
                } else if turned > around.config.unplant_yaw {
                    self.begin_step(Release::Turned, foot, around.config.step_time);
                } else if around.may_restep && (error > around.config.restep_distance || turned > 0.35) {
                    self.begin_step(Release::Restep, foot, around.config.step_time);
                }
            }
            Mode::Swing => {
                if foot.contact >= 0.5 {
                    if flat(self.offset.value).length() > around.config.unplant_radius * 0.4
                        && self.released != Release::ContactEnded
                    {
                        self.begin_step(Release::TooFar, foot, around.config.step_time);
                    } else if self.is_stuck(foot, around) {
                        // It came down where there is no room after all: it goes on to where there is.
                        self.begin_step(Release::NoRoom, foot, HURRY);
                    } else {
                        self.lock(foot, around);
                    }
                }
            }
            Mode::Stepping { elapsed, seconds, .. } => {
                if foot.contact < 0.5 {
                    self.takeoff = self.placed_ball.with_y(self.height);
                    self.mode = Mode::Swing;
                } else if elapsed >= seconds {
                    self.lock(foot, around);
                }
            }
        }
    }

    fn release(&mut self, why: Release, foot: &AnimatedFoot) {
        self.released = why;
        self.mode = Mode::Swing;
        self.offset = Spring::at(flat(self.placed_ball - foot.ball));
        self.takeoff = self.placed_ball.with_y(self.height);
        self.landing_height = Spring::at(self.height);
        self.bump = Spring::default();
        self.shift = 0.0;
        self.settled = None;
    }

    fn begin_step(&mut self, why: Release, foot: &AnimatedFoot, seconds: f32) {
        self.release(why, foot);
        self.mode = Mode::Stepping { elapsed: 0.0, seconds: seconds.max(HURRY), from: self.takeoff };
    }

    /// Whether the sole, laid down here, would stick in an edge.
    fn is_stuck<P: Probe, G: GroundFrames>(&self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) -> bool {
        footprint(around.probe, around.reach, self.placed_ball, foot.forward, around.sole)
            .is_some_and(|print| print.stuck > STUCK)
    }

    /// Takes hold of the ground where the foot is now.
    fn lock<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        let heel_first = foot.heel.y < foot.ball.y - 0.004 && self.flatten.value < 0.5;
        let pivot = if heel_first { Pivot::Heel } else { Pivot::Ball };
        let point = if heel_first { self.placed_ball - foot.forward * around.sole.heel } else { self.placed_ball };
        self.plant_at(pivot, point, foot, around);
    }

    fn plant_at<P: Probe, G: GroundFrames>(
        &mut self,
        pivot: Pivot,
        point: Vec3,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) {
        // The ball's ground carries the foot even while the heel touches first: one plane per stance.
        let found = footprint(around.probe, around.reach, self.placed_ball, foot.forward, around.sole);
        let Some(Footprint { ball: hit, normal, .. }) = found else {
            return;
        };
        let frame = around.frames.frame(hit.entity).unwrap_or(Isometry3d::IDENTITY);
        let plane = Plane { point: hit.point, normal };
        let into = frame.inverse();
        let facing = from_scaled_axis(Vec3::Y * self.yaw_offset) * foot.forward;
        self.mode = Mode::Planted(Plant {
            pivot,
            ground: hit.entity,
            anchor_ground: into * point.with_y(plane.height(point)),
            normal_ground: into.rotation * normal,
            yaw_ground: heading(into.rotation * facing),
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
        let plane = Plane { point: anchor, normal: frame.rotation * plant.normal_ground };
        let held = frame.rotation * (from_scaled_axis(Vec3::Y * plant.yaw_ground) * Vec3::NEG_Z);
        self.yaw_offset = wrap_angle(heading(held) - heading(foot.forward));
        self.lift.step(0.0, 0.03, dt);
        self.bump.step(0.0, 0.02, dt);
        self.flatten.step(0.0, 0.1, dt);
        // A landing that was foreseen wrongly sinks or rises onto its ground within a few frames.
        self.height = anchor.y + (self.height - anchor.y).max(-0.002) * remaining(0.015, dt);
        self.landing_height = Spring::at(self.height);
        let lifted = Plane { point: anchor.with_y(self.height), normal: plane.normal };
        let placed = self.place(foot, Some((plant.pivot, anchor)), lifted, around);
        if plant.pivot == Pivot::Heel && foot.ball.y - foot.floor <= 0.003 + (foot.heel.y - foot.floor).max(0.0) {
            // The forefoot is down: from now on it carries the lock.
            let ball = self.placed_ball;
            let height = self.height;
            self.plant_at(Pivot::Ball, ball, foot, around);
            self.height = height;
        }
        placed
    }

    /// Turns the foot to the plane and sets its lowest point as high over it as the clip has it over its floor.
    pub(super) fn place<P: Probe, G: GroundFrames>(
        &mut self,
        foot: &AnimatedFoot,
        held: Option<(Pivot, Vec3)>,
        plane: Plane,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        if held.is_some() {
            let target = limited_align(plane.normal, foot.forward, around.config);
            self.align = damp_quat(self.align, target, around.config.align_half_life * 0.5, around.dt);
        }
        let turn = (self.align
            * from_scaled_axis(Vec3::Y * self.yaw_offset)
            * flattening(foot, self.flatten.value.clamp(0.0, 1.0)))
        .normalize();
        let [heel, ball, tip] = [foot.heel, foot.ball, foot.tip].map(|point| turn * (point - foot.ankle));
        let place = match held {
            Some((Pivot::Heel, anchor)) => anchor - heel,
            Some((Pivot::Ball, anchor)) => anchor - ball,
            None => foot.ball + self.offset.value - ball,
        };
        let lowest = [foot.heel, foot.ball, foot.tip].into_iter().map(|p| p.y).fold(f32::MAX, f32::min) - foot.floor;
        let needed = [heel, ball, tip]
            .into_iter()
            .map(|offset| plane.height(place + offset) - offset.y)
            .fold(f32::MIN, f32::max);
        let ankle = place.with_y(needed + lowest + self.lift.value.max(0.0));
        self.placed_ball = ankle + ball;
        PlacedFoot { ankle, turn, sole: [heel, ball, tip].map(|offset| ankle + offset), plane, landing: None }
    }
}

/// Seconds of the shortest step.
const HURRY: f32 = 0.12;
/// Metres in the ground from which a sole doesn't stay where it came down.
const STUCK: f32 = 0.012;

fn anchor_world(plant: &Plant, frames: &impl GroundFrames) -> Option<Vec3> {
    frames.frame(plant.ground).map(|frame| frame * plant.anchor_ground)
}

pub(super) fn flat(vector: Vec3) -> Vec3 {
    vector.with_y(0.0)
}
