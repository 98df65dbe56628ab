//! Feet as a frame shows them: what lies between the last two ticks, like the pose that is seen.

use bevy::prelude::*;

use crate::character::foot_ik::{FootIk, PlacedFoot};

/// Both feet in the last two ticks, the older one first.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(super) struct ShownFeet([[Option<PlacedFoot>; 2]; 2]);

impl ShownFeet {
    /// Both feet `share` of the way from the older tick to the newer one.
    pub(super) fn at(&self, share: f32) -> [Option<PlacedFoot>; 2] {
        let [before, now] = self.0;
        [0, 1].map(|side| {
            let now = now[side]?;
            let before = before[side].unwrap_or(now);
            let sole = [0, 1, 2].map(|point| before.sole[point].lerp(now.sole[point], share));
            Some(PlacedFoot { ankle: before.ankle.lerp(now.ankle, share), sole, ..now })
        })
    }
}

/// Runs in each tick, when feet are placed.
pub(super) fn note(mut characters: Query<(&FootIk, &mut ShownFeet)>) {
    for (ik, mut shown) in &mut characters {
        shown.0 = [shown.0[1], ik.placed];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn feet_are_drawn_between_the_ticks_as_the_pose_is() {
        let plane = crate::character::foot_ik::Plane { point: Vec3::ZERO, normal: Vec3::Y };
        let foot = |x: f32| {
            let at = Vec3::X * x;
            Some(PlacedFoot { ankle: at, turn: Quat::IDENTITY, sole: [at; 3], plane, takeoff: at, landing: None })
        };
        let shown = ShownFeet([[foot(1.0), None], [foot(2.0), foot(4.0)]]);
        let ankles = |share| shown.at(share).map(|foot| foot.map(|foot| (foot.ankle.x, foot.sole[2].x)));
        assert_eq!(ankles(0.25), [Some((1.25, 1.25)), Some((4.0, 4.0))]);
        assert_eq!(ShownFeet::default().at(0.5), [None, None]);
    }
}
