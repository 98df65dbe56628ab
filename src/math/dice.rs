//! A small random number generator, the same on every machine.

use core::f32::consts::TAU;

use bevy::math::{Quat, Vec3, ops};

/// Rolls the same numbers for the same seed.
#[derive(Clone, Debug)]
pub struct Dice(u32);

impl Dice {
    /// Dice that begin at `seed`.
    #[must_use]
    pub fn new(seed: u32) -> Self {
        Self(seed)
    }

    /// 0..1.
    pub fn roll(&mut self) -> f32 {
        // PCG-RXS-M-XS-32 (O'Neill 2014); 24 bits fit a float.
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let word = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
        (((word >> 22) ^ word) >> 8) as f32 / 16_777_216.0
    }

    /// `from`..`to`.
    pub fn between(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * self.roll()
    }

    /// One of `0..count`.
    pub fn pick(&mut self, count: usize) -> usize {
        ((self.roll() * count as f32) as usize).min(count.saturating_sub(1))
    }

    /// Any turn about +Y.
    pub fn turn(&mut self) -> Quat {
        Quat::from_rotation_y(self.between(0.0, TAU))
    }

    /// Any unit vector.
    pub fn direction(&mut self) -> Vec3 {
        let (height, around) = (self.between(-1.0, 1.0), self.between(0.0, TAU));
        on_sphere(height, around)
    }
}

/// The point of the unit sphere at `height` -1..=1, `around` radians about +Y. Even steps of height and angle cover the sphere evenly.
#[must_use]
pub fn on_sphere(height: f32, around: f32) -> Vec3 {
    let (sin, cos) = ops::sin_cos(around);
    let flat = (1.0 - height * height).max(0.0).sqrt();
    Vec3::new(flat * cos, height, flat * sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rolls_spread_evenly_and_repeat() {
        let (mut dice, mut again) = (Dice::new(5), Dice::new(5));
        let rolls: Vec<f32> = (0..4000).map(|_| dice.roll()).collect();
        let mean = rolls.iter().sum::<f32>() / 4000.0;
        assert!((mean - 0.5).abs() < 0.02, "mean {mean}");
        assert!(rolls.iter().all(|roll| (0.0..1.0).contains(roll)), "a roll outside 0..1");
        assert_eq!(rolls, (0..4000).map(|_| again.roll()).collect::<Vec<f32>>());
    }
}
