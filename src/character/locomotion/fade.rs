//! Cross-fades between any number of states: weights that sum to one, move without jumps in value or slope, and may be
//! sent elsewhere at any time.

use smallvec::SmallVec;

use crate::math::fade::Fade;

/// Weights of all states of a machine.
///
/// Each is a [`Fade`] of its own; all of them together are normalised.
#[derive(Clone, Debug)]
pub struct Fades {
    /// States that weigh something or are on their way, in ascending order: all others weigh nothing.
    live: SmallVec<[Way; 4]>,
    /// Whether all weights have arrived.
    settled: bool,
}

/// One state.
#[derive(Clone, Copy, Debug)]
struct Way {
    state: u32,
    fade: Fade,
    /// Where it is now, normalised.
    weight: f32,
    /// Seconds into its clip; for turns, at the clip's own rate.
    clock: f32,
}

impl Way {
    fn at(state: usize, weight: f32) -> Self {
        Self { state: u32::try_from(state).unwrap_or(u32::MAX), fade: Fade::at(weight), weight, clock: 0.0 }
    }

    fn state(&self) -> usize {
        self.state as usize
    }
}

impl Fades {
    /// `count` states, all weight on `first`.
    #[must_use]
    pub fn new(count: usize, first: usize) -> Self {
        Self { live: (first < count).then(|| Way::at(first, 1.0)).into_iter().collect(), settled: true }
    }

    /// Sends all weight to `state` within `seconds`; at once for 0.
    pub fn send_to(&mut self, state: usize, seconds: f32) {
        if let Err(place) = self.live.binary_search_by_key(&state, Way::state) {
            self.live.insert(place, Way::at(state, 0.0));
        }
        for way in &mut self.live {
            way.fade.send_to(if way.state() == state { 1.0 } else { 0.0 }, seconds);
        }
        self.settled = false;
    }

    /// Lets `dt` seconds pass.
    pub fn advance(&mut self, dt: f32) {
        if self.settled {
            return;
        }
        let mut total = 0.0;
        for way in &mut self.live {
            way.fade.advance(dt);
            way.weight = way.fade.value();
            total += way.weight;
        }
        if total > 0.0 {
            self.live.iter_mut().for_each(|way| way.weight /= total);
        }
        self.settled = !self.is_fading();
        self.live.retain(|way| way.weight > 0.0 || way.fade.is_fading());
    }

    /// Weight of `state` as of the last [`Fades::advance`], 0..=1; all sum to one.
    #[must_use]
    pub fn weight(&self, state: usize) -> f32 {
        self.way(state).map_or(0.0, |way| way.weight)
    }

    /// Seconds into the clip of `state`; 0 for one that weighs nothing.
    #[must_use]
    pub fn clock(&self, state: usize) -> f32 {
        self.way(state).map_or(0.0, |way| way.clock)
    }

    /// Puts the clip of `state`, if that is live, so many seconds in.
    pub fn set_clock(&mut self, state: usize, seconds: f32) {
        self.live.iter_mut().filter(|way| way.state() == state).for_each(|way| way.clock = seconds);
    }

    /// Lets the clips of all states that weigh something go on for the seconds that `step` tells.
    pub fn run_clocks(&mut self, mut step: impl FnMut(usize) -> f32) {
        let heard = self.live.iter_mut().filter(|way| way.weight > 0.0);
        heard.for_each(|way| way.clock += step(way.state as usize));
    }

    fn way(&self, state: usize) -> Option<&Way> {
        self.live.iter().find(|way| way.state() == state)
    }

    /// States that weigh something, in ascending order.
    pub fn heard(&self) -> impl Iterator<Item = (usize, f32)> {
        self.live.iter().filter(|way| way.weight > 0.0).map(|way| (way.state(), way.weight))
    }

    /// Whether a fade is under way.
    #[must_use]
    pub fn is_fading(&self) -> bool {
        self.live.iter().any(|way| way.fade.is_fading())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_fade_takes_exactly_its_time() {
        let mut fades = Fades::new(3, 0);
        fades.send_to(2, 0.2);
        fades.advance(0.199);
        assert!(fades.weight(2) < 1.0 && fades.weight(2) > 0.99, "{} just before the end", fades.weight(2));
        fades.advance(0.002);
        assert!(fades.weight(2) >= 1.0 && !fades.is_fading());
    }

    proptest! {
        #[test]
        fn weights_sum_to_one_and_never_jump(sends in prop::collection::vec((0usize..4, 0.1f32..0.3, 0.0f32..0.25), 1..12)) {
            let mut fades = Fades::new(4, 0);
            let step = 1.0 / 240.0;
            let mut last: Vec<f32> = (0..4).map(|i| fades.weight(i)).collect();
            for (state, seconds, wait) in sends {
                fades.send_to(state, seconds);
                for _ in 0..=(wait / step) as usize {
                    fades.advance(step);
                    let now: Vec<f32> = (0..4).map(|i| fades.weight(i)).collect();
                    let sum: f32 = now.iter().sum();
                    prop_assert!((sum - 1.0).abs() < 1e-4, "weights sum to {sum}");
                    for (a, b) in last.iter().zip(&now) {
                        // The steepest smooth fade of 0.1 s moves 0.0625 per 1/240 s.
                        prop_assert!((a - b).abs() < 0.12, "a weight jumped by {}", (a - b).abs());
                    }
                    last = now;
                }
            }
        }
    }
}
