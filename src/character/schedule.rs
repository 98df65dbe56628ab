//! The spine: every stage of a character, in order, once. Other files only say `.in_set(…)`.

use bevy::prelude::*;

/// Fixed clock (`FixedUpdate`): deterministic, the same for every frame rate.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionSystems {
    /// Players, AI and tests write `MoveIntent`.
    Decide,
    /// The controller turns `MoveIntent` into a moved root and `MotionState`.
    Move,
}

/// Frame clock (`PostUpdate`, before transforms propagate): exact in dt, on the interpolated root.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PoseSystems {
    /// `MotionState` → clip weights and phase.
    Locomote,
    /// Who is posed in this frame.
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
    /// Targets → joints of IK chains.
    Reach,
    /// Poses of those that aren't posed in every frame → local and model pose of all joints.
    Ease,
    /// Model pose → what rides on it.
    Attach,
    /// Model pose → skinning matrices.
    Palette,
}

impl PoseSystems {
    /// All stages, in order.
    pub const ALL: [Self; 11] = [
        Self::Locomote,
        Self::Pace,
        Self::Sample,
        Self::Plant,
        Self::Look,
        Self::Model,
        Self::Aim,
        Self::Reach,
        Self::Ease,
        Self::Attach,
        Self::Palette,
    ];
}

/// Orders the stages.
pub struct SchedulePlugin;

impl Plugin for SchedulePlugin {
    fn build(&self, app: &mut App) {
        app.configure_sets(FixedUpdate, (MotionSystems::Decide, MotionSystems::Move).chain());
        for pair in PoseSystems::ALL.windows(2) {
            app.configure_sets(PostUpdate, pair[0].before(pair[1]));
        }
        for stage in PoseSystems::ALL {
            app.configure_sets(PostUpdate, stage.before(TransformSystems::Propagate));
        }
    }
}
