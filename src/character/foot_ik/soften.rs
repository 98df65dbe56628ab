//! A leg's joints change their velocity hardly more within a frame than the playing clips let them.
//!
//! What ground and turns ask of a leg may stop it, or set it off, from one frame to the next. It then goes on as it was and
//! eases into what is asked: inertialization of one leg. Local rotations in radians, model space in metres.

use bevy::prelude::*;

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
const LIVELIER: (f32, f32) = (1.7, 1.8);
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
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Soften {
    /// The leg in the last frame.
    last: Option<Shown>,
    /// What is left of its way before: offsets from what is asked, and their speeds, when it was left.
    offsets: [(Vec3, Vec3); 4],
    /// Seconds since then.
    elapsed: f32,
}

/// A leg as it was shown. Rotations of hip, knee, ankle and toes; places of knee, ankle and toes in model space.
#[derive(Clone, Copy, Debug)]
struct Shown {
    asked: [Quat; 4],
    rotations: [Quat; 4],
    places: [Vec3; 3],
    /// How it came there from the frame before: rad/s and m/s; `None` in its first frame.
    speeds: Option<([Vec3; 4], [Vec3; 3])>,
}

impl Soften {
    /// Eases the leg of `pose` from how it moved so far into how it is posed.
    pub(super) fn keep(&mut self, pose: &mut Pose, skeleton: &Skeleton, leg: &Leg, limits: Limits, dt: f32) {
        let dt = dt.max(1e-4);
        let asked = joints(leg).map(|joint| pose.local(joint).rotation);
        let mut shown = asked;
        self.elapsed += dt;
        if self.elapsed < EASES {
            for (shown, (offset, speed)) in shown.iter_mut().zip(self.offsets) {
                *shown = (from_scaled_axis(ebb(offset, speed * EASES, self.elapsed / EASES) * limits.share) * *shown)
                    .normalize();
            }
            shown = show(pose, skeleton, leg, shown);
        }
        let mut made = self.last.map(|last| last.turns_to(shown));
        if let (Some(last), Some(turned)) = (self.last, made)
            && let Some((turns, velocities)) = last.speeds
        {
            let moved = places(pose, leg).into_iter().zip(last.places);
            let jumps = moved.zip(velocities).map(|((now, before), velocity)| ((now - before) / dt).distance(velocity));
            let jump = jumps.fold(0.0, f32::max);
            if jump > limits.jump || turned.into_iter().map(Vec3::length).fold(0.0, f32::max) > limits.turn {
                for (index, shown) in shown.iter_mut().enumerate() {
                    let before = last.rotations[index];
                    let goes_on = from_scaled_axis(turns[index] * dt) * before;
                    let eased = goes_on.slerp(*shown, (limits.jump / jump.max(limits.jump)).min(1.0));
                    let turn = angle_between(eased, before);
                    *shown = if turn > limits.turn { before.slerp(eased, limits.turn / turn) } else { eased };
                    let speed = turn_between(before, *shown) - turn_between(last.asked[index], asked[index]);
                    self.offsets[index] = (turn_between(asked[index], *shown), speed / dt);
                }
                self.elapsed = 0.0;
                shown = show(pose, skeleton, leg, shown);
                made = Some(last.turns_to(shown));
            }
        }
        self.note(asked, shown, places(pose, leg), made, dt);
    }

    /// The leg is shown elsewhere than it was kept: it eases on from there.
    pub(super) fn correct(&mut self, pose: &Pose, leg: &Leg, dt: f32) {
        let Some(Shown { asked, rotations: kept, places: before, speeds }) = self.last else { return };
        let rotations = joints(leg).map(|joint| pose.local(joint).rotation);
        let now = places(pose, leg);
        let speeds = speeds.map(|(turns, moves)| {
            let turn = |index: usize| turns[index] + turn_between(kept[index], rotations[index]) / dt;
            let way = |index: usize| moves[index] + (now[index] - before[index]) / dt;
            ([0, 1, 2, 3].map(turn), [0, 1, 2].map(way))
        });
        for (index, offset) in self.offsets.iter_mut().enumerate() {
            *offset = (turn_between(asked[index], rotations[index]), Vec3::ZERO);
        }
        self.elapsed = 0.0;
        self.last = Some(Shown { asked, rotations, places: now, speeds });
    }

    /// Nothing is known of how the leg moved.
    pub(super) fn forget(&mut self) {
        *self = Self { elapsed: EASES, ..Self::default() };
    }

    /// Whether the leg isn't quite as it is asked to be.
    pub(super) fn eases(&self) -> bool {
        self.elapsed < EASES
    }

    /// `made` is how the leg turned since the last frame.
    fn note(&mut self, asked: [Quat; 4], rotations: [Quat; 4], places: [Vec3; 3], made: Option<[Vec3; 4]>, dt: f32) {
        let speeds = self.last.zip(made).map(|(last, made)| {
            (made.map(|turn| turn / dt), [0, 1, 2].map(|index| (places[index] - last.places[index]) / dt))
        });
        if self.last.is_none() {
            self.elapsed = EASES;
        }
        self.last = Some(Shown { asked, rotations, places, speeds });
    }
}

impl Shown {
    /// How its joints turn to come to `rotations`, axis times radians.
    fn turns_to(&self, rotations: [Quat; 4]) -> [Vec3; 4] {
        [0, 1, 2, 3].map(|index| turn_between(self.rotations[index], rotations[index]))
    }
}

/// Hip, knee, ankle and toes; the ankle again where there are no toes.
fn joints(leg: &Leg) -> [JointIndex; 4] {
    [leg.upper, leg.lower, leg.foot, leg.toes.unwrap_or(leg.foot)]
}

fn places(pose: &Pose, leg: &Leg) -> [Vec3; 3] {
    let [_, knee, ankle, toes] = joints(leg);
    [knee, ankle, toes].map(|joint| pose.position(joint))
}

/// Turns the joints so, as far as a knee goes; gives how they are turned then.
fn show(pose: &mut Pose, skeleton: &Skeleton, leg: &Leg, rotations: [Quat; 4]) -> [Quat; 4] {
    for (joint, rotation) in joints(leg).into_iter().zip(rotations) {
        let mut local = pose.local(joint);
        local.rotation = rotation;
        pose.set_local(joint, local);
    }
    pose.update_model_below(skeleton, leg.upper);
    keep_bent(pose, skeleton, leg);
    joints(leg).map(|joint| pose.local(joint).rotation)
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
