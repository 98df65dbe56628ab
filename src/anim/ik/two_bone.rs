//! Analytic two-bone IK, applied as rotation deltas on the animated pose, so that any bone axes work.
//!
//! All positions in one space (model or world, metres); the deltas are rotations in that space.

use bevy::math::{Quat, Vec3, Vec3A, ops};

use crate::math::rotation::{
    any_perpendicular, direction, direction_aligned, direction_or, shortest_arc_between_units,
};

/// Shortest bone in metres that still has a direction.
pub(in crate::anim) const SHORTEST_BONE: f32 = 1e-4;
/// Sine of the bend below which a limb counts as straight and its bend plane comes from the pole.
pub(in crate::anim) const STRAIGHT: f32 = 0.01;

/// Metres from the root within which a target lies in no direction.
const NOWHERE: f32 = 1e-8;

/// A limb as the clip left it: hip, knee, ankle of a leg, or shoulder, elbow, wrist of an arm.
#[derive(Clone, Copy, Debug)]
pub struct Limb {
    /// Where the limb hangs.
    pub root: Vec3,
    /// The hinge between its two bones.
    pub middle: Vec3,
    /// Its end.
    pub end: Vec3,
    /// Direction in which the middle bends where the limb is straight, e.g. forward for a knee.
    pub pole: Vec3,
}

/// How far a limb may stretch, as fractions of both bones' length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extension {
    /// From here on the limb resists. Default 0.97.
    pub soft: f32,
    /// It never reaches further. Default 0.995.
    pub hard: f32,
}

impl Default for Extension {
    fn default() -> Self {
        Self { soft: 0.97, hard: 0.995 }
    }
}

/// What turns a limb onto its target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution {
    /// Turns the upper bone, before its animated rotation: `new = delta * old`.
    pub upper_delta: Quat,
    /// Turns the lower bone, likewise from its animated rotation.
    pub lower_delta: Quat,
    /// Where the middle joint comes to lie.
    pub middle: Vec3,
    /// Where the end comes to lie.
    pub end: Vec3,
    /// Metres between the end and the target.
    pub missed: f32,
}

/// Turns a limb so that its end comes to `target`.
///
/// The bend plane is the animated one, carried along on the shortest arc from the old to the new reach. A target out of
/// reach gives the limb stretched toward it, up to `extension.hard`; a target on the root folds the limb as far as it goes.
#[must_use]
pub fn solve(limb: &Limb, target: Vec3, extension: Extension) -> Solution {
    let (root, knee, end) = (Vec3A::from(limb.root), Vec3A::from(limb.middle), Vec3A::from(limb.end));
    let target = Vec3A::from(target);
    let (upper, lower) = (knee - root, end - knee);
    let (a, b) = (upper.length(), lower.length());
    if !target.is_finite() || !(a + b).is_finite() || a.min(b) <= SHORTEST_BONE {
        return Solution {
            upper_delta: Quat::IDENTITY,
            lower_delta: Quat::IDENTITY,
            middle: limb.middle,
            end: limb.end,
            missed: end.distance(target),
        };
    }
    let (upper, lower) = (upper / a, lower / b);
    let wanted = target - root;
    let distance = wanted.length();
    let reach = soften(distance, a + b, extension).max((a - b).abs() + SHORTEST_BONE);
    let old_axis = direction_aligned(end - root).unwrap_or(upper);
    let new_axis = if distance > NOWHERE { wanted / distance } else { old_axis };
    let swing = shortest_arc_between_units(old_axis, new_axis);
    // At right angles to the new axis, as it was to the old one.
    let bend = swing * bend_direction(limb.pole, upper, old_axis);
    let cos = ((a * a + reach * reach - b * b) / (2.0 * a * reach)).clamp(-1.0, 1.0);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (new_upper, end) = (new_axis * cos + bend * sin, root + new_axis * reach);
    let middle = root + new_upper * a;
    let upper_delta = shortest_arc_between_units(swing * upper, new_upper) * swing;
    let lower_delta = shortest_arc_between_units(swing * lower, (end - middle) / b) * swing;
    Solution { upper_delta, lower_delta, middle: middle.into(), end: end.into(), missed: end.distance(target) }
}

/// Reach in metres that a limb of `length` gives when `wanted` is asked of it.
///
/// The same up to `soft`, from there on asymptotic to `hard` with a continuous slope
/// (after "Soft IK", Andy Nicholas, 2009), so that a knee never snaps straight.
#[must_use]
pub fn soften(wanted: f32, length: f32, extension: Extension) -> f32 {
    let (soft, hard) = (extension.soft * length, extension.hard * length);
    let room = hard - soft;
    if wanted <= soft || room <= 0.0 {
        return wanted.min(hard);
    }
    soft + room * (1.0 - ops::exp(-(wanted - soft) / room))
}

/// Angle between the two bones at the middle joint in radians: 0 straight, π folded.
#[must_use]
pub fn bend_angle(root: Vec3, middle: Vec3, end: Vec3) -> f32 {
    let (upper, lower) = (direction_or(middle - root, Vec3::NEG_Y), direction_or(end - middle, Vec3::NEG_Y));
    ops::acos(upper.dot(lower).clamp(-1.0, 1.0))
}

