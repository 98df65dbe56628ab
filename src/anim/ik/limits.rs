//! How far a joint turns: as a hinge about an axis, or as a ball within a cone and a range of twist.
//!
//! Turns are rotations from rest in the joint's own space: `local = rest * turn`. Swing and twist after Baerlocher and
//! Boulic, "Parametrization and range of motion of the ball-and-socket joint" (2001): `turn = swing * twist`.

use core::f32::consts::PI;

use bevy::math::{Quat, Vec3};

use crate::math::rotation::{direction_or, from_scaled_axis, to_scaled_axis, twist_about, twist_angle, wrap_angle};

/// Radians before a limit from which a joint is at it.
const AT_LIMIT: f32 = 1e-3;

/// How far a joint turns from rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Limit {
    /// Anywhere.
    #[default]
    Free,
    /// Not at all: it keeps the rotation it has.
    Fixed,
    /// About one axis only.
    Hinge {
        /// Unit axis in the joint's own space.
        axis: Vec3,
        /// Least angle in radians, right-handed about the axis, within -π..=π.
        min: f32,
        /// Greatest angle in radians, at least `min`.
        max: f32,
    },
    /// Within a cone about the direction of its bone.
    Cone {
        /// Unit direction of the bone in the joint's own space.
        axis: Vec3,
        /// Greatest angle in radians between the bone and where it is at rest.
        swing: f32,
        /// Least and greatest turn about the bone in radians, within -π..=π.
        twist: [f32; 2],
    },
}

impl Limit {
    /// The turn that is nearest to `turn` and within the limit.
    #[must_use]
    pub fn clamp(&self, turn: Quat) -> Quat {
        match *self {
            Self::Free | Self::Fixed => turn,
            Self::Hinge { axis, min, max } => from_scaled_axis(axis * clamp_angle(twist_angle(turn, axis), min, max)),
            Self::Cone { axis, swing, twist } => {
                let twisted = twist_about(turn, axis);
                let swung = to_scaled_axis(turn * twisted.inverse());
                let angle = twist_angle(twisted, axis);
                if swung.length() <= swing && (twist[0]..=twist[1]).contains(&angle) {
                    return turn;
                }
                let kept = clamp_angle(angle, twist[0], twist[1]);
                let swung = swung.clamp_length_max(swing.max(0.0));
                (from_scaled_axis(swung) * from_scaled_axis(axis * kept)).normalize()
            }
        }
    }

    /// Unit rotation vectors, in the space that turns are in, along which `turn` leaves the limit that it has come to.
    #[must_use]
    pub fn ways_out(&self, turn: Quat) -> [Option<Vec3>; 2] {
        match *self {
            Self::Free | Self::Fixed => [None; 2],
            Self::Hinge { axis, min, max } => {
                let angle = twist_angle(turn, axis);
                [(angle >= max - AT_LIMIT).then_some(axis), (angle <= min + AT_LIMIT).then_some(-axis)]
            }
            Self::Cone { axis, swing, twist: [least, most] } => {
                let twisted = twist_about(turn, axis);
                let swung = turn * twisted.inverse();
                let angle = twist_angle(twisted, axis);
                // A turn ω twists by ω·(a + b) / (1 + a·b), a the bone at rest, b the bone now.
                let along = direction_or(axis + swung * axis, axis);
                let twist =
                    if angle >= most - AT_LIMIT { Some(along) } else { (angle <= least + AT_LIMIT).then_some(-along) };
                let out = to_scaled_axis(swung);
                [(out.length() >= swing - AT_LIMIT).then_some(direction_or(out, Vec3::ZERO)), twist]
            }
        }
    }

    /// Radians by which `turn` is beyond the limit; 0 within it.
    #[must_use]
    pub fn excess(&self, turn: Quat) -> f32 {
        to_scaled_axis(turn * self.clamp(turn).inverse()).length()
    }

    /// Greatest angle in radians between the bone and where it is at rest.
    #[must_use]
    pub fn widest(&self) -> f32 {
        match *self {
            Self::Free | Self::Fixed => PI,
            Self::Hinge { min, max, .. } => min.abs().max(max.abs()),
            Self::Cone { swing, .. } => swing,
        }
    }
}

/// The angle in `min..=max` that is nearest to `angle` on the circle.
fn clamp_angle(angle: f32, min: f32, max: f32) -> f32 {
    if (min..=max).contains(&angle) {
        return angle;
    }
    let away = |end: f32| wrap_angle(angle - end).abs();
    if away(min) <= away(max) { min } else { max }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anim::ik::chain::samples::{direction, limit, rotation};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_was_clamped_is_within_the_limit(turn in rotation(), limit in limit()) {
            let excess = limit.excess(limit.clamp(turn));
            prop_assert!(excess < 2e-3, "{excess} rad beyond {limit:?}");
        }

        #[test]
        fn what_is_within_a_cone_stays(axis in direction(), side in direction(), swing in 0.0f32..1.0, twist in -1.0f32..1.0) {
            let limit = Limit::Cone { axis, swing: 1.0, twist: [-1.0, 1.0] };
            let across = axis.any_orthonormal_vector().lerp(side.reject_from(axis), 0.5).normalize();
            let turn = from_scaled_axis(across * swing) * from_scaled_axis(axis * twist);
            let excess = limit.excess(turn);
            prop_assert!(excess < 1e-3, "moved by {excess} rad");
        }
    }

    #[test]
    fn an_elbow_bent_backward_comes_back_to_straight() {
        let elbow = Limit::Hinge { axis: Vec3::X, min: 0.0, max: 2.5 };
        let angle = |turn: f32| twist_angle(elbow.clamp(from_scaled_axis(Vec3::X * turn)), Vec3::X);
        assert!(angle(-0.3).abs() < 1e-6, "at {}", angle(-0.3));
        assert!((angle(2.8) - 2.5).abs() < 1e-5, "at {}", angle(2.8));
        assert!((angle(1.2) - 1.2).abs() < 1e-5, "at {}", angle(1.2));
    }
}
