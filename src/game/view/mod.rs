//! `surefoot view FILE`: any glTF model. Tells what was found in it, plays its clips, and walks it over the course.
//!
//! In a window by keys, without one as a contact sheet, or as words alone.

mod keys;
pub(super) mod playback;
mod report;
pub(super) mod skeleton;
pub(super) mod subject;
pub(super) mod weights;

use std::{path::PathBuf, process::ExitCode};

use bevy::prelude::*;
use clap::Args;

use self::subject::{Part, Subject};
use super::{
    FAILED, LACKS,
    cli::Options,
    film, open, outcome,
    preflight::{self, Missing, display, gpu},
};
use crate::testing::peer::{self, PeerError};

/// Flags of `surefoot view`.
#[derive(Args, Clone, Debug, Default, PartialEq, Eq)]
pub struct ViewOptions {
    /// The model: a .glb or .gltf file, its buffers and textures beside it.
    #[arg(value_name = "FILE")]
    pub file: PathBuf,
    /// Only prints what was found: joints, clips, and which joint plays which part of a body.
    #[arg(long, conflicts_with = "film")]
    pub check: bool,
    /// Also compares every joint of every clip with Bevy's own animation of the file; exits with 1 when one is off by more
    /// than 0.1 mm (on a figure 1.8 m high) or 0.05 degrees.
    #[arg(long, requires = "check")]
    pub against_bevy: bool,
    /// Films it into one contact sheet in the folder of --out instead of opening a window.
    #[arg(long)]
    pub film: bool,
}

/// Does what `view` asks for.
pub(super) fn run(view: &ViewOptions, options: &Options) -> ExitCode {
    let told = |error: &dyn core::fmt::Display, code: u8| {
        eprintln!("surefoot: {error}");
        ExitCode::from(code)
    };
    let subject = match Subject::load(&view.file) {
        Ok(subject) => subject,
        Err(error) => return told(&error, FAILED),
    };
    print!("{}", report::of(&subject));
    if view.check {
        return match check(view) {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::from(FAILED),
            Err(error) => told(&error, FAILED),
        };
    }
    let films = view.film || !display::exists();
    if films && !view.film {
        eprintln!("No display (neither DISPLAY nor WAYLAND_DISPLAY is set): filming a contact sheet instead.");
    }
    match show(&subject, options, films) {
        Ok(code) => code,
        Err(missing) => told(&missing, LACKS),
    }
}

/// Whether the file moves as in the engine, as far as that is asked for.
fn check(view: &ViewOptions) -> Result<bool, PeerError> {
    if !view.against_bevy {
        return Ok(true);
    }
    let comparison = peer::compare(&view.file)?;
    println!("{comparison}");
    Ok(comparison.holds())
}

fn show(subject: &Subject, options: &Options, films: bool) -> Result<ExitCode, Missing> {
    gpu::check()?;
    let assets = preflight::assets::find()?;
    if films {
        return Ok(match film::figure::run(subject, options, &assets) {
            Ok(sheet) => {
                println!("{}", sheet.display());
                ExitCode::SUCCESS
            }
            Err(error) => {
                eprintln!("surefoot: {error}");
                ExitCode::from(FAILED)
            }
        });
    }
    display::check()?;
    let mut app = open(options, subject.app(), &assets)?;
    subject.enter(&mut app, Part::Walker);
    // Without meshes there is nothing else to see.
    app.insert_resource(skeleton::ShowSkeleton(subject.rig.meshes.is_empty()));
    app.add_plugins((playback::plugin, skeleton::plugin, weights::plugin, keys::plugin));
    Ok(outcome(app.run()))
}
