//! Laps: something that is noted between the stages of a frame's poses, such as the time or a count.

use avian3d::prelude::PhysicsSystems;
use bevy::{
    ecs::{schedule::IntoScheduleConfigs, system::ScheduleSystem},
    prelude::*,
};

use crate::character::schedule::PoseSystems;

/// All stages of a pose, those of a tick before those of a frame.
pub const STAGES: [PoseSystems; PoseSystems::TICK.len() + PoseSystems::FRAME.len()] = {
    let mut stages = [PoseSystems::Palette; PoseSystems::TICK.len() + PoseSystems::FRAME.len()];
    let mut stage = 0;
    while stage < stages.len() {
        let ticks = PoseSystems::TICK.len();
        stages[stage] = if stage < ticks { PoseSystems::TICK[stage] } else { PoseSystems::FRAME[stage - ticks] };
        stage += 1;
    }
    stages
};

/// Runs `start` before the first stage of a tick's and of a frame's poses, and `lap(n)` after stage `n` of [`STAGES`] and before
/// the next.
pub fn lap_stages<S, L, Start, Lap>(app: &mut App, start: S, lap: impl Fn(usize) -> L)
where
    S: IntoScheduleConfigs<ScheduleSystem, Start> + Clone,
    L: IntoScheduleConfigs<ScheduleSystem, Lap>,
{
    app.add_systems(FixedPostUpdate, start.clone().after(PhysicsSystems::Last).before(PoseSystems::TICK[0]))
        .add_systems(PostUpdate, start.before(PoseSystems::FRAME[0]));
    for index in 0..PoseSystems::TICK.len() {
        let after = lap(index).after(PoseSystems::TICK[index]);
        match PoseSystems::TICK.get(index + 1) {
            Some(next) => app.add_systems(FixedPostUpdate, after.before(*next)),
            None => app.add_systems(FixedPostUpdate, after),
        };
    }
    for index in 0..PoseSystems::FRAME.len() {
        let after = lap(PoseSystems::TICK.len() + index).after(PoseSystems::FRAME[index]);
        match PoseSystems::FRAME.get(index + 1) {
            Some(next) => app.add_systems(PostUpdate, after.before(*next)),
            None => app.add_systems(PostUpdate, after.before(TransformSystems::Propagate)),
        };
    }
}
