//! A foot on the ground: from heel strike over the flat sole to push-off, held by one point of the sole.
//!
//! World space, metres, +Y up. Plants are kept in the ground's own frame.

use bevy::prelude::*;

use super::{
    foot::{FootState, Mode, Pivot, Plant, flat},
    ground::{Footprint, Plane, Probe},
    landing::{Landing, print_at},
    surroundings::{AnimatedFoot, GroundFrames, PlacedFoot, Surroundings},
    turns::limited_align,
};
use crate::math::{
    rotation::{heading, twist_angle, wrap_angle, yaw},
    spring::{damp, damp_quat, remaining},
};

/// Metres of height between two grounds that don't carry one sole.
const ACROSS: f32 = 0.05;
/// Metres by which one end of the sole must be over the other to count as lifted.
const ROLLED: f32 = 0.002;
/// Metres by which the heel must be lower than the ball to come down first.
const STRIKES: f32 = 0.004;
/// Metres to which a foot may settle onto its ground from below.
const SUNK: f32 = 0.002;
/// Half-lives in seconds: in which a heel comes down after a landing on the toes, and in which a foot takes its weight.
const HEEL_DOWN: f32 = 0.05;
const TAKES_WEIGHT: f32 = 0.06;
/// Metres that a foot may drop at once as it comes to stand.
const DROPS: f32 = 0.02;
/// Half-life in seconds in which a foot that came down over or under its ground settles onto it.
const SETTLE: f32 = 0.02;
/// The same for one that its clip has over its own floor while it stands.
const HOVERS: f32 = 0.05;

impl FootState {
    /// Takes hold of the ground where the foot is now.
    pub(super) fn lock<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        self.placed_ball = self.landing.carried(self.placed_ball, around.frames);
        let has_room =
            |place: Vec3| print_at(place, foot.forward, around).is_some_and(|print| print.has_room(&around.sole));
        if self.mode == Mode::Swing && !has_room(self.placed_ball) {
            // The clip's foot came down between two frames: until then this one went on to where there is room.
            let rest = flat(self.landing.place - self.placed_ball);
            self.placed_ball += rest.clamp_length_max(flat(self.carry.velocity()).length() * around.dt);
        }
        self.carry.end();
        self.aside = flat(self.placed_ball - foot.ball).length();
        // After a step of its own a foot takes its weight by and by.
        self.forefoot = if matches!(self.mode, Mode::Stepping { .. }) { 0.0 } else { 1.0 };
        let heel_first = foot.heel.y < foot.ball.y - STRIKES * around.size && self.flatten.value < 0.5;
        let before = self.placed_ball.y;
        self.plant_at(if heel_first { Pivot::Heel } else { Pivot::Ball }, foot, around);
        if let Mode::Planted(plant) = self.mode {
            // What held it up until now lets it down by and by.
            let anchor = self.ground * plant.anchor_ground;
            let normal = self.ground.rotation * plant.normal_ground;
            let plane = Plane { point: anchor + Vec3::Y * self.over, normal };
            self.place(foot, Some((plant.pivot, anchor)), plane);
            self.over += (before - self.placed_ball.y - DROPS * around.size).max(0.0);
        }
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
        let facing = yaw(self.yaw_offset) * foot.forward;
        let point = self.placed(pivot);
        self.over = self.base - plane.height(self.placed_ball);
        self.ground = frame;
        self.mode = Mode::Planted(Plant {
            pivot,
            ground: hit.entity,
            anchor_ground: into * point.with_y(plane.height(point)),
            normal_ground: into.rotation * normal,
            yaw_ground: wrap_angle(heading(facing) - twist_angle(frame.rotation, Vec3::Y)),
        });
    }

    /// One frame on the ground.
    pub(super) fn hold<P: Probe, G: GroundFrames>(
        &mut self,
        plant: &Plant,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let dt = around.dt;
        let frame = around.frames.frame(plant.ground).unwrap_or(Isometry3d::IDENTITY);
        let anchor = frame * plant.anchor_ground;
        let normal = frame.rotation * plant.normal_ground;
        // What was placed in the last frame has moved with the ground since.
        let carried = frame * core::mem::replace(&mut self.ground, frame).inverse();
        self.placed_ball = carried * self.placed_ball;
        self.yaw_offset = plant.yaw_offset(foot, around.frames);
        // The clip brings the forefoot down by itself.
        self.flatten.step(self.flatten.value.round(), 0.05, dt);
        self.toes_down *= remaining(HEEL_DOWN, dt);
        self.forefoot = damp(self.forefoot, 1.0, TAKES_WEIGHT, dt);
        // A landing that was foreseen wrongly sinks or rises onto its ground within a few frames.
        self.over = self.over.max(-SUNK * around.size) * remaining(SETTLE, dt);
        self.hovers = damp(self.hovers, foot.lowest().max(0.0), HOVERS, dt);
        let target = limited_align(normal, foot.forward, around.config);
        self.align = damp_quat(self.align, target, around.config.align_half_life, dt);
        let plane = Plane { point: anchor + Vec3::Y * self.over, normal };
        // The sole rolls from heel over ball to tip; what lies on the ground carries the lock, from where it was last.
        let [heel, ball, tip] = [foot.heel, foot.ball, foot.tip].map(|point| point.y - foot.floor);
        let rolled = ROLLED * around.size;
        let (pivot, anchor) = match plant.pivot {
            // A clip that pushes its tip into the floor is shown that much higher: what is lowest lies on the ground.
            Pivot::Ball if ball > rolled + tip && tip < heel => self.roll(Pivot::Tip, plant, plane, frame),
            Pivot::Tip if ball <= tip => self.roll(Pivot::Ball, plant, plane, frame),
            pivot => (pivot, anchor),
        };
        let placed = self.place(foot, Some((pivot, anchor)), plane);
        self.base = plane.height(self.placed_ball);
        if plant.pivot == Pivot::Heel && ball <= rolled + heel.max(0.0) {
            self.roll(Pivot::Ball, plant, plane, frame);
            self.forefoot = 0.0;
            self.lay_flat(foot, around);
        }
        PlacedFoot { takeoff: self.placed_ball.with_y(self.base), ..placed }
    }

    /// The forefoot is down: the ground under it carries the sole, unless that is across an edge.
    fn lay_flat<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        let found = print_at(self.placed_ball, foot.forward, around);
        if found.is_some_and(|print| (print.ball.point.y - self.base).abs() < ACROSS * around.size) {
            self.landing = Landing::default();
            self.plant_at(Pivot::Ball, foot, around);
        }
    }

    /// The same plane carries the foot on, held by another point; gives that, and where it is held.
    fn roll(&mut self, onto: Pivot, plant: &Plant, plane: Plane, frame: Isometry3d) -> (Pivot, Vec3) {
        let point = self.placed(onto);
        let on_ground = point.with_y(plane.height(point) - self.over);
        self.mode = Mode::Planted(Plant { pivot: onto, anchor_ground: frame.inverse() * on_ground, ..*plant });
        (onto, on_ground)
    }
}
