//! The end of a fall: legs reach the ground before the body has come down, and slow it. Pure; metres and m/s, downward.

use super::space::SKIN;

/// How fast a fall slows just above the ground, m/s²: from 4 m/s within three hands' breadths and 0.03 s, so that no root stops
/// at once.
const SLOWS: f32 = 120.0;
/// Metres within which any fall slows, however hard.
const WITHIN: f32 = 0.3;
/// Speed with which a slowed fall touches the ground.
const TOUCHES: f32 = 1.0;
/// Metres over the ground at which a slowed fall has ended: a sweep comes no nearer.
pub(super) const TOUCHING: f32 = 1.2 * SKIN;

/// A fall from its apex to the ground.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Descent {
    /// Largest speed of this fall.
    pub(super) fastest: f32,
    /// World height of the ground that it is about to end on, while it slows.
    pub(super) onto: Option<f32>,
}

impl Descent {
    /// Speed of the fall after a tick that begins at the height `from` (world) with the speed `before`, and would end with
    /// `speed`. `ground` looks for ground within the metres that it is given, and tells its height.
    pub(super) fn slowed(
        &mut self,
        from: f32,
        (before, speed): (f32, f32),
        ground: impl FnOnce(f32) -> Option<f32>,
        dt: f32,
    ) -> f32 {
        self.onto = None;
        self.fastest = if speed > 0.0 { self.fastest.max(speed) } else { 0.0 };
        if speed < TOUCHES {
            return speed;
        }
        let squares = self.fastest * self.fastest - TOUCHES * TOUCHES;
        let slows = SLOWS.max(squares / (2.0 * WITHIN));
        let Some(ground) = ground(speed * dt + squares / (2.0 * slows) + TOUCHING) else { return speed };
        let most = fastest_within((from - ground - TOUCHING).max(0.0), before, slows, dt);
        if most < speed {
            self.onto = Some(ground);
        }
        most.min(speed)
    }
}

/// Largest speed after a tick, begun with the speed `before` and `height` metres to go, from which it can slow in what is left by
/// `slows` m/s².
///
/// The tick goes by the mean of both speeds: (before + v) dt / 2 + (v² - touch²) / 2a = height, solved for v.
fn fastest_within(height: f32, before: f32, slows: f32, dt: f32) -> f32 {
    let half = 0.5 * slows * dt;
    let square = half * half - slows * dt * before + TOUCHES * TOUCHES + 2.0 * slows * height;
    (square.max(0.0).sqrt() - half).max(TOUCHES)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fall_slows_before_it_ends_and_is_told_at_its_fastest() {
        const DT: f32 = 1.0 / 64.0;
        for from in [0.3f32, 0.943, 2.0] {
            let (mut height, mut before, mut descent) = (from, 0.0f32, Descent::default());
            let mut hardest = 0.0f32;
            while height > TOUCHING + 1e-4 {
                let falls = before + 14.0 * DT;
                let now = descent.slowed(height, (before, falls), |within| (height < within).then_some(0.0), DT);
                hardest = hardest.max(before - now);
                height -= 0.5 * (before + now) * DT;
                before = now;
            }
            let free = (2.0 * 14.0 * from).sqrt();
            assert!(hardest < 1.3 * SLOWS * DT, "from {from} m: slows by {hardest} m/s in a tick");
            assert!(before < TOUCHES + 0.01 && height > -0.01, "from {from} m: ends with {before} m/s at {height} m");
            assert!((0.9..1.05).contains(&(descent.fastest / free)), "{} of {free} m/s", descent.fastest);
        }
    }

    #[test]
    fn nothing_below_lets_it_fall() {
        let mut descent = Descent::default();
        assert!((descent.slowed(9.0, (4.0, 4.2), |_| None, 0.016) - 4.2).abs() < 1e-6 && descent.onto.is_none());
    }
}
