//! An upright capsule that moves against one that stands, without iteration: what characters meet in a crowd.
//!
//! World space, metres.

use avian3d::prelude::Collider;
use bevy::prelude::*;

use super::frame::Frame;

/// Most in metres by which the ends of an upright capsule's axis lie beside each other.
const UPRIGHT: f32 = 1e-5;

/// A capsule with a vertical axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct UprightCapsule {
    /// The lower end of its axis.
    foot: Vec3,
    /// Length of its axis.
    length: f32,
    radius: f32,
}

/// Where a capsule came to touch another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub(super) distance: f32,
    /// Unit normal toward the one that moves.
    pub(super) normal: Vec3,
    pub(super) point: Vec3,
}

impl UprightCapsule {
    /// The collider's capsule, if it is one and stands upright.
    pub(super) fn of(collider: &Collider, frame: Frame) -> Option<Self> {
        let capsule = collider.shape_scaled().as_capsule()?;
        let [a, b] = [capsule.segment.a, capsule.segment.b].map(|end| frame.world(Vec3::new(end.x, end.y, end.z)));
        let upright = (a - b).with_y(0.0).length_squared() < UPRIGHT * UPRIGHT;
        let foot = if a.y < b.y { a } else { b };
        upright.then_some(Self { foot, length: (a.y - b.y).abs(), radius: capsule.radius })
    }

    /// Metres by which the two reach into each other; negative where they are apart.
    pub(super) fn depth_in(&self, other: &Self) -> f32 {
        self.radius + other.radius - self.apart(other).length()
    }

    /// Which way leads out of the other: a unit vector; `beside` where their axes cross.
    pub(super) fn way_out_of(&self, other: &Self, beside: Vec3) -> Vec3 {
        self.apart(other).normalize_or(beside)
    }

    /// From the other's axis to its own.
    fn apart(&self, other: &Self) -> Vec3 {
        let way = self.foot - other.foot;
        way - Vec3::Y * way.y.clamp(-self.length, other.length)
    }
}

/// Where `moving` first touches `obstacle` within `reach` metres. One that starts in the other touches it unless it leaves.
#[must_use]
pub(super) fn sweep_capsule(
    moving: UprightCapsule,
    direction: Dir3,
    reach: f32,
    obstacle: UprightCapsule,
) -> Option<Touch> {
    // The same as the foot of the one against the other grown by it: a point against a capsule.
    let radius = moving.radius + obstacle.radius;
    let (low, high) = (-moving.length, obstacle.length);
    let start = moving.foot - obstacle.foot;
    let to_axis = |at: Vec3| at - Vec3::Y * at.y.clamp(low, high);
    let touch = |distance: f32| {
        let at = start + direction * distance;
        let normal = to_axis(at).normalize_or(Vec3::Y);
        // In the middle of what lies side by side.
        let (from, to) = (at.y.max(0.0), (at.y + moving.length).min(obstacle.length));
        let height = (0.5 * (from + to)).clamp(0.0, obstacle.length);
        Touch { distance, normal, point: obstacle.foot + Vec3::Y * height + normal * obstacle.radius }
    };
    if to_axis(start).length_squared() < radius * radius {
        return Some(touch(0.0)).filter(|touch| touch.normal.dot(*direction) < 0.0);
    }
    let side = enter(start.with_y(0.0), direction.with_y(0.0), radius).filter(|distance| {
        let height = start.y + direction.y * distance;
        (low..=high).contains(&height)
    });
    let end = |height: f32| enter(start - Vec3::Y * height, *direction, radius);
    let first = side.or_else(|| [end(low), end(high)].into_iter().flatten().min_by(f32::total_cmp))?;
    (first < reach).then(|| touch(first))
}

