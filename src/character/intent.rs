//! What a character wants: the only input there is. Players, AI, network and tests write it, motion reads it.

use bevy::prelude::*;

/// What a character wants to do now. Written by anyone in [`MotionSystems::Decide`](super::schedule::MotionSystems::Decide).
///
/// Values that are not finite count as zero (`None` for `facing`); a warning says so once.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component)]
pub struct MoveIntent {
    /// Wanted velocity in world space, m/s. Only the horizontal part counts.
    pub velocity: Vec3,
    /// World direction to face; `None` faces the way the character moves.
    pub facing: Option<Vec3>,
    /// Held for as long as the jump shall rise.
    pub jump: bool,
    /// Held to crouch.
    pub crouch: bool,
}

impl MoveIntent {
    /// Whether every number in it is finite.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.velocity.is_finite() && self.facing.is_none_or(Vec3::is_finite)
    }

    /// The same intent made safe: horizontal, at most `top_speed` m/s, with nothing in it that is not finite.
    #[must_use]
    pub fn sanitised(&self, top_speed: f32) -> Self {
        let flat = Vec3::new(self.velocity.x, 0.0, self.velocity.z);
        // Scaled down first, so that the length of a huge vector stays finite.
        let velocity = if self.velocity.is_finite() {
            flat.clamp(Vec3::splat(-1e6), Vec3::splat(1e6)).clamp_length_max(top_speed.max(0.0))
        } else {
            Vec3::ZERO
        };
        Self { velocity, facing: self.facing.filter(|facing| facing.is_finite()), ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_finite_counts_as_nothing() {
        let broken = MoveIntent {
            velocity: Vec3::new(f32::NAN, 0.0, 1.0),
            facing: Some(Vec3::splat(f32::INFINITY)),
            jump: true,
            crouch: false,
        };
        assert!(!broken.is_sound());
        assert_eq!(broken.sanitised(5.0), MoveIntent { jump: true, ..default() });
    }

    #[test]
    fn velocity_is_cut_to_the_top_speed_and_the_horizontal() {
        for wanted in [Vec3::new(3.0, 9.0, -4.0), Vec3::new(3e38, 1.0, -3e38)] {
            let cut = MoveIntent { velocity: wanted, ..default() }.sanitised(2.0).velocity;
            assert!((cut.length() - 2.0).abs() < 1e-5 && cut.y.to_bits() == 0, "{wanted} became {cut}");
        }
    }
}
