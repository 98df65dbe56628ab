//! Runs the gauntlet and prints its table; writes it as JSON, and one figure a row. Needs neither display nor GPU.

mod json;
mod plot;
mod rates;
mod readme;
mod table;

use std::{
    fs, io,
    path::{Path, PathBuf},
    time::Duration,
};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use thiserror::Error;

use crate::testing::{
    StageError,
    gauntlet::{Course, Feet, Row, Runner, courses, jobs, rates::compare_all, run as run_all},
};

/// Flags of `surefoot gauntlet`.
#[derive(Args, Clone, Debug, Default, PartialEq, Eq)]
pub struct GauntletOptions {
    /// Writes all rows to FILE: worlds, tapes, measures, bars and whether they hold.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Measures another character; paths in its file start at the folder it lies in.
    #[arg(long, value_name = "FILE.character.ron")]
    pub character: Option<PathBuf>,
    /// Only rows whose "world tape" holds TEXT, such as "stairs" or "hills walk".
    #[arg(long, value_name = "TEXT")]
    pub only: Option<String>,
    /// Draws one figure a row into DIR: feet, ground, plants and pelvis over time, as SVG.
    #[arg(long, value_name = "DIR", num_args = 0..=1, default_missing_value = "target/gauntlet")]
    pub plot: Option<PathBuf>,
    /// Runs the few rows that a README shows and writes their table into FILE, between its marks.
    #[arg(long, value_name = "FILE", conflicts_with = "only", num_args = 0..=1, default_missing_value = "README.md")]
    pub readme: Option<PathBuf>,
    /// Instead plays each row at 30 and 144 frames a second, too, and prints what differs from 60.
    #[arg(long, conflicts_with_all = ["json", "plot", "readme", "strict"])]
    pub frame_rates: bool,
    /// Exits with 1 when a row with foot IK is over a bar.
    #[arg(long)]
    pub strict: bool,
}

