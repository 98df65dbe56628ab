//! How the controller moves a character.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// How the controller moves a character.
///
/// It is meant for a person of 1.8 m; [`fitted`](Self::fitted) gives that of a smaller or larger one, and a character's file
/// is fitted to its body by itself.
#[derive(Component, Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[reflect(Component)]
#[serde(default, deny_unknown_fields)]
pub struct MotionConfig {
    /// Walking speed in m/s. Default 1.4.
    pub walk_speed: f32,
    /// Running speed in m/s. Default 3.5.
    pub run_speed: f32,
    /// Fastest speed on the ground, m/s; faster intents are cut to it. Default 6.
    pub sprint_speed: f32,
    /// Fastest speed while crouched, m/s. Default 1.2.
    pub crouch_speed: f32,
    /// Fastest speed sideways and backward while the facing is given, m/s. Default 1.8.
    ///
    /// Large: legs that close and open can't keep up, and feet slide.
    pub strafe_speed: f32,
    /// Rate at which speed grows, m/s². Default 8.
    ///
    /// Small: heavy and late. Large: the body darts off before the legs can follow.
    pub acceleration: f32,
    /// Rate at which speed falls to a slower one, m/s². Default 12.
    pub braking: f32,
    /// Rate while the wanted direction points backward, m/s². Default 16.
    pub reversal: f32,
    /// How much a slope slows what is beyond walking speed, per unit of grade (rise over run), up and down. Default 1.5.
    ///
    /// 0: runs as fast over stairs as on the flat, with legs that can't follow.
    pub climb_slowing: f32,
    /// Rate at which the intent steers in the air, m/s². Default 3.
    pub air_acceleration: f32,
    /// Half-life of the turn toward the facing, seconds. Default 0.07.
    pub turn_half_life: f32,
    /// How fast a turn may gain speed, degrees per second squared in RON. Default 4,500°.
    ///
    /// Small: turns start lazily. Large: they jerk, since the feet stand while the body turns over them.
    #[serde(with = "super::degrees")]
    pub turn_acceleration: f32,
    /// Fastest turn, degrees per second in RON. Default 450°.
    #[serde(with = "super::degrees")]
    pub turn_rate: f32,
    /// Fastest turn on the spot, degrees per second in RON. Default 120°.
    ///
    /// Large: the feet can't step round as fast.
    #[serde(with = "super::degrees")]
    pub standing_turn_rate: f32,
    /// Radius of the capsule, metres. Default 0.28.
    pub radius: f32,
    /// Height of the capsule from the ground to its top, metres. Default 1.8.
    pub height: f32,
    /// Height while crouched, metres. Default 1.35.
    pub crouch_height: f32,
    /// Steepest ground to walk on, degrees in RON. Default 45°. Steeper ground is slid down.
    #[serde(with = "super::degrees")]
    pub slope_limit: f32,
    /// Highest step climbed without a jump, metres. Default 0.35.
    ///
    /// Steps up to 0.6 of the radius are climbed whatever this says, since a slope can't be told from them.
    pub step_up: f32,
    /// Deepest step walked down without a fall, metres. Default 0.35.
    pub step_down: f32,
    /// Half-life in which the root follows a step of the ground, seconds. Default 0.07.
    ///
    /// Short: the root jumps with every stair. Long: it lags behind the stairs.
    pub step_half_life: f32,
    /// Downward acceleration in the air, m/s². Default 14.
    pub gravity: f32,
    /// Fastest fall, m/s. Default 50.
    pub fall_speed: f32,
    /// Height of a jump with the button held, metres. Default 0.9.
    pub jump_height: f32,
    /// Height of a jump with the button only tapped, metres. Default 0.4.
    pub jump_tap_height: f32,
    /// Seconds after leaving a ledge in which a jump still counts. Default 0.12.
    pub jump_coyote: f32,
    /// Seconds before landing from which a press of the button still counts. Default 0.15.
    pub jump_buffer: f32,
    /// Metres by which a ceiling's edge may be in the way of a jump without stopping it. Default 0.12.
    ///
    /// 0: every edge that the head brushes ends the jump. Large: it slips out from under anything.
    pub jump_corner: f32,
    /// Mass with which the character weighs on dynamic bodies, kg. Default 75.
    pub mass: f32,
    /// Greatest force with which it pushes dynamic bodies, N. Default 600.
    ///
    /// Small: crates stop it like walls. Large: it shoves whatever stands there.
    pub push_force: f32,
}

