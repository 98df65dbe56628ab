//! One value on its way to another: in exactly the time given, without jumps in value or slope.

use bevy::math::Vec3;

/// A weight that fades. It may be sent elsewhere at any time.
///
/// It follows a cubic Hermite curve from its present value and slope to its target; an interrupted fade starts the next
/// one with the value and slope that it had.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fade {
    start: f32,
    slope: f32,
    target: f32,
    elapsed: f32,
    seconds: f32,
}

impl Fade {
    /// At rest at `value`, 0..=1.
    #[must_use]
    pub fn at(value: f32) -> Self {
        Self { start: value, target: value, ..Self::default() }
    }

    /// Sends it to `target`, 0..=1, within `seconds`; at once for 0.
    pub fn send_to(&mut self, target: f32, seconds: f32) {
        let (start, slope) = self.now();
        // Who rests there already has no way to go.
        let seconds = if (start - target).abs() + slope.abs() <= 0.0 { 0.0 } else { seconds.max(0.0) };
        *self = Self { start, slope, target, elapsed: 0.0, seconds };
    }

    /// Lets `dt` seconds pass.
    pub fn advance(&mut self, dt: f32) {
        self.elapsed = (self.elapsed + dt.max(0.0)).min(self.seconds + 1.0);
    }

    /// Where it is, 0..=1.
    #[must_use]
    pub fn value(&self) -> f32 {
        self.now().0
    }

    /// Where it goes.
    #[must_use]
    pub fn target(&self) -> f32 {
        self.target
    }

    /// Whether it is under way.
    #[must_use]
    pub fn is_fading(&self) -> bool {
        self.elapsed < self.seconds
    }

    /// Value clamped to 0..=1, and slope per second.
    fn now(&self) -> (f32, f32) {
        let Self { start, slope, target, elapsed, seconds } = *self;
        if elapsed >= seconds {
            return (target, 0.0);
        }
        let u = elapsed / seconds;
        let (u2, u3) = (u * u, u * u * u);
        let value = (2.0 * u3 - 3.0 * u2 + 1.0) * start
            + (u3 - 2.0 * u2 + u) * seconds * slope
            + (3.0 * u2 - 2.0 * u3) * target;
        let rate = (6.0 * u2 - 6.0 * u) / seconds * (start - target) + (3.0 * u2 - 4.0 * u + 1.0) * slope;
        if (0.0..=1.0).contains(&value) { (value, rate) } else { (value.clamp(0.0, 1.0), 0.0) }
    }
}

/// What is left of an `offset` that started to move with `speed` (per unit of `t`), at `t` from 0 to 1: it ends at rest at 1, and
/// starts and ends without acceleration.
///
/// The quintic of Bollo, "Inertialization: High-Performance Animation Transitions in Gears of War" (GDC 2018), with no
/// acceleration at its start.
#[must_use]
pub fn ebb(offset: Vec3, speed: Vec3, t: f32) -> Vec3 {
    let rest = 1.0 - t.clamp(0.0, 1.0);
    let cube = rest * rest * rest;
    offset * (cube * (1.0 + 3.0 * t + 6.0 * t * t)) + speed * (cube * t * (1.0 + 3.0 * t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn it_takes_exactly_its_time() {
        let mut fade = Fade::at(0.0);
        fade.send_to(0.7, 0.2);
        fade.advance(0.199);
        assert!(fade.value() < 0.7 && fade.value() > 0.69, "{} just before the end", fade.value());
        fade.advance(0.002);
        assert!((fade.value() - 0.7).abs() < 1e-6 && !fade.is_fading(), "{} at the end", fade.value());
        fade.send_to(0.0, 0.0);
        assert!(fade.value() <= 0.0, "a fade without time is at {}", fade.value());
    }

    proptest! {
        #[test]
        fn it_never_jumps_wherever_it_is_sent(sends in prop::collection::vec((0.0f32..=1.0, 0.1f32..0.3, 0.0f32..0.25), 1..12)) {
            let mut fade = Fade::at(0.0);
            let mut last = 0.0;
            for (target, seconds, wait) in sends {
                fade.send_to(target, seconds);
                for _ in 0..=(wait * 240.0) as usize {
                    fade.advance(1.0 / 240.0);
                    let now = fade.value();
                    // The steepest smooth fade of 0.1 s moves 0.0625 per 1/240 s.
                    prop_assert!((0.0..=1.0).contains(&now) && (now - last).abs() < 0.12, "from {last} to {now}");
                    last = now;
                }
            }
        }
    }

    #[test]
    fn an_offset_ebbs_as_told_and_ends_at_rest() {
        let at = |t| ebb(Vec3::X, Vec3::Y, t);
        assert!((at(0.0) - Vec3::X).length() < 1e-6 && at(1.0).length() < 1e-6);
        let speed = (at(0.01) - at(0.0)) / 0.01;
        assert!((speed - Vec3::Y).length() < 0.01, "starts with {speed}");
        let last = at(0.99).length();
        assert!(last < 1e-4, "{last} left just before its end");
    }
}
