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
    /// Without two recorded frames there is nothing to carry over.
    pub fn begin(&mut self, pose: &[JointTransform], seconds: f32) {
        if self.frames < 2 {
            return;
        }
        (self.elapsed, self.seconds) = (0.0, seconds);
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

    /// Adds what is left of the offset to `pose`, `dt` seconds later.
    pub fn apply(&mut self, pose: &mut [JointTransform], dt: f32) {
        self.elapsed += dt;
        if self.elapsed >= self.seconds {
            return;
        }
        let (t, seconds) = (self.elapsed / self.seconds, self.seconds);
        for (offset, joint) in self.offsets.iter().zip(pose) {
            let turn = ebb(offset.rotation, offset.turn * seconds, t);
            joint.rotation = (from_scaled_axis(turn) * joint.rotation).normalize();
            joint.translation += ebb(offset.translation, offset.velocity * seconds, t);
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
    fn the_pose_does_not_jump_and_arrives() {
        let dt = 1.0 / 60.0;
        let mut inertializer = Inertializer::new(1);
        inertializer.record(&bent(0.98), dt);
        inertializer.record(&bent(1.0), dt);
        inertializer.begin(&bent(0.0), 0.4);
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
