//! What a foot does next: hold, swing, or step by itself.
//!
//! World space, metres, +Y up. The clip's contacts decide, and how far the body has left a plant; who stops finishes his
//! steps himself.

use super::{
    flight::{Flight, ease},
    foot::{FootState, Mode, Pivot, Release, anchor_world, flat},
    ground::Probe,
    landing::Landing,
    surroundings::{AnimatedFoot, GroundFrames, Surroundings},
};
use crate::math::rotation::yaw;

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
/// Metres over its ground from which on a foot doesn't land yet.
const HIGH: f32 = 0.1;
/// Metres by which a leg may miss its place on the ground: one that misses it by more isn't there.
const MISSES: f32 = 0.02;
/// Metres by which a leg may be behind its foot's place when the foot comes to stand there: it would slide the rest.
const BEHIND: f32 = 0.01;
/// The same for a foot that stands already: from there on it steps.
const SLIDES: f32 = 0.03;
/// Seconds in which the pelvis of one who stands sinks so far that his legs reach.
const SINKS: f32 = 0.4;
/// Share of its time in the air from which on a foot counts as landed when its clip stands.
const NEARLY: f32 = 0.85;
/// Metres of a step from which on it is lifted by the whole step height.
const FULL_ARC: f32 = 0.15;
/// Share of the step height that any step is lifted by.
const LEAST_ARC: f32 = 0.3;

impl FootState {
    /// One frame: keeps what it does, or begins something else.
    pub(super) fn decide<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        let size = around.size;
        // What a small body misses on steps made for people is no smaller.
        let slack = size.max(1.0);
        match self.mode {
            Mode::Planted(plant) => {
                let Some(anchor) = anchor_world(&plant, around.frames) else {
                    return self.release(Release::LostGround, foot, around);
                };
                if foot.contact < 0.5 && !around.halts {
                    return self.release(Release::ContactEnded, foot, around);
                }
                if foot.contact < 0.5 && around.other.is_some() {
                    // Who stops makes the last step himself: a swing that fades would only drag the foot.
                    return self.begin_step(Release::ContactEnded, foot, around);
                }
                let error = flat(anchor - foot.point(plant.pivot)).length();
                let turned = self.yaw_offset.abs();
                let config = around.config;
                // A gait lifts the foot soon by itself.
                let patience = if around.may_restep { 1.0 } else { PATIENCE };
                let strained = self.missed > MISSES * slack || self.behind > SLIDES * slack;
                self.strained = if strained { self.strained + around.dt } else { 0.0 };
                if strained && (self.strained > SINKS || !around.may_restep) {
                    self.begin_step(Release::TooFar, foot, around);
                } else if foot.contact < 0.9 || matches!(around.other, None | Some(Pivot::Tip)) {
                    // Half lifted already, or the other is or soon will be.
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
                let (down, amid) = if around.halts { (TOUCHES, true) } else { (DOWN, self.flight.share() < NEARLY) };
                if self.missed > MISSES * slack
                    || self.behind > BEHIND * slack
                    || amid && (self.above > down * slack || aside > THERE * slack)
                {
                    // Down a step there is little room: it goes on to where it was coming down, on that tread and no other.
                    let keeps = !around.halts && self.steps_down(size) && self.landing.was_foreseen(foot.ball, size);
                    let kept = keeps.then_some(self.landing);
                    self.finish_step(foot, aside, size);
                    self.flight.keeps_landing = keeps;
                    self.landing = kept.unwrap_or_default();
                } else if self.above < HIGH * size || self.flight.share() >= 1.0 {
                    // One that is still high has one frame more to come down to its landing.
                    self.lock(foot, around);
                }
            }
            Mode::Swing => {}
            Mode::Stepping { elapsed, seconds } => {
                if foot.contact < 0.5 && !around.halts {
                    self.mode = Mode::Swing;
                    self.change_way(foot);
                } else if elapsed >= seconds && self.behind < BEHIND * slack || self.touches_down(slack) {
                    self.lock(foot, around);
                } else if self.flight.keeps_landing && around.halts {
                    // Who halts stands elsewhere than he would have stepped.
                    self.change_way(foot);
                    self.flight.finishes = true;
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
            self.yaw_offset = plant.yaw_offset(foot, around.frames);
            let from_pivot = yaw(self.yaw_offset) * (foot.ball - foot.point(plant.pivot));
            self.placed_ball = (anchor + from_pivot).with_y(self.placed_ball.y);
        }
        self.released = why;
        self.mode = Mode::Swing;
        self.landing = Landing::default();
        self.flight = Flight::from(self, foot);
        self.flight.leave(plant.map(|plant| plant.ground), around.frames);
        self.carry.lift_off();
    }

    fn begin_step<P: Probe, G: GroundFrames>(
        &mut self,
        why: Release,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) {
        self.release(why, foot, around);
        let aside = flat(self.placed_ball - foot.ball).length();
        let far = aside * UNHURRIED / around.size;
        let turned = (self.yaw_offset.abs() / RESTEP_YAW).min(1.0);
        self.flight.arc = ease((aside / (FULL_ARC * around.size)).min(1.0)).max(ease(turned)).max(LEAST_ARC);
        self.mode = Mode::Stepping { elapsed: 0.0, seconds: around.config.step_time.max(HURRY).max(far) };
    }

    /// The clip stands while the foot is still in the air: it comes down by a step of its own.
    pub(super) fn finish_step(&mut self, foot: &AnimatedFoot, aside: f32, size: f32) {
        let (aside, above) = (aside / size, self.above / size);
        let seconds = (SHORTEST_FINISH + UNHURRIED * aside + FALLS * above).min(LONGEST_FINISH);
        self.mode = Mode::Stepping { elapsed: 0.0, seconds };
        self.change_way(foot);
        self.flight.arc = ease((aside / FULL_ARC).min(1.0)) * (1.0 - above / FULL_ARC).max(0.0);
        self.flight.finishes = true;
    }

    /// A foot that finishes what its clip began is down as soon as it is there.
    fn touches_down(&self, slack: f32) -> bool {
        let aside = flat(self.placed_ball - self.landing.place).length();
        self.flight.finishes
            && self.flight.share() > 0.0
            && self.behind < BEHIND * slack
            && self.above < TOUCHES * slack
            && aside < THERE * slack
    }
}
