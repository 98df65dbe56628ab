//! Inertialization: the new clip plays at once, the old pose's offset from it decays, velocity and all.
//!
//! Local space, joint by joint. Sources: David Bollo, "Inertialization" (GDC 2018); Daniel Holden, "Inertialization
//! Transition Cost" and "Spring-It-On" (theorangeduck.com), whose critically damped decay this is.

use bevy::math::Vec3;

use super::skeleton::JointTransform;
use crate::math::{
    rotation::{from_scaled_axis, to_scaled_axis},
    spring::Spring,
};

/// Offsets of one joint.
#[derive(Clone, Copy, Debug, Default)]
struct Offset {
    rotation: Spring<Vec3>,
    translation: Spring<Vec3>,
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
    half_life: f32,
    active: bool,
}

/// Offsets below this, in radians or metres, are over.
const OVER: f32 = 1e-5;

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

    /// Whether an offset is still decaying.
    #[must_use]
    pub fn is_active(&self) -> bool {
        self.active
    }

    /// From now on `pose` is played instead of what was recorded: the difference becomes the offset.
    ///
    /// `half_life` in seconds. Without two recorded frames there is nothing to carry over.
    pub fn begin(&mut self, pose: &[JointTransform], half_life: f32) {
        if self.frames < 2 {
            return;
        }
        self.half_life = half_life;
        self.active = true;
        let per_second = 1.0 / self.dt.max(1e-4);
        for (((offset, last), before), new) in self.offsets.iter_mut().zip(&self.last).zip(&self.before).zip(pose) {
            offset.rotation = Spring {
                value: to_scaled_axis(last.rotation * new.rotation.inverse()),
                velocity: to_scaled_axis(last.rotation * before.rotation.inverse()) * per_second,
            };
            offset.translation = Spring {
                value: last.translation - new.translation,
                velocity: (last.translation - before.translation) * per_second,
            };
        }
    }

    /// Adds what is left of the offset to `pose`, after letting it decay for `dt` seconds.
    pub fn apply(&mut self, pose: &mut [JointTransform], dt: f32) {
        if !self.active {
            return;
        }
        let mut largest = 0.0f32;
        for (offset, joint) in self.offsets.iter_mut().zip(pose) {
            offset.rotation.step(Vec3::ZERO, self.half_life, dt);
            offset.translation.step(Vec3::ZERO, self.half_life, dt);
            joint.rotation = (from_scaled_axis(offset.rotation.value) * joint.rotation).normalize();
            joint.translation += offset.translation.value;
            largest =
                largest.max(offset.rotation.value.length_squared()).max(offset.translation.value.length_squared());
        }
        self.active = largest > OVER * OVER;
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
        inertializer.begin(&bent(0.0), 0.1);
        let mut last = 1.0;
        for frame in 0..120 {
            let mut pose = bent(0.0);
            inertializer.apply(&mut pose, dt);
            let angle = to_scaled_axis(pose[0].rotation).x;
            assert!((angle - last).abs() < 0.12, "jumped by {} in frame {frame}", (angle - last).abs());
            last = angle;
        }
        assert!(last.abs() < 1e-3, "{last} rad are left");
    }
}
