//! Cross-fades between any number of states: weights that sum to one, move without jumps in value or slope, and may be
//! sent elsewhere at any time.

use crate::math::fade::Fade;

/// Weights of all states of a machine.
///
/// Each is a [`Fade`] of its own; all of them together are normalised.
#[derive(Clone, Debug)]
pub struct Fades {
    ways: Vec<Way>,
    /// States that weigh something or are on their way, in ascending order: all others are left alone.
    live: Vec<usize>,
    /// Whether all weights have arrived.
    settled: bool,
}

/// One state.
#[derive(Clone, Copy, Debug)]
struct Way {
    fade: Fade,
    /// Where it is now, normalised.
    weight: f32,
}

impl Fades {
    /// `count` states, all weight on `first`.
    #[must_use]
    pub fn new(count: usize, first: usize) -> Self {
        let way = |state| if state == first { 1.0 } else { 0.0 };
        let mut live = Vec::with_capacity(count);
        live.extend((first < count).then_some(first));
        Self {
            ways: (0..count).map(way).map(|at| Way { fade: Fade::at(at), weight: at }).collect(),
            live,
            settled: true,
        }
    }

    /// Sends all weight to `state` within `seconds`; at once for 0.
    pub fn send_to(&mut self, state: usize, seconds: f32) {
        if let Err(place) = self.live.binary_search(&state) {
            self.live.insert(place, state);
        }
        for live in &self.live {
            self.ways[*live].fade.send_to(if *live == state { 1.0 } else { 0.0 }, seconds);
        }
        self.settled = false;
    }

    /// Lets `dt` seconds pass.
    pub fn advance(&mut self, dt: f32) {
        if self.settled {
            return;
        }
        let Self { ways, live, settled } = self;
        let mut total = 0.0;
        *settled = true;
        for state in &*live {
            let way = &mut ways[*state];
            way.fade.advance(dt);
            way.weight = way.fade.value();
            total += way.weight;
            *settled &= !way.fade.is_fading();
        }
        if total > 0.0 {
            live.iter().for_each(|state| ways[*state].weight /= total);
        }
        live.retain(|state| ways[*state].weight > 0.0 || ways[*state].fade.is_fading());
    }

    /// Weight of `state` as of the last [`Fades::advance`], 0..=1; all sum to one.
    #[must_use]
    pub fn weight(&self, state: usize) -> f32 {
        self.ways[state].weight
    }

    /// States that weigh something, and those on their way, in ascending order.
    #[must_use]
    pub fn live(&self) -> &[usize] {
        &self.live
    }

    /// Whether a fade is under way.
    #[must_use]
    pub fn is_fading(&self) -> bool {
        self.live.iter().any(|state| self.ways[*state].fade.is_fading())
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
