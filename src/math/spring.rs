//! Springs and decay by half-life: exact in time, so any frame rate gives the same motion.
//!
//! Source: Daniel Holden, "Spring-It-On: The Game Developer's Spring-Roll-Call" (theorangeduck.com, 2021).

use bevy::math::{Quat, Vec2, Vec3, ops};

use super::rotation::{from_scaled_axis, to_scaled_axis};

/// Below this half-life, in seconds, a spring is a jump.
const SHORTEST_HALF_LIFE: f32 = 1e-5;

/// Fraction of an offset that is left after `dt` seconds, when half of it goes every `half_life` seconds.
///
/// 1 for `dt` ≤ 0; 0 for a half-life of 0.
#[must_use]
pub fn remaining(half_life: f32, dt: f32) -> f32 {
    if half_life < SHORTEST_HALF_LIFE {
        return if dt > 0.0 { 0.0 } else { 1.0 };
    }
    ops::exp2(-dt.max(0.0) / half_life)
}

/// Moves `from` toward `to`; half of the way every `half_life` seconds.
#[must_use]
pub fn damp(from: f32, to: f32, half_life: f32, dt: f32) -> f32 {
    to + (from - to) * remaining(half_life, dt)
}

/// [`damp`] for vectors.
#[must_use]
pub fn damp_vec3(from: Vec3, to: Vec3, half_life: f32, dt: f32) -> Vec3 {
    to + (from - to) * remaining(half_life, dt)
}

/// [`damp`] for rotations, on the shortest arc.
#[must_use]
pub fn damp_quat(from: Quat, to: Quat, half_life: f32, dt: f32) -> Quat {
    let offset = to_scaled_axis(from * to.inverse());
    (from_scaled_axis(offset * remaining(half_life, dt)) * to).normalize()
}

/// What a [`Spring`] moves: anything that adds and scales.
pub trait Springy:
    Copy + core::ops::Add<Output = Self> + core::ops::Sub<Output = Self> + core::ops::Mul<f32, Output = Self>
{
}
impl<T: Copy + core::ops::Add<Output = T> + core::ops::Sub<Output = T> + core::ops::Mul<f32, Output = T>> Springy
    for T
{
}

/// A value on a critically damped spring: arrives without overshoot, velocity stays continuous.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spring<T> {
    /// Where it is.
    pub value: T,
    /// How fast it moves, per second.
    pub velocity: T,
}

impl<T: Springy> Spring<T> {
    /// A spring at rest.
    #[must_use]
    pub fn at(value: T) -> Self {
        Self { value, velocity: value * 0.0 }
    }

    /// Moves toward `goal` for `dt` seconds: half-way after about `half_life` seconds.
    ///
    /// The exact solution of a critically damped spring, so two steps of dt/2 equal one of dt.
    pub fn step(&mut self, goal: T, half_life: f32, dt: f32) {
        if half_life < SHORTEST_HALF_LIFE {
            if dt > 0.0 {
                *self = Self::at(goal);
            }
            return;
        }
        // Holden 2021: damping 4 ln 2 / half_life, critical, hence y = damping / 2.
        let y = 2.0 * core::f32::consts::LN_2 / half_life;
        let dt = dt.max(0.0);
        let offset = self.value - goal;
        let slope = self.velocity + offset * y;
        let decay = ops::exp(-y * dt);
        self.value = goal + (offset + slope * dt) * decay;
        self.velocity = (self.velocity - slope * (y * dt)) * decay;
    }
}

impl<T: Springy> Spring<T> {
    /// [`step`](Self::step) toward a goal that is at `goal` now and moves by `goal_velocity` per second: exact, too.
    pub fn step_after(&mut self, goal: T, goal_velocity: T, half_life: f32, dt: f32) {
        let dt = dt.max(0.0);
        if half_life < SHORTEST_HALF_LIFE {
            return self.step(goal + goal_velocity * dt, half_life, dt);
        }
        // Behind a goal in steady motion it comes to trail by 2 v / y; that difference is a spring at rest.
        let lag = goal_velocity * (half_life / core::f32::consts::LN_2);
        let mut trail = Self { value: self.value - goal + lag, velocity: self.velocity - goal_velocity };
        trail.step(goal * 0.0, half_life, dt);
        self.value = trail.value + goal + goal_velocity * dt - lag;
        self.velocity = trail.velocity + goal_velocity;
    }
}

