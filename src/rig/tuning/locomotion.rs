//! The locomotion state machine: states that play clips, transitions between them.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// The locomotion state machine.
#[derive(Reflect, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LocomotionConfig {
    /// States. The first is where a character starts.
    pub states: Vec<StateConfig>,
    /// Transitions, tried in order; the first whose condition holds is taken.
    pub transitions: Vec<TransitionConfig>,
    /// Slowest and fastest playback rate of a clip that follows the ground speed. Default (0.75, 1.25).
    ///
    /// Speeds beyond are reached by warping the stride. Narrow: strides shrink and stretch. Wide: legs whirl or crawl.
    pub rate_range: (f32, f32),
    /// Shortest and longest stride, as fractions of the clip's own. Default (0.3, 1.6).
    pub stride_range: (f32, f32),
    /// How much quicker, and shorter, steps become per unit of grade (rise over run), uphill and down. Default 0.9.
    ///
    /// 0: strides as on the level, which on stairs take three treads at once. Large: feet patter.
    pub climb_cadence: f32,
}

/// A state: what plays while the character is in it.
#[derive(Reflect, Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateConfig {
    /// Its name, for transitions and for looking at.
    pub name: String,
    /// The clip that plays: a name of the character's `clips`.
    pub clip: String,
    /// How the clip's time runs.
    #[serde(default)]
    pub pace: Pace,
}

/// How a state's clip runs.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Pace {
    /// At its own rate, from its start whenever the state is entered. The default.
    #[default]
    Clock,
    /// By the feet: one stride of ground for one stride of the clip. All such states share one phase, so that a change
    /// of gait keeps the feet in step.
    Gait {
        /// Phase 0..1 from which the gait starts when it is entered from standing; 0 is left contact.
        start_phase: f32,
    },
}

/// A way from state to state.
#[derive(Reflect, Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransitionConfig {
    /// States it leaves; empty means any.
    #[serde(default)]
    pub from: Vec<String>,
    /// The state it enters.
    pub to: String,
    /// When it is taken.
    pub when: Condition,
    /// Seconds that the change takes. Default 0.2.
    #[serde(default = "default_fade")]
    pub fade: f32,
    /// How the change looks.
    #[serde(default)]
    pub blend: TransitionBlend,
}

fn default_fade() -> f32 {
    0.2
}

/// How one state's pose becomes another's.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TransitionBlend {
    /// Both play, weights move over. The default; right between gaits that share a phase.
    #[default]
    CrossFade,
    /// Only the new one plays, the old pose's offset decays. Right for sudden changes such as landings.
    Inertialize,
}

/// When a transition is taken.
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Condition {
    /// Ground speed above, in m/s. Together with a lower [`Condition::SpeedBelow`] the other way this is a hysteresis.
    SpeedAbove(f32),
    /// Ground speed below, in m/s.
    SpeedBelow(f32),
    /// On the ground.
    Grounded,
    /// Off the ground for longer than this, in seconds.
    AirborneFor(f32),
    /// Falling faster than this, in m/s, downward positive.
    FallingFaster(f32),
    /// Longer in the state than this, in seconds.
    InStateFor(f32),
    /// The state's clip has played to its end.
    Finished,
    /// Crouching, as the controller has it.
    Crouched,
    /// Not crouching.
    Upright,
    /// `Animator::trigger` was called with this name.
    Trigger(String),
    /// All of these.
    All(#[reflect(ignore)] Vec<Condition>),
}

impl Default for LocomotionConfig {
    fn default() -> Self {
        let state = |name: &str, pace| StateConfig { name: name.to_owned(), clip: name.to_owned(), pace };
        let change = |from: &str, to: &str, when, fade| TransitionConfig {
            from: vec![from.to_owned()],
            to: to.to_owned(),
            when,
            fade,
            blend: TransitionBlend::CrossFade,
        };
        Self {
            states: vec![
                state("idle", Pace::Clock),
                state("walk", Pace::Gait { start_phase: 0.14 }),
                state("run", Pace::Gait { start_phase: 0.05 }),
            ],
            transitions: vec![
                change("idle", "run", Condition::SpeedAbove(2.4), 0.2),
                change("idle", "walk", Condition::SpeedAbove(0.15), 0.2),
                change("walk", "run", Condition::SpeedAbove(2.4), 0.25),
                change("run", "walk", Condition::SpeedBelow(2.0), 0.25),
                change("walk", "idle", Condition::SpeedBelow(0.08), 0.25),
            ],
            rate_range: (0.75, 1.25),
            stride_range: (0.3, 1.6),
            climb_cadence: 0.9,
        }
    }
}
