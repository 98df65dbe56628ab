//! Runs courses, several at a time.

use std::{
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use bevy::prelude::*;

use super::Course;
use crate::{
    measure::{
        bars::{Bars, Breach, listed},
        frame::Frame,
        summary::{Measures, summarize_all},
    },
    rig::character::CharacterAsset,
    testing::stage::Stage,
};

/// A course to be run.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The course.
    pub course: Course,
    /// Whether feet are placed.
    pub foot_ik: bool,
}

/// What came of a job.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the ground.
    pub world: String,
    /// Name of the tape.
    pub tape: String,
    /// Whether feet were placed.
    pub foot_ik: bool,
    /// What was measured, all walkers together.
    pub measures: Measures,
    /// What it is held to.
    pub bars: Bars,
    /// What is over its bar.
    pub breaches: Vec<Breach>,
    /// What the first walker did.
    pub frames: Vec<Frame>,
}

/// Each course twice: with foot IK, then without.
#[must_use]
pub fn with_and_without(courses: Vec<Course>) -> Vec<Job> {
    let both = |course: Course| [true, false].map(|foot_ik| Job { course: course.clone(), foot_ik });
    courses.into_iter().flat_map(both).collect()
}

/// Seconds of standing before the recording.
const SETTLING: f32 = 0.5;

/// Runs all jobs with this character on all cores; `done` hears of each as it ends. Rows come in the order of `jobs`.
pub fn run(jobs: &[Job], character: &CharacterAsset, done: impl Fn(&Row) + Sync) -> Vec<Row> {
    let next = AtomicUsize::new(0);
    let rows = Mutex::new(Vec::with_capacity(jobs.len()));
    let work = || {
        while let Some((index, job)) = {
            let index = next.fetch_add(1, Ordering::Relaxed);
            jobs.get(index).map(|job| (index, job))
        } {
            let row = job.run(character);
            done(&row);
            rows.lock().unwrap_or_else(PoisonError::into_inner).push((index, row));
        }
    };
    thread::scope(|scope| {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        for _ in 0..cores.min(jobs.len()) {
            scope.spawn(work);
        }
    });
    let mut rows = rows.into_inner().unwrap_or_else(PoisonError::into_inner);
    rows.sort_by_key(|(index, _)| *index);
    rows.into_iter().map(|(_, row)| row).collect()
}

impl Job {
    /// Runs it.
    #[must_use]
    pub fn run(&self, character: &CharacterAsset) -> Row {
        let Course { world, tape, starts } = &self.course;
        let mut character = character.clone();
        character.file.foot_ik.enabled = self.foot_ik;
        let mut stage = Stage::on(world);
        let walkers = stage.spawn_loaded(character, starts);
        stage.run_for(SETTLING);
        for walker in &walkers {
            stage.start_recording(*walker);
        }
        stage.play_all(&walkers, tape);
        let runs: Vec<&[Frame]> = walkers.iter().map(|walker| stage.frames(*walker)).collect();
        let (measures, bars) = (summarize_all(&runs), world.bars());
        Row {
            world: world.name.clone(),
            tape: tape.name.clone(),
            foot_ik: self.foot_ik,
            breaches: bars.check(&measures),
            measures,
            bars,
            frames: runs.first().map(|frames| frames.to_vec()).unwrap_or_default(),
        }
    }
}

/// For tests: that no row is over a bar.
///
/// # Panics
/// When one is; the message lists every such row with all its breaches.
#[track_caller]
pub fn assert_within(rows: &[Row]) {
    let over: Vec<String> = rows
        .iter()
        .filter(|row| !row.breaches.is_empty())
        .map(|row| format!("\n{} / {}: {}", row.world, row.tape, listed(&row.breaches)))
        .collect();
    assert!(over.is_empty(), "{} of {} rows are over their bars:{}", over.len(), rows.len(), over.concat());
}
