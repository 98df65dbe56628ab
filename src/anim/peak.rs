//! The liveliest moment of a clip: what a pose may do without looking like a pop.

use bevy::prelude::*;

use super::{clip::Clip, pose::Pose, skeleton::Skeleton};
use crate::math::rotation::angle_between;

/// Largest angular speed and largest jump of velocity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peak {
    /// Angular speed of a joint against its parent, rad/s.
    pub joint_speed: f32,
    /// Change of a joint's velocity in model space from one frame to the next, m/s.
    pub velocity_jump: f32,
}

/// Frames of a clip that are looked at: beyond five minutes it is taken to be no livelier.
const MOST_FRAMES: usize = 36_000;

impl Peak {
    /// The liveliest moment of `clip`, played at its own speed in frames of `dt` seconds.
    #[must_use]
    pub fn of(clip: &Clip, skeleton: &Skeleton, dt: f32) -> Self {
        let mut motion = JointMotion::default();
        let mut pose = Pose::rest(skeleton);
        let mut peak = Self::default();
        // Two frames more than the clip has, so that the seam of a loop is seen.
        let count = if dt > 0.0 { ((clip.duration / dt) as usize).min(MOST_FRAMES) + 3 } else { 0 };
        for frame in 0..count {
            clip.sample(skeleton, frame as f32 * dt, pose.locals_mut());
            pose.update_model(skeleton);
            let step = motion.advance(&pose, dt);
            peak = peak.max(Self { joint_speed: step.joint_speed, velocity_jump: step.velocity_jump });
        }
        peak
    }

    /// The larger of each.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            joint_speed: self.joint_speed.max(other.joint_speed),
            velocity_jump: self.velocity_jump.max(other.velocity_jump),
        }
    }

    /// Played `rate` times as fast: speeds grow with the rate, changes of speed with its square.
    #[must_use]
    pub fn at_rate(self, rate: f32) -> Self {
        Self { joint_speed: self.joint_speed * rate, velocity_jump: self.velocity_jump * rate * rate }
    }
}

impl core::ops::Mul<f32> for Peak {
    type Output = Self;

    fn mul(self, share: f32) -> Self {
        Self { joint_speed: self.joint_speed * share, velocity_jump: self.velocity_jump * share }
    }
}

/// Seconds between frames for which the liveliness of a clip is known.
const FRAMES: [f32; 3] = [1.0 / 120.0, 1.0 / 60.0, 1.0 / 30.0];

/// The liveliest moments of a clip as frames see it: they depend on the time between them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Liveliness([Peak; 3]);

impl Liveliness {
    /// Of `clip` at its own speed.
    #[must_use]
    pub fn of(clip: &Clip, skeleton: &Skeleton) -> Self {
        Self(FRAMES.map(|frame| Peak::of(clip, skeleton, frame)))
    }

    /// In frames of `dt` seconds: what lies between those that are known is taken as even.
    #[must_use]
    pub fn at(&self, dt: f32) -> Peak {
        let Self(peaks) = self;
        let within = |short: usize| {
            let share = ((dt - FRAMES[short]) / (FRAMES[short + 1] - FRAMES[short])).clamp(0.0, 1.0);
            let between = |short: f32, long: f32| short + (long - short) * share;
            Peak {
                joint_speed: between(peaks[short].joint_speed, peaks[short + 1].joint_speed),
                velocity_jump: between(peaks[short].velocity_jump, peaks[short + 1].velocity_jump),
            }
        };
        let peak = if dt < FRAMES[1] { within(0) } else { within(1) };
        // What a clip does within less than the shortest frame is smooth.
        Peak { velocity_jump: peak.velocity_jump * (dt / FRAMES[0]).min(1.0), ..peak }
    }
}

/// How a pose moved from the last frame to this one.
#[derive(Clone, Copy, Debug, Default)]
pub struct PoseStep {
    /// Largest speed of a joint in model space, m/s.
    pub speed: f32,
    /// Largest angular speed of a joint against its parent, rad/s.
    pub joint_speed: f32,
    /// Largest change of a joint's model-space velocity, m/s.
    pub velocity_jump: f32,
}

/// Follows all joints of a pose from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct JointMotion {
    rotations: Vec<Quat>,
    positions: Vec<Vec3>,
    velocities: Vec<Vec3>,
    frames: usize,
}

impl JointMotion {
    /// One frame. The first gives zeros, the second no velocity jump.
    pub fn advance(&mut self, pose: &Pose, dt: f32) -> PoseStep {
        let mut step = PoseStep::default();
        if self.positions.len() != pose.len() {
            self.frames = 0;
            self.rotations.resize(pose.len(), Quat::IDENTITY);
            self.positions.resize(pose.len(), Vec3::ZERO);
            self.velocities.resize(pose.len(), Vec3::ZERO);
        }
        for (index, (local, model)) in pose.locals().iter().zip(pose.models()).enumerate() {
            let position = model.translation();
            let velocity = (position - self.positions[index]) / dt;
            if self.frames > 0 {
                step.speed = step.speed.max(velocity.length());
                step.joint_speed = step.joint_speed.max(angle_between(local.rotation, self.rotations[index]) / dt);
            }
            if self.frames > 1 {
                step.velocity_jump = step.velocity_jump.max(velocity.distance(self.velocities[index]));
            }
            self.rotations[index] = local.rotation;
            self.positions[index] = position;
            self.velocities[index] = velocity;
        }
        self.frames += 1;
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_frame_rates_peaks_are_even() {
        let peak = |joint_speed, velocity_jump| Peak { joint_speed, velocity_jump };
        let lively = Liveliness([peak(9.0, 0.2), peak(8.0, 0.4), peak(6.0, 0.8)]);
        for (hz, told) in [
            (120.0, peak(9.0, 0.2)),
            (60.0, peak(8.0, 0.4)),
            (40.0, peak(7.0, 0.6)),
            (240.0, peak(9.0, 0.1)),
            (10.0, peak(6.0, 0.8)),
        ] {
            let got = lively.at(1.0 / hz);
            let off = (got.joint_speed - told.joint_speed).abs() + (got.velocity_jump - told.velocity_jump).abs();
            assert!(off < 1e-4, "{got:?} at {hz} Hz");
        }
    }
}
