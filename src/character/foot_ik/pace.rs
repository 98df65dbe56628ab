//! Legs in the air move hardly faster than the playing clips move them: what is asked of them comes a few frames later.
//!
//! Ground that is seen late, or that lies high or low, asks a foot to be elsewhere within a frame or two. Local rotations,
//! radians.

use bevy::prelude::*;

use super::SEEN;
use crate::{
    anim::{leg::Leg, pose::Pose, skeleton::Skeleton},
    math::rotation::{angle_between, to_scaled_axis},
};

/// How much faster than in the clips a leg may move: up to twice looks like the clip.
const LIVELIER: f32 = 1.67;
/// Seconds in which a leg at rest may come to move as fast as it may.
const STARTS: f32 = 0.0285;
/// Seconds for which a leg that has come down still moves as in the air.
const LANDS: f32 = 0.02;
/// Share of what is asked by which a leg that is late makes more of it in every frame, until it has caught up.
const CATCHES_UP: f32 = 0.12;

/// How a leg's joints were turned in the last frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    /// Hip, knee, ankle and toes, and whether they are known.
    last: [Quat; 3],
    toes: Quat,
    known: bool,
    /// Whether it is behind what was asked.
    late: bool,
    /// Angular velocities of hip, knee and ankle, rad/s.
    speeds: [Vec3; 3],
    /// Seconds since it stands.
    stands: f32,
    /// Share of what was asked that hip and knee, and the ankle, made in the last frame, if they are late.
    shares: [f32; 2],
}

impl Pace {
    /// Share of what was asked that the leg made in the last frame, 0..1.
    pub(super) fn share(&self) -> f32 {
        if self.late { self.shares[0] } else { 1.0 }
    }

    /// Whether the leg is behind what was asked.
    pub(super) fn is_late(&self) -> bool {
        self.late
    }

    /// Notes a pose that nobody asked anything of.
    pub(super) fn note(&mut self, pose: &Pose, leg: &Leg, dt: f32) {
        let last = leg.joints().map(|joint| pose.turn(joint));
        let speeds = self.turns(&last).map(|turn| turn / dt.max(1e-4));
        let toes = leg.toes.map_or(Quat::IDENTITY, |toes| pose.turn(toes));
        *self = Self { last, toes, known: true, speeds, ..Self::default() };
    }

    /// Turns since the last frame, in each joint's own space then.
    fn turns(&self, now: &[Quat; 3]) -> [Vec3; 3] {
        if !self.known {
            return [Vec3::ZERO; 3];
        }
        let turn = |joint: usize| to_scaled_axis(self.last[joint].inverse() * now[joint]);
        [turn(0), turn(1), turn(2)]
    }

    /// Turns the leg no faster than `fastest` lets it (rad/s, that of the clips). A leg that stands is where it stands, once
    /// it has arrived.
    pub(super) fn keep(
        &mut self,
        pose: &mut Pose,
        skeleton: &Skeleton,
        leg: &Leg,
        flies: bool,
        (fastest, dt): (f32, f32),
    ) {
        let most = LIVELIER * fastest * dt;
        let joints = leg.joints();
        let [hip, knee, ankle] = joints;
        let asked = [pose.turn(hip), pose.turn(knee), pose.turn(ankle)];
        // A leg that isn't late is as it was asked to be.
        let (mut now, mut turns) = (asked, self.turns(&asked));
        self.stands = if flies { 0.0 } else { self.stands + dt };
        let was_late = core::mem::take(&mut self.late);
        if self.known && (was_late || self.stands < LANDS) {
            let share = |joint: usize| share(turns[joint], self.speeds[joint] * dt, most, dt);
            // Hip and knee together, so that the foot keeps to its way; the ankle by itself.
            let before = if was_late { self.shares } else { [1.0; 2] };
            let shares = [share(0).min(share(1)).min(before[0] + CATCHES_UP), share(2).min(before[1] + CATCHES_UP)];
            self.late = shares[0].min(shares[1]) < 1.0;
            self.shares = shares.map(|share| share.min(1.0));
        }
        if self.late {
            for (index, joint) in joints.into_iter().enumerate() {
                now[index] = self.last[index].slerp(asked[index], self.shares[index / 2]);
                pose.set_turn(joint, now[index]);
            }
            pose.update_model_below(skeleton, leg.upper);
            turns = self.turns(&now);
        }
        self.keep_toes(pose, skeleton, leg, most);
        let per_second = dt.max(1e-4).recip();
        self.speeds = [turns[0] * per_second, turns[1] * per_second, turns[2] * per_second];
        self.last = now;
        self.known = true;
    }

    /// Toes never turn faster than they may.
    fn keep_toes(&mut self, pose: &mut Pose, skeleton: &Skeleton, leg: &Leg, most: f32) {
        let Some(toes) = leg.toes else { return };
        let asked = pose.turn(toes);
        let last = core::mem::replace(&mut self.toes, asked);
        let turn = if self.known { angle_between(last, asked) } else { 0.0 };
        if turn > most {
            self.toes = last.slerp(asked, most / turn);
            pose.set_turn(toes, self.toes);
            pose.update_model_below(skeleton, toes);
        }
    }
}

/// Share of the turn `asked` that a joint may make, which turned by `last` in the frame before: `most` radians, and not much
/// more than then.
fn share(asked: Vec3, last: Vec3, most: f32, dt: f32) -> f32 {
    let angle = asked.length();
    if angle < 1e-6 {
        return 1.0;
    }
    let more = most * dt.max(SEEN) / STARTS;
    // The largest share with |share·asked - last| ≤ more.
    let along = asked.dot(last) / angle;
    let reach = along * along - last.length_squared() + more * more;
    let starts = if reach >= 0.0 { along + reach.sqrt() } else { along };
    // Whoever slows may stop at once.
    let starts = if angle <= last.length() { angle } else { starts.max(0.0) };
    (starts.min(most) / angle).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f32 = 1.0 / 60.0;

    /// Degrees that a joint turns in each frame, asked at once for `degrees` in a clip that has legs of `fastest` °/s.
    fn steps(degrees: f32, fastest: f32) -> Vec<f32> {
        let (mut at, mut last) = (0.0f32, 0.0f32);
        let most = LIVELIER * fastest * DT;
        (0..120)
            .map(|_| {
                let asked = Vec3::X * (degrees - at).to_radians();
                let step = (degrees - at) * share(asked, Vec3::X * last.to_radians(), most.to_radians(), DT);
                (at, last) = (at + step, step);
                step
            })
            .collect()
    }

    #[test]
    fn a_leg_moves_no_faster_than_twice_its_clips() {
        for step in steps(90.0, 300.0) {
            assert!(step <= 10.0 + 1e-3, "turns by {step}° in a frame, clips by 5°");
        }
    }

    #[test]
    fn it_comes_where_it_is_asked_to() {
        let made: f32 = steps(90.0, 300.0).iter().sum();
        assert!((made - 90.0).abs() < 0.01, "turned by {made}° of 90°");
    }

    #[test]
    fn it_starts_over_some_frames() {
        let steps = steps(90.0, 300.0);
        let first = steps[0];
        assert!(first < 0.7 * LIVELIER * 5.0, "turns by {first}° in the first frame");
    }

    #[test]
    fn what_is_slow_enough_is_not_touched() {
        let slow = Vec3::new(0.02, -0.01, 0.005);
        let share = share(slow, slow * 0.9, 0.1, DT);
        assert!(share >= 1.0, "makes {share} of a turn that is slow enough");
    }
}
