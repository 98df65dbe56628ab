//! Where a flying foot will come down: ground that carries the whole sole, near where the clip would land.
//!
//! World space, metres, +Y up. Probes only when the place has moved; a decision stays from frame to frame, and is not
//! changed any more shortly before contact.

use bevy::{math::ops, prelude::*};

use super::{
    flight::ease,
    foot::flat,
    ground::{Footprint, Plane, Probe, find_room, footprint},
    surroundings::{GroundFrames, Surroundings},
    turns::limited_align,
};
use crate::{
    math::spring::{Spring, damp, damp_quat, damp_vec3, remaining},
    rig::tuning::foot_ik::TUNED_LEG,
};

/// Seconds before contact from which the landing is not moved any more.
const SETTLED: f32 = 0.1;
/// Seconds before that over which it is moved less and less.
const SETTLES: f32 = 0.1;
/// Metres that it may stay behind where the clip would land by then: a body that turns back would leave it out of reach.
const STAYS: f32 = 0.3;
/// Share of that from which on it stays less and less, so that it never starts at once.
const YIELDS: f32 = 0.7;
/// Metres that a place may move before its ground is probed again.
const MOVED: f32 = 0.01;
/// Half-life in seconds over which a landing follows what is found; shorter when little time is left.
const FOLLOW: f32 = 0.05;
/// Metres from the planned place within which a foot counts as landed there.
const NEAR: f32 = 0.05;
/// Metres between where a clip's foot was to come down and where it did, within which that was foreseen.
const FORESEEN: f32 = 0.05;
/// Metres under the heel from which on a landing hangs over an edge.
const EDGE: f32 = 0.025;

/// A lower step: from which height on, metres, a foot reaches for it with its toes, and by how much higher it does so fully.
const STEP_DOWN: (f32, f32) = (0.06, 0.1);

/// Height from one foot's ground to the other's, in lengths of the leg, that legs take in one step, and the places that are
/// tried on the way back to the body from one that is further up or down.
const HIGHEST: f32 = 0.6;
const NEARER: u8 = 6;

/// Room that feet look for, longer for their legs than the mannequin's, as a factor on what it looks for.
const LONG_FEET: (f32, f32) = (1.0, 1.75);

/// Where a foot will come down.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Landing {
    /// The ball's place on the ground.
    pub(super) place: Vec3,
    /// Turn from upright to the ground there.
    pub(super) align: Quat,
    /// Whether the heel would hang over an edge.
    pub(super) over_edge: bool,
    /// Metres along the foot from where the clip would land to where there is room; smoothed, and as found.
    shift: f32,
    wanted_shift: f32,
    /// Metres from there to where legs reach, likewise.
    nearer: Vec3,
    wanted_nearer: Vec3,
    height: Spring<f32>,
    /// Whether the place is not moved any more; where the clip would land, and how far from there it has stayed behind.
    settled: bool,
    clip: Vec3,
    behind: Vec3,
    /// The ground there, and its frame in the last frame.
    ground: Option<(Entity, Isometry3d)>,
    /// Where the ground was probed last, as seen from which height, and what was there.
    probed: Option<(Vec3, Option<Footprint>)>,
    known: bool,
}

impl Landing {
    /// Looks for room near `ball` and takes it at once. Without any ground the foot stays at `height`.
    pub(super) fn plan<P: Probe, G: GroundFrames>(
        &mut self,
        ball: Vec3,
        forward: Vec3,
        height: f32,
        around: &Surroundings<'_, P, G>,
    ) {
        self.known = false;
        self.probed = None;
        self.foresee(ball, forward, 1.0, height, around);
    }