impl Default for MotionConfig {
    fn default() -> Self {
        Self {
            walk_speed: 1.4,
            run_speed: 3.5,
            sprint_speed: 6.0,
            crouch_speed: 1.2,
            strafe_speed: 1.8,
            acceleration: 8.0,
            braking: 12.0,
            reversal: 16.0,
            climb_slowing: 1.5,
            air_acceleration: 3.0,
            turn_half_life: 0.07,
            turn_acceleration: 4500f32.to_radians(),
            turn_rate: 450f32.to_radians(),
            standing_turn_rate: 120f32.to_radians(),
            radius: 0.28,
            height: 1.8,
            crouch_height: 1.35,
            slope_limit: 45f32.to_radians(),
            step_up: 0.35,
            step_down: 0.35,
            step_half_life: 0.07,
            gravity: 14.0,
            fall_speed: 50.0,
            jump_height: 0.9,
            jump_tap_height: 0.4,
            jump_coyote: 0.12,
            jump_buffer: 0.15,
            jump_corner: 0.12,
            mass: 75.0,
            push_force: 600.0,
        }
    }
}

impl MotionConfig {
    /// The first field that is out of range, and what would be valid; `None` when all is well.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let mut copy = self.clone();
        if let Some((name, value)) = copy.fields().into_iter().find(|(_, value)| !valid(**value)) {
            return Some(format!("{name} is {value}; valid is a number from 0 up"));
        }
        let bounded = [
            ("radius", self.radius, 0.02, 10.0),
            ("height", self.height, 2.0 * self.radius, 100.0),
            ("crouch_height", self.crouch_height, 2.0 * self.radius, self.height),
            ("slope_limit, in degrees,", self.slope_limit.to_degrees(), 0.0, 85.0),
            ("jump_tap_height", self.jump_tap_height, 0.0, self.jump_height),
            ("step_up", self.step_up, 0.0, self.crouch_height - 2.0 * self.radius),
        ];
        bounded
            .into_iter()
            .find(|&(_, value, least, most)| !(value >= least && value <= most))
            .map(|(name, value, least, most)| format!("{name} is {value}; valid is {least} to {most}"))
    }

    /// The same config with every field that is no number from 0 up at its default, and lengths that make a capsule.
    #[must_use]
    pub fn mended(&self) -> Self {
        let (mut mended, mut fallback) = (self.clone(), Self::default());
        for ((_, value), (_, default)) in mended.fields().into_iter().zip(fallback.fields()) {
            if !valid(*value) {
                *value = *default;
            }
        }
        mended.radius = mended.radius.clamp(0.02, 10.0);
        mended.crouch_height = mended.crouch_height.clamp(2.0 * mended.radius, 100.0);
        mended.height = mended.height.clamp(mended.crouch_height, 100.0);
        mended.step_up = mended.step_up.min(mended.crouch_height - 2.0 * mended.radius);
        mended.slope_limit = mended.slope_limit.min(85f32.to_radians());
        mended
    }

    fn fields(&mut self) -> [(&'static str, &mut f32); 30] {
        [
            ("walk_speed", &mut self.walk_speed),
            ("run_speed", &mut self.run_speed),
            ("sprint_speed", &mut self.sprint_speed),
            ("crouch_speed", &mut self.crouch_speed),
            ("strafe_speed", &mut self.strafe_speed),
            ("acceleration", &mut self.acceleration),
            ("braking", &mut self.braking),
            ("reversal", &mut self.reversal),
            ("climb_slowing", &mut self.climb_slowing),
            ("air_acceleration", &mut self.air_acceleration),
            ("turn_half_life", &mut self.turn_half_life),
            ("turn_acceleration", &mut self.turn_acceleration),
            ("turn_rate", &mut self.turn_rate),
            ("standing_turn_rate", &mut self.standing_turn_rate),
            ("radius", &mut self.radius),
            ("height", &mut self.height),
            ("crouch_height", &mut self.crouch_height),
            ("slope_limit", &mut self.slope_limit),
            ("step_up", &mut self.step_up),
            ("step_down", &mut self.step_down),
            ("step_half_life", &mut self.step_half_life),
            ("gravity", &mut self.gravity),
            ("fall_speed", &mut self.fall_speed),
            ("jump_height", &mut self.jump_height),
            ("jump_tap_height", &mut self.jump_tap_height),
            ("jump_coyote", &mut self.jump_coyote),
            ("jump_buffer", &mut self.jump_buffer),
            ("jump_corner", &mut self.jump_corner),
            ("mass", &mut self.mass),
            ("push_force", &mut self.push_force),
        ]
    }

    /// The same config for another body: lengths go with its stature, speeds with the root of its legs' length, so that
    /// bodies alike but for size move alike (Alexander 1989); times, angles and accelerations stay.
    #[must_use]
    pub fn fitted(&self, size: BodySize) -> Self {
        let BodySize { stature, legs } = size.rounded();
        // Physics can't hold forces of giants taller than that.
        let (pace, mass) = (legs.sqrt(), (stature * stature * stature).min(1000.0));
        Self {
            walk_speed: self.walk_speed * pace,
            run_speed: self.run_speed * pace,
            sprint_speed: self.sprint_speed * pace,
            crouch_speed: self.crouch_speed * pace,
            strafe_speed: self.strafe_speed * pace,
            radius: self.radius * stature,
            height: self.height * stature,
            crouch_height: self.crouch_height * stature,
            step_up: self.step_up * stature,
            step_down: self.step_down * stature,
            jump_height: self.jump_height * stature,
            jump_tap_height: self.jump_tap_height * stature,
            jump_corner: self.jump_corner * stature,
            mass: self.mass * mass,
            push_force: self.push_force * mass,
            ..self.clone()
        }
    }
}

