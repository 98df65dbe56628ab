//! How soon a standing character answers. Pure.

use super::frame::Frame;

/// Speed in m/s from which a wanted velocity is a run.
const RUN: f32 = 2.4;
/// Speed in m/s below which a character stands.
const STANDS: f32 = 0.05;
/// Frames of standing before a start, by which is known how much the pose moves anyway.
const BEFORE: usize = 10;
/// A pose changes when a joint gets faster than this many times its speed in standing, and by `CLEARLY` m/s.
const FASTER: f32 = 1.5;
const CLEARLY: f32 = 0.02;
/// Speed in m/s of a joint in standing above which a change can't be told: a foot is still being put down.
const RESTLESS: f32 = 0.1;

/// The slowest of all starts from standing; `None` where there was none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Starts {
    /// Frames from the intent to the first change of the pose, the frame of the intent included.
    pub(super) frames: Option<f32>,
    /// Seconds to 63 % and 90 % of a walk's speed.
    pub(super) walk: Option<[f32; 2]>,
    /// The same of a run.
    pub(super) run: Option<[f32; 2]>,
}

impl Starts {
    /// The slower of each.
    pub(super) fn slowest(self, other: Self) -> Self {
        let slower = |a: Option<[f32; 2]>, b: Option<[f32; 2]>| match (a, b) {
            (Some(a), Some(b)) => Some([a[0].max(b[0]), a[1].max(b[1])]),
            (one, other) => one.or(other),
        };
        Self {
            frames: self.frames.into_iter().chain(other.frames).reduce(f32::max),
            walk: slower(self.walk, other.walk),
            run: slower(self.run, other.run),
        }
    }
}

/// Looks at every start. What isn't reached before the intent changes counts with the time until then.
pub(super) fn starts(frames: &[Frame]) -> Starts {
    let mut starts = Starts::default();
    for index in BEFORE..frames.len() {
        let before = &frames[index - BEFORE..index];
        let wanted = frames[index].wanted;
        let stood = before.iter().all(|frame| frame.wanted.length() < STANDS && frame.velocity.length() < STANDS);
        if !stood || wanted.length() < 10.0 * STANDS {
            continue;
        }
        let rest = &frames[index..];
        let same = rest.iter().take_while(|frame| frame.wanted.distance(wanted) < STANDS).count();
        let rest = &rest[..same];
        let idle = before.iter().map(|frame| frame.pose_speed).fold(0.0, f32::max);
        let changed = rest.iter().position(|frame| frame.pose_speed > FASTER * idle + CLEARLY);
        let count = (idle < RESTLESS).then_some(changed.unwrap_or(same) as f32 + 1.0);
        let direction = wanted.normalize_or_zero();
        let last = rest.len() - 1;
        let reached = [0.63, 0.9].map(|share| {
            let fast = |frame: &Frame| frame.velocity.dot(direction) >= share * wanted.length();
            rest[rest.iter().position(fast).unwrap_or(last)].time - before[BEFORE - 1].time
        });
        let walks = wanted.length() < RUN;
        let (walk, run) = (walks.then_some(reached), (!walks).then_some(reached));
        starts = starts.slowest(Starts { frames: count, walk, run });
    }
    starts
}

#[cfg(test)]
mod tests {
    use bevy::prelude::*;

    use super::*;

    #[test]
    fn a_start_is_timed_from_the_intent() {
        let frame = |index: usize| {
            let since = index as f32 - 29.0;
            Frame {
                time: index as f32 / 60.0,
                wanted: if since > 0.0 { Vec3::NEG_Z * 3.5 } else { Vec3::ZERO },
                velocity: Vec3::NEG_Z * (since * 0.1).clamp(0.0, 3.5),
                pose_speed: if since > 2.0 { 1.0 } else { 0.03 },
                ..default()
            }
        };
        let frames: Vec<Frame> = (0..120).map(frame).collect();
        let got = starts(&frames);
        assert_eq!(got.frames, Some(3.0), "frames until the pose changes");
        let [most, nearly] = got.run.unwrap();
        assert!((most - 23.0 / 60.0).abs() < 1e-3, "63 % after {most} s");
        assert!((nearly - 32.0 / 60.0).abs() < 1e-3, "90 % after {nearly} s");
        assert_eq!(got.walk, None, "nobody started to walk");
    }
}
