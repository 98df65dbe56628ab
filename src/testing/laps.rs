//! Laps: something that is noted between the stages of a frame's poses, such as the time or a count.

use avian3d::prelude::PhysicsSystems;
use bevy::{
    ecs::{
        schedule::{IntoScheduleConfigs, ScheduleLabel},
        system::ScheduleSystem,
    },
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
    for (index, stage) in STAGES.into_iter().enumerate() {
        let in_tick = index < PoseSystems::TICK.len();
        let schedule = if in_tick { FixedPostUpdate.intern() } else { PostUpdate.intern() };
        let after = lap(index).after(stage);
        match STAGES.get(index + 1) {
            Some(next) => app.add_systems(schedule, after.before(*next)),
            None => app.add_systems(schedule, after.before(TransformSystems::Propagate)),
        };
    }
}
