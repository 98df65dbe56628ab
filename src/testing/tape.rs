//! What a player would press, over time.

use core::f32::consts::TAU;

use bevy::{math::ops, prelude::*};

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

/// Walking speed of tapes, m/s.
const WALK: f32 = 1.4;
/// Running speed of tapes, m/s.
const RUN: f32 = 3.5;

impl Tape {
    /// A tape of velocities in m/s, each from its second on.
    #[must_use]
    pub fn of(name: &str, seconds: f32, velocities: &[(f32, Vec3)]) -> Self {
        let cue = |&(at, velocity): &(f32, Vec3)| Cue { at, intent: MoveIntent { velocity, ..default() } };
        Self { name: name.to_owned(), cues: velocities.iter().map(cue).collect(), seconds }
    }

    /// The same, everything `seconds` later; until then what its first cue wants.
    #[must_use]
    pub fn later(&self, seconds: f32) -> Self {
        let cue = |cue: &Cue| Cue { at: cue.at + seconds, ..cue.clone() };
        Self { cues: self.cues.iter().map(cue).collect(), ..self.clone() }
    }

    /// Stands for a second, then walks along -Z.
    #[must_use]
    pub fn walk() -> Self {
        Self::of("walk", 7.0, &[(0.0, Vec3::ZERO), (1.0, Vec3::NEG_Z * WALK)])
    }

    /// Stands for a second, then runs along -Z.
    #[must_use]
    pub fn run() -> Self {
        Self::of("run", 6.0, &[(0.0, Vec3::ZERO), (1.0, Vec3::NEG_Z * RUN)])
    }

    /// Turns round and walks along +Z.
    #[must_use]
    pub fn walk_back() -> Self {
        Self::of("walk back", 6.0, &[(0.5, Vec3::Z * WALK)])
    }

    /// Stands.
    #[must_use]
    pub fn stand() -> Self {
        Self::of("stand", 3.0, &[(0.0, Vec3::ZERO)])
    }

    /// Walks and stops, a second each.
    #[must_use]
    pub fn start_stop() -> Self {
        let go = |index: usize| if index.is_multiple_of(2) { Vec3::NEG_Z * WALK } else { Vec3::ZERO };
        let cues: Vec<_> = (0..6).map(|index| (0.5 + index as f32, go(index))).collect();
        Self::of("start and stop", 7.0, &cues)
    }

    /// Walks, runs, walks.
    #[must_use]
    pub fn change_gait() -> Self {
        let (walk, run) = (Vec3::NEG_Z * WALK, Vec3::NEG_Z * RUN);
        Self::of("walk, run, walk", 7.0, &[(0.5, walk), (2.5, run), (4.5, walk)])
    }

    /// Walks in bends of 50° to both sides, 4 s each pair.
    #[must_use]
    pub fn s_curve() -> Self {
        let heading = |tenth: u16| 50f32.to_radians() * ops::sin(f32::from(tenth) * 0.1 * TAU / 4.0);
        let way =
            |tenth: u16| (0.5 + f32::from(tenth) * 0.1, Quat::from_rotation_y(heading(tenth)) * Vec3::NEG_Z * WALK);
        Self::of("S-curve", 7.0, &(0..65).map(way).collect::<Vec<_>>())
    }

    /// Walks and turns right round, twice.
    #[must_use]
    pub fn pivot() -> Self {
        let go = Vec3::NEG_Z * WALK;
        Self::of("180° pivot", 6.0, &[(0.5, go), (2.5, -go), (4.0, go)])
    }

    /// Aims along -Z all the time and walks right, back, left, forward.
    #[must_use]
    pub fn strafe() -> Self {
        let ways = [
            (0.0, Vec3::ZERO),
            (0.5, Vec3::X),
            (1.8, Vec3::Z),
            (3.1, Vec3::NEG_X),
            (4.4, Vec3::NEG_Z),
            (5.7, Vec3::ZERO),
        ];
        let cue = |(at, way): (f32, Vec3)| Cue {
            at,
            intent: MoveIntent { velocity: way * WALK, facing: Some(Vec3::NEG_Z), ..default() },
        };
        Self { name: "strafe while aiming".to_owned(), cues: ways.map(cue).to_vec(), seconds: 7.0 }
    }

    /// Jumps where it stands, in a walk and in a run.
    #[must_use]
    pub fn jump() -> Self {
        let cue = |(at, speed, jump): (f32, f32, bool)| Cue {
            at,
            intent: MoveIntent { velocity: Vec3::NEG_Z * speed, jump, ..default() },
        };
        let presses = [(0.5, 0.0), (3.0, WALK), (5.5, RUN)];
        let before = [(0.0, 0.0), (1.8, WALK), (4.2, RUN)];
        let cues = presses.iter().zip(before).flat_map(|(&(at, speed), (start, faster))| {
            [cue((start, faster, false)), cue((at, speed, true)), cue((at + 0.3, speed, false))]
        });
        Self { name: "jump".to_owned(), cues: cues.collect(), seconds: 7.5 }
    }

    /// Stands and turns: by 45°, 90° and 180°, then steadily by 60° a second.
    #[must_use]
    pub fn turning() -> Self {
        let steps = [(0.0, 0.0), (0.5, 45.0), (1.7, -45.0), (3.1, 135.0)];
        let steady = (0u16..50).map(|index| (4.6 + 0.05 * f32::from(index), 135.0 + 3.0 * f32::from(index)));
        let cue = |(at, degrees): (f32, f32)| Cue {
            at,
            intent: MoveIntent { facing: Some(Quat::from_rotation_y(degrees.to_radians()) * Vec3::NEG_Z), ..default() },
        };
        Self { name: "turning".to_owned(), cues: steps.into_iter().chain(steady).map(cue).collect(), seconds: 8.0 }
    }

    /// What is wanted at `seconds` from the start.
    #[must_use]
    pub fn intent_at(&self, seconds: f32) -> MoveIntent {
        self.cues.iter().rev().find(|cue| cue.at <= seconds).map_or_else(MoveIntent::default, |cue| cue.intent.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cues_are_in_order_of_time_and_end_before_the_tape() {
        for tape in [
            Tape::walk(),
            Tape::run(),
            Tape::start_stop(),
            Tape::change_gait(),
            Tape::s_curve(),
            Tape::pivot(),
            Tape::strafe(),
            Tape::jump(),
            Tape::turning(),
        ] {
            let times: Vec<f32> = tape.cues.iter().map(|cue| cue.at).collect();
            assert!(times.is_sorted() && times[0] >= 0.0, "{}: {times:?}", tape.name);
            assert!(times[times.len() - 1] < tape.seconds, "{} ends before its last cue", tape.name);
        }
    }
}
