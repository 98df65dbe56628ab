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

/// Memory of a change: three values for each joint. Whoever eases no longer gives it back for others to use.
#[derive(Clone, Debug, Default)]
pub struct Offsets {
    offsets: Vec<Offset>,
    /// Final poses of the last two frames, newest first.
    last: Vec<JointTransform>,
    before: Vec<JointTransform>,
}

impl Offsets {
    /// The pose before the last one.
    pub fn set_before(&mut self, pose: &[JointTransform]) {
        fill(&mut self.before, pose);
    }

    /// The last pose.
    pub fn set_last(&mut self, pose: &[JointTransform]) {
        fill(&mut self.last, pose);
    }
}

fn fill(buffer: &mut Vec<JointTransform>, pose: &[JointTransform]) {
    buffer.clear();
    buffer.extend_from_slice(pose);
}

/// Decaying offsets of a whole pose. It has memory only from [`begin`](Self::begin) until it is [at rest](Self::rest).
#[derive(Clone, Debug, Default)]
pub struct Inertializer {
    memory: Option<Offsets>,
    /// Whether the new clip was seen in but one frame, and it is still to be found out how it moves.
    begun: bool,
    elapsed: f32,
    seconds: f32,
    /// Frames since nothing was left of the offset.
    rested: u8,
}

impl Inertializer {
    /// Whether the last two poses are known, since something was carried over in them.
    #[must_use]
    pub fn remembers(&self) -> bool {
        self.memory.is_some()
    }

    /// Takes the last two poses, where it doesn't [remember](Self::remembers) them.
    pub fn recall(&mut self, memory: Offsets) {
        self.memory = Some(memory);
    }

    /// Carries nothing over any longer; gives the memory back.
    pub fn forget(&mut self) -> Option<Offsets> {
        core::mem::take(self).memory
    }

    /// From now on `pose` is played instead of the last two poses, `dt` seconds apart: the difference becomes the offset, which
    /// is gone after `seconds`.
    ///
    /// The new pose's own motion is added `at_once`, or eased in like its place. Without two known poses there is nothing to
    /// carry over.
    pub fn begin(&mut self, pose: &[JointTransform], dt: f32, seconds: f32, at_once: bool) {
        let Some(Offsets { offsets, last, before }) = self.memory.as_mut() else { return };
        (self.begun, self.elapsed, self.seconds, self.rested) = (!at_once, 0.0, seconds, 0);
        let per_second = 1.0 / dt.max(1e-4);
        offsets.clear();
        offsets.extend(last.iter().zip(before).zip(pose).map(|((last, before), new)| Offset {
            rotation: to_scaled_axis(last.rotation * new.rotation.inverse()),
            turn: to_scaled_axis(last.rotation * before.rotation.inverse()) * per_second,
            translation: last.translation - new.translation,
            velocity: (last.translation - before.translation) * per_second,
        }));
    }

    /// Adds what is left of the offset to `pose`, `dt` seconds later. Gives whether there was any.
    pub fn apply(&mut self, pose: &mut [JointTransform], dt: f32) -> bool {
        let Some(memory) = self.memory.as_mut() else { return false };
        self.elapsed += dt;
        if self.elapsed >= self.seconds {
            return false;
        }
        if self.begun && self.elapsed > dt {
            (self.begun, self.elapsed) = (false, dt);
            memory.see_motion(pose, dt);
        }
        let (t, seconds) = (self.elapsed / self.seconds, self.seconds);
        for (offset, joint) in memory.offsets.iter().zip(pose) {
            let turn = ebb(offset.rotation, offset.turn * seconds, t);
            joint.rotation = (from_scaled_axis(turn) * joint.rotation).normalize();
            joint.translation += ebb(offset.translation, offset.velocity * seconds, t);
        }
        true
    }

    /// Remembers a finished pose, as long as something is carried over.
    pub fn record(&mut self, pose: &[JointTransform]) {
        if let Some(memory) = self.memory.as_mut() {
            core::mem::swap(&mut memory.last, &mut memory.before);
            memory.set_last(pose);
        }
    }

    /// Once a frame, after [`record`](Self::record): gives the memory back when nothing was left in the last two poses.
    pub fn rest(&mut self) -> Option<Offsets> {
        if self.elapsed < self.seconds {
            return None;
        }
        self.rested = self.rested.saturating_add(1);
        if self.rested < 2 { None } else { self.memory.take() }
    }
}

impl Offsets {
    /// From the last frame on the offset moves as the old pose did against the new clip, which is at `pose` now.
    fn see_motion(&mut self, pose: &[JointTransform], dt: f32) {
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bent(angle: f32) -> [JointTransform; 1] {
        [JointTransform { rotation: from_scaled_axis(Vec3::X * angle), ..JointTransform::IDENTITY }]
    }

    /// Two poses were shown.
    fn after(before: f32, last: f32) -> Inertializer {
        let mut memory = Offsets::default();
        memory.set_before(&bent(before));
        memory.set_last(&bent(last));
        let mut inertializer = Inertializer::default();
        inertializer.recall(memory);
        inertializer
    }

    #[test]
    fn memory_comes_back_when_two_poses_were_those_of_the_clip() {
        let dt = 1.0 / 60.0;
        let mut inertializer = after(0.98, 1.0);
        inertializer.begin(&bent(0.0), dt, 0.1, false);
        let mut free = Vec::new();
        for _ in 0..12 {
            let mut pose = bent(0.0);
            let eased = inertializer.apply(&mut pose, dt);
            inertializer.record(&pose);
            free.push((eased, inertializer.rest().is_some()));
        }
        let eased = free.iter().filter(|(eased, _)| *eased).count();
        let given: Vec<_> = (0..12).filter(|frame| free[*frame].1).collect();
        assert_eq!(given, [eased + 1], "given back in the frames {given:?}, eased in the first {eased}");
        assert!(!inertializer.remembers() && !inertializer.apply(&mut bent(0.0), dt));
    }

    #[test]
    fn a_clip_that_moves_is_taken_up_gently() {
        let dt = 1.0 / 60.0;
        // Still at 0.3; the new clip turns by 3 rad/s.
        let new = |frame: u8| bent(0.05 * f32::from(frame));
        let mut inertializer = after(0.3, 0.3);
        inertializer.begin(&new(0), dt, 0.3, false);
        let mut angles = vec![0.3, 0.3];
        for frame in 0..30 {
            let mut pose = new(frame);
            inertializer.apply(&mut pose, dt);
            inertializer.record(&pose);
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
        let mut inertializer = after(0.98, 1.0);
        inertializer.begin(&bent(0.0), dt, 0.4, false);
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