/// Distance at which a point from `start`, outside, comes within `radius` of the origin; of the vertical axis if both are flat.
fn enter(start: Vec3, direction: Vec3, radius: f32) -> Option<f32> {
    // |start + t direction|² = radius², solved for the lesser t.
    let (a, b, c) = (direction.length_squared(), start.dot(direction), start.length_squared() - radius * radius);
    let root = b * b - a * c;
    (a > 1e-12 && b < 0.0 && root >= 0.0).then(|| ((-b - root.sqrt()) / a).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const STANDING: Frame = Frame { position: Vec3::ZERO, rotation: Quat::IDENTITY };

    /// How far two upright axes lie apart: one from `low` upward by `length`, one from the origin upward by `other`.
    fn apart(low: Vec3, length: f32, other: f32) -> f32 {
        let over = (low.y - other).max(-(low.y + length)).max(0.0);
        Vec3::new(low.x, over, low.z).length()
    }

    proptest! {
        #[test]
        fn capsules_meet_where_their_axes_are_as_far_apart_as_both_are_thick(x in -2.0f32..2.0, y in -3.0f32..3.0, z in -2.0f32..2.0, dx in -1.0f32..1.0, dy in -1.0f32..1.0, dz in -1.0f32..1.0, length in 0.01f32..1.5) {
            let Ok(direction) = Dir3::new(Vec3::new(dx, dy, dz)) else { return Ok(()) };
            let (radii, reach) = (0.25 + 0.3, 5.0);
            let low = Vec3::new(x, y, z);
            let frame = |low: Vec3, length: f32| Frame { position: low + Vec3::Y * 0.5 * length, ..STANDING };
            let moving = UprightCapsule::of(&Collider::capsule(0.25, length), frame(low, length)).expect("it is upright");
            let obstacle = UprightCapsule::of(&Collider::capsule(0.3, 1.0), frame(Vec3::ZERO, 1.0)).expect("it is upright");
            // Metres between the two after some way; rounding of the two colliders takes some micrometres.
            let gap = |way: f32| apart(low + direction * way, length, 1.0) - radii;
            prop_assert!((gap(0.0) + moving.depth_in(&obstacle)).abs() < 2e-5, "{} m deep", moving.depth_in(&obstacle));
            let hit = sweep_capsule(moving, direction, reach, obstacle);
            if gap(0.0) < 0.0 {
                let nearer = gap(1e-3) < gap(0.0);
                prop_assert!(hit.is_some() == nearer || (gap(1e-3) - gap(0.0)).abs() < 1e-5, "{hit:?}, {} m within", -gap(0.0));
                prop_assert!(hit.is_none_or(|touch| touch.distance == 0.0), "{hit:?}");
                return Ok(());
            }
            let free = hit.map_or(reach, |touch| touch.distance);
            for step in 0..200_u8 {
                let way = free * f32::from(step) / 200.0;
                prop_assert!(gap(way) > -2e-5, "{} m deep in it after {way} m of {hit:?}", -gap(way));
            }
            let Some(touch) = hit else { return Ok(()) };
            prop_assert!(gap(touch.distance).abs() < 2e-5, "{} m apart at {touch:?}", gap(touch.distance));
            // The point lies on both of them, the normal at it.
            let there = low + direction * touch.distance;
            let of_obstacle = apart(touch.point - touch.normal * 0.3, 0.0, 1.0);
            let of_moving = apart(touch.point + touch.normal * 0.25 - there, 0.0, length);
            prop_assert!(of_obstacle < 2e-5, "{touch:?} lies {of_obstacle} m beside what stands");
            prop_assert!(of_moving < 2e-5, "{touch:?} lies {of_moving} m beside what moves");
        }
    }

    #[test]
    fn a_capsule_that_leans_is_left_to_casts() {
        let frame = Frame { rotation: Quat::from_rotation_x(0.1), ..STANDING };
        assert!(UprightCapsule::of(&Collider::capsule(0.3, 1.0), frame).is_none());
        assert!(UprightCapsule::of(&Collider::sphere(0.3), STANDING).is_none());
    }

    #[test]
    fn one_within_another_may_leave_it_but_not_go_deeper() {
        let collider = Collider::capsule(0.3, 1.0);
        let obstacle = UprightCapsule::of(&collider, STANDING).expect("it is upright");
        let moving =
            UprightCapsule::of(&collider, Frame { position: Vec3::X * 0.5, ..STANDING }).expect("it is upright");
        assert!(sweep_capsule(moving, Dir3::X, 1.0, obstacle).is_none());
        let deeper = sweep_capsule(moving, Dir3::NEG_X, 1.0, obstacle).map(|touch| (touch.distance, touch.normal));
        assert_eq!(deeper, Some((0.0, Vec3::X)));
    }
}