/// Stature in metres that the defaults are meant for.
pub const TUNED_STATURE: f32 = 1.8;

/// A body's size against that of the person of 1.8 m whom the defaults are meant for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySize {
    /// Height, as a factor.
    pub stature: f32,
    /// Length of the legs, as a factor.
    pub legs: f32,
}

/// Factors that are nearer to 1 than this are 1.
const ALIKE: f32 = 0.03;

impl BodySize {
    /// Positive, and 1 where it is about 1.
    fn rounded(self) -> Self {
        let factor = |factor: f32| {
            let sound = if factor.is_finite() { factor.clamp(0.02, 50.0) } else { 1.0 };
            if (sound - 1.0).abs() < ALIKE { 1.0 } else { sound }
        };
        Self { stature: factor(self.stature), legs: factor(self.legs) }
    }
}

/// Whether a field holds a number from 0 up, below what physics can't hold any more.
fn valid(value: f32) -> bool {
    (0.0..1e6).contains(&value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_valid() {
        assert_eq!(MotionConfig::default().problem(), None);
        for factor in [0.1, 0.5, 1.7, 20.0] {
            let size = BodySize { stature: factor, legs: factor };
            assert_eq!(MotionConfig::default().fitted(size).problem(), None, "{factor} times as tall");
        }
    }

    #[test]
    fn short_legs_go_slower_and_small_bodies_are_small() {
        let fitted = MotionConfig::default().fitted(BodySize { stature: 0.5, legs: 0.25 });
        assert!((fitted.walk_speed - 0.7).abs() < 1e-6 && (fitted.sprint_speed - 3.0).abs() < 1e-6, "{fitted:?}");
        assert!((fitted.height - 0.9).abs() < 1e-6 && (fitted.step_up - 0.175).abs() < 1e-6, "{fitted:?}");
        let alike = BodySize { stature: 1.01, legs: 0.99 };
        assert_eq!(MotionConfig::default().fitted(alike), MotionConfig::default());
        let broken = BodySize { stature: f32::NAN, legs: 0.0 };
        assert_eq!(MotionConfig::default().fitted(broken).problem(), None, "of a body without size");
    }

    #[test]
    fn a_bad_field_is_named_with_what_would_be_valid() {
        let narrow = MotionConfig { crouch_height: 0.1, ..default() };
        let problem = narrow.problem().unwrap_or_default();
        assert!(problem.contains("crouch_height is 0.1; valid is 0.56 to 1.8"), "{problem}");
        let unnumbered = MotionConfig { gravity: f32::NAN, ..default() };
        let problem = unnumbered.problem().unwrap_or_default();
        assert!(problem.contains("gravity is NaN"), "{problem}");
    }

    #[test]
    fn a_mended_config_is_valid() {
        for value in [f32::NAN, f32::INFINITY, -1.0, 0.0, 50.0] {
            let bad = MotionConfig {
                radius: value,
                height: value,
                step_up: value,
                slope_limit: value,
                mass: value,
                ..default()
            };
            assert_eq!(bad.mended().problem(), None, "every length {value}");
        }
        assert_eq!(MotionConfig::default().mended(), MotionConfig::default());
    }
}
