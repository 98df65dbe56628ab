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