/// Unit direction from the reach axis toward the middle joint, at right angles to the axis; the pole's where the limb is
/// straight. `upper` is the upper bone's direction.
#[inline]
fn bend_direction(pole: Vec3, upper: Vec3A, axis: Vec3A) -> Vec3A {
    let off_axis = upper - axis * upper.dot(axis);
    let sine = off_axis.length();
    // Between straight and clearly bent the pole hands over to the animated plane.
    let share = ((sine / STRAIGHT) - 1.0).clamp(0.0, 1.0);
    if share >= 1.0 {
        return off_axis / sine;
    }
    let (off_axis, axis) = (Vec3::from(off_axis), Vec3::from(axis));
    let bent = direction(off_axis);
    let pole = direction(pole - axis * pole.dot(axis)).unwrap_or_else(|| any_perpendicular(axis));
    let bent = bent.unwrap_or(pole);
    direction_or(pole * (1.0 - share) + bent * share, bent).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rotation::from_scaled_axis;
    use proptest::prelude::*;

    fn leg() -> Limb {
        Limb {
            root: Vec3::new(0.0, 0.9, 0.0),
            middle: Vec3::new(0.0, 0.5, -0.15),
            end: Vec3::new(0.0, 0.08, 0.0),
            pole: Vec3::NEG_Z,
        }
    }

    fn direction() -> impl Strategy<Value = Vec3> {
        (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0)
            .prop_map(|(x, y, z)| Vec3::new(x, y, z))
            .prop_filter("has a direction", |v| v.length() > 0.05)
            .prop_map(Vec3::normalize)
    }

    proptest! {
        #[test]
        fn a_reachable_target_is_reached(toward in direction(), share in 0.2f32..0.96, turn in direction()) {
            let turn = from_scaled_axis(turn);
            let leg = leg();
            let leg = Limb { root: turn * leg.root, middle: turn * leg.middle, end: turn * leg.end, pole: turn * leg.pole };
            let length = leg.root.distance(leg.middle) + leg.middle.distance(leg.end);
            let target = leg.root + toward * (share * length);
            let got = solve(&leg, target, Extension::default());
            prop_assert!(got.missed < 1e-4, "missed by {} m", got.missed);
            let middle = leg.root + got.upper_delta * (leg.middle - leg.root);
            let end = middle + got.lower_delta * (leg.end - leg.middle);
            prop_assert!(end.distance(target) < 1e-3, "turned bones end {} m off", end.distance(target));
            prop_assert!(middle.distance(got.middle) < 1e-3, "the knee is {} m off", middle.distance(got.middle));
        }

        #[test]
        fn an_unreachable_target_is_approached_straight(toward in direction(), share in 1.01f32..5.0) {
            let leg = leg();
            let length = leg.root.distance(leg.middle) + leg.middle.distance(leg.end);
            let target = leg.root + toward * (share * length);
            let got = solve(&leg, target, Extension::default());
            let ratio = got.end.distance(leg.root) / length;
            prop_assert!(ratio <= 0.995 + 1e-4 && ratio > 0.98, "stretched to {ratio}");
            prop_assert!((got.end - leg.root).normalize().dot(toward) > 0.999, "not toward the target");
        }

        #[test]
        fn anything_goes_in_and_no_nan_comes_out(root in direction(), middle in direction(), end in direction(), target in direction(), zero in 0u8..16) {
            let pick = |v: Vec3, bit: u8| if zero & bit == 0 { v } else { Vec3::ZERO };
            let limb = Limb { root: pick(root, 1), middle: pick(middle, 2), end: pick(end, 4), pole: pick(end, 8) };
            let got = solve(&limb, pick(target, 8), Extension::default());
            prop_assert!(got.end.is_finite() && got.upper_delta.is_finite() && got.lower_delta.is_finite(), "{got:?}");
        }
    }

    #[test]
    fn the_animated_pose_stands_when_the_target_is_its_own_ankle() {
        let leg = leg();
        let got = solve(&leg, leg.end, Extension::default());
        assert!(got.end.distance(leg.end) < 1e-5 && got.middle.distance(leg.middle) < 1e-4, "{got:?}");
    }

    #[test]
    fn a_straight_leg_bends_toward_its_pole() {
        let leg = Limb { middle: Vec3::new(0.0, 0.49, 0.0), ..leg() };
        let got = solve(&leg, leg.end + Vec3::Y * 0.2, Extension::default());
        assert!(got.middle.z < -0.1, "the knee went to {}", got.middle);
    }

    #[test]
    fn softening_keeps_short_reaches_and_never_passes_hard() {
        let extension = Extension::default();
        assert!((soften(0.9, 1.0, extension) - 0.9).abs() < 1e-7);
        let last = soften(10.0, 1.0, extension);
        assert!(last <= 0.995, "{last}");
        let slope = (soften(0.9701, 1.0, extension) - soften(0.97, 1.0, extension)) / 1e-4;
        assert!((slope - 1.0).abs() < 0.02, "slope {slope} where softening begins");
    }
}