/// Why there is no table.
#[derive(Error, Debug)]
pub enum GauntletError {
    /// The character could not be loaded.
    #[error(transparent)]
    Character(#[from] StageError),
    /// `--character` names no file.
    #[error("{} is no file", .0.display())]
    NoFile(PathBuf),
    /// `--only` leaves nothing.
    #[error("no row holds `{text}`; worlds: {worlds}; tapes: {tapes}")]
    NoRow {
        /// What was looked for.
        text: String,
        /// All worlds.
        worlds: String,
        /// All tapes.
        tapes: String,
    },
    /// A file could not be written.
    #[error("{}: {reason}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
}

impl GauntletError {
    fn file(path: &Path, reason: impl ToString) -> Self {
        Self::File { path: path.to_path_buf(), reason: reason.to_string() }
    }
}

/// The character's file that is measured when none is named, in the folder of assets.
const MANNEQUIN: &str = "mannequin.character.ron";

/// Frames a second that `--frame-rates` compares with 60, and how often each plays a tape.
const RATES: [f32; 2] = [30.0, 144.0];
const STARTS: usize = 4;

/// Runs what `options` ask for, with the mannequin of the folder `assets` unless they name another character.
///
/// Gives whether every row with foot IK holds its bars.
///
/// # Errors
/// [`GauntletError`]: nothing to run, or a file that can't be read or written.
pub fn run(options: &GauntletOptions, assets: &Path) -> Result<bool, GauntletError> {
    let mut courses = chosen(courses(), options.only.as_deref())?;
    if options.readme.is_some() {
        courses.retain(readme::shows);
    }
    let runner = load(options.character.as_deref(), assets)?;
    if options.frame_rates {
        let bar = progress(courses.len() * RATES.len());
        let rows = compare_all(&courses, &runner, &RATES, STARTS, || tick(&bar))?;
        bar.finish_and_clear();
        print!("{}", rates::Rates(&rows));
        return Ok(true);
    }
    let rows = measured(&courses, &runner)?;
    print!("{}", table::Comparison(&rows));
    if let Some(file) = &options.json {
        write(file, &json::text(&rows))?;
    }
    if let Some(file) = &options.readme {
        let text = fs::read_to_string(file).map_err(|error| GauntletError::file(file, error))?;
        let text =
            readme::updated(&text, &rows).ok_or_else(|| GauntletError::file(file, "no marks to write between"))?;
        write(file, &text)?;
    }
    if let Some(folder) = &options.plot {
        for row in &rows {
            let file = folder.join(plot::file_name(row));
            let figure = plot::figure(row).map_err(|error| GauntletError::file(&file, error))?;
            write(&file, &figure)?;
        }
        println!("{} figures in {}", rows.len(), folder.display());
    }
    Ok(rows.iter().all(|row| row.feet != Feet::Placed || row.breaches.is_empty()))
}

/// All rows of these courses: with foot IK, without, and as Bevy's own player animates, if it can play this character.
fn measured(courses: &[Course], runner: &Runner) -> Result<Vec<Row>, GauntletError> {
    let all = [Feet::Placed, Feet::AsClips, Feet::BuiltIn];
    let feet = if plays_built_in(runner) { &all[..] } else { &all[..2] };
    let jobs = jobs(courses, feet);
    let bar = progress(jobs.len());
    let rows = run_all(&jobs, runner, || tick(&bar))?;
    bar.finish_and_clear();
    Ok(rows)
}

/// Whether the character's model itself has the clips that Bevy's player would play: it can't borrow those of other files.
fn plays_built_in(runner: &Runner) -> bool {
    ["idle", "walk", "run"].iter().all(|name| runner.character.rig.clip(name).is_some())
}

/// The courses whose world and tape hold `text`.
fn chosen(courses: Vec<Course>, text: Option<&str>) -> Result<Vec<Course>, GauntletError> {
    let Some(text) = text else { return Ok(courses) };
    let holds = |course: &Course| format!("{} {}", course.world.name, course.tape.name).contains(text);
    let listed = |name: fn(&Course) -> &String| {
        let mut names: Vec<&str> = Vec::new();
        for course in &courses {
            if !names.contains(&name(course).as_str()) {
                names.push(name(course));
            }
        }
        names.join(", ")
    };
    let error = || GauntletError::NoRow {
        text: text.to_owned(),
        worlds: listed(|course| &course.world.name),
        tapes: listed(|course| &course.tape.name),
    };
    let chosen: Vec<Course> = courses.iter().filter(|course| holds(course)).cloned().collect();
    if chosen.is_empty() { Err(error()) } else { Ok(chosen) }
}

fn load(file: Option<&Path>, assets: &Path) -> Result<Runner, GauntletError> {
    let (folder, name) = match file {
        None => (assets.to_path_buf(), MANNEQUIN.to_owned()),
        Some(file) => {
            let no_file = || GauntletError::NoFile(file.to_path_buf());
            // Whole, since the asset server starts at the program's own folder.
            let whole = file.canonicalize().ok().filter(|file| file.is_file()).ok_or_else(no_file)?;
            let name = whole.file_name().ok_or_else(no_file)?.to_string_lossy().into_owned();
            (whole.parent().unwrap_or(Path::new("/")).to_path_buf(), name)
        }
    };
    Ok(Runner::load(&folder, &name)?)
}

fn write(file: &Path, text: &str) -> Result<(), GauntletError> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    let written: io::Result<()> = folder.map_or(Ok(()), fs::create_dir_all).and_then(|()| fs::write(file, text));
    written.map_err(|error| GauntletError::file(file, error))
}

fn progress(count: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("running {bar:40} {pos}/{len}, {eta} left");
    let bar = ProgressBar::new(count as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar.enable_steady_tick(Duration::from_millis(500));
    bar
}

/// Shows progress: a bar on a terminal, else a line every tenth of the way.
fn tick(bar: &ProgressBar) {
    bar.inc(1);
    let (done, count) = (bar.position(), bar.length().unwrap_or(1).max(1));
    if bar.is_hidden() && done * 10 / count > (done - 1) * 10 / count {
        eprintln!("running {done}/{count}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_rows_that_hold_the_text_are_run() {
        let stairs = chosen(courses(), Some("stairs up w")).unwrap();
        let names: Vec<_> = stairs.iter().map(|course| (&*course.world.name, &*course.tape.name)).collect();
        assert_eq!(names, [("stairs up", "walk")]);
        let error = chosen(courses(), Some("swamp")).unwrap_err().to_string();
        assert!(error.contains("`swamp`") && error.contains("rubble") && error.contains("S-curve"), "{error}");
    }

    #[test]
    fn a_character_that_is_not_there_is_named() {
        let error = load(Some(Path::new("nobody.character.ron")), Path::new("assets")).unwrap_err().to_string();
        assert_eq!(error, "nobody.character.ron is no file");
    }
}
