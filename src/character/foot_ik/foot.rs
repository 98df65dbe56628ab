//! One foot: planted, swinging, or stepping to correct itself.
//!
//! World space, metres, +Y up. Reads the animated sole and the ground; gives where the ankle shall be and how the foot
//! turns. Horizontal places come from a lock in the ground's frame or from the clip plus a decaying offset; heights from
//! the ground under them plus the height that the clip has over its own floor. On flat ground that is the clip itself.

use bevy::prelude::*;

use super::ground::{Footprint, Plane, Probe, Reach, SoleShape, find_room};
use crate::{
    math::{
        rotation::{direction_or, from_scaled_axis, heading, shortest_arc, to_scaled_axis, wrap_angle},
        spring::{Spring, damp_quat, remaining},
    },
    rig::tuning::foot_ik::FootIkConfig,
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
    offset: Spring<Vec3>,
    /// Turn about +Y from the clip's foot to the placed foot, radians.
    yaw_offset: f32,
    /// World height of the landing, smoothed.
    landing_height: Spring<f32>,
    /// Height of what lies in the way over the line from take-off to landing, metres.
    bump: Spring<f32>,
    /// Lift of a correcting step, metres.
    lift: Spring<f32>,
    /// Take-off: world place of the ball, and ground there.
    takeoff: Vec3,
    /// Turn from upright to the ground's normal, smoothed.
    align: Quat,
    /// How far a heel strike is flattened, 0..1, since the heel would land over an edge.
    flatten: Spring<f32>,
    /// Where the landing was shifted to, metres along the foot.
    shift: f32,
    /// Height of the plane under the foot, world.
    height: f32,
    /// Where the ball was placed last, world.
    placed_ball: Vec3,
    /// Whether it has run before.
    awake: bool,
}

/// The sole as the clip has it, in world space on the character's own floor plane.
#[derive(Clone, Copy, Debug)]
pub struct AnimatedFoot {
    /// Ankle joint, its stride warped to the ground speed.
    pub ankle: Vec3,
    /// Ankle joint as the clip has it.
    pub clip_ankle: Vec3,
    /// Under the heel.
    pub heel: Vec3,
    /// Under the ball.
    pub ball: Vec3,
    /// Under the toes' tip.
    pub tip: Vec3,
    /// The floor plane's height.
    pub floor: f32,
    /// Direction that the foot points to.
    pub forward: Vec3,
    /// How surely the clip has this foot on the ground, 0..1.
    pub contact: f32,
    /// Seconds until it lands, while it swings.
    pub time_to_contact: f32,
    /// Where its ball lands if the body keeps its course, world; the height doesn't matter.
    pub landing: Vec3,
    /// Direction that it points to when it lands.
    pub landing_forward: Vec3,
}

/// Where the ground entity is.
pub trait GroundFrames {
    /// Position and rotation of a ground entity; `None` once it is gone.
    fn frame(&self, entity: Entity) -> Option<Isometry3d>;
}

/// What surrounds one foot in one frame.
pub struct Surroundings<'a, P, G> {
    /// Casts into the ground.
    pub probe: &'a P,
    /// Frames of what moves.
    pub frames: &'a G,
    /// Heights to look between.
    pub reach: Reach,
    /// The sole's shape.
    pub sole: SoleShape,
    /// Tuning, already scaled to the leg.
    pub config: &'a FootIkConfig,
    /// Seconds since the last frame.
    pub dt: f32,
    /// Whether the character stands, so that the foot may correct its place.
    pub may_restep: bool,
}

