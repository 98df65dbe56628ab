//! What ground can be stood on, and how high it lies. Pure; world space, metres, +Y up.

use bevy::math::{Vec3, ops};

use crate::math::rotation::direction_or;

/// Slack on the slope limit, so that ground of exactly the limit counts as walkable whatever its last bit says.
const COS_SLACK: f32 = 1e-3;

/// Most that a slope says about the height of a step, as the normal's least vertical part. Guards the division.
const LEAST_UP: f32 = 0.1;

/// The cosine to compare with [`walkable`], for the steepest slope in radians.
#[must_use]
pub(super) fn limit_cos(slope_limit: f32) -> f32 {
    ops::cos(slope_limit)
}

/// Whether ground with the unit normal `normal` is no steeper than the limit.
#[must_use]
pub(super) fn walkable(normal: Vec3, limit_cos: f32) -> bool {
    normal.y >= limit_cos - COS_SLACK
}

/// Height that ground of this normal gains over the horizontal way `travel`, metres.
#[must_use]
pub(super) fn rise_along(normal: Vec3, travel: Vec3) -> f32 {
    -(normal.x * travel.x + normal.z * travel.z) / normal.y.max(LEAST_UP)
}

/// How far the lowest point of a ball that touches a plane stands above the plane under the ball's centre, metres.
#[must_use]
pub(super) fn hover(radius: f32, normal: Vec3) -> f32 {
    radius * (1.0 / normal.y.clamp(LEAST_UP, 1.0) - 1.0)
}

/// The wall that a steep normal amounts to for one who walks: its horizontal direction.
#[must_use]
pub(super) fn as_wall(normal: Vec3) -> Vec3 {
    direction_or(Vec3::new(normal.x, 0.0, normal.z), Vec3::ZERO)
}

/// The part of a change of height that neither slope explains, metres.
///
/// Slopes before and after explain anything between what they would have risen over `travel`; the rest is a step.
#[must_use]
pub(super) fn step_in(change: f32, normal_before: Vec3, normal_after: Vec3, travel: Vec3) -> f32 {
    let (before, after) = (rise_along(normal_before, travel), rise_along(normal_after, travel));
    change - change.clamp(before.min(after), before.max(after))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn slope(degrees: f32) -> Vec3 {
        let radians = degrees.to_radians();
        Vec3::new(-ops::sin(radians), ops::cos(radians), 0.0)
    }

    #[test]
    fn the_limit_itself_is_walkable_and_a_degree_more_is_not() {
        let limit = limit_cos(45f32.to_radians());
        assert!(walkable(slope(45.0), limit) && walkable(slope(20.0), limit));
        assert!(!walkable(slope(46.0), limit) && !walkable(Vec3::NEG_Y, limit));
    }

    #[test]
    fn a_slope_explains_its_own_rise_and_no_stair() {
        let (flat, ramp, travel) = (Vec3::Y, slope(30.0), Vec3::X * 0.05);
        let rise = rise_along(ramp, travel);
        assert!((rise - 0.05 * ops::tan(30f32.to_radians())).abs() < 1e-6, "rises {rise} m");
        assert!(step_in(rise * 0.5, flat, ramp, travel).abs() < 1e-6, "the foot of a ramp counted as a step");
        let stair = step_in(0.17, flat, flat, travel);
        assert!((stair - 0.17).abs() < 1e-6, "a stair counted as {stair} m");
    }

    proptest! {
        #[test]
        fn a_ball_touches_the_plane_it_hovers_over(degrees in 0.0f32..60.0, radius in 0.05f32..1.0) {
            let normal = slope(degrees);
            let centre = Vec3::Y * (radius + hover(radius, normal));
            prop_assert!((centre.dot(normal) - radius).abs() < 1e-4, "{} from the plane", centre.dot(normal) - radius);
        }
    }
}
