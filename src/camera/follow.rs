//! Following a moving goal: exact for a goal that moves evenly within a frame, so any frame rate trails it alike.
//!
//! [`crate::math::spring`] holds its goal still during a step; behind a walking target that would lag by up to a frame more at
//! 30 Hz than at 144 Hz.

use core::f32::consts::LN_2;

use crate::math::spring::{Spring, Springy, remaining};

/// Moves a spring for `dt` seconds while its goal goes evenly from `from` to `to`.
///
/// Behind a steady goal the value trails by its speed times `half_life` / ln 2.
pub fn track<T: Springy>(spring: &mut Spring<T>, from: T, to: T, half_life: f32, dt: f32) {
    if dt.is_nan() || dt <= 0.0 {
        return;
    }
    let rate = (to - from) * (1.0 / dt);
    // Seen from the point that a spring would trail at, the goal stands still.
    let lag = rate * (half_life.max(0.0) / LN_2);
    let mut offset = Spring { value: spring.value - from + lag, velocity: spring.velocity - rate };
    offset.step(to * 0.0, half_life, dt);
    spring.value = to - lag + offset.value;
    spring.velocity = rate + offset.velocity;
}

/// [`track`] without momentum: `value` loses half of its distance every `half_life` seconds while the goal moves.
#[must_use]
pub fn approach(value: f32, from: f32, to: f32, half_life: f32, dt: f32) -> f32 {
    if dt.is_nan() || dt <= 0.0 {
        return value;
    }
    let lag = (to - from) / dt * (half_life.max(0.0) / LN_2);
    to - lag + (value - from + lag) * remaining(half_life, dt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn two_half_frames_are_one_whole(value in -5.0f32..5.0, velocity in -5.0f32..5.0, from in -5.0f32..5.0, to in -5.0f32..5.0, half_life in 0.02f32..0.5, dt in 0.002f32..0.1) {
            let (mut once, middle) = (Spring { value, velocity }, (from + to) * 0.5);
            let mut twice = once;
            track(&mut once, from, to, half_life, dt);
            track(&mut twice, from, middle, half_life, dt * 0.5);
            track(&mut twice, middle, to, half_life, dt * 0.5);
            let tolerance = 1e-3 * (1.0 + (to - from).abs() / dt * half_life);
            prop_assert!((once.value - twice.value).abs() < tolerance, "{} and {}", once.value, twice.value);

            let once = approach(value, from, to, half_life, dt);
            let twice = approach(approach(value, from, middle, half_life, dt * 0.5), middle, to, half_life, dt * 0.5);
            prop_assert!((once - twice).abs() < tolerance, "{once} and {twice}");
        }
    }

    #[test]
    fn a_steady_goal_is_trailed_by_the_stated_distance() {
        let (mut spring, speed, half_life) = (Spring::at(0.0), 3.0, 0.1);
        for frame in 0..600 {
            track(&mut spring, speed * frame as f32 / 60.0, speed * (frame + 1) as f32 / 60.0, half_life, 1.0 / 60.0);
        }
        let behind = 30.0 - spring.value;
        assert!((behind - speed * half_life / LN_2).abs() < 1e-3, "{behind} m behind");
    }

    #[test]
    fn no_half_life_is_no_lag() {
        let mut spring = Spring::at(0.0);
        track(&mut spring, 0.0, 2.0, 0.0, 0.1);
        assert!((spring.value - 2.0).abs() < 1e-6, "{}", spring.value);
        assert!((approach(0.0, 0.0, 2.0, 0.0, 0.1) - 2.0).abs() < 1e-6);
    }
}