/// Where the foot shall be.
#[derive(Clone, Copy, Debug)]
pub struct PlacedFoot {
    /// Ankle joint, world.
    pub ankle: Vec3,
    /// Turn of the foot joint's animated world rotation: `new = turn * animated`.
    pub turn: Quat,
    /// Heel, ball and tip of the placed sole, world.
    pub sole: [Vec3; 3],
    /// The plane that it is placed on.
    pub plane: Plane,
    /// Where the ball will land, world, and in how many seconds, while the foot is in the air.
    pub landing: Option<(Vec3, f32)>,
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
            Mode::Stepping { elapsed, from } => self.step(elapsed, from, foot, around),
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
                    self.begin_step(Release::TooFar, foot);
                } else if turned > around.config.unplant_yaw {
                    self.begin_step(Release::Turned, foot);
                } else if around.may_restep && (error > around.config.restep_distance || turned > 0.35) {
                    self.begin_step(Release::Restep, foot);
                }
            }
            Mode::Swing => {
                if foot.contact >= 0.5 {
                    if flat(self.offset.value).length() > around.config.unplant_radius * 0.4
                        && self.released != Release::ContactEnded
                    {
                        self.begin_step(Release::TooFar, foot);
                    } else {
                        self.lock(foot, around);
                    }
                }
            }
            Mode::Stepping { elapsed, .. } => {
                if foot.contact < 0.5 {
                    self.takeoff = self.placed_ball.with_y(self.height);
                    self.mode = Mode::Swing;
                } else if elapsed >= around.config.step_time {
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
    }

    fn begin_step(&mut self, why: Release, foot: &AnimatedFoot) {
        self.release(why, foot);
        self.mode = Mode::Stepping { elapsed: 0.0, from: self.takeoff };
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
        let Some(hit) = around.reach.at(around.probe, self.placed_ball) else {
            return;
        };
        let frame = around.frames.frame(hit.entity).unwrap_or(Isometry3d::IDENTITY);
        let plane = Plane { point: hit.point, normal: hit.normal };
        let into = frame.inverse();
        let facing = from_scaled_axis(Vec3::Y * self.yaw_offset) * foot.forward;
        self.mode = Mode::Planted(Plant {
            pivot,
            ground: hit.entity,
            anchor_ground: into * point.with_y(plane.height(point)),
            normal_ground: into.rotation * hit.normal,
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
        let anchor = Vec3::from(anchor);
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

    fn swing<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) -> PlacedFoot {
        let (dt, config) = (around.dt, around.config);
        self.yaw_offset *= remaining(config.release_half_life, dt);
        let time_left = foot.time_to_contact.clamp(0.0, 0.6);
        let landing = self.foresee(foot.landing, foot.landing_forward, time_left, around);
        let half_life = config.release_half_life.min((time_left * 0.3).max(0.01));
        self.offset.step(foot.landing_forward * self.shift, half_life, dt);
        self.lift.step(0.0, 0.05, dt);
        let ball = foot.ball + self.offset.value;
        let share = progress(self.takeoff, landing, ball, foot.time_to_contact);
        self.fly(ball, landing, share, time_left, foot, around)
    }

    fn step<P: Probe, G: GroundFrames>(
        &mut self,
        elapsed: f32,
        from: Vec3,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let (dt, config) = (around.dt, around.config);
        let elapsed = elapsed + dt;
        let share = (elapsed / config.step_time.max(0.05)).clamp(0.0, 1.0);
        let time_left = (config.step_time - elapsed).max(0.0);
        self.mode = Mode::Stepping { elapsed, from };
        self.yaw_offset *= remaining(config.step_time * 0.25, dt);
        let landing = self.foresee(foot.ball, foot.forward, time_left, around);
        let smooth = share * share * (3.0 - 2.0 * share);
        let ball = from.lerp(landing, smooth).with_y(foot.ball.y);
        self.offset = Spring::at(flat(ball - foot.ball));
        let arc = 4.0 * share * (1.0 - share);
        self.lift = Spring::at(config.step_height * arc * arc);
        self.fly(ball, landing, smooth, time_left, foot, around)
    }

    /// Smooths where the foot will come down: place and height, moved until the whole sole has room.
    fn foresee<P: Probe, G: GroundFrames>(
        &mut self,
        landing: Vec3,
        forward: Vec3,
        time_left: f32,
        around: &Surroundings<'_, P, G>,
    ) -> Vec3 {
        let half_life = (time_left * 0.25).clamp(0.01, 0.06);
        let Some((shift, print)) = self.room(landing, forward, around) else {
            self.flatten.step(0.0, 0.05, around.dt);
            return landing.with_y(self.landing_height.value);
        };
        self.shift = shift;
        self.landing_height.step(print.ball.point.y, half_life, around.dt);
        self.flatten.step(if print.heel_gap > 0.025 { 1.0 } else { 0.0 }, 0.05, around.dt);
        let target = limited_align(print.ball.normal, forward, around.config);
        self.align = damp_quat(self.align, target, around.config.align_half_life, around.dt);
        (landing + forward * shift).with_y(self.landing_height.value)
    }

    fn room<P: Probe, G: GroundFrames>(
        &self,
        ball: Vec3,
        forward: Vec3,
        around: &Surroundings<'_, P, G>,
    ) -> Option<(f32, Footprint)> {
        let most = around.config.landing_shift;
        find_room(around.probe, around.reach, ball, forward, around.sole, self.shift, most)
    }

    /// Carries the foot over the ground between take-off and landing.
    fn fly<P: Probe, G: GroundFrames>(
        &mut self,
        ball: Vec3,
        landing: Vec3,
        share: f32,
        time_left: f32,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let line = |at: f32| self.takeoff.y + (landing.y - self.takeoff.y) * at;
        let ahead = direction_or(flat(landing - self.takeoff), foot.forward);
        let mut in_the_way = 0.0f32;
        for step in 0..4 {
            let along = step as f32 / 4.0;
            let place = ball.lerp(landing, along) + ahead * around.sole.tip;
            if let Some(hit) = around.reach.at(around.probe, place) {
                let at = share + (1.0 - share) * along;
                in_the_way = in_the_way.max(hit.point.y - line(at));
            }
        }
        for place in [ball, ball - foot.forward * around.sole.heel] {
            if let Some(hit) = around.reach.at(around.probe, place) {
                in_the_way = in_the_way.max(hit.point.y - line(share));
            }
        }
        let bump = if in_the_way > 0.02 { in_the_way + around.config.clearance } else { 0.0 };
        // What lies under the landing itself is no obstacle.
        let bump = bump * (1.0 - share * share).max(0.0).sqrt();
        self.bump.step(bump, (time_left * 0.3).clamp(0.012, 0.05), around.dt);
        self.height = line(share) + self.bump.value.max(0.0);
        let normal = self.align * Vec3::Y;
        let plane = Plane { point: ball.with_y(self.height), normal };
        let mut placed = self.place(foot, None, plane, around);
        placed.landing = Some((landing, time_left));
        self.clear(&mut placed, around);
        placed
    }

    /// Lifts a flying foot out of ground that nobody foresaw.
    fn clear<P: Probe, G: GroundFrames>(&mut self, placed: &mut PlacedFoot, around: &Surroundings<'_, P, G>) {
        let mut deepest = 0.0f32;
        for point in placed.sole {
            if let Some(hit) = around.reach.at(around.probe, point) {
                deepest = deepest.max(hit.point.y - point.y);
            }
        }
        if deepest > TOUCH {
            let lift = Vec3::Y * (deepest - TOUCH);
            placed.ankle += lift;
            placed.sole = placed.sole.map(|point| point + lift);
            self.placed_ball += lift;
            self.bump.value += lift.y;
        }
    }

    /// Turns the foot to the plane and sets its lowest point as high over it as the clip has it over its floor.
    fn place<P: Probe, G: GroundFrames>(
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

/// Depth in metres to which a flying foot may graze the ground.
const TOUCH: f32 = 0.002;

/// Takes toe-up pitch out of a foot, as far as `share` says.
fn flattening(foot: &AnimatedFoot, share: f32) -> Quat {
    let sole = foot.ball - foot.heel;
    if share <= 0.0 || sole.y <= 0.0 {
        return Quat::IDENTITY;
    }
    from_scaled_axis(to_scaled_axis(shortest_arc(sole, flat(sole))) * share)
}

/// Turn from upright to the ground's normal, within the foot's limits of pitch and roll.
fn limited_align(normal: Vec3, forward: Vec3, config: &FootIkConfig) -> Quat {
    let forward = direction_or(flat(forward), Vec3::NEG_Z);
    let side = forward.cross(Vec3::Y);
    let turn = to_scaled_axis(shortest_arc(Vec3::Y, normal));
    let pitch = turn.dot(side).clamp(-config.pitch_limit, config.pitch_limit);
    let roll = turn.dot(forward).clamp(-config.roll_limit, config.roll_limit);
    from_scaled_axis(side * pitch + forward * roll)
}

/// How far between take-off and landing the ball is, 0..1.
fn progress(from: Vec3, to: Vec3, at: Vec3, time_left: f32) -> f32 {
    let way = flat(to - from);
    let length = way.length_squared();
    if length < 0.01 {
        return (1.0 - time_left / 0.4).clamp(0.0, 1.0);
    }
    (flat(at - from).dot(way) / length).clamp(0.0, 1.0)
}

fn anchor_world(plant: &Plant, frames: &impl GroundFrames) -> Option<Vec3> {
    frames.frame(plant.ground).map(|frame| Vec3::from(frame * plant.anchor_ground))
}

fn flat(vector: Vec3) -> Vec3 {
    vector.with_y(0.0)
}
