//! The same tape at another frame rate: what differs from 60 frames a second.
//!
//! Both sides are measured at the same moments, 60 a second or as many as the slower one has frames: speeds and changes are
//! differences of frames, and half of them tell another speed.

use bevy::prelude::*;

use super::{Course, Runner, run::each};
use crate::{
    measure::{
        bars::Row,
        frame::Frame,
        summary::{Measures, summarize_all},
    },
    testing::stage::{Stage, StageError},
};

/// Frames a second that others are compared with.
const USUAL: f32 = 60.0;
/// Share of the larger of two figures by which they may differ.
const SHARE: f32 = 0.2;
/// Share of its bar below which a difference of a measure can't be told: poses between two frames are blended, and what falls
/// into one frame at one rate falls between two at another.
const NOISE: f32 = 0.1;
/// Seconds before a tape begins: whole frames at all rates, and within a tick, so that it is the same one at all of them.
const SETTLING: f32 = 2.0 / 3.0;
/// Seconds of the controller's ticks.
const TICK: f32 = 1.0 / 64.0;

/// A course at two frame rates.
#[derive(Clone, Debug)]
pub struct Alike {
    /// The ground's name.
    pub world: String,
    /// The tape's name.
    pub tape: String,
    /// The other frame rate.
    pub hertz: f32,
    /// Metres from where the tape ends at 60 frames a second to where it ends at the other.
    pub away: f32,
    /// Every measure that both have.
    pub pairs: Vec<Pair>,
}

/// One measure at two frame rates.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// What is measured, and its bar.
    pub row: Row,
    /// At 60 frames a second.
    pub usual: f32,
    /// At the other frame rate.
    pub other: f32,
    /// By how much it may differ.
    pub allowed: f32,
}

impl Pair {
    fn new(row: Row, other: Row, every: f32) -> Option<Self> {
        let (usual, other) = (row.value?, other.value?);
        let noise = match row.key {
            // An intent waits for the next tick, and what came of it for the next moment that is measured.
            "start_frames" => ((TICK + every) / every).round(),
            _ => NOISE * row.limit,
        };
        Some(Self { row, usual, other, allowed: noise.max(SHARE * usual.max(other)) })
    }

    /// Whether it differs by more than a fifth of the larger, however small both are.
    #[must_use]
    pub fn differs_at_all(&self) -> bool {
        (self.other - self.usual).abs() > SHARE * self.usual.max(self.other)
    }

    /// Whether it differs by more than a fifth of the larger and more than can be told.
    ///
    /// Less skate isn't counted: how high the last frame before a landing finds a foot decides whether it counts as sliding.
    #[must_use]
    pub fn differs(&self) -> bool {
        let more = self.other - self.usual;
        if self.row.key == "skate_cm_s" { more > self.allowed } else { more.abs() > self.allowed }
    }
}

/// Plays the course at 60 and at `hertz` frames a second, `starts` times each, every time the tape a little later within a
/// frame. The first walker alone.
///
/// # Errors
/// When a file can't be loaded.
pub fn compare(course: &Course, runner: &Runner, hertz: f32, starts: usize) -> Result<Alike, StageError> {
    let every = 1.0 / hertz.min(USUAL);
    let (usual_end, usual) = outcome(course, runner, (USUAL, every), starts)?;
    let (end, other) = outcome(course, runner, (hertz, every), starts)?;
    let bars = course.world.bars();
    let rows = bars.rows(&usual).into_iter().zip(bars.rows(&other));
    Ok(Alike {
        world: course.world.name.clone(),
        tape: course.tape.name.clone(),
        hertz,
        away: end.distance(usual_end),
        pairs: rows.filter_map(|(usual, other)| Pair::new(usual, other, every)).collect(),
    })
}

/// Compares each course at each of `rates`, several at a time; `done` hears of each as it ends.
///
/// # Errors
/// When a file can't be loaded.
pub fn compare_all(
    courses: &[Course],
    runner: &Runner,
    rates: &[f32],
    starts: usize,
    done: impl Fn() + Sync,
) -> Result<Vec<Alike>, StageError> {
    let jobs: Vec<_> = courses.iter().flat_map(|course| rates.iter().map(move |hertz| (course, *hertz))).collect();
    each(&jobs, |(course, hertz)| compare(course, runner, *hertz, starts), done)
}

/// Where the first run ends, and the figures of all runs together, measured `every` so many seconds.
fn outcome(
    course: &Course,
    runner: &Runner,
    (hertz, every): (f32, f32),
    starts: usize,
) -> Result<(Vec3, Measures), StageError> {
    let mut ends = Vec::with_capacity(starts);
    let mut runs: Vec<Vec<Frame>> = Vec::with_capacity(starts);
    for start in 0..starts {
        let mut stage = Stage::new(&course.world, &runner.assets);
        let places = &course.starts[..course.starts.len().min(1)];
        for walker in stage.spawn_loaded(runner.character.clone(), places) {
            stage.set_frame_rate(hertz);
            stage.run_for(SETTLING).record_every(walker, every).start_recording(walker);
            stage.play(walker, &course.tape.later(every * start as f32 / starts as f32));
            ends.push(stage.root(walker));
            runs.push(stage.frames(walker).to_vec());
        }
    }
    let frames: Vec<&[Frame]> = runs.iter().map(|run| &run[..]).collect();
    Ok((ends.first().copied().unwrap_or_default(), summarize_all(&frames)))
}
