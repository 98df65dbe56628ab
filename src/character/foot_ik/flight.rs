//! A foot in the air: from where it left to where it will land, over what lies between.
//!
//! World space, metres, +Y up. What the flight adds to the clip eases from take-off to landing with neither speed nor
//! acceleration at both ends: a foot leaves its place without sliding and comes to rest on the next.

use bevy::prelude::*;

use super::{
    foot::{FootState, Mode, flat},
    ground::{Plane, Probe},
    surroundings::{AnimatedFoot, GroundFrames, PlacedFoot, Surroundings},
    way::Way,
};
use crate::math::{
    rotation::{heading, to_scaled_axis, wrap_angle},
    spring::{damp, remaining},
};

/// Depth in metres to which a flying foot may graze the ground.
const TOUCH: f32 = 0.002;
/// Metres beyond heel and tip that clear the ground too: an edge is not passed by a hair.
const RIM: f32 = 0.005;
/// Metres that a swinging foot keeps from its ground, and the shares of a swing at both ends in which that eases.
const CLEARS: f32 = 0.015;
const EDGES: f32 = 0.2;
/// Half-life in seconds of a lift out of ground that nobody foresaw.
const GUARD_HALF_LIFE: f32 = 0.06;
/// Share of a swing over which a foot is held that leaves late or has something right before it, and share of the swing
/// from which on it is late.
const HOLD: f32 = 0.4;
const LATE: f32 = 0.15;
/// Height in metres of a thing right before a foot from which on it goes up before it goes over.
const BLOCKS: f32 = 0.1;
/// Radians of a slope from which on a foot leaves upward before it goes forward, and the share of a swing in which it does:
/// turned to a slope it is nearer to the ground than the clip has it.
const TILTED: (f32, f32) = (0.1, 0.12);
/// Most that toes point down to reach a lower step, radians: 23°, of some 50° that an ankle has (GAIT.md).
const TOES_DOWN: f32 = 0.4;
/// Share of a swing after which toes begin to point down, and the share over which they do.
const POINTS: (f32, f32) = (0.3, 0.5);
/// Half-life in seconds in which toes follow a landing that was foreseen anew.
const FOLLOWS: f32 = 0.02;
/// Seconds that a metre of height takes in a step of its own.
const CLIMBS: f32 = 2.0;
/// Share of a flight over which a foot comes to turn with the body.
const TURNS: f32 = 0.4;
/// Metres of a way that is too short to tell by place how much of it is done.
const SHORT_WAY: f32 = 0.15;

/// How a foot left the ground, and what it flies over.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flight {
    /// Where the ball is now without obstacles, world; the height doesn't matter.
    pub(super) ball: Vec3,
    /// Metres that the foot is lifted beyond clip and ground.
    pub(super) lift: f32,
    /// The ball at take-off, on the ground there; and the same in the frame of that ground.
    takeoff: Vec3,
    left: Option<(Entity, Vec3)>,
    /// Horizontal metres from the clip's ball to the placed one at take-off.
    offset: Vec3,
    /// Turns of take-off: about +Y against the clip, and to the ground.
    yaw: f32,
    align: Quat,
    /// Way that the clip's foot had in the last frame, heading in radians, and how far it has turned since take-off.
    heading: f32,
    turned: f32,
    /// Metres by which the clip had the standing foot over its floor.
    hovers: f32,
    /// Share of the clip's swing that had passed at take-off, and of its time in the air that has passed by now.
    since: f32,
    share: f32,
    way: Way,
    /// Lift out of ground that nobody foresaw, metres.
    guard: f32,
    /// Whether it finishes what a clip began.
    pub(super) finishes: bool,
    /// Whether it does so where it was to end, not where the clip's foot is.
    pub(super) keeps_landing: bool,
    /// How much of the step height a step of its own is lifted by, 0..1.
    pub(super) arc: f32,
}

impl Flight {
    /// Takes off from where `state` has the foot.
    pub(super) fn from(state: &FootState, foot: &AnimatedFoot) -> Self {
        Self {
            ball: state.placed_ball,
            takeoff: state.placed_ball.with_y(state.base),
            offset: flat(state.placed_ball - foot.ball),
            yaw: state.yaw_offset,
            align: state.align,
            heading: heading(foot.forward),
            hovers: state.hovers,
            since: if foot.swing < 1.0 { foot.swing.min(0.9) } else { 0.0 },
            arc: 1.0,
            ..Self::default()
        }
    }

    /// Remembers take-off in the frame of the ground that it left.
    pub(super) fn leave(&mut self, ground: Option<Entity>, frames: &impl GroundFrames) {
        self.left = ground.and_then(|ground| Some((ground, frames.frame(ground)?.inverse() * self.takeoff)));
    }

