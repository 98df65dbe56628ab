//! `MotionState` → clip weights and phase.
//!
//! Reads what the controller did and the clips' gaits; writes [`Locomotion`]: which clip weighs how much, where it is, and
//! for each foot what the clips say of its contact with the ground.

mod cues;
mod fade;
mod machine;

use bevy::prelude::*;

pub use cues::FootCue;
pub use fade::Fades;
pub use machine::{ClipFacts, Facts, Machine, Taken};

use super::{bind::CharacterAssets, motion::MotionState, schedule::PoseSystems};
use crate::{
    anim::pose::Pose,
    math::spring::damp,
    rig::character::{CharacterAsset, CharacterClip},
};

/// What plays: the state machine and what follows from it.
#[derive(Component, Clone, Debug)]
pub struct Locomotion {
    /// The machine, with weights and phases.
    pub machine: Machine,
    /// What the playing clips say of the left and right foot.
    pub cues: [FootCue; 2],
    /// The transition taken in this frame.
    pub taken: Option<Taken>,
    clips: Vec<usize>,
    landings: cues::Landings,
    triggers: Vec<String>,
    grade: f32,
    last_root: Option<Vec3>,
}

impl Locomotion {
    /// The machine of `asset`'s file. `scratch` is a pose of its skeleton; its content is lost.
    #[must_use]
    pub fn new(asset: &CharacterAsset, scratch: &mut Pose) -> Self {
        let states = &asset.file.locomotion.states;
        let clips: Vec<usize> = states.iter().map(|state| asset.clip_index(&state.clip).unwrap_or(0)).collect();
        let facts: Vec<ClipFacts> = clips
            .iter()
            .map(|&index| {
                let CharacterClip { clip, gait, .. } = &asset.clips()[index];
                ClipFacts {
                    duration: clip.duration,
                    looping: clip.looping,
                    stride: gait.stride * f32::from(gait.strides),
                }
            })
            .collect();
        let landings = cues::Landings::find(asset, &clips, scratch);
        *scratch = Pose::rest(&asset.skeleton);
        Self {
            machine: Machine::new(&asset.file.locomotion, &facts),
            cues: Default::default(),
            taken: None,
            clips,
            landings,
            triggers: Vec::new(),
            grade: 0.0,
            last_root: None,
        }
    }

    /// The clip that a state plays.
    #[must_use]
    pub fn clip<'a>(&self, asset: &'a CharacterAsset, state: usize) -> Option<&'a CharacterClip> {
        asset.clips().get(*self.clips.get(state)?)
    }

    /// Pulls a trigger: a transition that waits for `name` may be taken in the next frame.
    pub fn trigger(&mut self, name: impl Into<String>) {
        self.triggers.push(name.into());
    }

    /// Name of the state that the machine is in.
    #[must_use]
    pub fn state(&self) -> &str {
        if self.machine.is_empty() { "" } else { self.machine.name(self.machine.current()) }
    }

    /// Weight of the state named `name`; 0 for an unknown one.
    #[must_use]
    pub fn weight_of(&self, name: &str) -> f32 {
        (0..self.machine.len()).filter(|i| self.machine.name(*i) == name).map(|i| self.machine.weight(i)).sum()
    }
}

impl Locomotion {
    /// Rise over run of the root's way, smoothed.
    fn follow_grade(&mut self, root: Vec3, dt: f32) {
        let last = self.last_root.replace(root).unwrap_or(root);
        let way = root - last;
        let run = Vec2::new(way.x, way.z).length();
        let grade = if run > 0.1 * dt { (way.y / run).clamp(-1.0, 1.0) } else { 0.0 };
        self.grade = damp(self.grade, grade, GRADE_HALF_LIFE, dt);
    }

    /// Phase of a state's clip by its gait: 0 is left contact.
    fn gait_phase(&self, asset: &CharacterAsset, state: usize) -> f32 {
        let phase = self.machine.clip_phase(state);
        match self.clip(asset, state) {
            Some(CharacterClip { clip, gait, .. }) if !self.machine.is_gait(state) => {
                gait.phase_at(phase * clip.duration, clip.duration)
            }
            _ => phase,
        }
    }
}

/// Half-life in seconds over which the grade of the way is found.
const GRADE_HALF_LIFE: f32 = 0.15;

/// Runs the locomotion state machines.
pub struct LocomotionPlugin;

impl Plugin for LocomotionPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, locomote.in_set(PoseSystems::Locomote));
    }
}

fn locomote(
    time: Res<Time>,
    assets: CharacterAssets,
    mut characters: Query<(&super::Character, &Transform, &MotionState, &mut Locomotion)>,
) {
    let dt = time.delta_secs();
    characters.par_iter_mut().for_each(|(character, root, motion, mut locomotion)| {
        let Some(asset) = assets.get(character) else { return };
        let locomotion = &mut *locomotion;
        locomotion.follow_grade(root.translation, dt);
        let facts = Facts {
            grade: locomotion.grade,
            speed: Vec2::new(motion.ground_velocity.x, motion.ground_velocity.z).length(),
            grounded: motion.ground.is_some(),
            air_time: motion.air_time,
            fall_speed: -motion.velocity.y,
            crouched: motion.crouched,
            triggers: &locomotion.triggers,
        };
        locomotion.taken = locomotion.machine.advance(&facts, dt);
        locomotion.triggers.clear();
        for foot in 0..2 {
            locomotion.cues[foot] = cues::cue(locomotion, asset, foot);
        }
    });
}
