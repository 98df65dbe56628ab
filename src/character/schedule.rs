//! The spine: every stage of a character, in order, once. Other files only say `.in_set(…)`.
//!
//! All that decides where a character is and how it stands runs on the fixed clock, so it is the same at every frame rate.
//! Frames show what lies between the last two ticks, root and pose alike.

use avian3d::prelude::PhysicsSystems;
use bevy::prelude::*;

/// A share, 0..1, by which things that are done now and then are put off, so that neighbours don't do them at once.
pub(super) fn stagger(character: Entity) -> f32 {
    // Neighbours have numbers that follow on each other; the golden ratio spreads them evenly.
    (character.index_u32() as f32 * 0.618_034).fract()
}

/// Fixed clock (`FixedUpdate`): deterministic, the same for every frame rate.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionSystems {
    /// Players, AI and tests write `MoveIntent`.
    Decide,
    /// The controller turns `MoveIntent` into a moved root and `MotionState`.
    Move,
}

/// Stages of a pose: those of [`TICK`](Self::TICK) on the fixed clock (`FixedPostUpdate`, when physics has moved the ground),
/// those of [`FRAME`](Self::FRAME) in every frame (`PostUpdate`, before transforms propagate).
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PoseSystems {
    /// `MotionState` → clip weights and phase.
    Locomote,
    /// Who is posed in this tick.
    Pace,
    /// Clips → local pose. From here to `Model` the model pose is that of legs, spine and head alone.
    Sample,
    /// Ground → feet, ankles, pelvis of the local pose.
    Plant,
    /// Where it goes → chest, neck and head of the local pose.
    Look,
    /// Local pose → model pose of all joints.
    Model,
    /// Aim → arms of the local pose, model pose of all joints.
    Aim,
    /// Poses of those that aren't posed in every tick → local and model pose of all joints. At its end the model pose goes to
    /// `Show`.
    Ease,
    /// Model poses of the last two ticks → that of this frame.
    Show,
    /// Targets → joints of IK chains.
    Reach,
    /// Model pose → what rides on it.
    Attach,
    /// Model pose → skinning matrices.
    Palette,
}

impl PoseSystems {
    /// Stages of a tick, in order.
    pub const TICK: [Self; 8] =
        [Self::Locomote, Self::Pace, Self::Sample, Self::Plant, Self::Look, Self::Model, Self::Aim, Self::Ease];

    /// Stages of a frame, in order.
    pub const FRAME: [Self; 4] = [Self::Show, Self::Reach, Self::Attach, Self::Palette];
}

/// How much time each tick poses characters for.
///
/// Where a frame takes long it has many ticks, and each costs as much as a frame's poses: the more time they take the more of
/// them there are. So no more than [`most`](Self::most) of them are posed; the first of these takes the others' time with it.
#[derive(Resource, Reflect, Clone, Debug)]
#[reflect(Resource)]
pub struct PoseClock {
    /// Largest number of ticks of one frame in which characters are posed; at least 1. Default 3.
    ///
    /// With as many ticks as a frame has, poses are the same at every frame rate: 3 is enough for 30 frames a second at
    /// bevy's 64 ticks. For crowds that take most of a frame set it to 1.
    pub most: u32,
    waited: f32,
    delta: f32,
    ticks: f32,
}

impl Default for PoseClock {
    fn default() -> Self {
        Self { most: 3, waited: 0.0, delta: 0.0, ticks: 1.0 }
    }
}

impl PoseClock {
    /// Poses characters in `most` ticks of a frame.
    #[must_use]
    pub fn at_most(most: u32) -> Self {
        Self { most, ..Self::default() }
    }

    /// Seconds that characters are posed for in this tick; 0 while they aren't.
    #[must_use]
    pub fn delta_secs(&self) -> f32 {
        self.delta
    }

