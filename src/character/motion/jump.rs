//! Jumps: how fast to leave the ground, and when a press of the button counts. Pure.

use crate::rig::tuning::motion::MotionConfig;

/// Upward speed in m/s that carries a body `height` metres up under `gravity` m/s².
#[must_use]
pub(super) fn jump_speed(height: f32, gravity: f32) -> f32 {
    (2.0 * height.max(0.0) * gravity.max(0.0)).sqrt()
}

/// Downward acceleration in m/s² while a jump rises with the button already let go.
///
/// A jump let go at once then rises to the tap height; one held throughout to the full height.
#[must_use]
pub(super) fn cut_gravity(config: &MotionConfig) -> f32 {
    if config.jump_tap_height < 1e-3 {
        // The whole height in a tap of nothing would be infinite; this stops a jump within a few ticks.
        return config.gravity * 100.0;
    }
    config.gravity * (config.jump_height / config.jump_tap_height).max(1.0)
}

/// Remembers the button and the ground for as long as they matter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct JumpMemory {
    /// Whether the button was held on the last tick.
    held: bool,
    /// Seconds since it went down; infinite once used up.
    since_press: f32,
    /// Seconds since there was ground to jump from; infinite after a jump.
    since_ground: f32,
}

impl Default for JumpMemory {
    fn default() -> Self {
        Self { held: false, since_press: f32::INFINITY, since_ground: f32::INFINITY }
    }
}

impl JumpMemory {
    /// One tick of `dt` seconds: whether to jump now, with the button `held` and the body `grounded`.
    ///
    /// One press gives one jump: for `jump_buffer` seconds before landing, or up to `jump_coyote` seconds after the ground ended.
    #[must_use]
    pub(super) fn jumps(&mut self, held: bool, grounded: bool, config: &MotionConfig, dt: f32) -> bool {
        self.since_press = if held && !self.held { 0.0 } else { self.since_press + dt };
        self.since_ground = if grounded { 0.0 } else { self.since_ground + dt };
        self.held = held;
        let jumps = self.since_press <= config.jump_buffer && self.since_ground <= config.jump_coyote;
        if jumps {
            self.since_press = f32::INFINITY;
            self.since_ground = f32::INFINITY;
        }
        jumps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const DT: f32 = 1.0 / 64.0;

    #[test]
    fn a_tap_just_before_landing_jumps_on_landing() {
        let (config, mut memory) = (MotionConfig::default(), JumpMemory::default());
        assert!(!memory.jumps(true, false, &config, DT), "jumped in the air");
        for _ in 0..8 {
            assert!(!memory.jumps(false, false, &config, DT), "jumped in the air");
        }
        assert!(memory.jumps(false, true, &config, DT), "the tap 0.14 s before landing was lost");
    }

    #[test]
    fn a_tap_long_before_landing_is_forgotten() {
        let (config, mut memory) = (MotionConfig::default(), JumpMemory::default());
        let _ = memory.jumps(true, false, &config, DT);
        for _ in 0..10 {
            let _ = memory.jumps(true, false, &config, DT);
        }
        assert!(!memory.jumps(true, true, &config, DT), "a press 0.17 s before landing still jumped");
    }

    #[test]
    fn a_ledge_just_left_can_still_be_jumped_from_once() {
        let (config, mut memory) = (MotionConfig::default(), JumpMemory::default());
        let _ = memory.jumps(false, true, &config, DT);
        for _ in 0..6 {
            assert!(!memory.jumps(false, false, &config, DT), "jumped unasked");
        }
        assert!(memory.jumps(true, false, &config, DT), "no jump 0.11 s after the ledge");
        let _ = memory.jumps(false, false, &config, DT);
        assert!(!memory.jumps(true, false, &config, DT), "jumped twice");
    }

    #[test]
    fn a_held_button_jumps_once() {
        let (config, mut memory) = (MotionConfig::default(), JumpMemory::default());
        let jumps = (0..100).filter(|_| memory.jumps(true, true, &config, DT)).count();
        assert_eq!(jumps, 1);
    }

    proptest! {
        #[test]
        fn a_jump_rises_to_its_height(height in 0.05f32..5.0, gravity in 1.0f32..40.0) {
            let speed = jump_speed(height, gravity);
            let apex = speed * speed / (2.0 * gravity);
            prop_assert!((apex - height).abs() < 1e-3, "{apex} m instead of {height} m");
        }
    }
}
