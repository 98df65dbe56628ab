//! Films a walk over the course: PNG frames, one contact sheet, and the table of measures. Needs no display.
//!
//! The walk is stepped 60 times a second whatever the film's frame rate, so every film of one seed shows the same walk.

pub(super) mod figure;
pub mod frames;
pub mod lettering;
mod operator;
pub mod route;
pub mod scenes;
pub mod sheet;
pub mod shots;
pub mod shutter;
mod stage;
pub mod table;
mod walk;

use std::{
    path::{Path, PathBuf},
    time::{Duration, Instant},
};

use bevy::prelude::*;
use indicatif::{ProgressBar, ProgressStyle};
use thiserror::Error;

use super::{
    cli::Options,
    engine::{self, TICKS_PER_SECOND},
    level::{self, Loading},
    telemetry,
};
use frames::FrameWriter;
use sheet::ContactSheet;
use shutter::{ShutterPlugin, developed, expose};

/// Width and height of a picture, pixels: two cores without a GPU draw three of these in about a second.
const SIZE: UVec2 = UVec2::new(960, 540);
/// Updates within which a picture must have come back from the renderer.
const PATIENCE: u32 = 100;
/// Seconds of wall time within which the assets must be there.
const LOADING_TIME: Duration = Duration::from_secs(120);
/// Name of the contact sheet in the film's folder.
const SHEET: &str = "contact_sheet.png";

/// Why there is no film.
#[derive(Error, Debug)]
pub enum FilmError {
    /// A file or folder could not be written.
    #[error("{}: {reason}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// A thread that writes pictures ended early.
    #[error("writing the pictures stopped half-way")]
    Writer,
    /// No scene has this name.
    #[error("no scene is called {0}")]
    Scene(String),
    /// The character could not be loaded.
    #[error("the level did not load: {0}")]
    Loading(String),
    /// The renderer gave no picture.
    #[error("the renderer gave no picture of frame {0}")]
    NoPicture(usize),
}

impl FilmError {
    fn file(path: &Path, reason: impl ToString) -> Self {
        Self::File { path: path.to_path_buf(), reason: reason.to_string() }
    }
}

/// Films as `options` say, with the assets of the folder `assets`.
///
/// # Errors
/// [`FilmError`]: nothing loaded, or nothing could be written.
pub fn run(options: &Options, assets: &Path) -> Result<(), FilmError> {
    if let Some(scene) = &options.scene {
        return stage::run(scene, options, assets);
    }
    let began = Instant::now();
    let writer = FrameWriter::start(&options.out)?;
    let mut app = studio(options, assets);
    load(&mut app)?;

    let count = frame_count(options.seconds, options.fps);
    let mut sheet = ContactSheet::new(count);
    let mut captions = Vec::with_capacity(count);
    let mut written = 0;
    let bar = progress(count);
    for frame in 0..count {
        expose(&mut app, frame, TICKS_PER_SECOND / options.fps);
        captions.push(walk::caption(app.world_mut(), (frame + 1) as f32 / options.fps as f32));
        written += develop(&mut app, &writer, &mut sheet, &captions);
        tick(&bar, written, count);
    }
    for _ in 0..PATIENCE {
        if written == count {
            break;
        }
        app.update();
        written += develop(&mut app, &writer, &mut sheet, &captions);
        tick(&bar, written, count);
    }
    bar.finish_and_clear();
    if written < count {
        return Err(FilmError::NoPicture(written));
    }
    writer.finish()?;
    if let Some(sheet) = sheet.compose() {
        frames::save(&options.out.join(SHEET), &sheet)?;
    }
    let seconds = began.elapsed().as_secs_f32();
    println!("{}", walk::measures(app.world_mut()));
    println!("{count} pictures and {SHEET} in {} after {seconds:.0} s", options.out.display());
    Ok(())
}

/// Pictures of a film, at least one.
fn frame_count(seconds: f32, fps: u32) -> usize {
    ((seconds * fps as f32).round() as usize).max(1)
}

/// An app with the level, a walker and a camera that draws into a picture.
fn studio(options: &Options, assets: &Path) -> App {
    let mut app = engine::headless(assets);
    app.insert_resource(level::Seed(options.seed)).add_plugins((
        ShutterPlugin { size: options.size.unwrap_or(SIZE) },
        level::plugin,
        walk::plugin,
        telemetry::plugin,
    ));
    super::open_telemetry(&mut app, options);
    engine::finish(&mut app);
    app
}

/// Updates, with time standing still, until the level is complete.
fn load(app: &mut App) -> Result<(), FilmError> {
    let began = Instant::now();
    loop {
        app.update();
        match app.world().resource::<Loading>() {
            Loading::Done => return Ok(()),
            Loading::Failed(reason) => return Err(FilmError::Loading(reason.clone())),
            Loading::Waiting if began.elapsed() > LOADING_TIME => {
                return Err(FilmError::Loading(format!("nothing came within {} s", LOADING_TIME.as_secs())));
            }
            Loading::Waiting => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

/// Hands finished pictures to writer and sheet; returns how many.
fn develop(app: &mut App, writer: &FrameWriter, sheet: &mut ContactSheet, captions: &[String]) -> usize {
    let pictures = developed(app);
    let count = pictures.len();
    for (frame, picture) in pictures {
        if sheet.wants(frame) {
            sheet.add(frame, picture.clone(), captions[frame].clone());
        }
        writer.write(frame, picture);
    }
    count
}

fn progress(count: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("filming {bar:40} {pos}/{len}, {eta} left");
    ProgressBar::new(count as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Shows progress: a bar on a terminal, else a line every tenth of the way.
fn tick(bar: &ProgressBar, written: usize, count: usize) {
    let before = usize::try_from(bar.position()).unwrap_or(0);
    bar.set_position(written as u64);
    if bar.is_hidden() && written * 10 / count > before * 10 / count {
        eprintln!("filming {written}/{count}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twenty_seconds_are_six_hundred_pictures_and_an_instant_is_one() {
        assert_eq!([frame_count(20.0, 30), frame_count(0.1, 1)], [600, 1]);
    }
}