    /// 1 in flight, eased to 0 at take-off and landing.
    fn amid(&self) -> f32 {
        ease((self.share / EDGES).min(1.0)) * ease(((1.0 - self.share) / EDGES).min(1.0))
    }

    /// How much of its time in the air has passed, 0..1.
    pub(super) fn share(&self) -> f32 {
        self.share
    }

    /// How much of its time in the air has passed, `dt` seconds later: the rest of it is over when the clip's foot lands,
    /// however often the clips change their minds when that is.
    fn advance(&mut self, foot: &AnimatedFoot, dt: f32) -> f32 {
        if foot.swing < 1.0 {
            let left = foot.time_to_contact.max(0.0);
            self.share = 1.0 - (1.0 - self.share) * left / (left + dt);
        }
        self.share
    }

    /// How much what is right before the foot is in its way, 0..1.
    fn blocked(&self) -> f32 {
        (self.way.ahead() / (BLOCKS * self.way.size())).min(1.0)
    }

    /// A foot that leaves in the middle of the clip's swing, or before a step up, is let go by and by, until it is off the
    /// ground.
    fn held(&self, ball: Vec3) -> Vec3 {
        let tilt = TILTED.1 * (to_scaled_axis(self.align).length() / TILTED.0).min(1.0);
        let window = tilt.max(HOLD * (self.since / LATE).max(self.blocked()).min(1.0));
        self.takeoff.lerp(ball, ease((self.share / window.max(1e-3)).min(1.0)))
    }

    /// Radians by which a foot stays behind one that turns with its body: it leaves the ground first.
    fn stays_behind(&mut self, forward: Vec3) -> f32 {
        let now = heading(forward);
        self.turned += wrap_angle(now - core::mem::replace(&mut self.heading, now));
        self.turned * (1.0 - ease((self.share / TURNS).min(1.0)))
    }

    /// The plane that the foot left.
    fn ground(&self) -> Plane {
        Plane { point: self.takeoff, normal: self.align * Vec3::Y }
    }

    fn follow_ground(&mut self, frames: &impl GroundFrames) {
        if let Some((ground, place)) = self.left
            && let Some(frame) = frames.frame(ground)
        {
            self.takeoff = frame * place;
        }
    }
}

impl FootState {
    pub(super) fn swing<P: Probe, G: GroundFrames>(
        &mut self,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let time_left = foot.time_to_contact.clamp(0.0, 0.6);
        let eased = ease(self.flight.advance(foot, around.dt));
        self.landing.foresee(foot.landing, foot.landing_forward, time_left, self.base, around);
        self.look_over_the_way(foot, around);
        let at_landing = flat(self.landing.place - foot.landing);
        let left = self.flight.offset * (1.0 - eased);
        let ball = self.flight.held(foot.ball + left + at_landing * eased);
        self.fly(ball, eased, time_left, foot, around)
    }

    pub(super) fn step<P: Probe, G: GroundFrames>(
        &mut self,
        (elapsed, seconds): (f32, f32),
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let begins = elapsed == 0.0;
        // A leg that is behind its way is waited for.
        let elapsed = elapsed + around.dt * self.pace.share();
        self.landing.ride(around.frames);
        let follows = if self.flight.keeps_landing { 0.0 } else { (seconds - elapsed).max(0.0) };
        self.landing.foresee(foot.ball, foot.forward, follows, self.base, around);
        self.look_over_the_way(foot, around);
        // Up, down or over something takes longer.
        let climb = (self.landing.place.y - self.flight.takeoff.y).abs().max(self.flight.way.highest());
        let seconds = if begins { seconds + CLIMBS * climb / around.size } else { seconds };
        self.mode = Mode::Stepping { elapsed, seconds };
        let share = (elapsed / seconds).clamp(0.0, 1.0);
        self.flight.share = share;
        let time_left = (seconds - elapsed).max(0.0);
        let eased = ease(share);
        let ball = self.flight.takeoff.lerp(self.landing.place, eased);
        let arc = 4.0 * share * (1.0 - share);
        self.flight.lift = self.flight.arc * around.config.step_height * arc * arc;
        self.fly(ball, eased, time_left, foot, around)
    }

    /// Whether it comes down on a lower step.
    pub(super) fn steps_down(&self, size: f32) -> bool {
        self.landing.step_down(self.flight.ground(), size) > 0.5
    }

    fn look_over_the_way<P: Probe, G: GroundFrames>(&mut self, foot: &AnimatedFoot, around: &Surroundings<'_, P, G>) {
        self.flight.follow_ground(around.frames);
        let normal = self.flight.align.slerp(self.landing.align, 0.5) * Vec3::Y;
        self.flight.way.look([self.flight.takeoff, self.landing.place], foot.forward, normal, around);
    }