    /// Where between the last two poses a frame lies, 0..=1, that shows `share` of its last tick.
    #[must_use]
    pub fn share(&self, share: f32) -> f32 {
        (1.0 - (1.0 - share) / self.ticks).clamp(0.0, 1.0)
    }

    /// Seconds after the last pose but one that are shown by a frame that shows `share` of its last tick.
    #[must_use]
    pub fn shown_secs(&self, share: f32) -> f32 {
        self.share(share) * self.delta
    }

    /// One tick of `step` seconds, with `ahead` more of them to come in this frame.
    fn advance(&mut self, step: f32, ahead: u32) {
        self.waited += step;
        self.delta = if ahead < self.most.max(1) { core::mem::take(&mut self.waited) } else { 0.0 };
        if self.delta > 0.0 {
            self.ticks = (self.delta / step).max(1.0);
        }
    }
}

/// All stages of a tick.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
struct PoseTick;

/// Orders the stages.
pub struct SchedulePlugin;

impl Plugin for SchedulePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PoseClock>().register_type::<PoseClock>();
        app.configure_sets(FixedUpdate, (MotionSystems::Decide, MotionSystems::Move).chain());
        app.configure_sets(FixedPostUpdate, PoseTick.after(PhysicsSystems::Last).run_if(poses_are_due))
            .add_systems(FixedPostUpdate, advance_clock.after(PhysicsSystems::Last).before(PoseTick));
        for stage in PoseSystems::TICK {
            app.configure_sets(FixedPostUpdate, stage.in_set(PoseTick));
        }
        for pair in PoseSystems::TICK.windows(2) {
            app.configure_sets(FixedPostUpdate, pair[0].before(pair[1]));
        }
        for stage in PoseSystems::FRAME {
            app.configure_sets(PostUpdate, stage.before(TransformSystems::Propagate));
        }
        for pair in PoseSystems::FRAME.windows(2) {
            app.configure_sets(PostUpdate, pair[0].before(pair[1]));
        }
    }
}

fn advance_clock(fixed: Res<Time<Fixed>>, mut clock: ResMut<PoseClock>) {
    let step = fixed.timestep();
    let ahead = fixed.overstep().as_nanos() / step.as_nanos().max(1);
    clock.advance(step.as_secs_f32(), u32::try_from(ahead).unwrap_or(u32::MAX));
}

fn poses_are_due(clock: Res<PoseClock>) -> bool {
    clock.delta > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f32 = 1.0 / 64.0;

    /// Seconds of the poses of one frame with so many ticks.
    fn frame(clock: &mut PoseClock, ticks: u32) -> Vec<f32> {
        let poses = (0..ticks).rev().map(|ahead| {
            clock.advance(STEP, ahead);
            clock.delta_secs()
        });
        poses.filter(|delta| *delta > 0.0).collect()
    }

    #[test]
    fn long_frames_are_posed_in_few_steps_and_no_time_is_lost() {
        let mut clock = PoseClock::default();
        assert_eq!(frame(&mut clock, 1), [STEP]);
        assert_eq!(frame(&mut clock, 3), [STEP; 3], "30 frames a second are posed tick by tick");
        assert_eq!(frame(&mut clock, 16), [14.0 * STEP, STEP, STEP], "a quarter of a second");
        clock.most = 1;
        assert_eq!(frame(&mut clock, 4), [4.0 * STEP]);
    }

    #[test]
    fn a_frame_lies_in_its_last_tick_whatever_was_posed_together() {
        let mut clock = PoseClock { most: 1, ..PoseClock::default() };
        frame(&mut clock, 1);
        let thousandths =
            |clock: &PoseClock, shares: [f32; 3]| shares.map(|share| (clock.share(share) * 1000.0).round() as u32);
        assert_eq!(thousandths(&clock, [0.0, 0.25, 1.0]), [0, 250, 1000]);
        frame(&mut clock, 4);
        assert_eq!(thousandths(&clock, [0.0, 0.5, 1.0]), [750, 875, 1000], "of four ticks the last");
    }
}
