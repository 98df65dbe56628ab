//! A leg's joints change their velocity hardly more within a frame than the playing clips let them.
//!
//! What ground and turns ask of a leg may stop it, or set it off, from one frame to the next. It then goes on as it was and
//! eases into what is asked: inertialization of one leg. Local rotations in radians, model space in metres.

use bevy::{math::ops, prelude::*};

use crate::{
    anim::{
        leg::Leg,
        peak::Peak,
        pose::Pose,
        skeleton::{JointIndex, Skeleton},
    },
    character::legs::keep_bent,
    math::{
        fade::ebb,
        rotation::{angle_between, from_scaled_axis, to_scaled_axis},
    },
};

/// How much more than in the clips a leg's velocity may change, and how much faster its joints may turn: up to twice looks
/// like the clip.
pub(super) const LIVELIER: (f32, f32) = (1.7, 1.8);
/// Seconds in which a leg eases into what is asked.
const EASES: f32 = 0.1;

/// What a leg may do within a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Largest change of a joint's velocity in model space, m/s.
    pub(super) jump: f32,
    /// Largest turn of a joint, radians.
    pub(super) turn: f32,
    /// How much is kept, 0..1, of what is left of its way before.
    pub(super) share: f32,
}

impl Limits {
    /// For who falls or stands in the air: no ground asks anything then.
    pub(super) const NONE: Self = Self { jump: f32::MAX, turn: f32::MAX, share: 0.0 };

    /// For a frame of `dt` seconds, while the clips are so lively.
    pub(super) fn of(clips: Peak, dt: f32) -> Self {
        Self { jump: LIVELIER.0 * clips.velocity_jump, turn: LIVELIER.1 * clips.joint_speed * dt, share: 1.0 }
    }
}

/// What a leg keeps of its motion.
#[derive(Clone, Debug, Default)]
pub(super) struct Soften {
    /// What is known of the leg in the last frame.
    known: Known,
    /// The leg then: as asked and as shown.
    asked: [Quat; JOINTS],
    rotations: [Quat; JOINTS],
    /// Places of knee, ankle and toes in model space.
    places: [Vec3; 3],
    /// How its joints were turned in the frame before, and how many seconds passed since then.
    before: [Quat; JOINTS],
    seconds: f32,
    /// How its places moved meanwhile, m/s.
    moves: [Vec3; 3],
    /// What is left of its way before: offsets from what is asked, and their speeds, when it was left.
    offsets: [(Vec3, Vec3); JOINTS],
    /// Seconds since then.
    elapsed: f32,
}

/// Hip, knee, ankle and toes.
const JOINTS: usize = 4;

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Debug, Default)]
enum Known {
    #[default]
    Nothing,
    Place,
    Motion,
}

impl Soften {
    /// Eases the leg of `pose` from how it moved so far into how it is posed.
    pub(super) fn keep(&mut self, pose: &mut Pose, skeleton: &Skeleton, leg: &Leg, limits: Limits, dt: f32) {
        let dt = dt.max(1e-4);
        let per_second = dt.recip();
        let asked = turns_of(pose, leg);
        let mut shown = asked;
        self.elapsed += dt;
        if self.elapsed < EASES {
            for (shown, (offset, speed)) in shown.iter_mut().zip(self.offsets) {
                *shown = (from_scaled_axis(ebb(offset, speed * EASES, self.elapsed / EASES) * limits.share) * *shown)
                    .normalize();
            }
            shown = show(pose, skeleton, leg, shown);
        }
        let mut places = places(pose, leg);
        if self.known == Known::Motion {
            let jump =
                |index: usize| ((places[index] - self.places[index]) * per_second).distance_squared(self.moves[index]);
            let jump = jump(0).max(jump(1)).max(jump(2));
            if jump > limits.jump * limits.jump || self.turns_further(&shown, limits.turn) {
                shown = self.limit(&asked, &shown, jump.sqrt(), limits, dt);
                shown = show(pose, skeleton, leg, shown);
                places = self::places(pose, leg);
            }
        }
        self.note(asked, shown, places, dt);
    }

