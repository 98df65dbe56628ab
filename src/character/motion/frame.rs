//! Ground that moves: where it carries a point, and where it will be when the tick ends. Pure; world space.

use bevy::math::{Quat, Vec3};

use crate::math::rotation::{from_scaled_axis, twist_angle};

/// Where a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    /// World position of its origin, metres.
    pub(super) position: Vec3,
    /// World rotation.
    pub(super) rotation: Quat,
}

impl Frame {
    /// A world point in this frame.
    #[must_use]
    pub(super) fn local(&self, world: Vec3) -> Vec3 {
        self.rotation.inverse() * (world - self.position)
    }

    /// A point of this frame in the world.
    #[must_use]
    pub(super) fn world(&self, local: Vec3) -> Vec3 {
        self.position + self.rotation * local
    }

    /// Turn about +Y from this frame to `next`, radians.
    #[must_use]
    pub(super) fn yaw_to(&self, next: &Self) -> f32 {
        twist_angle((next.rotation * self.rotation.inverse()).normalize(), Vec3::Y)
    }

    /// Whether both are the same to within what a physics step's rounding changes.
    #[must_use]
    pub(super) fn is_near(&self, other: &Self) -> bool {
        let distance = self.position.distance_squared(other.position);
        let turn = 1.0 - self.rotation.dot(other.rotation).abs();
        distance < 1e-12 * (1.0 + self.position.length_squared()) && turn < 1e-7
    }

    /// This frame after `dt` seconds of steady `linear` m/s and `angular` rad/s about its centre of mass.
    #[must_use]
    pub(super) fn after(&self, centre_of_mass: Vec3, linear: Vec3, angular: Vec3, dt: f32) -> Self {
        let rotation = (from_scaled_axis(angular * dt) * self.rotation).normalize();
        let swing = self.rotation * centre_of_mass - rotation * centre_of_mass;
        Self { position: self.position + linear * dt + swing, rotation }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::PI;

    #[test]
    fn a_turntable_carries_a_point_round() {
        let table = Frame { position: Vec3::new(5.0, 0.0, 0.0), rotation: Quat::IDENTITY };
        let turned = table.after(Vec3::ZERO, Vec3::ZERO, Vec3::Y * PI, 0.5);
        let carried = turned.world(table.local(Vec3::new(6.0, 0.0, 0.0)));
        assert!(carried.distance(Vec3::new(5.0, 0.0, -1.0)) < 1e-5, "carried to {carried}");
        assert!((table.yaw_to(&turned) - PI / 2.0).abs() < 1e-5, "turned by {}", table.yaw_to(&turned));
    }

    #[test]
    fn a_body_turns_about_its_centre_of_mass() {
        let centre = Vec3::new(1.0, 2.0, 0.0);
        let body = Frame { position: Vec3::ZERO, rotation: Quat::from_rotation_z(0.3) };
        let next = body.after(centre, Vec3::X, Vec3::new(0.2, 1.0, -0.4), 0.25);
        let moved = next.world(centre) - body.world(centre);
        assert!(moved.distance(Vec3::X * 0.25) < 1e-5, "the centre moved by {moved}");
    }

    #[test]
    fn standing_still_is_near_itself() {
        let body = Frame { position: Vec3::new(90.0, 3.0, -40.0), rotation: Quat::from_rotation_y(1.0) };
        assert!(body.is_near(&body));
        assert!(!body.is_near(&body.after(Vec3::ZERO, Vec3::X * 0.1, Vec3::ZERO, 1.0 / 64.0)));
    }
}
