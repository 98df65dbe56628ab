//! Layer 5: the game. Joins input, level, camera, HUD and film to the layers below; one plugin per file.

pub mod cli;
mod debug;
pub mod engine;
pub mod film;
pub mod gauntlet;
mod hud;
mod input;
mod level;
mod look;
pub mod preflight;
mod shell;
mod taps;
mod telemetry;
pub mod touch;
pub mod view;

use std::{
    panic::{self, AssertUnwindSafe},
    path::Path,
    process::ExitCode,
};

use bevy::prelude::*;
use clap::Parser;

use cli::{Cli, Command, Options};
use preflight::{Missing, display, gpu};

/// Exit code when the machine lacks something.
const LACKS: u8 = 3;
/// Exit code when the film or the gauntlet went wrong.
const FAILED: u8 = 1;
/// Width and height of the window, pixels.
const WINDOW_SIZE: UVec2 = UVec2::new(1280, 720);

/// Reads the command line and does what it says.
#[must_use]
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    if let Some(Command::Gauntlet(options)) = &cli.command {
        return run_gauntlet(options);
    }
    if let Some(Command::View(view)) = &cli.command {
        return view::run(view, &cli.options);
    }
    let films = cli.command == Some(Command::Film);
    if !films && !display::exists() {
        eprintln!("No display (neither DISPLAY nor WAYLAND_DISPLAY is set): filming a walk instead.");
    }
    match start(&cli.options, films || !display::exists()) {
        Ok(code) => code,
        Err(missing) => {
            eprintln!("surefoot: {missing}");
            ExitCode::from(LACKS)
        }
    }
}

fn start(options: &Options, films: bool) -> Result<ExitCode, Missing> {
    gpu::check()?;
    let assets = preflight::assets::find()?;
    if films {
        return Ok(match film::run(options, &assets) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("surefoot: {error}");
                ExitCode::from(FAILED)
            }
        });
    }
    display::check()?;
    Ok(outcome(open(options, App::new(), &assets)?.run()))
}

/// The game in a window, made from `app`.
fn open(options: &Options, app: App, assets: &Path) -> Result<App, Missing> {
    opened(|| windowed(options, app, assets))
}

fn outcome(exit: AppExit) -> ExitCode {
    match exit {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    }
}

fn run_gauntlet(options: &gauntlet::GauntletOptions) -> ExitCode {
    let assets = match preflight::assets::find() {
        Ok(assets) => assets,
        Err(missing) => {
            eprintln!("surefoot: {missing}");
            return ExitCode::from(LACKS);
        }
    };
    match gauntlet::run(options, &assets) {
        Ok(holds) if holds || !options.strict => ExitCode::SUCCESS,
        Ok(_) => ExitCode::from(FAILED),
        Err(error) => {
            eprintln!("surefoot: {error}");
            ExitCode::from(FAILED)
        }
    }
}

/// The game in a window.
fn windowed(options: &Options, app: App, assets: &Path) -> App {
    let shape = engine::WindowShape { size: options.size.unwrap_or(WINDOW_SIZE), fullscreen: options.fullscreen };
    let mut app = engine::windowed_from(app, assets, shape);
    app.insert_resource(level::Seed(options.seed)).add_plugins((
        level::plugin,
        input::plugin,
        shell::plugin,
        taps::plugin,
        look::plugin,
        hud::plugin,
        debug::plugin,
        telemetry::plugin,
        touch::plugin,
    ));
    open_telemetry(&mut app, options);
    app
}

/// Makes the telemetry file, if one is asked for. A file that can't be made is told and left out.
fn open_telemetry(app: &mut App, options: &Options) {
    let Some(file) = &options.telemetry else { return };
    match telemetry::Telemetry::create(file) {
        Ok(telemetry) => {
            app.insert_resource(telemetry);
        }
        Err(error) => eprintln!("surefoot: no telemetry, {}: {error}", file.display()),
    }
}

/// What `open` gives, or why the window library panicked, which is its way to say that it found no display or library.
fn opened(open: impl FnOnce() -> App) -> Result<App, Missing> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| {}));
    let app = panic::catch_unwind(AssertUnwindSafe(open));
    panic::set_hook(hook);
    app.map_err(|reason| {
        let text = reason.downcast_ref::<String>().map(String::as_str);
        display::explain(text.or_else(|| reason.downcast_ref::<&str>().copied()).unwrap_or("unknown reason"))
    })
}