    /// How a leg is turned that is asked to be turned as `shown`, which lets it `jump` by so many m/s, and keeps to its limits.
    fn limit(
        &mut self,
        asked: &[Quat; JOINTS],
        shown: &[Quat; JOINTS],
        jump: f32,
        limits: Limits,
        dt: f32,
    ) -> [Quat; JOINTS] {
        let mut kept = *shown;
        for (index, shown) in kept.iter_mut().enumerate() {
            let before = self.rotations[index];
            let turn = turn_between(self.before[index], before) * (dt / self.seconds);
            let goes_on = from_scaled_axis(turn) * before;
            let eased = goes_on.slerp(*shown, (limits.jump / jump.max(limits.jump)).min(1.0));
            let turn = angle_between(eased, before);
            *shown = if turn > limits.turn { before.slerp(eased, limits.turn / turn) } else { eased };
            let speed = turn_between(before, *shown) - turn_between(self.asked[index], asked[index]);
            self.offsets[index] = (turn_between(asked[index], *shown), speed / dt);
        }
        self.elapsed = 0.0;
        kept
    }

    /// The leg is shown elsewhere than it was kept: it eases on from there.
    pub(super) fn correct(&mut self, pose: &Pose, leg: &Leg, dt: f32) {
        if self.known == Known::Nothing {
            return;
        }
        let (rotations, places) = (turns_of(pose, leg), places(pose, leg));
        for (index, offset) in self.offsets.iter_mut().enumerate() {
            *offset = (turn_between(self.asked[index], rotations[index]), Vec3::ZERO);
        }
        for (index, now) in places.iter().enumerate() {
            self.moves[index] += (now - self.places[index]) / dt;
        }
        self.elapsed = 0.0;
        (self.rotations, self.places) = (rotations, places);
    }

    /// Nothing is known of how the leg moved.
    pub(super) fn forget(&mut self) {
        *self = Self { elapsed: EASES, ..Self::default() };
    }

    /// Whether the leg isn't quite as it is asked to be.
    pub(super) fn eases(&self) -> bool {
        self.elapsed < EASES
    }

    /// Notes the leg as it is shown, `dt` seconds after the last time.
    fn note(&mut self, asked: [Quat; JOINTS], rotations: [Quat; JOINTS], places: [Vec3; 3], dt: f32) {
        if self.known == Known::Nothing {
            self.elapsed = EASES;
            self.known = Known::Place;
        } else {
            let per_second = dt.recip();
            for (index, speed) in self.moves.iter_mut().enumerate() {
                *speed = (places[index] - self.places[index]) * per_second;
            }
            self.known = Known::Motion;
        }
        (self.before, self.seconds) = (self.rotations, dt);
        (self.asked, self.rotations, self.places) = (asked, rotations, places);
    }

    /// Whether a joint turns by more than `most` radians to come to `rotations`.
    fn turns_further(&self, rotations: &[Quat; JOINTS], most: f32) -> bool {
        // A turn by an angle has the cosine of its half for its last number.
        let least = ops::cos(0.5 * most.min(core::f32::consts::PI));
        let further = |index: usize| self.rotations[index].dot(rotations[index]).abs() < least;
        further(0) | further(1) | further(2) | further(3)
    }
}

/// Hip, knee, ankle and toes; the ankle again where there are no toes.
fn joints(leg: &Leg) -> [JointIndex; JOINTS] {
    [leg.upper, leg.lower, leg.foot, leg.toes.unwrap_or(leg.foot)]
}

fn turns_of(pose: &Pose, leg: &Leg) -> [Quat; JOINTS] {
    let [hip, knee, ankle, toes] = joints(leg);
    [pose.turn(hip), pose.turn(knee), pose.turn(ankle), pose.turn(toes)]
}

fn places(pose: &Pose, leg: &Leg) -> [Vec3; 3] {
    let [_, knee, ankle, toes] = joints(leg);
    pose.positions_of([knee, ankle, toes])
}

