//! What a character wants: the only input there is. Players, AI, network and tests write it, motion reads it.

use bevy::prelude::*;

/// What a character wants to do now. Written by anyone in [`MotionSystems::Decide`](super::schedule::MotionSystems::Decide).
///
/// Values that are not finite count as zero (`None` for `facing` and `aim`); a warning says so once.
#[derive(Component, Reflect, Clone, Debug, Default, PartialEq)]
#[reflect(Component)]
pub struct MoveIntent {
    /// Wanted velocity in world space, m/s. Only the horizontal part counts.
    pub velocity: Vec3,
    /// World direction to face; `None` faces the way the character moves.
    pub facing: Option<Vec3>,
    /// World direction, up and down too, to point an arm and the head along; `None` lowers the arm. The body follows only
    /// by `facing`.
    pub aim: Option<Vec3>,
    /// Held for as long as the jump shall rise.
    pub jump: bool,
    /// Held to crouch.
    pub crouch: bool,
}

impl MoveIntent {
    /// Whether every number in it is finite.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.velocity.is_finite() && [self.facing, self.aim].into_iter().flatten().all(Vec3::is_finite)
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
        let sound = |way: Option<Vec3>| way.filter(|way| way.is_finite());
        Self { velocity, facing: sound(self.facing), aim: sound(self.aim), ..*self }
    }

    /// The direction to aim along, one long; `None` where there is none.
    #[must_use]
    pub fn aims(&self) -> Option<Vec3> {
        self.aim.and_then(Vec3::try_normalize)
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
            aim: Some(Vec3::NAN),
            jump: true,
            crouch: false,
        };
        assert!(!broken.is_sound());
        assert_eq!(broken.sanitised(5.0), MoveIntent { jump: true, ..default() });
        for nowhere in [None, Some(Vec3::ZERO), Some(Vec3::NAN), Some(Vec3::INFINITY)] {
            assert_eq!(MoveIntent { aim: nowhere, ..default() }.aims(), None, "{nowhere:?} is no direction");
        }
    }

    #[test]
    fn velocity_is_cut_to_the_top_speed_and_the_horizontal() {
        for wanted in [Vec3::new(3.0, 9.0, -4.0), Vec3::new(3e38, 1.0, -3e38)] {
            let cut = MoveIntent { velocity: wanted, ..default() }.sanitised(2.0).velocity;
            assert!((cut.length() - 2.0).abs() < 1e-5 && cut.y.to_bits() == 0, "{wanted} became {cut}");
        }
    }
}
