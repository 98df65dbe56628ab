//! Rotations: shortest arcs, logarithm and exponential, swing and twist. Every function takes any input without NaN.

use bevy::math::{Quat, Vec2, Vec3, Vec3A, ops};

/// Squared lengths below this have no direction that `f32` can hold.
const TINY_SQUARED: f32 = 1e-16;

/// `vector` made one long; `None` where it has no direction.
#[must_use]
pub fn direction(vector: Vec3) -> Option<Vec3> {
    let squared = vector.length_squared();
    (squared.is_finite() && squared > TINY_SQUARED).then(|| vector / squared.sqrt())
}

/// As [`direction`], for aligned vectors.
#[must_use]
#[inline]
pub fn direction_aligned(vector: Vec3A) -> Option<Vec3A> {
    let squared = vector.length_squared();
    (squared.is_finite() && squared > TINY_SQUARED).then(|| vector / squared.sqrt())
}

/// `vector` made one long, or `fallback` where it has no direction.
#[must_use]
pub fn direction_or(vector: Vec3, fallback: Vec3) -> Vec3 {
    direction(vector).unwrap_or(fallback)
}

/// Some unit vector at right angles to `axis`.
#[must_use]
pub fn any_perpendicular(axis: Vec3) -> Vec3 {
    let other = if axis.x.abs() < 0.7 * axis.length() { Vec3::X } else { Vec3::Y };
    direction_or(axis.cross(other), Vec3::Z)
}

/// The least rotation that turns direction `from` into direction `to`.
///
/// Opposite directions turn half a circle about some perpendicular axis; a zero vector gives the identity.
#[must_use]
pub fn shortest_arc(from: Vec3, to: Vec3) -> Quat {
    let (Some(from), Some(to)) = (direction(from), direction(to)) else { return Quat::IDENTITY };
    shortest_arc_between_units(from.into(), to.into())
}

/// As [`shortest_arc`], for vectors that are one long.
#[must_use]
#[inline]
pub fn shortest_arc_between_units(from: Vec3A, to: Vec3A) -> Quat {
    let cos = from.dot(to);
    if cos < -0.999_999 {
        return Quat::from_vec4(any_perpendicular(from.into()).extend(0.0));
    }
    Quat::from_vec4(from.cross(to).extend(1.0 + cos)).normalize()
}

/// Squared sine of half an angle (here of 11°) up to which a short series gives the angle.
const SMALL_SQUARED: f32 = 0.01;

/// Rotation vector: axis times angle in radians, angle in 0..=π (the shorter way round).
#[must_use]
pub fn to_scaled_axis(rotation: Quat) -> Vec3 {
    let q = if rotation.w < 0.0 { -rotation } else { rotation };
    let xyz = Vec3::new(q.x, q.y, q.z);
    let squared = xyz.length_squared();
    if squared < SMALL_SQUARED && q.w > 0.5 {
        // The series of 2 asin(s) / s: below rounding from its fifth term on.
        let terms = 1.0 / 6.0 + squared * (3.0 / 40.0 + squared * (15.0 / 336.0));
        return xyz * (2.0 + 2.0 * squared * terms);
    }
    let sin = squared.sqrt();
    xyz * (2.0 * ops::atan2(sin, q.w) / sin)
}

/// The inverse of [`to_scaled_axis`].
#[must_use]
pub fn from_scaled_axis(vector: Vec3) -> Quat {
    let angle = vector.length();
    if angle < 1e-6 {
        return Quat::from_xyzw(vector.x * 0.5, vector.y * 0.5, vector.z * 0.5, 1.0).normalize();
    }
    let (sin, cos) = ops::sin_cos(angle * 0.5);
    let xyz = vector * (sin / angle);
    Quat::from_xyzw(xyz.x, xyz.y, xyz.z, cos)
}

/// Turn about +Y by an angle in radians: [`from_scaled_axis`] of what has no other part.
#[must_use]
#[inline]
pub fn yaw(radians: f32) -> Quat {
    let (sin, cos) = ops::sin_cos(radians * 0.5);
    Quat::from_xyzw(0.0, sin, 0.0, cos)
}

/// Angle between two rotations in radians, 0..=π.
#[must_use]
pub fn angle_between(a: Quat, b: Quat) -> f32 {
    to_scaled_axis(a * b.inverse()).length()
}

/// The part of `rotation` that turns about the unit vector `axis`; `rotation * twist⁻¹` is the swing.
#[must_use]
pub fn twist_about(rotation: Quat, axis: Vec3) -> Quat {
    let along = Vec3::new(rotation.x, rotation.y, rotation.z).dot(axis);
    let twist = Quat::from_xyzw(axis.x * along, axis.y * along, axis.z * along, rotation.w);
    if twist.length_squared() < 1e-12 { Quat::IDENTITY } else { twist.normalize() }
}