/// Turns the joints so, as far as a knee goes; gives how they are turned then.
fn show(pose: &mut Pose, skeleton: &Skeleton, leg: &Leg, rotations: [Quat; JOINTS]) -> [Quat; JOINTS] {
    for (joint, rotation) in joints(leg).into_iter().zip(rotations) {
        pose.set_turn(joint, rotation);
    }
    pose.update_model_below(skeleton, leg.upper);
    keep_bent(pose, skeleton, leg);
    turns_of(pose, leg)
}

/// The turn that takes `from` to `to`, axis times radians.
fn turn_between(from: Quat, to: Quat) -> Vec3 {
    to_scaled_axis(to * from.inverse())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anim::skeleton::JointTransform;
    use bevy::math::Affine3A;

    const DT: f32 = 1.0 / 60.0;

    /// A leg of two segments of 0.4 m with a foot.
    fn leg() -> (Skeleton, Leg) {
        let names = ["hip", "knee", "ankle", "toes"];
        let joints = names.into_iter().enumerate().map(|(index, name)| {
            let down = if index == 0 { 0.0 } else { 0.4 };
            let rest = JointTransform { translation: Vec3::Y * -down, ..JointTransform::IDENTITY };
            (name.to_owned(), index.checked_sub(1).map(|parent| JointIndex(parent as u16)), rest)
        });
        let skeleton = Skeleton::new(joints.collect::<Vec<_>>(), Affine3A::IDENTITY).expect("parents come first");
        let [upper, lower, foot, toes] = [0, 1, 2, 3].map(JointIndex);
        (skeleton, Leg { upper, lower, foot, toes: Some(toes), ..Leg::default() })
    }

    /// Angles of the hip as shown, asked for those that `asked` tells by frame.
    fn shown(limits: Limits, frames: usize, asked: impl Fn(usize) -> f32) -> Vec<f32> {
        let (skeleton, leg) = leg();
        let (mut pose, mut soften) = (Pose::rest(&skeleton), Soften::default());
        (0..frames)
            .map(|frame| {
                let rotation = Quat::from_rotation_x(asked(frame));
                pose.set_local(leg.upper, JointTransform { rotation, ..pose.local(leg.upper) });
                pose.update_model(&skeleton);
                soften.keep(&mut pose, &skeleton, &leg, limits, DT);
                to_scaled_axis(pose.local(leg.upper).rotation).x
            })
            .collect()
    }

    /// Swings by 3 rad/s for 10 frames, then stands.
    fn stops(frame: usize) -> f32 {
        0.05 * frame.min(10) as f32
    }

    #[test]
    fn a_leg_that_is_stopped_goes_on_for_a_moment() {
        // Toes hang 1.2 m below the hip: they stop from 3.6 m/s.
        let angles = shown(Limits { jump: 1.5, turn: 1.0, share: 1.0 }, 40, stops);
        for (frame, three) in angles.windows(3).enumerate() {
            let jump = 1.2 * (three[2] - 2.0 * three[1] + three[0]).abs() / DT;
            assert!(jump < 1.55, "toes change their velocity by {jump} m/s in frame {frame}");
        }
        let furthest = angles.iter().copied().fold(0.0, f32::max);
        assert!((0.51..0.6).contains(&furthest), "goes on to {furthest} of 0.5");
        assert!((angles[17] - 0.5).abs() < 1e-3, "is at {} 0.1 s later", angles[17]);
    }

    #[test]
    fn a_leg_within_its_limits_is_where_it_is_asked_to_be() {
        let angles = shown(Limits { jump: 4.0, turn: 0.06, share: 1.0 }, 40, stops);
        let off = angles.iter().enumerate().map(|(frame, angle)| (angle - stops(frame)).abs()).fold(0.0, f32::max);
        assert!(off < 1e-6, "{off} rad off");
    }

    #[test]
    fn no_joint_turns_further_than_it_may() {
        let angles =
            shown(Limits { jump: f32::MAX, turn: 0.1, share: 1.0 }, 60, |frame| if frame < 5 { 0.0 } else { 0.8 });
        let widest = angles.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
        assert!(widest < 0.101, "turns by {widest} rad in a frame");
        assert!((angles[59] - 0.8).abs() < 1e-3, "comes to {} of 0.8", angles[59]);
    }
}