    /// One frame: smooths where the foot will come down in `time_left` seconds, if the clip would land at `ball`.
    pub(super) fn foresee<P: Probe, G: GroundFrames>(
        &mut self,
        ball: Vec3,
        forward: Vec3,
        time_left: f32,
        height: f32,
        around: &Surroundings<'_, P, G>,
    ) {
        let first = !self.known;
        self.known = true;
        let ball = self.follow(ball, time_left, first, around);
        self.probe(ball, forward, around);
        let print = self.probed.and_then(|(_, print)| print);
        let on = print.map(|print| print.ball.entity);
        self.ground = on.and_then(|on| Some((on, around.frames.frame(on)?)));
        let half_life = if first { 0.0 } else { FOLLOW.min(0.25 * time_left).max(0.01) };
        self.shift = damp(self.shift, self.wanted_shift, half_life, around.dt);
        self.nearer = damp_vec3(self.nearer, self.wanted_nearer, half_life, around.dt);
        let level = print.map_or(height, |print| print.ball.point.y);
        let align = print.map_or(Quat::IDENTITY, |print| limited_align(print.normal, forward, around.config));
        if first {
            self.height = Spring::at(level);
            self.align = align;
        }
        self.height.step(level, half_life, around.dt);
        self.align = damp_quat(self.align, align, half_life, around.dt);
        self.over_edge = print.is_some_and(|print| print.heel_gap > EDGE * around.size);
        self.place = (ball + forward * self.shift + self.nearer).with_y(self.height.value);
        if time_left < SETTLED && !self.settled {
            self.settled = true;
            self.behind += forward * self.wanted_shift + self.wanted_nearer;
            self.shift -= self.wanted_shift;
            self.nearer -= self.wanted_nearer;
            (self.wanted_shift, self.wanted_nearer) = (0.0, Vec3::ZERO);
        }
    }

    /// The clip's place, followed less and less as the foot comes down.
    fn follow<P: Probe, G: GroundFrames>(
        &mut self,
        clip: Vec3,
        time_left: f32,
        first: bool,
        around: &Surroundings<'_, P, G>,
    ) -> Vec3 {
        let follows = ease(((time_left - SETTLED) / SETTLES).clamp(0.0, 1.0));
        let moved = if first { Vec3::ZERO } else { clip - self.clip };
        self.clip = clip;
        self.behind -= moved * (1.0 - follows);
        if follows >= 1.0 {
            self.behind *= remaining(FOLLOW, around.dt);
        }
        clip + short_of(self.behind, STAYS * around.size)
    }

    /// The ground has moved since the last frame, and carries along a place that is told as it is now. A landing that is foreseen
    /// is told as it will be, with all that the ground carries it.
    pub(super) fn ride(&mut self, frames: &impl GroundFrames) {
        self.clip += self.carried(self.place, frames) - self.place;
    }

    /// Where `point`, world, is now that moved with the ground there since the last frame; its height stays.
    pub(super) fn carried(&self, point: Vec3, frames: &impl GroundFrames) -> Vec3 {
        let moved = self.ground.and_then(|(on, before)| Some(frames.frame(on)? * (before.inverse() * point)));
        moved.map_or(point, |moved| moved.with_y(point.y))
    }

    /// Whether the clip's foot came down at `ball` as was foreseen: what takes the place from there is room alone.
    pub(super) fn was_foreseen(&self, ball: Vec3, size: f32) -> bool {
        self.known && flat(self.clip - ball).length() < FORESEEN * size
    }

    /// How far, 0..1, the place is a step down from `takeoff`, rather than further down one slope or up another.
    pub(super) fn step_down(&self, takeoff: Plane, size: f32) -> f32 {
        let (least, more) = STEP_DOWN;
        let plane = Plane { point: self.place, normal: self.align * Vec3::Y };
        let below = (takeoff.point.y - plane.height(takeoff.point)).min(takeoff.height(self.place) - self.place.y);
        ((below / size - least) / more).clamp(0.0, 1.0)
    }

    /// The footprint that carries a foot whose ball came down at `ball`: the one that was planned, if it is that.
    pub(super) fn print_under<P: Probe, G: GroundFrames>(
        &self,
        ball: Vec3,
        forward: Vec3,
        around: &Surroundings<'_, P, G>,
    ) -> Option<Footprint> {
        let planned = self.probed.and_then(|(_, print)| print);
        let away = flat(ball - self.place).length();
        planned.filter(|_| away < NEAR * around.size.max(1.0)).or_else(|| print_at(ball, forward, around))
    }

