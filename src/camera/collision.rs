//! Keeps the camera out of walls and above the ground.
//!
//! World space. A ball is swept from the target's axis to the arm's root and from there back along the arm; where it stops, the
//! camera stops. In at once, out slowly. Narrow things such as posts and rails may come between: one looks past them.

use avian3d::prelude::{Collider, ColliderOf, Sensor, ShapeCastConfig, SpatialQuery, SpatialQueryFilter};
use bevy::{ecs::system::SystemParam, prelude::*};

use super::{config::OrbitCameraConfig, orbit::Arm};
use crate::math::spring::remaining;

/// The world's colliders as the camera sees them: without sensors and without whom it follows.
#[derive(SystemParam)]
pub struct Obstacles<'w, 's> {
    spatial: SpatialQuery<'w, 's>,
    bodies: Query<'w, 's, &'static ColliderOf>,
    sensors: Query<'w, 's, (), With<Sensor>>,
}

/// How much room there is along an [`Arm`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Where the arm's root may stand, world space.
    pub root: Vec3,
    /// Metres that are free behind it, at most the arm's length.
    pub free: f32,
}

impl Obstacles<'_, '_> {
    /// Sweeps the camera's ball along `arm`.
    #[must_use]
    pub fn room(&self, arm: &Arm, target: Entity, config: &OrbitCameraConfig) -> Room {
        let aside = arm.root - arm.axis;
        let root = match Dir3::new(aside) {
            Ok(toward) => arm.axis + toward * self.sweep(arm.axis, toward, aside.length(), target, config.ball),
            Err(_) => arm.axis,
        };
        let Ok(back) = Dir3::new(arm.rotation * Vec3::Z) else { return Room { root, free: 0.0 } };
        let free = self.sweep(root, back, arm.length, target, config.ball);
        let narrow = free < arm.length
            && self.fits(root + back * arm.length, target, config.ball)
            && self.is_seen_past(root, arm, target, config.narrow);
        Room { root, free: if narrow { arm.length } else { free } }
    }

    /// Whether a ball has room at `eye`.
    fn fits(&self, eye: Vec3, target: Entity, ball: f32) -> bool {
        let touch = ShapeCastConfig::from_max_distance(0.01);
        let (ball, filter) = (Collider::sphere(ball), SpatialQueryFilter::default());
        let seen = |entity: Entity| self.sees(entity, target);
        let hit = self.spatial.cast_shape_predicate(&ball, eye, Quat::IDENTITY, Dir3::Y, &touch, &filter, &seen);
        hit.is_none()
    }

    /// Whether lines `beside` metres to the left and right of the arm are free, or those above and below it.
    fn is_seen_past(&self, root: Vec3, arm: &Arm, target: Entity, beside: f32) -> bool {
        let way = arm.rotation * Vec3::Z * arm.length;
        let free = |aside: Vec3| self.line_is_free(root + arm.rotation * aside * beside, way, target);
        (free(Vec3::X) && free(Vec3::NEG_X)) || (free(Vec3::Y) && free(Vec3::NEG_Y))
    }

    fn line_is_free(&self, from: Vec3, way: Vec3, target: Entity) -> bool {
        let Ok(toward) = Dir3::new(way) else { return false };
        let filter = SpatialQueryFilter::default();
        let seen = |entity: Entity| self.sees(entity, target);
        self.spatial.cast_ray_predicate(from, toward, way.length(), true, &filter, &seen).is_none()
    }

    /// Metres by which a camera at `eye` must rise to be clear of the ground, as far as the ceiling allows.
    #[must_use]
    pub fn lift(&self, eye: Vec3, target: Entity, config: &OrbitCameraConfig) -> f32 {
        let filter = SpatialQueryFilter::default();
        let seen = |entity: Entity| self.sees(entity, target);
        let hit = self.spatial.cast_ray_predicate(eye, Dir3::NEG_Y, config.clearance, true, &filter, &seen);
        let lacking = hit.map_or(0.0, |hit| config.clearance - hit.distance);
        if lacking > 0.0 { self.sweep(eye, Dir3::Y, lacking, target, config.ball * 0.5) } else { 0.0 }
    }

    /// Metres that a ball can go before it touches something.
    fn sweep(&self, from: Vec3, toward: Dir3, length: f32, target: Entity, ball: f32) -> f32 {
        if length.is_nan() || length <= 0.0 {
            return 0.0;
        }
        let cast = ShapeCastConfig { ignore_origin_penetration: true, ..ShapeCastConfig::from_max_distance(length) };
        let (ball, filter) = (Collider::sphere(ball), SpatialQueryFilter::default());
        let seen = |entity: Entity| self.sees(entity, target);
        self.spatial
            .cast_shape_predicate(&ball, from, Quat::IDENTITY, toward, &cast, &filter, &seen)
            .map_or(length, |hit| hit.distance)
    }

    fn sees(&self, collider: Entity, target: Entity) -> bool {
        let body = self.bodies.get(collider).map_or(collider, |of| of.body);
        collider != target && body != target && !self.sensors.contains(collider)
    }
}

/// Metres by which an arm of `length` stays shortened, given how much it was and how much is free now.
///
/// Grows at once, so that no wall comes between; halves every `half_life` seconds.
#[must_use]
pub fn shortened(before: f32, length: f32, free: f32, half_life: f32, dt: f32) -> f32 {
    (before * remaining(half_life, dt)).max(length - free).clamp(0.0, length.max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wall_shortens_the_arm_at_once() {
        let short = shortened(0.0, 4.0, 1.0, 0.3, 1.0 / 60.0);
        assert!((short - 3.0).abs() < 1e-6, "shortened by {short} m");
    }

    #[test]
    fn the_arm_eases_out_by_halves() {
        let short = shortened(3.0, 4.0, 4.0, 0.3, 0.3);
        assert!((short - 1.5).abs() < 1e-5, "still shortened by {short} m");
    }

    #[test]
    fn easing_out_does_not_depend_on_the_frame_rate() {
        let after = |rate: u32| (0..rate).fold(3.0, |short, _| shortened(short, 4.0, 4.0, 0.25, 1.0 / rate as f32));
        let (slow, fast) = (after(30), after(144));
        assert!((slow - fast).abs() < 1e-4, "{slow} m at 30 Hz, {fast} m at 144 Hz");
    }
}
