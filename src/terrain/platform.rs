//! Platforms that move: kinematic bodies whose velocity says where they will be after the next physics step.
//!
//! Reads the fixed clock; writes [`LinearVelocity`] and [`AngularVelocity`] in world space, so whoever stands on a platform
//! can ride along by the velocity at its feet.

use core::f64::consts::TAU;

use avian3d::prelude::{AngularVelocity, LinearVelocity, Position, RigidBody};
use bevy::{
    math::{ops, prelude::*},
    prelude::*,
};

/// Sets of the platforms' systems.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PlatformSystems {
    /// Platforms set their velocities, in `FixedPreUpdate`: before anyone moves in the same tick.
    Drive,
}

/// A platform that glides between two points and may turn.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component)]
#[require(RigidBody::Kinematic, LinearVelocity, AngularVelocity)]
pub struct MovingPlatform {
    /// Where its middle starts, world space, metres.
    pub from: Vec3,
    /// Where it turns back, world space, metres.
    pub to: Vec3,
    /// Seconds there and back. Default 10.
    ///
    /// Short: fast and hard to board. Not above 0: it stays where it starts.
    pub period: f32,
    /// Turning about +Y in radians per second. Default 0.
    pub turn: f32,
}

impl Default for MovingPlatform {
    fn default() -> Self {
        Self { from: Vec3::ZERO, to: Vec3::ZERO, period: 10.0, turn: 0.0 }
    }
}

impl MovingPlatform {
    /// Where its middle is at `time` seconds: slow at both ends, fastest half-way.
    #[must_use]
    pub fn position(&self, time: f64) -> Vec3 {
        if self.period.is_nan() || self.period <= 0.0 {
            return self.from;
        }
        let turns = (time / f64::from(self.period)).rem_euclid(1.0);
        self.from.lerp(self.to, 0.5 - 0.5 * ops::cos((turns * TAU) as f32))
    }
}

pub(super) fn drive(
    time: Res<Time<Fixed>>,
    mut platforms: Query<(&MovingPlatform, &Position, &mut LinearVelocity, &mut AngularVelocity)>,
) {
    let dt = time.delta_secs();
    if dt <= 0.0 {
        return;
    }
    // The fixed clock already shows the time at the end of this tick.
    let after = time.elapsed_secs_f64();
    for (platform, position, mut linear, mut angular) in &mut platforms {
        linear.0 = (platform.position(after) - position.0) / dt;
        angular.0 = Vec3::Y * platform.turn;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_platform_is_there_and_back_once_a_period() {
        let platform = MovingPlatform { to: Vec3::X * 4.0, period: 8.0, ..default() };
        for (time, expected) in [(0.0, 0.0), (2.0, 2.0), (4.0, 4.0), (8.0, 0.0), (8_000_004.0, 4.0)] {
            let x = platform.position(time).x;
            assert!((x - expected).abs() < 1e-3, "at {x} m after {time} s, not {expected}");
        }
    }

    #[test]
    fn a_platform_without_a_period_stays() {
        let platform = MovingPlatform { to: Vec3::X, period: f32::NAN, ..default() };
        assert_eq!(platform.position(3.0), Vec3::ZERO);
    }
}