/// Signed angle in radians by which `rotation` turns about the unit vector `axis`, -π..=π.
#[must_use]
pub fn twist_angle(rotation: Quat, axis: Vec3) -> f32 {
    to_scaled_axis(twist_about(rotation, axis)).dot(axis)
}

/// Angle wrapped into -π..=π.
#[must_use]
pub fn wrap_angle(radians: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    // Half a turn, give or take rounding, is one to the right: rounding isn't to decide it.
    if radians.abs() < 3.0 {
        return radians;
    }
    if !radians.is_finite() {
        return 0.0;
    }
    let turned = (radians + PI).rem_euclid(TAU) - PI;
    turned.clamp(-PI, PI)
}

/// Heading of a world direction about +Y in radians: 0 along -Z, positive to the left (+90° along -X).
#[must_use]
pub fn heading(direction: Vec3) -> f32 {
    ops::atan2(-direction.x, -direction.z)
}

/// Heading and rise of `direction` in radians: x is 0 along -Z and positive to the left, y is positive up.
///
/// Straight up and down have heading 0, no direction has neither.
#[must_use]
pub fn yaw_and_pitch(direction: Vec3) -> Vec2 {
    let direction = direction_or(direction, Vec3::ZERO);
    let across = direction.with_y(0.0).length();
    Vec2::new(if across > 1e-4 { heading(direction) } else { 0.0 }, ops::atan2(direction.y, across))
}

/// Rotation about `+Y` that turns -Z to the horizontal part of `direction`; identity where there is none.
#[must_use]
pub fn facing(direction: Vec3) -> Quat {
    let flat = Vec3::new(direction.x, 0.0, direction.z);
    if flat.length_squared() < TINY_SQUARED {
        return Quat::IDENTITY;
    }
    from_scaled_axis(Vec3::Y * heading(flat))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vec3> {
        (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0).prop_map(|(x, y, z)| Vec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn the_shortest_arc_turns_one_into_the_other(from in vector(), to in vector()) {
            prop_assume!(from.length() > 0.01 && to.length() > 0.01);
            let turned = shortest_arc(from, to) * from.normalize();
            prop_assert!(turned.distance(to.normalize()) < 2e-3, "{turned} is not {}", to.normalize());
        }

        #[test]
        fn exponential_undoes_logarithm(axis in vector(), angle in 0.0f32..3.1) {
            prop_assume!(axis.length() > 0.01);
            let vector = axis.normalize() * angle;
            let back = to_scaled_axis(from_scaled_axis(vector));
            prop_assert!(back.distance(vector) < 1e-3, "{vector} came back as {back}");
        }

        #[test]
        fn swing_times_twist_is_the_rotation(vector in vector(), axis in vector()) {
            prop_assume!(axis.length() > 0.01);
            let (rotation, axis) = (from_scaled_axis(vector * 3.0), axis.normalize());
            let twist = twist_about(rotation, axis);
            let swing = rotation * twist.inverse();
            let left = twist_angle(swing, axis).abs();
            prop_assert!(left < 2e-3 || (left - core::f32::consts::PI).abs() < 2e-3, "swing still twists by {left}");
        }

        #[test]
        fn facing_turns_forward_to_the_direction(x in -1.0f32..1.0, z in -1.0f32..1.0) {
            let direction = Vec3::new(x, 0.0, z);
            prop_assume!(direction.length() > 0.01);
            let forward = facing(direction) * Vec3::NEG_Z;
            prop_assert!(forward.distance(direction.normalize()) < 1e-4, "{forward}");
        }
    }

    #[test]
    fn yaw_and_pitch_make_the_direction_again() {
        for direction in [Vec3::NEG_Z, Vec3::X, Vec3::new(0.3, -0.8, 0.9), Vec3::Y, Vec3::NEG_Y] {
            let Vec2 { x: yaw, y: pitch } = yaw_and_pitch(direction * 3.0);
            let again = Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch) * Vec3::NEG_Z;
            assert!(again.distance(direction.normalize()) < 1e-4, "{direction} came back as {again}");
        }
        assert_eq!(yaw_and_pitch(Vec3::ZERO), Vec2::ZERO);
        assert_eq!(yaw_and_pitch(Vec3::NAN), Vec2::ZERO);
    }

    #[test]
    fn opposite_directions_turn_half_a_circle() {
        let turned = shortest_arc(Vec3::Y, Vec3::NEG_Y) * Vec3::Y;
        assert!(turned.distance(Vec3::NEG_Y) < 1e-6, "{turned}");
    }

    #[test]
    fn zero_vectors_give_no_nan() {
        assert_eq!(shortest_arc(Vec3::ZERO, Vec3::X), Quat::IDENTITY);
        assert_eq!(facing(Vec3::Y), Quat::IDENTITY);
        assert_eq!(direction_or(Vec3::NAN, Vec3::X), Vec3::X);
    }
}
