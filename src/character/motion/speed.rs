//! How velocity follows what is wanted. Pure; horizontal vectors, m/s.

use bevy::math::{Vec2, Vec3, ops};

use crate::{math::rotation::direction_or, rig::tuning::motion::MotionConfig};

/// How fast velocity may change, m/s².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SpeedRates {
    /// Toward a faster velocity.
    pub(super) accelerate: f32,
    /// Toward a slower one.
    pub(super) brake: f32,
    /// While the wanted velocity points backward.
    pub(super) reverse: f32,
}

/// How fast a body's velocity may change.
#[must_use]
pub(super) fn speed_rates(config: &MotionConfig) -> SpeedRates {
    SpeedRates { accelerate: config.acceleration, brake: config.braking, reverse: config.reversal }
}

/// `current` moved straight toward `wanted` for `dt` seconds; never beyond it.
#[must_use]
pub(super) fn approach_velocity(current: Vec3, wanted: Vec3, rates: SpeedRates, dt: f32) -> Vec3 {
    let way = wanted - current;
    let distance = way.length();
    let rate = if current.dot(wanted) < 0.0 {
        rates.reverse
    } else if wanted.length_squared() < current.length_squared() {
        rates.brake
    } else {
        rates.accelerate
    };
    let step = (rate * dt).max(0.0);
    if distance <= step { wanted } else { current + way * (step / distance) }
}

/// `wanted` as fast as a body goes up or down a `grade` (rise over run): what is beyond `walk` m/s dwindles by
/// e^(-`slowing` · |grade|).
///
/// The form is Tobler's hiking function (Tobler, "Three presentations on geographical analysis and modeling", 1993).
#[must_use]
pub(super) fn slowed_by_grade(wanted: Vec3, walk: f32, grade: f32, slowing: f32) -> Vec3 {
    let speed = wanted.length();
    if speed <= walk || slowing <= 0.0 {
        return wanted;
    }
    wanted * ((walk + (speed - walk) * ops::exp(-slowing * grade.abs())) / speed)
}

/// `wanted` cut to the ellipse of speeds that a body facing `facing` reaches: `ahead` m/s forward, `aside` m/s to the sides
/// and backward. A body that faces nowhere is not limited.
#[must_use]
pub(super) fn limit_strafe(wanted: Vec3, facing: Vec3, ahead: f32, aside: f32) -> Vec3 {
    let forward = direction_or(facing.with_y(0.0), Vec3::ZERO);
    if forward == Vec3::ZERO {
        return wanted;
    }
    let along = wanted.dot(forward);
    let across = (wanted - forward * along).length();
    let most = if along > 0.0 { ahead } else { aside };
    let share = Vec2::new(along / most.max(1e-3), across / aside.max(1e-3)).length();
    if share > 1.0 { wanted / share } else { wanted }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RATES: SpeedRates = SpeedRates { accelerate: 8.0, brake: 12.0, reverse: 16.0 };

    #[test]
    fn slopes_slow_a_run_and_no_walk() {
        let at = |speed: f32, grade: f32| slowed_by_grade(Vec3::X * speed, 1.4, grade, 1.0).x;
        assert!((at(1.4, 0.6) - 1.4).abs() < 1e-6, "walks at {} m/s", at(1.4, 0.6));
        assert!((at(3.5, 0.0) - 3.5).abs() < 1e-6 && (at(3.5, 0.4) - at(3.5, -0.4)).abs() < 1e-6);
        assert!((2.5..2.6).contains(&at(3.5, 0.6)), "runs up 30° at {} m/s", at(3.5, 0.6));
    }

    /// Seconds until `fraction` of `speed` is reached from rest.
    fn time_to(fraction: f32, speed: f32) -> f32 {
        let (mut velocity, mut time, dt) = (Vec3::ZERO, 0.0, 1.0 / 64.0);
        while velocity.length() < fraction * speed {
            velocity = approach_velocity(velocity, Vec3::X * speed, RATES, dt);
            time += dt;
        }
        time
    }

    #[test]
    fn speed_arrives_in_time() {
        for (speed, most_63, most_90) in [(1.4, 0.2, 0.4), (3.5, 0.35, 0.6)] {
            let (to_63, to_90) = (time_to(0.63, speed), time_to(0.9, speed));
            assert!(to_63 <= most_63 && to_90 <= most_90, "{speed} m/s: 63 % after {to_63} s, 90 % after {to_90} s");
        }
    }

    #[test]
    fn sideways_and_backward_are_slower_than_ahead() {
        for (wanted, speed) in [(Vec3::NEG_Z, 3.5), (Vec3::X, 1.8), (Vec3::Z, 1.8), (Vec3::new(1.0, 0.0, -1.0), 2.438)]
        {
            let got = limit_strafe(wanted.normalize() * 3.5, Vec3::NEG_Z * 7.0, 6.0, 1.8);
            assert!((got.length() - speed).abs() < 0.01, "{wanted}: {} m/s instead of {speed}", got.length());
        }
        assert_eq!(limit_strafe(Vec3::X, Vec3::NEG_Z, 6.0, 1.8), Vec3::X, "slow enough already");
    }

    #[test]
    fn a_zero_rate_changes_nothing() {
        let rates = SpeedRates { accelerate: 0.0, brake: 0.0, reverse: 0.0 };
        assert_eq!(approach_velocity(Vec3::X, Vec3::Z, rates, 0.1), Vec3::X);
    }

    proptest! {
        #[test]
        fn velocity_never_overshoots(x in -9.0f32..9.0, z in -9.0f32..9.0, wx in -9.0f32..9.0, wz in -9.0f32..9.0, dt in 0.0f32..0.5) {
            let (from, wanted) = (Vec3::new(x, 0.0, z), Vec3::new(wx, 0.0, wz));
            let to = approach_velocity(from, wanted, RATES, dt);
            let detour = from.distance(to) + to.distance(wanted) - from.distance(wanted);
            prop_assert!(detour.abs() < 1e-4, "{detour} m/s of detour from {from} by {to} to {wanted}");
            prop_assert!(from.distance(to) <= 16.0 * dt + 1e-4, "changed by {} in {dt} s", from.distance(to));
        }
    }
}
