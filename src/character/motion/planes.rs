//! The surfaces that stop a body during one tick, and what movement they leave. Pure; world space.

use bevy::math::Vec3;

/// Surfaces more alike than this count as one: the cosine of 1°, so that no more than 2 % of a speed goes into the other.
const SAME: f32 = 0.999_848;

/// Most surfaces kept in a tick; a body wedged between more stands still anyway.
const MOST: usize = 8;

/// A surface in the way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plane {
    /// Unit normal, toward the body.
    normal: Vec3,
    /// Speed with which the surface itself comes along its normal, m/s.
    speed: f32,
}

/// The surfaces met during one tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planes {
    planes: [Plane; MOST],
    count: usize,
}

impl Default for Planes {
    fn default() -> Self {
        Self { planes: [Plane { normal: Vec3::Y, speed: 0.0 }; MOST], count: 0 }
    }
}

impl Planes {
    /// Adds a surface with a unit `normal` toward the body, coming along it with `speed` m/s.
    pub(super) fn push(&mut self, normal: Vec3, speed: f32) {
        if normal.length_squared() < 0.5 {
            return;
        }
        if let Some(same) = self.planes[..self.count].iter_mut().find(|plane| plane.normal.dot(normal) > SAME) {
            same.speed = same.speed.max(speed);
        } else if self.count < MOST {
            self.planes[self.count] = Plane { normal, speed };
            self.count += 1;
        }
    }

    /// Whether nothing was met.
    #[must_use]
    pub(super) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The movement nearest to `movement` that goes into none of the surfaces, taken as standing still.
    ///
    /// Along one surface if that is free, else along the edge of two, else nowhere.
    #[must_use]
    pub(super) fn slide(&self, movement: Vec3) -> Vec3 {
        let planes = &self.planes[..self.count];
        let slack = 1e-5 * movement.length();
        let free = |candidate: Vec3| planes.iter().all(|plane| candidate.dot(plane.normal) >= -slack);
        if free(movement) {
            return movement;
        }
        let along = |plane: &Plane| movement - plane.normal * movement.dot(plane.normal).min(0.0);
        if let Some(nearest) = nearest_free(movement, planes.iter().map(along), free) {
            return nearest;
        }
        let edges = (0..self.count).flat_map(|a| (0..a).map(move |b| planes[a].normal.cross(planes[b].normal)));
        // Surfaces that are almost parallel have no edge between them.
        let along_edge = |edge: Vec3| edge * (movement.dot(edge) / edge.length_squared());
        let along_edges = edges.filter(|edge| edge.length_squared() > 1e-4).map(along_edge);
        nearest_free(movement, along_edges, free).unwrap_or(Vec3::ZERO)
    }

    /// The horizontal velocity nearest to `velocity` that no wall stops; walls that come along push it.
    ///
    /// Two walls that leave no way between them leave no velocity.
    #[must_use]
    pub(super) fn clip_flat(&self, velocity: Vec3) -> Vec3 {
        let planes = &self.planes[..self.count];
        let free = |candidate: Vec3| planes.iter().all(|plane| candidate.dot(plane.normal) >= plane.speed - 1e-4);
        if free(velocity) {
            return velocity;
        }
        let pushed = |plane: &Plane| velocity + plane.normal * (plane.speed - velocity.dot(plane.normal)).max(0.0);
        nearest_free(velocity, planes.iter().map(pushed), free).unwrap_or(Vec3::ZERO)
    }
}

/// The candidate nearest to `wanted` that is free; the first of equals.
fn nearest_free(wanted: Vec3, candidates: impl Iterator<Item = Vec3>, free: impl Fn(Vec3) -> bool) -> Option<Vec3> {
    candidates
        .filter(|candidate| free(*candidate))
        .min_by(|a, b| a.distance_squared(wanted).total_cmp(&b.distance_squared(wanted)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn walls(normals: &[Vec3]) -> Planes {
        let mut planes = Planes::default();
        for &normal in normals {
            planes.push(normal, 0.0);
        }
        planes
    }

    #[test]
    fn a_wall_leaves_the_movement_along_it() {
        let slid = walls(&[Vec3::X]).slide(Vec3::new(-1.0, 0.0, 2.0));
        assert!(slid.distance(Vec3::new(0.0, 0.0, 2.0)) < 1e-5, "{slid}");
    }

    #[test]
    fn a_corner_leaves_nothing() {
        let corner = walls(&[Vec3::X, Vec3::Z]);
        assert_eq!(corner.slide(Vec3::new(-1.0, 0.0, -1.0)), Vec3::ZERO);
        assert_eq!(corner.clip_flat(Vec3::new(-1.0, 0.0, -1.0)), Vec3::ZERO);
    }

    #[test]
    fn a_wall_that_comes_along_pushes() {
        let mut planes = Planes::default();
        planes.push(Vec3::X, 2.0);
        let pushed = planes.clip_flat(Vec3::new(-1.0, 0.0, 1.0));
        assert!(pushed.distance(Vec3::new(2.0, 0.0, 1.0)) < 1e-5, "{pushed}");
    }

    proptest! {
        #[test]
        fn no_movement_goes_into_a_surface(tilts in proptest::collection::vec((-3.1f32..3.1, -1.0f32..1.0), 1..7), x in -5.0f32..5.0, y in -5.0f32..5.0, z in -5.0f32..5.0) {
            let normals: Vec<_> = tilts.iter().map(|&(a, up)| Vec3::new(bevy::math::ops::sin(a), up, bevy::math::ops::cos(a)).normalize()).collect();
            let (movement, planes) = (Vec3::new(x, y, z), walls(&normals));
            let slid = planes.slide(movement);
            prop_assert!(slid.length() <= movement.length() + 1e-4, "{movement} grew to {slid}");
            for normal in normals {
                prop_assert!(slid.dot(normal) >= -4e-2 * movement.length() - 1e-5, "{slid} goes into {normal}");
            }
        }

        #[test]
        fn no_velocity_goes_into_a_wall(angles in proptest::collection::vec(0.0f32..6.2, 1..6), x in -5.0f32..5.0, z in -5.0f32..5.0) {
            let normals: Vec<_> = angles.iter().map(|&a| Vec3::new(bevy::math::ops::sin(a), 0.0, bevy::math::ops::cos(a))).collect();
            let (velocity, planes) = (Vec3::new(x, 0.0, z), walls(&normals));
            let clipped = planes.clip_flat(velocity);
            prop_assert!(clipped.length() <= velocity.length() + 1e-4, "{velocity} grew to {clipped}");
            for normal in normals {
                prop_assert!(clipped.dot(normal) >= -2e-2 * (1.0 + velocity.length()), "{clipped} goes into {normal}");
            }
        }
    }
}
