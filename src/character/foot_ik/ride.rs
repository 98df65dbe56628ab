//! What ground the body rides over: the line from foothold to foothold, where the root is. World space, metres, +Y up.
//!
//! On a plane that is the plane, on stairs the slope of the flight: it neither hops with the capsule nor waits for feet.

use bevy::prelude::*;

use super::surroundings::PlacedFoot;

/// The ground under the body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ride {
    /// World height.
    pub height: f32,
    /// How fast it rises as the body goes, m/s.
    pub speed: f32,
}

/// Metres between two footholds below which there is no line between them.
const APART: f32 = 0.05;

/// The ground that a body with its root at `root` rides over, going at `velocity` (m/s, over the ground) on ground that
/// itself rises at `carried` m/s.
#[must_use]
pub fn ride(feet: &[PlacedFoot; 2], root: Vec3, velocity: Vec3, carried: f32) -> Ride {
    let (from, to) = footholds(feet, root);
    let way = (to - from).with_y(0.0);
    let rise = to.y - from.y;
    let length = way.length();
    if length < APART {
        return Ride { height: 0.5 * (from.y + to.y), speed: carried };
    }
    let done = (root - from).dot(way) / (length * length);
    let along = if (0.0..=1.0).contains(&done) { velocity.dot(way) / (length * length) } else { 0.0 };
    Ride { height: from.y + rise * done.clamp(0.0, 1.0), speed: rise * along + carried }
}

/// The foothold behind the root and the one ahead of it.
fn footholds(feet: &[PlacedFoot; 2], root: Vec3) -> (Vec3, Vec3) {
    let place = |foot: &PlacedFoot| foot.takeoff;
    let landing = |foot: &PlacedFoot| foot.landing.map(|(place, _)| place);
    let seconds = |foot: &PlacedFoot| foot.landing.map_or(0.0, |(_, seconds)| seconds);
    match (landing(&feet[0]), landing(&feet[1])) {
        (None, None) => (place(&feet[0]), place(&feet[1])),
        (Some(next), None) => between(place(&feet[0]), place(&feet[1]), next, root),
        (None, Some(next)) => between(place(&feet[1]), place(&feet[0]), next, root),
        (Some(first), Some(second)) => {
            // In flight: from the foot that left last to the one that lands first.
            let sooner = seconds(&feet[0]) <= seconds(&feet[1]);
            if sooner { (place(&feet[1]), first) } else { (place(&feet[0]), second) }
        }
    }
}

/// While a foot swings from `last` to `next` past the one that stands: the half of the way that the root is on.
fn between(last: Vec3, stands: Vec3, next: Vec3, root: Vec3) -> (Vec3, Vec3) {
    let past = (root - stands).with_y(0.0).dot(next - last) > 0.0;
    if past { (stands, next) } else { (last, stands) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::character::foot_ik::ground::Plane;

    fn foot(takeoff: Vec3, landing: Option<(Vec3, f32)>) -> PlacedFoot {
        PlacedFoot {
            ankle: takeoff,
            turn: Quat::IDENTITY,
            sole: [takeoff; 3],
            plane: Plane { point: takeoff, normal: Vec3::Y },
            takeoff,
            landing,
        }
    }

    #[test]
    fn on_stairs_a_body_rises_evenly() {
        // Feet two treads of 0.29 x 0.17 m apart, the root going from the lower to the upper.
        let low = foot(Vec3::new(-0.1, 0.0, 0.0), None);
        let high = foot(Vec3::new(0.1, 0.34, -0.58), None);
        let heights = [0.0, -0.29, -0.58].map(|z| ride(&[low, high], Vec3::new(0.0, 0.0, z), Vec3::NEG_Z, 0.0).height);
        let steps = [heights[1] - heights[0], heights[2] - heights[1]];
        assert!((steps[0] - steps[1]).abs() < 0.02, "rises by {steps:?} m");
    }

    #[test]
    fn a_landing_changes_nothing() {
        let stands = foot(Vec3::new(-0.1, 0.17, -0.3), None);
        let place = Vec3::new(0.1, 0.34, -0.6);
        let root = Vec3::new(0.0, 0.0, -0.4);
        let flying = ride(&[stands, foot(Vec3::new(0.1, 0.0, 0.0), Some((place, 0.0)))], root, Vec3::NEG_Z, 0.0);
        let landed = ride(&[stands, foot(place, None)], root, Vec3::NEG_Z, 0.0);
        assert!((flying.height - landed.height).abs() < 1e-5, "{flying:?} before, {landed:?} after");
    }
}
