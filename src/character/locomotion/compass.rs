//! Which of several gaits play for the way a body goes: forward, backward, sideways and all between.
//!
//! Blended in step, feet move by the weighted sum of the gaits' strides. Weights are chosen so that this sum points
//! exactly the way that the body goes, hence feet don't slide sideways. Pure; the body's own plane: x right, y ahead.

use core::f32::consts::{PI, TAU};

use bevy::math::{Vec2, ops};

use super::facts::ClipFacts;

/// Clips whose headings differ by less than this, in radians, go the same way, each at its speed.
const SAME_WAY: f32 = 0.2;
/// Speeds below this, in m/s, have no direction.
const STILL: f32 = 0.02;
/// Two ways further apart than this, in radians, have no sum that points between them.
const OPPOSITE: f32 = 3.0;

/// Clips by the way that they go.
#[derive(Clone, Debug, Default)]
pub(super) struct Compass {
    /// In order of heading.
    ways: Vec<Way>,
}

/// Clips of one heading.
#[derive(Clone, Debug)]
struct Way {
    /// Radians from straight ahead, left positive, -π..π.
    heading: f32,
    /// In order of speed.
    clips: Vec<Paced>,
}

#[derive(Clone, Copy, Debug)]
struct Paced {
    clip: usize,
    speed: f32,
    stride: f32,
}

/// The clips of one way that play at a speed: one, or two neighbours.
#[derive(Clone, Copy, Debug)]
struct Pick {
    slow: Paced,
    fast: Paced,
    /// Share of the faster one.
    share: f32,
}

impl Compass {
    /// For clips with these facts; those that stay in place take no part.
    pub(super) fn new(clips: &[ClipFacts]) -> Self {
        let mut ways: Vec<Way> = Vec::new();
        for (clip, facts) in clips.iter().enumerate() {
            if facts.stride <= 0.0 || facts.duration <= 0.0 {
                continue;
            }
            let paced = Paced { clip, speed: facts.stride / facts.duration, stride: facts.stride };
            match ways.iter_mut().find(|way| angle_from(way.heading, facts.heading).abs() < SAME_WAY) {
                Some(way) => way.clips.push(paced),
                None => ways.push(Way { heading: angle_from(0.0, facts.heading), clips: vec![paced] }),
            }
        }
        ways.iter_mut().for_each(|way| way.clips.sort_by(|a, b| a.speed.total_cmp(&b.speed)));
        ways.sort_by(|a, b| a.heading.total_cmp(&b.heading));
        Self { ways }
    }

    /// Sends the shares of clips to `give`, for a body that goes with `velocity`; those of one clip add up, all sum to one.
    /// False, and nothing sent, for a body that stands or clips that go nowhere.
    pub(super) fn shares(&self, velocity: Vec2, mut give: impl FnMut(usize, f32)) -> bool {
        let speed = velocity.length();
        let (Some(last), false) = (self.ways.last(), speed < STILL) else { return false };
        let heading = ops::atan2(-velocity.x, velocity.y);
        let next = self.ways.iter().position(|way| way.heading > heading).unwrap_or(0);
        let right = if next == 0 { last } else { &self.ways[next - 1] };
        let left = &self.ways[next];
        let gap = angle_from(right.heading, left.heading).rem_euclid(TAU);
        let into = angle_from(right.heading, heading).rem_euclid(TAU);
        let [from, to] = [right, left].map(|way| way.pick(speed));
        if gap < SAME_WAY {
            to.send(1.0, &mut give);
            return true;
        }
        // Sine rule: a · from + b · to points to `heading`.
        let (a, b) = if gap < OPPOSITE {
            (ops::sin(gap - into) / from.stride(), ops::sin(into) / to.stride())
        } else {
            (gap - into, into)
        };
        let sum = a + b;
        from.send(a / sum, &mut give);
        to.send(b / sum, &mut give);
        true
    }
}

