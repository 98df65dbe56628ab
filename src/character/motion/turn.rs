//! How the body turns toward what it faces. Pure; headings about +Y in radians.

use core::f32::consts::PI;

use crate::math::{rotation::wrap_angle, spring::Spring};

/// How fast a body turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TurnRates {
    /// Half-life of the turn, seconds.
    pub(super) half_life: f32,
    /// Fastest turn, rad/s.
    pub(super) most: f32,
    /// How fast a turn may gain speed, rad/s².
    pub(super) gain: f32,
}

/// Turns the heading `yaw` toward `goal` for `dt` seconds, the shorter way round.
///
/// A critically damped spring whose rate, and what it gains of it, are cut: planted feet and swinging arms can't follow a
/// body that turns at once. A turn that is more than a hair over half a
/// circle goes on the way it already turns, so that a goal straight behind never makes it waver.
#[must_use]
pub(super) fn turn_toward(yaw: Spring<f32>, goal: f32, rates: TurnRates, dt: f32) -> Spring<f32> {
    if dt <= 0.0 {
        return yaw;
    }
    let way = way_round(yaw, goal);
    let mut spring = Spring { value: 0.0, velocity: yaw.velocity };
    spring.step(way, rates.half_life, dt);
    let gain = rates.gain.max(0.0) * dt;
    if yaw.velocity * way < 0.0 && yaw.velocity.abs() > gain {
        // The goal has gone to the other side: first this turn comes to its end.
        let velocity = (yaw.velocity - gain * yaw.velocity.signum()).clamp(-rates.most.max(0.0), rates.most.max(0.0));
        return Spring { value: wrap_angle(yaw.value + velocity * dt), velocity };
    }
    let before = if yaw.velocity * way >= 0.0 { yaw.velocity.abs() } else { 0.0 };
    let fastest = rates.most.max(0.0).min(before + gain);
    if spring.value.abs() > fastest * dt {
        spring.value = fastest * dt * spring.value.signum();
    }
    spring.velocity = spring.velocity.clamp(-fastest, fastest);
    Spring { value: wrap_angle(yaw.value + spring.value), velocity: spring.velocity }
}

/// Speed in m/s beyond a walk over which a body gives up turning while it brakes, and the share of its turn that it keeps.
const BRAKES: (f32, f32) = (1.0, 0.1);

/// Share of its fastest turn that a body makes which moves at `speed` m/s away from where it shall face: who runs brakes
/// first, to about `walk` m/s, since legs that stand wide can't turn.
#[must_use]
pub(super) fn brakes_first(speed: f32, walk: f32) -> f32 {
    (1.0 - (speed - walk) / BRAKES.0).clamp(BRAKES.1, 1.0)
}

/// Angle from the heading `yaw` to `goal`, the way that it turns.
#[must_use]
pub(super) fn way_round(yaw: Spring<f32>, goal: f32) -> f32 {
    let way = wrap_angle(goal - yaw.value);
    // Within 10° of straight behind either way is as short; keep turning the way it turns.
    if way.abs() > PI - 0.17 && way * yaw.velocity < 0.0 { way + 2.0 * PI * yaw.velocity.signum() } else { way }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RATES: TurnRates = TurnRates { half_life: 0.1, most: 12.5, gain: 80.0 };

    #[test]
    fn a_quarter_turn_is_done_in_half_a_second() {
        let mut yaw = Spring::at(0.0);
        for _ in 0..32 {
            yaw = turn_toward(yaw, PI / 2.0, RATES, 1.0 / 64.0);
        }
        assert!((yaw.value - PI / 2.0).abs() < 0.02, "at {}° after 0.5 s", yaw.value.to_degrees());
    }

    #[test]
    fn who_runs_back_brakes_before_turning() {
        let shares = [3.5, 2.4, 1.9, 1.4, 0.0, -3.5].map(|speed| brakes_first(speed, 1.4));
        let told = [0.1, 0.1, 0.5, 1.0, 1.0, 1.0];
        let off = shares.iter().zip(told).map(|(share, told)| (share - told).abs()).fold(0.0, f32::max);
        assert!(off < 1e-5, "turns by {shares:?} of its fastest");
    }

    #[test]
    fn a_goal_that_wavers_behind_does_not_turn_the_body_back() {
        let mut yaw = Spring::at(0.0);
        let mut turned = 0.0;
        for tick in 0..20u8 {
            let goal = PI + if tick % 2 == 0 { 0.05 } else { -0.05 };
            let next = turn_toward(yaw, goal, RATES, 1.0 / 64.0);
            turned += wrap_angle(next.value - yaw.value);
            yaw = next;
        }
        assert!(turned.abs() > 2.0, "turned only {}°", turned.to_degrees());
    }

    #[test]
    fn a_turn_neither_starts_nor_turns_back_at_once() {
        let mut yaw = Spring::at(0.0);
        let mut before = 0.0;
        for tick in 0..64u8 {
            let goal = if tick < 12 { 2.0 } else { -1.0 };
            yaw = turn_toward(yaw, goal, RATES, 1.0 / 64.0);
            let change = (yaw.velocity - before).abs();
            let braking = yaw.velocity * before > 0.0 && yaw.velocity.abs() < before.abs();
            assert!(braking || change <= 2.0 * RATES.gain / 64.0 + 1e-4, "{change} rad/s faster within tick {tick}");
            before = yaw.velocity;
        }
        assert!((yaw.value + 1.0).abs() < 0.02, "at {} after a second", yaw.value);
    }

    proptest! {
        #[test]
        fn a_turn_keeps_its_rate_and_never_overshoots(from in -3.1f32..3.1, goal in -9.0f32..9.0, half_life in 0.0f32..0.5, dt in 0.001f32..0.1) {
            let rates = TurnRates { half_life, most: 6.0, gain: 60.0 };
            let yaw = turn_toward(Spring::at(from), goal, rates, dt);
            let turned = wrap_angle(yaw.value - from);
            let way = wrap_angle(goal - from);
            prop_assert!(turned.abs() <= 6.0 * dt + 1e-5, "{turned} rad in {dt} s");
            prop_assert!(turned.abs() <= way.abs() + 1e-4, "turned {turned} of {way}");
            prop_assert!(yaw.value.abs() <= PI + 1e-5 && yaw.velocity.abs() <= 6.0, "{yaw:?}");
        }
    }
}
