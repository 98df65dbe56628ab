//! Laps: something that is noted between the stages of a frame's poses, such as the time or a count.

use bevy::{
    ecs::{schedule::IntoScheduleConfigs, system::ScheduleSystem},
    prelude::*,
};

use crate::character::schedule::PoseSystems;

/// Runs `start` before the first stage of the poses, and `lap(n)` after stage `n` of [`PoseSystems::ALL`] and before the next.
pub fn lap_stages<S, L, Start, Lap>(app: &mut App, start: S, lap: impl Fn(usize) -> L)
where
    S: IntoScheduleConfigs<ScheduleSystem, Start>,
    L: IntoScheduleConfigs<ScheduleSystem, Lap>,
{
    let [first, ..] = PoseSystems::ALL;
    app.add_systems(PostUpdate, start.before(first));
    for (index, stage) in PoseSystems::ALL.into_iter().enumerate() {
        let after = lap(index).after(stage);
        match PoseSystems::ALL.get(index + 1) {
            Some(next) => app.add_systems(PostUpdate, after.before(*next)),
            None => app.add_systems(PostUpdate, after.before(TransformSystems::Propagate)),
        };
    }
}
