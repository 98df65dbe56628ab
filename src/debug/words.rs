//! What a foot does, in a few words. Pure.

use crate::character::foot_ik::{FootState, Mode, Pivot, PlacedFoot, Release};

/// Why a foot let go of the ground last.
#[must_use]
pub fn reason(release: Release) -> &'static str {
    match release {
        Release::Never => "never let go",
        Release::ContactEnded => "let go: lifted",
        Release::TooFar => "let go: too far away",
        Release::Turned => "let go: turned too far",
        Release::Restep => "let go: off its place",
        Release::LostGround => "let go: ground is gone",
        Release::Reset => "let go: reset",
    }
}

/// What a foot does now.
#[must_use]
pub fn describe(foot: &FootState, placed: &PlacedFoot) -> String {
    match (&foot.mode, placed.landing) {
        (Mode::Planted(plant), _) if plant.pivot == Pivot::Heel => "held by the heel".to_owned(),
        (Mode::Planted(_), _) => "held by the ball".to_owned(),
        (Mode::Swing, Some((_, seconds))) => format!("lands in {seconds:.2} s"),
        (Mode::Swing, None) => "swings".to_owned(),
        (Mode::Stepping { elapsed, seconds, .. }, _) => {
            format!("steps, {:.2} s left", (seconds - elapsed).max(0.0))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::character::foot_ik::Plane;
    use bevy::math::{Quat, Vec3};

    #[test]
    fn a_foot_in_the_air_tells_when_it_lands() {
        let plane = Plane { point: Vec3::ZERO, normal: Vec3::Y };
        let landing = Some((Vec3::ZERO, 0.214));
        let placed = PlacedFoot {
            ankle: Vec3::Y,
            turn: Quat::IDENTITY,
            sole: [Vec3::ZERO; 3],
            plane,
            takeoff: Vec3::ZERO,
            landing,
        };
        assert_eq!(describe(&FootState::default(), &placed), "lands in 0.21 s");
    }
}
