//! Shuts the eyes now and then, whatever plays. Reads the character's file; writes [`Blink`].

use bevy::prelude::*;

use crate::{
    character::{Character, bind::CharacterAssets},
    math::dice::Dice,
    rig::tuning::blink::BlinkConfig,
};

/// When a character's eyes shut, in a rhythm of its own.
///
/// Every character gets one by its entity's index; put one on beforehand, of another seed, for a rhythm of your choice.
#[derive(Component, Clone, Debug)]
pub struct Blink {
    dice: Dice,
    /// Seconds until the lids begin to fall, negative from then on; `None` before the first frame.
    until: Option<f32>,
}

/// Shares of a blink in which the lids fall, and after which they rise.
const FALL: f32 = 0.3;
const RISE: f32 = 0.45;

impl Blink {
    /// Eyes whose rhythm follows from `seed`.
    #[must_use]
    pub fn new(seed: u32) -> Self {
        Self { dice: Dice::new(seed), until: None }
    }

    /// Lets `dt` seconds pass; at most one blink ends in them.
    pub fn advance(&mut self, config: &BlinkConfig, dt: f32) {
        // Whom we meet is somewhere between two blinks.
        let until = self.until.unwrap_or_else(|| interval(&mut self.dice, config) * self.dice.roll()) - dt;
        let next = if until > -config.duration { 0.0 } else { interval(&mut self.dice, config) };
        self.until = Some(until + next);
    }

    /// How far the eyes are shut, 0..=1.
    #[must_use]
    pub fn shut(&self, config: &BlinkConfig) -> f32 {
        let passed = -self.until.unwrap_or(0.0) / config.duration;
        if !config.enabled || !(0.0..=1.0).contains(&passed) {
            return 0.0;
        }
        ease(passed / FALL) - ease((passed - RISE) / (1.0 - RISE))
    }
}

/// Seconds from one blink to the next: short ones are more frequent than long ones.
fn interval(dice: &mut Dice, config: &BlinkConfig) -> f32 {
    // The mean of a roll's square is a third.
    let roll = dice.roll();
    let spread = BlinkConfig::LONGEST - BlinkConfig::SHORTEST;
    config.interval * (BlinkConfig::SHORTEST + spread * roll * roll)
}

/// From 0 to 1 as `t` does, with level ends.
fn ease(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

pub(super) fn blink(time: Res<Time>, assets: CharacterAssets, mut characters: Query<(&Character, &mut Blink)>) {
    for (character, mut blink) in &mut characters {
        if let Some(asset) = assets.get(character) {
            blink.advance(&asset.file.blink, time.delta_secs());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seconds at which the lids begin to fall within ten minutes at `rate` frames a second.
    fn blinks(seed: u32, rate: u16) -> Vec<f32> {
        let (config, mut blink) = (BlinkConfig::default(), Blink::new(seed));
        let (mut begins, mut open) = (vec![], true);
        for frame in 0..600 * u32::from(rate) {
            blink.advance(&config, 1.0 / f32::from(rate));
            let now = blink.shut(&config) > 0.0;
            if now && open {
                begins.push(frame as f32 / f32::from(rate));
            }
            open = !now;
        }
        begins
    }

    #[test]
    fn eyes_blink_seventeen_times_a_minute_at_uneven_intervals() {
        for seed in [0, 1, 2, 77] {
            let begins = blinks(seed, 60);
            let a_minute = begins.len() as f32 / 10.0;
            assert!((14.0..21.0).contains(&a_minute), "seed {seed}: {a_minute} a minute");
            let intervals: Vec<f32> = begins.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let (short, long) = intervals.iter().fold((f32::MAX, 0.0f32), |sum, i| (sum.0.min(*i), sum.1.max(*i)));
            assert!(short > 1.35 && short < 1.6, "seed {seed}: shortest interval {short} s");
            assert!(long > 7.0 && long < 7.75, "seed {seed}: longest interval {long} s");
        }
    }

    #[test]
    fn each_seed_has_a_rhythm_of_its_own_at_any_frame_rate() {
        let (one, other) = (blinks(4, 60), blinks(5, 60));
        let together = one.iter().filter(|begin| other.iter().any(|o| (*begin - o).abs() < 0.2)).count();
        assert!(together * 4 < one.len(), "{together} of {} blinks are in step", one.len());
        for (a, b) in one.iter().zip(blinks(4, 144)) {
            assert!((a - b).abs() < 0.05, "at 60 Hz it blinks at {a} s, at 144 Hz at {b} s");
        }
    }

    #[test]
    fn lids_fall_and_rise_without_a_jump() {
        let config = BlinkConfig::default();
        let mut blink = Blink { dice: Dice::new(1), until: Some(0.05) };
        let (mut last, mut most, mut step) = (0.0f32, 0.0f32, 0.0f32);
        for _ in 0..400 {
            blink.advance(&config, 0.001);
            let now = blink.shut(&config);
            assert!((0.0..=1.0).contains(&now), "{now}");
            (most, step, last) = (most.max(now), step.max((now - last).abs()), now);
        }
        assert!(most > 0.999 && last.abs() < f32::EPSILON, "shut by {most}, then {last}");
        assert!(step < 0.02, "a jump of {step} in a millisecond");
        let off = BlinkConfig { enabled: false, ..config };
        assert!(
            (0..10_000).all(|_| {
                blink.advance(&off, 0.01);
                blink.shut(&off).abs() < f32::EPSILON
            }),
            "it is off"
        );
    }
}
