//! What a player would press, over time.

use bevy::prelude::*;

use crate::character::intent::MoveIntent;

/// From a moment on: this intent.
#[derive(Clone, Debug, PartialEq)]
pub struct Cue {
    /// Seconds from the tape's start.
    pub at: f32,
    /// What is wanted from then on.
    pub intent: MoveIntent,
}

/// What a player would press, over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Tape {
    /// For tables and failures.
    pub name: String,
    /// In order of time.
    pub cues: Vec<Cue>,
    /// Seconds that the tape lasts.
    pub seconds: f32,
}

impl Tape {
    /// A tape of velocities in m/s, each from its second on.
    #[must_use]
    pub fn of(name: &str, seconds: f32, velocities: &[(f32, Vec3)]) -> Self {
        let cue = |&(at, velocity): &(f32, Vec3)| Cue { at, intent: MoveIntent { velocity, ..default() } };
        Self { name: name.to_owned(), cues: velocities.iter().map(cue).collect(), seconds }
    }

    /// Stands for a second, then walks along -Z.
    #[must_use]
    pub fn walk() -> Self {
        Self::of("walk", 7.0, &[(0.0, Vec3::ZERO), (1.0, Vec3::NEG_Z * 1.4)])
    }

    /// Stands for a second, then runs along -Z.
    #[must_use]
    pub fn run() -> Self {
        Self::of("run", 6.0, &[(0.0, Vec3::ZERO), (1.0, Vec3::NEG_Z * 3.5)])
    }

    /// Stands.
    #[must_use]
    pub fn stand() -> Self {
        Self::of("stand", 3.0, &[(0.0, Vec3::ZERO)])
    }

    /// Walks and stops, a second each.
    #[must_use]
    pub fn start_stop() -> Self {
        let go = Vec3::NEG_Z * 1.4;
        Self::of(
            "start and stop",
            7.0,
            &[(0.5, go), (1.5, Vec3::ZERO), (2.5, go), (3.5, Vec3::ZERO), (4.5, go), (5.5, Vec3::ZERO)],
        )
    }

    /// Walks, runs, walks.
    #[must_use]
    pub fn change_gait() -> Self {
        let (walk, run) = (Vec3::NEG_Z * 1.4, Vec3::NEG_Z * 3.5);
        Self::of("walk, run, walk", 7.0, &[(0.5, walk), (2.5, run), (4.5, walk)])
    }

    /// Walks and turns right round.
    #[must_use]
    pub fn pivot() -> Self {
        Self::of("180° pivot", 6.0, &[(0.5, Vec3::NEG_Z * 1.4), (2.5, Vec3::Z * 1.4), (4.0, Vec3::NEG_Z * 1.4)])
    }

    /// What is wanted at `seconds` from the start.
    #[must_use]
    pub fn intent_at(&self, seconds: f32) -> MoveIntent {
        self.cues.iter().rev().find(|cue| cue.at <= seconds).map_or_else(MoveIntent::default, |cue| cue.intent.clone())
    }
}
