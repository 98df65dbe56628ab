//! The controller: `MoveIntent` → a moved root and `MotionState`, on the fixed clock.

use bevy::prelude::*;

/// What the controller did. World space; written once per fixed tick.
#[derive(Component, Reflect, Clone, Debug, Default)]
#[reflect(Component)]
pub struct MotionState {
    /// Velocity of the root in world space, m/s, after collisions. Includes the platform's.
    pub velocity: Vec3,
    /// Velocity relative to the ground the character stands on, m/s.
    pub ground_velocity: Vec3,
    /// The ground under the capsule; `None` in the air.
    pub ground: Option<Ground>,
    /// Turn rate of the root about +Y in rad/s.
    pub yaw_rate: f32,
    /// Seconds since the character last stood on ground; 0 when grounded.
    pub air_time: f32,
    /// Sum of all vertical jumps of the root by step-up, step-down and snapping, metres.
    ///
    /// A frame's difference tells the pelvis what to take out, so that the body doesn't pop.
    pub stepped: f32,
    /// Counts teleports (respawn, recovery); a change tells later stages to forget the ground.
    pub teleports: u32,
}

/// The ground under the capsule.
#[derive(Reflect, Clone, Copy, Debug)]
pub struct Ground {
    /// The collider's entity.
    pub entity: Entity,
    /// World normal.
    pub normal: Vec3,
    /// World velocity of the ground at the contact, m/s.
    pub velocity: Vec3,
}
