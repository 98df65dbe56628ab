//! The locomotion state machine: states that play clips, transitions between them.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::standard;

/// The locomotion state machine.
#[derive(Reflect, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LocomotionConfig {
    /// States. The first is where a character starts. Default `None`: the [standard ones](super::standard), as far as
    /// their clips exist.
    pub states: Option<Vec<StateConfig>>,
    /// Transitions, tried in order; the first whose condition holds is taken. Default `None`: the standard ones, as far as
    /// their states exist; their speeds go with the root of the leg's length.
    pub transitions: Option<Vec<TransitionConfig>>,
    /// Slowest and fastest playback rate of a clip that follows the ground speed. Default (0.75, 1.2).
    ///
    /// Speeds beyond are reached by warping the stride. Narrow: strides shrink and stretch. Wide: legs whirl or crawl.
    pub rate_range: (f32, f32),
    /// Shortest and longest stride, as fractions of the clip's own. Default (0.3, 1.6).
    pub stride_range: (f32, f32),
    /// How much quicker, and shorter, steps become per unit of grade (rise over run), uphill and down. Default 0.9.
    ///
    /// 0: strides as on the level, which on stairs take three treads at once. Large: feet patter.
    pub climb_cadence: f32,
    /// Half-life, in seconds, in which a blend of clips follows the way that the character goes. Default 0.08.
    ///
    /// Short: a sudden sidestep jerks. Long: the feet slide until the blend has come round.
    pub blend_half_life: f32,
}

/// A state: what plays while the character is in it.
#[derive(Reflect, Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateConfig {
    /// Its name, for transitions and for looking at.
    pub name: String,
    /// The clip that plays: a name of the character's `clips`. Empty for a blend.
    #[serde(default)]
    pub clip: String,
    /// Instead of one clip, several gaits that go different ways: they are mixed by the way the character goes, as its
    /// body sees it. Where each one goes and how fast is read from its feet.
    #[serde(default)]
    pub blend: Vec<String>,
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
    /// By the turn: once through the clip while the character turns by `angle` over its ground. For turns on the spot.
    Turn {
        /// Degrees in RON, left positive.
        #[serde(with = "super::degrees")]
        angle: f32,
    },
}

impl StateConfig {
    /// Names of all clips that it plays.
    pub fn clips(&self) -> impl Iterator<Item = &str> {
        let single = (!self.clip.is_empty()).then_some(&self.clip);
        single.into_iter().chain(&self.blend).map(String::as_str)
    }
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
    /// Only the new one plays; the pose goes on as it moved and eases into it. Right for sudden changes such as landings.
    Inertialize,
    /// The same, but the new one's own motion is seen at once. Right for what bursts forth, such as a jump.
    Burst,
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
    /// A jump has just begun.
    Jumped,
    /// On the ground after a landing faster than this, in m/s.
    LandedFaster(f32),
    /// What it shall face is given (it aims), whatever way it goes.
    FacingLocked,
    /// It faces the way it goes.
    FacingFree,
    /// It still has to turn by more than this to the left to face what it shall, degrees in RON.
    TurnLeftAbove(#[serde(with = "super::degrees")] f32),
    /// The same to the right.
    TurnRightAbove(#[serde(with = "super::degrees")] f32),
    /// It faces what it shall, but for this, degrees in RON.
    TurnBelow(#[serde(with = "super::degrees")] f32),
    /// Longer in the state than this, in seconds.
    InStateFor(f32),
    /// The state's clip has played to its end.
    Finished,
    /// Crouching, as the controller has it.
    Crouched,
    /// Not crouching.
    Upright,
    /// `Locomotion::trigger` was called with this name.
    Trigger(String),
    /// All of these.
    All(#[reflect(ignore)] Vec<Condition>),
}

impl Condition {
    /// Multiplies speeds over ground.
    fn pace(&mut self, factor: f32) {
        match self {
            Self::SpeedAbove(speed) | Self::SpeedBelow(speed) => *speed *= factor,
            Self::All(conditions) => conditions.iter_mut().for_each(|condition| condition.pace(factor)),
            _ => {}
        }
    }
}

impl Default for LocomotionConfig {
    fn default() -> Self {
        Self {
            states: None,
            transitions: None,
            rate_range: (0.75, 1.2),
            stride_range: (0.3, 1.6),
            climb_cadence: 0.9,
            blend_half_life: 0.08,
        }
    }
}

impl LocomotionConfig {
    /// Its states; none while they are left to the standard ones.
    #[must_use]
    pub fn states(&self) -> &[StateConfig] {
        self.states.as_deref().unwrap_or_default()
    }

    /// Its transitions; none while they are left to the standard ones.
    #[must_use]
    pub fn transitions(&self) -> &[TransitionConfig] {
        self.transitions.as_deref().unwrap_or_default()
    }

    /// The same with every speed of its transitions times `factor`.
    #[must_use]
    pub fn paced(mut self, factor: f32) -> Self {
        for transition in self.transitions.iter_mut().flatten() {
            transition.when.pace(factor);
        }
        self
    }

    /// The same with standard lists in place of those left out: states whose clip exists, transitions between states that
    /// exist. Lists that are there stay as they are.
    #[must_use]
    pub fn completed(&self, has_clip: impl Fn(&str) -> bool) -> Self {
        let states = self.states.clone().unwrap_or_else(|| {
            let mut states = standard::states();
            for state in &mut states {
                state.blend.retain(|clip| has_clip(clip));
            }
            // Of ways to go, one is no choice.
            states.retain(|state| if state.clip.is_empty() { state.blend.len() > 1 } else { has_clip(&state.clip) });
            states
        });
        let exists = |name: &String| states.iter().any(|state| &state.name == name);
        let transitions = self.transitions.clone().unwrap_or_else(|| {
            let mut transitions = standard::transitions();
            transitions.retain_mut(|transition| {
                let from_any = transition.from.is_empty();
                transition.from.retain(exists);
                exists(&transition.to) && (from_any || !transition.from.is_empty())
            });
            transitions
        });
        Self { states: Some(states), transitions: Some(transitions), ..self.clone() }
    }
}