    /// Carries the foot over the ground between take-off and landing.
    fn fly<P: Probe, G: GroundFrames>(
        &mut self,
        ball: Vec3,
        eased: f32,
        time_left: f32,
        foot: &AnimatedFoot,
        around: &Surroundings<'_, P, G>,
    ) -> PlacedFoot {
        let landing = self.landing.place;
        self.flight.ball = ball;
        self.hovers = self.flight.hovers * (1.0 - eased);
        if self.mode == Mode::Swing {
            // Clips blended across each other may drag their feet; who swings them through the floor clears it three times as high.
            let sunk = (-foot.lowest() / (CLEARS * around.size)).clamp(0.0, 1.0);
            let clears = CLEARS * around.size * (1.0 + 2.0 * sunk);
            self.flight.lift = (clears * self.flight.amid() - self.height(foot)).max(0.0);
        }
        let done = self.flight.done(landing, eased, SHORT_WAY * around.size);
        let behind = if self.mode == Mode::Swing { 0.0 } else { self.flight.stays_behind(foot.forward) };
        self.yaw_offset = self.flight.yaw * (1.0 - eased) - behind;
        self.align = self.flight.align.slerp(self.landing.align, eased);
        let (later, over) = POINTS;
        let down = self.landing.step_down(self.flight.ground(), around.size);
        // A foot without toes comes down flat: its tip would go ahead into the step.
        let points = if around.sole.bends { TOES_DOWN } else { 0.0 };
        let points = points * down * ease(((self.flight.share - later) / over).clamp(0.0, 1.0));
        self.toes_down = damp(self.toes_down, points, FOLLOWS, around.dt);
        let flat_sole = self.landing.over_edge || down > 0.5;
        self.flatten.step(if flat_sole { 1.0 } else { 0.0 }, 0.05, around.dt);
        self.base = self.flight.takeoff.y + (landing.y - self.flight.takeoff.y) * done;
        let normal = self.align * Vec3::Y;
        let over = self.flight.way.lift(ball, self.flight.share);
        let plane = Plane { point: ball.with_y(self.base + over), normal };
        let mut placed = self.place(foot, None, plane);
        placed.takeoff = self.flight.takeoff;
        placed.landing = Some((landing, time_left));
        let kept = self.carry.offset(placed.ankle, placed.sole[2], 0.8 * time_left, around.dt);
        // A foot with something right before it is held by its place instead.
        let free = if self.carry.is_brief() { 1.0 - self.flight.blocked() } else { 1.0 };
        self.shift(&mut placed, kept * free);
        self.clear(&mut placed, around);
        let ground = Plane { point: landing, normal: self.landing.align * Vec3::Y };
        self.above = placed.sole.into_iter().map(|point| point.y - ground.height(point)).fold(f32::MAX, f32::min);
        placed
    }

    /// Lifts a flying foot out of ground that nobody foresaw.
    fn clear<P: Probe, G: GroundFrames>(&mut self, placed: &mut PlacedFoot, around: &Surroundings<'_, P, G>) {
        self.flight.guard *= remaining(GUARD_HALF_LIFE, around.dt);
        let mut deepest = self.flight.guard;
        // What comes down on a step below is almost there.
        let amid = if self.flight.keeps_landing { 0.0 } else { self.flight.amid() };
        let keeps = around.size * ((CLEARS + TOUCH) * amid - TOUCH);
        let rim = flat(placed.sole[2] - placed.sole[0]).normalize_or_zero() * (RIM * around.size);
        for (point, out) in placed.sole.into_iter().zip([-rim, Vec3::ZERO, rim]) {
            if let Some(ground) = around.reach.height(around.probe, point + out) {
                deepest = deepest.max(ground - point.y + keeps + self.droops);
            }
        }
        self.flight.guard = deepest;
        self.shift(placed, Vec3::Y * deepest);
    }

    fn shift(&mut self, placed: &mut PlacedFoot, by: Vec3) {
        placed.ankle += by;
        placed.sole = placed.sole.map(|point| point + by);
        self.placed_ball += by;
    }
}

impl Flight {
    /// Share of the way from take-off to landing that the ball has made; of the time where it is shorter than `short` metres.
    fn done(&self, landing: Vec3, eased: f32, short: f32) -> f32 {
        let way = flat(landing - self.takeoff);
        let length = way.length();
        let by_place = flat(self.ball - self.takeoff).dot(way) / (length * length).max(1e-6);
        let sure = ((length - 0.5 * short) / (0.5 * short)).clamp(0.0, 1.0);
        (eased + (by_place - eased) * sure).clamp(0.0, 1.0)
    }
}

/// 0 to 1 with neither speed nor acceleration at both ends.
pub(super) fn ease(t: f32) -> f32 {
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn easing_starts_and_ends_at_rest() {
        for (from, to) in [(0.0, 0.01), (0.99, 1.0)] {
            let moved = ease(to) - ease(from);
            assert!(moved.abs() < 1.1e-5, "{moved} between {from} and {to}");
        }
    }
}