    fn probe<P: Probe, G: GroundFrames>(&mut self, ball: Vec3, forward: Vec3, around: &Surroundings<'_, P, G>) {
        // A body that rises or sinks may be carried by its ground.
        let seen = ball.with_y(around.reach.root.y);
        if self.probed.is_some_and(|(last, _)| last.distance(seen) < MOVED * around.size) {
            return;
        }
        let print = if self.settled {
            print_at(ball, forward, around)
        } else {
            let (least, longest) = LONG_FEET;
            let most = around.config.landing_shift * (around.sole.size() / around.size).clamp(least, longest);
            let found = find_room(around.probe, around.reach, ball, forward, around.sole, self.wanted_shift, most);
            let nearer =
                found.filter(|(_, print)| !around.may_step_to(print)).and_then(|_| self.nearer(ball, forward, around));
            self.wanted_nearer = nearer.map_or(Vec3::ZERO, |(nearer, _)| nearer);
            self.wanted_shift =
                if nearer.is_some() { 0.0 } else { found.map_or(self.wanted_shift, |(shift, _)| shift) };
            nearer.map(|(_, print)| print).or(found.map(|(_, print)| print))
        };
        self.probed = Some((seen, print));
    }
}

impl Landing {
    /// For what is too high or too low for legs that stand where the other foot does: a place nearer to the body that isn't,
    /// the last one if it will do.
    fn nearer<P: Probe, G: GroundFrames>(
        &self,
        ball: Vec3,
        forward: Vec3,
        around: &Surroundings<'_, P, G>,
    ) -> Option<(Vec3, Footprint)> {
        // A landing stays no further behind than that.
        let back = flat(around.reach.root - ball).clamp_length_max(YIELDS * STAYS * around.size);
        let tries = (1..=NEARER).map(|step| back * (f32::from(step) / f32::from(NEARER)));
        let mut reached = None;
        for shift in core::iter::once(self.wanted_nearer).chain(tries) {
            let print = print_at(ball + shift, forward, around).filter(|print| around.may_step_to(print));
            let Some(print) = print else { continue };
            if print.has_room(&around.sole) {
                return Some((shift, print));
            }
            reached = reached.or(Some((shift, print)));
        }
        reached
    }
}

impl<P, G> Surroundings<'_, P, G> {
    /// Whether legs bend and stretch far enough to stand on both.
    fn may_step_to(&self, print: &Footprint) -> bool {
        self.level.is_none_or(|level| (print.ball.point.y - level).abs() <= HIGHEST * TUNED_LEG * self.size)
    }
}

/// `way` as long as it is well below `most`, and less and less of it beyond, so that it is never longer than that.
fn short_of(way: Vec3, most: f32) -> Vec3 {
    let (length, whole) = (way.length(), YIELDS * most);
    if length <= whole {
        return way;
    }
    way * ((whole + (most - whole) * ops::tanh((length - whole) / (most - whole))) / length)
}

/// The footprint at `ball`, on the ground.
pub(super) fn print_at<P: Probe, G: GroundFrames>(
    ball: Vec3,
    forward: Vec3,
    around: &Surroundings<'_, P, G>,
) -> Option<Footprint> {
    footprint(around.probe, around.reach, ball, forward, around.sole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_landing_yields_smoothly_and_never_stays_too_far_behind() {
        let lengths: Vec<f32> = (0..200).map(|cm| short_of(Vec3::X * (cm as f32 * 0.01), STAYS).x).collect();
        assert!((lengths[15] - 0.15).abs() < 1e-6, "{} m of 0.15 are stayed behind", lengths[15]);
        assert!(lengths.iter().all(|length| *length < STAYS + 1e-6), "stays {} m behind", lengths[199]);
        for three in lengths.windows(3) {
            let kink = (three[2] - 2.0 * three[1] + three[0]).abs();
            assert!(kink < 1e-3, "kinks by {kink} m in 1 cm at {} m", three[1]);
        }
    }
}