impl Way {
    fn pick(&self, speed: f32) -> Pick {
        let faster = self.clips.iter().position(|clip| clip.speed > speed).unwrap_or(self.clips.len() - 1);
        let (slow, fast) = (self.clips[faster.saturating_sub(1)], self.clips[faster]);
        let gap = fast.speed - slow.speed;
        let share = if gap > 1e-3 { ((speed - slow.speed) / gap).clamp(0.0, 1.0) } else { 1.0 };
        Pick { slow, fast, share }
    }
}

impl Pick {
    fn stride(&self) -> f32 {
        self.slow.stride + (self.fast.stride - self.slow.stride) * self.share
    }

    fn send(&self, weight: f32, give: &mut impl FnMut(usize, f32)) {
        if self.slow.clip != self.fast.clip {
            give(self.slow.clip, weight * (1.0 - self.share));
        }
        give(self.fast.clip, weight * if self.slow.clip == self.fast.clip { 1.0 } else { self.share });
    }
}

/// Angle from heading `from` to `to`, -π..π.
fn angle_from(from: f32, to: f32) -> f32 {
    (to - from + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::FRAC_PI_2;
    use proptest::prelude::*;

    const fn clip(duration: f32, speed: f32, heading: f32) -> ClipFacts {
        ClipFacts { duration, looping: true, stride: speed * duration, heading }
    }

    /// Walk, run, back, left, right.
    const CLIPS: [ClipFacts; 5] = [
        clip(1.07, 1.4, 0.0),
        clip(0.7, 3.5, 0.0),
        clip(1.07, 1.1, PI),
        clip(0.58, 1.2, FRAC_PI_2),
        clip(0.58, 1.2, -FRAC_PI_2),
    ];

    fn shares(velocity: Vec2) -> [f32; 5] {
        let mut shares = [0.0; 5];
        Compass::new(&CLIPS).shares(velocity, |clip, share| shares[clip] += share);
        shares
    }

    #[test]
    fn a_way_that_one_clip_goes_plays_that_clip_alone() {
        for (velocity, clip) in [
            (Vec2::new(0.0, 1.4), 0),
            (Vec2::new(0.0, 0.4), 0),
            (Vec2::new(0.0, 3.5), 1),
            (Vec2::new(0.0, 6.0), 1),
            (Vec2::new(0.0, -1.0), 2),
            (Vec2::new(-1.0, 0.0), 3),
            (Vec2::new(1.5, 0.0), 4),
        ] {
            let shares = shares(velocity);
            assert!(shares[clip] > 0.999, "{velocity}: {shares:?}");
        }
    }

    #[test]
    fn a_speed_between_walk_and_run_plays_both() {
        let shares = shares(Vec2::new(0.0, 2.45));
        assert!((shares[0] - 0.5).abs() < 1e-4 && (shares[1] - 0.5).abs() < 1e-4, "{shares:?}");
    }

    #[test]
    fn a_clip_alone_plays_whatever_the_way() {
        let mut share = 0.0;
        Compass::new(&CLIPS[..1]).shares(Vec2::new(1.0, -1.0), |_, given| share += given);
        assert!((share - 1.0).abs() < 1e-6, "{share}");
    }

    proptest! {
        #[test]
        fn blended_feet_go_exactly_the_bodys_way(x in -3.0f32..3.0, y in -3.0f32..3.0) {
            let velocity = Vec2::new(x, y);
            prop_assume!(velocity.length() > 0.1);
            let shares = shares(velocity);
            let sum: f32 = shares.iter().sum();
            prop_assert!((sum - 1.0).abs() < 1e-4, "shares {shares:?} sum to {sum}");
            let way: Vec2 = CLIPS.iter().zip(shares).map(|(clip, share)| Vec2::from_angle(clip.heading + FRAC_PI_2) * (clip.stride * share)).sum();
            let off = way.angle_to(velocity).abs();
            prop_assert!(off < 0.01, "feet go {way}, the body {velocity}: {off} rad off");
        }

        #[test]
        fn a_small_turn_changes_shares_little(angle in -3.2f32..3.2, speed in 0.2f32..4.0) {
            let at = |angle: f32| shares(Vec2::from_angle(angle) * speed);
            let change = at(angle).iter().zip(at(angle + 0.01)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            prop_assert!(change < 0.06, "a share jumps by {change}");
        }
    }
}
