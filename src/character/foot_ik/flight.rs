//! A foot in the air: where it will land, and how it gets there over what lies between.
//!
//! World space, metres, +Y up.

use bevy::prelude::*;

use super::{
    foot::{FootState, Mode, flat},
    ground::{Footprint, Plane, Probe, find_room, footprint},
    surroundings::{AnimatedFoot, GroundFrames, PlacedFoot, Surroundings},
    turns::limited_align,
};
use crate::math::{
    rotation::direction_or,
    spring::{Spring, damp_quat, remaining},
};

/// Depth in metres to which a flying foot may graze the ground.
const TOUCH: f32 = 0.002;

/// Seconds before contact from which the landing is not moved any more.
const SETTLED: f32 = 0.1;

impl FootState {
    pub(super) fn swing<P: Probe, G: GroundFrames>(
        &mut self,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let (dt, config) = (around.dt, around.config);
        self.yaw_offset *= remaining(config.release_half_life, dt);
        let time_left = foot.time_to_contact.clamp(0.0, 0.6);
        let landing = self.foresee(foot.landing, foot.landing_forward, time_left, around);
        let half_life = config.release_half_life.min((time_left * 0.3).max(0.01));
        if time_left < SETTLED && self.settled.is_none() {
            self.settled = Some(landing);
        }
        // What the landing is moved by, the foot is moved by; both meet on the ground.
        self.offset.step(flat(landing - foot.landing), half_life, dt);
        self.lift.step(0.0, 0.05, dt);
        let ball = foot.ball + self.offset.value;
        let share = progress(self.takeoff, landing, ball, foot.time_to_contact);
        self.fly(ball, landing, share, time_left, foot, around)
    }

    pub(super) fn step<P: Probe, G: GroundFrames>(
        &mut self,
        (elapsed, seconds): (f32, f32),
        from: Vec3,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let (dt, config) = (around.dt, around.config);
        let elapsed = elapsed + dt;
        let share = (elapsed / seconds).clamp(0.0, 1.0);
        let time_left = (seconds - elapsed).max(0.0);
        self.mode = Mode::Stepping { elapsed, seconds, from };
        self.yaw_offset *= remaining(seconds * 0.25, dt);
        let landing = self.foresee(foot.ball, foot.forward, time_left, around);
        let smooth = share * share * (3.0 - 2.0 * share);
        let ball = from.lerp(landing, smooth).with_y(foot.ball.y);
        self.offset = Spring::at(flat(ball - foot.ball));
        let arc = 4.0 * share * (1.0 - share);
        self.lift = Spring::at(config.step_height * (seconds / config.step_time).min(1.0) * arc * arc);
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
        let found = match self.settled {
            Some(place) => footprint(around.probe, around.reach, place, forward, around.sole).map(|print| (0.0, print)),
            None => self.room(landing, forward, around),
        };
        let landing = self.settled.unwrap_or(landing);
        let Some((shift, print)) = found else {
            self.flatten.step(0.0, 0.05, around.dt);
            return landing.with_y(self.landing_height.value);
        };
        if self.settled.is_none() {
            self.shift = shift;
        }
        self.landing_height.step(print.ball.point.y, half_life, around.dt);
        self.flatten.step(if print.heel_gap > 0.025 { 1.0 } else { 0.0 }, 0.05, around.dt);
        let target = limited_align(print.normal, forward, around.config);
        self.align = damp_quat(self.align, target, around.config.align_half_life, around.dt);
        (landing + forward * shift).with_y(self.landing_height.value)
    }

    pub(super) fn room<P: Probe, G: GroundFrames>(
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
