//! How the pelvis heaves: its height changes its speed no faster than in a lively stride.
//!
//! Legs that come to their ends, and ground that is seen late, ask for more within a frame. The pelvis then goes on as it did
//! and eases to where it is asked: inertialization of one height. World space, metres, +Y up.

use bevy::math::Vec3;

use crate::math::fade::ebb;

/// Largest acceleration of the pelvis, m/s², unless the clips' own is far larger; a run's own is 12.
const MOST: f32 = 14.0;
/// Share of the clips' own that is followed: the peaks of those that bounce hard are kinks between their keys.
const FOLLOWED: f32 = 0.45;
/// Seconds in which the pelvis eases to where it is asked.
const EASES: f32 = 0.2;

/// What the pelvis keeps of its motion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Heave {
    /// The hips in the last frame: height asked, height shown, and how fast they came there, m/s; that not in their first.
    last: Option<(f32, f32, Option<f32>)>,
    left: Option<Left>,
}

/// What is left of the way before: offset and its speed when it was left, and the seconds since then.
#[derive(Clone, Copy, Debug)]
struct Left {
    offset: f32,
    speed: f32,
    elapsed: f32,
}

impl Left {
    fn offset(&self) -> f32 {
        ebb(Vec3::Y * self.offset, Vec3::Y * (self.speed * EASES), self.elapsed / EASES).y
    }
}

impl Heave {
    /// Metres by which hips that are asked to be at the world height `asked` stay off it, which the clips accelerate by `own`
    /// m/s² at most. Who falls or jumps is `free` to.
    pub(super) fn keep(&mut self, asked: f32, own: f32, free: bool, dt: f32) -> f32 {
        let dt = dt.max(1e-4);
        let most = MOST.max(FOLLOWED * own) * dt;
        self.left =
            self.left.map(|left| Left { elapsed: left.elapsed + dt, ..left }).filter(|left| left.elapsed < EASES);
        let mut offset = self.left.map_or(0.0, |left| left.offset());
        if let Some((before, shown, Some(speed))) = self.last.filter(|_| !free) {
            let change = (asked + offset - shown) / dt - speed;
            if change.abs() > most {
                let now = speed + change.clamp(-most, most);
                offset = shown + now * dt - asked;
                self.left = Some(Left { offset, speed: now - (asked - before) / dt, elapsed: 0.0 });
            }
        }
        let shown = asked + offset;
        self.last = Some((asked, shown, self.last.map(|(_, last, _)| (shown - last) / dt)));
        offset
    }

    /// The hips are at the world height `hips`, whatever was asked.
    pub(super) fn let_go(&mut self, hips: f32, dt: f32) {
        self.left = None;
        self.keep(hips, 0.0, true, dt);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::ops;

    const DT: f32 = 1.0 / 60.0;

    /// Heights shown for those that `asked` tells by frame.
    fn shown(free: bool, asked: impl Fn(usize) -> f32) -> Vec<f32> {
        let mut heave = Heave::default();
        (0..60).map(|frame| asked(frame) + heave.keep(asked(frame), 0.0, free, DT)).collect()
    }

    /// Largest acceleration, m/s².
    fn hardest(heights: &[f32]) -> f32 {
        heights.windows(3).map(|h| ((h[2] - 2.0 * h[1] + h[0]) / (DT * DT)).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn a_clip_that_bounces_harder_is_followed() {
        // 4 cm up and down 4.5 times a second: 32 m/s².
        let bounces = |frame: usize| 0.9 + 0.04 * ops::sin(core::f32::consts::TAU * 4.5 * frame as f32 * DT);
        let mut heave = Heave::default();
        let off = (0..60).map(|frame| heave.keep(bounces(frame), 72.0, false, DT).abs()).fold(0.0, f32::max);
        assert!(off < 1e-6, "{off} m off its clip");
    }

    /// Sinks with 0.5 m/s from the tenth frame on, and stands from the twentieth.
    fn sinks(frame: usize) -> f32 {
        0.9 - 0.5 * DT * frame.clamp(10, 20) as f32
    }

    #[test]
    fn hips_that_are_pulled_at_once_start_and_stop_gently() {
        let heights = shown(false, sinks);
        let (hardest, off) = (hardest(&heights), (heights[50] - sinks(50)).abs());
        assert!(hardest < MOST + 0.1, "{hardest} m/s²");
        assert!(off < 1e-4, "{off} m off in the end");
    }

    #[test]
    fn a_stride_is_left_alone_and_so_is_a_fall() {
        // 4 cm up and down 2.5 times a second: 10 m/s².
        let stride = |frame: usize| 0.9 + 0.04 * ops::sin(core::f32::consts::TAU * 2.5 * frame as f32 * DT);
        for (heights, asked) in [(shown(false, stride), &stride as &dyn Fn(usize) -> f32), (shown(true, sinks), &sinks)]
        {
            let off =
                heights.iter().enumerate().map(|(frame, height)| (height - asked(frame)).abs()).fold(0.0, f32::max);
            assert!(off < 1e-6, "{off} m off");
        }
    }
}
