//! Inertialization: the new clip plays at once, the old pose's offset from it decays, velocity and all.
//!
//! Local space, joint by joint. Source: David Bollo, "Inertialization: High-Performance Animation Transitions in Gears of War"
//! (GDC 2018). It starts without acceleration, as no spring does: arms that hang far from where they shall be aren't
//! thrown there.

use bevy::math::Vec3;

use super::skeleton::JointTransform;
use crate::math::{
    fade::ebb,
    rotation::{from_scaled_axis, to_scaled_axis},
};

/// Offsets of one joint when the change began, rotation vector and metres, and how fast it moved then, per second.
#[derive(Clone, Copy, Debug, Default)]
struct Offset {
    rotation: Vec3,
    turn: Vec3,
    translation: Vec3,
    velocity: Vec3,
}

/// Decaying offsets of a whole pose. Buffers are sized once.
#[derive(Clone, Debug, Default)]
pub struct Inertializer {
    offsets: Vec<Offset>,
    /// Final poses of the last two frames, newest first, and the seconds between them.
    last: Vec<JointTransform>,
    before: Vec<JointTransform>,
    dt: f32,
    frames: u8,
    /// Whether the new clip was seen in but one frame, and it is still to be found out how it moves.
    begun: bool,
    elapsed: f32,
    seconds: f32,
}

impl Inertializer {
    /// For poses of `joint_count` joints.
    #[must_use]
    pub fn new(joint_count: usize) -> Self {
        Self {
            offsets: vec![Offset::default(); joint_count],
            last: vec![JointTransform::IDENTITY; joint_count],
            before: vec![JointTransform::IDENTITY; joint_count],
            ..Self::default()
        }
    }

    /// From now on `pose` is played instead of what was recorded: the difference becomes the offset, which is gone after
    /// `seconds`.
    ///
    /// The new pose's own motion is added `at_once`, or eased in like its place. Without two recorded frames there is nothing to
    /// carry over.
    pub fn begin(&mut self, pose: &[JointTransform], seconds: f32, at_once: bool) {
        if self.frames < 2 {
            return;
        }
        (self.begun, self.elapsed, self.seconds) = (!at_once, 0.0, seconds);
        let per_second = 1.0 / self.dt.max(1e-4);
        for (((offset, last), before), new) in self.offsets.iter_mut().zip(&self.last).zip(&self.before).zip(pose) {
            *offset = Offset {
                rotation: to_scaled_axis(last.rotation * new.rotation.inverse()),
                turn: to_scaled_axis(last.rotation * before.rotation.inverse()) * per_second,
                translation: last.translation - new.translation,
                velocity: (last.translation - before.translation) * per_second,
            };
        }
    }

    /// Adds what is left of the offset to `pose`, `dt` seconds later. Gives whether there was any.
    pub fn apply(&mut self, pose: &mut [JointTransform], dt: f32) -> bool {
        self.elapsed += dt;
        if self.elapsed >= self.seconds {
            return false;
        }
        if self.begun && self.elapsed > dt {
            self.begun = false;
            self.see_motion(pose, dt);
        }
        let (t, seconds) = (self.elapsed / self.seconds, self.seconds);
        for (offset, joint) in self.offsets.iter().zip(pose) {
            let turn = ebb(offset.rotation, offset.turn * seconds, t);
            joint.rotation = (from_scaled_axis(turn) * joint.rotation).normalize();
            joint.translation += ebb(offset.translation, offset.velocity * seconds, t);
        }
        true
    }

    /// From the last frame on the offset moves as the old pose did against the new clip, which is at `pose` now.
    fn see_motion(&mut self, pose: &[JointTransform], dt: f32) {
        self.elapsed = dt;
        let per_second = 1.0 / dt.max(1e-4);
        for (((offset, last), before), now) in self.offsets.iter_mut().zip(&self.last).zip(&self.before).zip(pose) {
            // The new clip in the last frame: the offset was told against it.
            let rotation = from_scaled_axis(-offset.rotation) * before.rotation;
            let translation = before.translation - offset.translation;
            *offset = Offset {
                rotation: to_scaled_axis(last.rotation * rotation.inverse()),
                turn: offset.turn - to_scaled_axis(now.rotation * rotation.inverse()) * per_second,
                translation: last.translation - translation,
                velocity: offset.velocity - (now.translation - translation) * per_second,
            };
        }
    }

    /// Remembers a finished pose, so that an offset can be taken from it.
    pub fn record(&mut self, pose: &[JointTransform], dt: f32) {
        core::mem::swap(&mut self.last, &mut self.before);
        self.last.copy_from_slice(pose);
        self.dt = dt;
        self.frames = self.frames.saturating_add(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent(angle: f32) -> [JointTransform; 1] {
        [JointTransform { rotation: from_scaled_axis(Vec3::X * angle), ..JointTransform::IDENTITY }]
    }

    #[test]
    fn a_clip_that_moves_is_taken_up_gently() {
        let dt = 1.0 / 60.0;
        // Still at 0.3; the new clip turns by 3 rad/s.
        let new = |frame: u8| bent(0.05 * f32::from(frame));
        let mut inertializer = Inertializer::new(1);
        for _ in 0..2 {
            inertializer.record(&bent(0.3), dt);
        }
        inertializer.begin(&new(0), 0.3, false);
        let mut angles = vec![0.3, 0.3];
        for frame in 0..30 {
            let mut pose = new(frame);
            inertializer.apply(&mut pose, dt);
            inertializer.record(&pose, dt);
            angles.push(to_scaled_axis(pose[0].rotation).x);
        }
        for (frame, three) in angles.windows(3).enumerate() {
            let change = (three[2] - 2.0 * three[1] + three[0]).abs() / dt;
            assert!(change < 0.9, "turns {change} rad/s faster in frame {frame}");
        }
        assert!((angles[31] - 1.45).abs() < 1e-4, "is at {} of 1.45", angles[31]);
    }

    #[test]
    fn the_pose_does_not_jump_and_arrives() {
        let dt = 1.0 / 60.0;
        let mut inertializer = Inertializer::new(1);
        inertializer.record(&bent(0.98), dt);
        inertializer.record(&bent(1.0), dt);
        inertializer.begin(&bent(0.0), 0.4, false);
        let mut last = 1.0;
        for frame in 0..120 {
            let mut pose = bent(0.0);
            inertializer.apply(&mut pose, dt);
            let angle = to_scaled_axis(pose[0].rotation).x;
            assert!((angle - last).abs() < 0.1, "jumped by {} in frame {frame}", (angle - last).abs());
            last = angle;
        }
        assert!(last.abs() < 1e-3, "{last} rad are left");
    }
}
