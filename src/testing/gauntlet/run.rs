//! Runs courses, several at a time.

use std::{
    path::{Path, PathBuf},
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use super::{Course, built_in};
use crate::{
    measure::{
        bars::{Bars, Breach, listed},
        frame::Frame,
        summary::{Measures, summarize_all},
    },
    rig::character::CharacterAsset,
    testing::{
        stage::{Stage, StageError},
        world::World,
    },
};

/// Who runs: a character's file, and the folder that its paths start at.
#[derive(Clone, Debug)]
pub struct Runner {
    /// The character.
    pub character: CharacterAsset,
    /// The folder of assets.
    pub assets: PathBuf,
}

impl Runner {
    /// The character of `file`, a path in the folder `assets`.
    ///
    /// # Errors
    /// When it can't be loaded.
    pub fn load(assets: &Path, file: &str) -> Result<Self, StageError> {
        let character = Stage::new(&World::flat(), assets).load_character(file)?;
        Ok(Self { character, assets: assets.to_path_buf() })
    }

    /// This crate's mannequin, from its source folder.
    ///
    /// # Errors
    /// When it can't be loaded.
    pub fn mannequin() -> Result<Self, StageError> {
        Self::load(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/assets")), "mannequin.character.ron")
    }
}

/// What moves the body's joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Feet {
    /// This crate's animation, its feet placed by foot IK.
    Placed,
    /// This crate's animation without foot IK.
    AsClips,
    /// Bevy's own `AnimationPlayer` and graph with the same clips, as a game without this crate has them.
    BuiltIn,
}

/// A course to be run.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// The course.
    pub course: Course,
    /// What moves the joints.
    pub feet: Feet,
}

/// What came of a job.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the ground.
    pub world: String,
    /// Name of the tape.
    pub tape: String,
    /// What moved the joints.
    pub feet: Feet,
    /// What was measured, all walkers together.
    pub measures: Measures,
    /// What it is held to.
    pub bars: Bars,
    /// What is over its bar.
    pub breaches: Vec<Breach>,
    /// What the first walker did.
    pub frames: Vec<Frame>,
}

/// Each course once for each of `feet`, in this order.
#[must_use]
pub fn jobs(courses: &[Course], feet: &[Feet]) -> Vec<Job> {
    let each =
        |course: &Course| feet.iter().map(|feet| Job { course: course.clone(), feet: *feet }).collect::<Vec<_>>();
    courses.iter().flat_map(each).collect()
}

/// Seconds of standing before the recording.
const SETTLING: f32 = 0.5;

/// Runs all jobs on all cores; `done` hears of each as it ends. Rows come in the order of `jobs`.
///
/// # Errors
/// When a job needs a file that can't be loaded.
pub fn run(jobs: &[Job], runner: &Runner, done: impl Fn() + Sync) -> Result<Vec<Row>, StageError> {
    each(jobs, |job| job.run(runner), done)
}

/// What `work` makes of each job, on all cores, in the order of `jobs`.
pub(super) fn each<J: Sync, R: Send>(
    jobs: &[J],
    work: impl Fn(&J) -> Result<R, StageError> + Sync,
    done: impl Fn() + Sync,
) -> Result<Vec<R>, StageError> {
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::with_capacity(jobs.len()));
    let take = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(index) else { break };
            let result = work(job);
            done();
            results.lock().unwrap_or_else(PoisonError::into_inner).push((index, result));
        }
    };
    thread::scope(|scope| {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        for _ in 0..cores.min(jobs.len()) {
            scope.spawn(take);
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

impl Job {
    /// Runs it.
    ///
    /// # Errors
    /// When it needs a file that can't be loaded.
    pub fn run(&self, runner: &Runner) -> Result<Row, StageError> {
        let Course { world, tape, starts } = &self.course;
        let (mut stage, walkers) = match self.feet {
            Feet::Placed | Feet::AsClips => {
                let mut character = runner.character.clone();
                character.file.foot_ik.enabled = self.feet == Feet::Placed;
                let mut stage = Stage::new(world, &runner.assets);
                let walkers = stage.spawn_loaded(character, starts);
                (stage, walkers)
            }
            Feet::BuiltIn => built_in::stage(world, runner, starts)?,
        };
        stage.run_for(SETTLING);
        for walker in &walkers {
            stage.start_recording(*walker);
        }
        stage.play_all(&walkers, tape);
        let runs: Vec<&[Frame]> = walkers.iter().map(|walker| stage.frames(*walker)).collect();
        let (measures, bars) = (summarize_all(&runs), world.bars());
        Ok(Row {
            world: world.name.clone(),
            tape: tape.name.clone(),
            feet: self.feet,
            breaches: bars.check(&measures),
            measures,
            bars,
            frames: runs.first().map(|frames| frames.to_vec()).unwrap_or_default(),
        })
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