/// A value that goes after a goal, however far that jumps, with bounded speed and acceleration.
///
/// A spring after a lure, which itself goes straight to the goal at no more than the fastest speed. So the value is never
/// faster than the lure, and gains no more than 2 · fastest · y / e per second, y = 2 ln 2 / half-life. Exact in time: two
/// steps of dt/2 equal one of dt.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pursuit<T> {
    spring: Spring<T>,
    lure: T,
}

impl Pursuit<Vec2> {
    /// At rest at `value`.
    #[must_use]
    pub fn at(value: Vec2) -> Self {
        Self { spring: Spring::at(value), lure: value }
    }

    /// Where it is.
    #[must_use]
    pub fn value(&self) -> Vec2 {
        self.spring.value
    }

    /// How fast it moves, per second.
    #[must_use]
    pub fn velocity(&self) -> Vec2 {
        self.spring.velocity
    }

    /// Goes after `goal` for `dt` seconds, at most `fastest` units per second.
    pub fn step(&mut self, goal: Vec2, fastest: f32, half_life: f32, dt: f32) {
        let (way, fastest) = (goal - self.lure, fastest.max(0.0));
        let arrives = if fastest > 0.0 { way.length() / fastest } else { f32::INFINITY };
        let under_way = dt.max(0.0).min(arrives);
        if under_way > 0.0 {
            let velocity = way.normalize_or_zero() * fastest;
            self.spring.step_after(self.lure, velocity, half_life, under_way);
            self.lure += velocity * under_way;
        }
        if dt > under_way {
            self.lure = goal;
            self.spring.step(goal, half_life, dt - under_way);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn half_is_left_after_one_half_life() {
        let left = remaining(0.3, 0.3);
        assert!((left - 0.5).abs() < 1e-6, "{left} is left");
    }

    #[test]
    fn a_zero_half_life_arrives_at_once() {
        let mut spring = Spring::at(1.0);
        spring.step(3.0, 0.0, 0.01);
        assert_eq!(spring, Spring::at(3.0));
        assert!(damp(1.0, 3.0, 0.0, 0.01).to_bits() == 3.0f32.to_bits());
    }

    proptest! {
        #[test]
        fn two_half_steps_are_one_whole(value in -10.0f32..10.0, velocity in -10.0f32..10.0, goal in -10.0f32..10.0, half_life in 0.02f32..1.0, dt in 0.0f32..0.5) {
            let mut once = Spring { value, velocity };
            let mut twice = once;
            once.step(goal, half_life, dt);
            twice.step(goal, half_life, dt * 0.5);
            twice.step(goal, half_life, dt * 0.5);
            prop_assert!((once.value - twice.value).abs() < 1e-3, "{} after one step, {} after two", once.value, twice.value);
            prop_assert!((once.velocity - twice.velocity).abs() < 1e-2 * (1.0 + once.velocity.abs()), "velocity {} and {}", once.velocity, twice.velocity);
        }

        #[test]
        fn a_pursuit_is_exact_and_bounded(goals in proptest::collection::vec((-3.0f32..3.0, -3.0f32..3.0), 1..6), fastest in 0.5f32..12.0, half_life in 0.02f32..0.3, dt in 0.002f32..0.2) {
            let mut once = Pursuit::at(Vec2::ZERO);
            let mut finely = once;
            let most = 2.0 * fastest * (2.0 * core::f32::consts::LN_2 / half_life) / core::f32::consts::E;
            for (x, y) in goals {
                let before = once;
                once.step(Vec2::new(x, y), fastest, half_life, dt);
                for _ in 0..4 {
                    finely.step(Vec2::new(x, y), fastest, half_life, dt / 4.0);
                }
                prop_assert!(once.value().distance(finely.value()) < 2e-3, "{} in one step, {} in four", once.value(), finely.value());
                prop_assert!(once.velocity().length() <= 1.001 * fastest + 1e-3, "{} at most {fastest}", once.velocity().length());
                let gained = once.velocity().distance(before.velocity()) / dt;
                prop_assert!(gained <= 1.01 * most + 0.1, "gained {gained} per second, at most {most}");
            }
        }

        #[test]
        fn a_spring_at_rest_never_overshoots(value in -10.0f32..10.0, goal in -10.0f32..10.0, half_life in 0.02f32..1.0, dt in 0.0f32..0.5) {
            let mut spring = Spring::at(value);
            spring.step(goal, half_life, dt);
            let way = (goal - value).abs();
            prop_assert!((spring.value - value).abs() <= way + 1e-4 && (goal - spring.value).abs() <= way + 1e-4, "from {value} to {goal}: {}", spring.value);
        }
    }
}
