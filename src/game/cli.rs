//! The command line of the game.

use std::path::PathBuf;

use bevy::math::UVec2;
use clap::{Args, Parser, Subcommand};

use super::{gauntlet::GauntletOptions, view::ViewOptions};

/// What the command line asks for.
#[derive(Parser, Clone, Debug)]
#[command(
    name = "surefoot",
    version,
    about = "A character that walks over uneven ground, and whose feet stay where they land.",
    long_about = "A character that walks over uneven ground, and whose feet stay where they land.\n\n\
        Without a command it opens a window to play in. Where no display exists (Linux without DISPLAY or \
        WAYLAND_DISPLAY) it does what `surefoot film` does instead: films a walk over the course into pictures, \
        one contact sheet, and a table of measures.",
    after_help = "In the window: WASD or left stick walks, Shift or right trigger runs, Ctrl or a press of the left stick sprints, Space jumps, C crouches, H waves, mouse or right stick \
        looks around, wheel zooms, right mouse button or left trigger aims, F1 hides the help, F3 shows how the feet are placed.\n\
        With `view`, besides: N and B go through the clips, V walks, K shows the skeleton, G the weights, M each morph target and expression.\n\
        Exit codes: 0 all well, 1 the film or the gauntlet's files could not be written, `--strict` found a bar broken or `--against-bevy` a joint off, 2 wrong arguments, 3 the machine lacks a graphics driver, a display or the assets."
)]
pub struct Cli {
    /// What to do; nothing plays the game.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Everything else; each works with every command it makes sense for.
    #[command(flatten)]
    pub options: Options,
}

/// What to do besides playing.
#[derive(Subcommand, Clone, Debug, PartialEq, Eq)]
pub enum Command {
    /// Films a walk over the course into PNG frames and one contact sheet, and prints the measures.
    Film,
    /// Sends a character over many grounds and prints how well it walked, with and without foot IK; figures over their bar are marked.
    Gauntlet(GauntletOptions),
    /// Shows any glTF model: what was found in it, each of its clips, and how it walks over the course.
    View(ViewOptions),
}

/// All flags.
#[derive(Args, Clone, Debug)]
pub struct Options {
    /// Seed of the hills; another number, other hills.
    #[arg(long, global = true, default_value_t = 7, allow_negative_numbers = true, value_name = "NUMBER")]
    pub seed: i32,
    /// Writes what the character does to FILE, ten lines of JSON a second.
    #[arg(long, global = true, value_name = "FILE")]
    pub telemetry: Option<PathBuf>,
    /// Width and height in pixels, such as 1280x720. Default 1280x720 in a window, 960x540 on film.
    #[arg(long, global = true, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<UVec2>,
    /// Window: fills the whole screen.
    #[arg(long, global = true)]
    pub fullscreen: bool,
    /// Film: folder for the pictures; made if it does not exist.
    #[arg(long, global = true, default_value = "target/film", value_name = "DIR")]
    pub out: PathBuf,
    /// Film: length of the walk in seconds.
    #[arg(long, global = true, default_value_t = 20.0, value_name = "SECONDS", value_parser = parse_seconds)]
    pub seconds: f32,
    /// Film: instead of the walk a scene on flat ground that shows one state of locomotion, as one sheet of pictures; `all`
    /// films every scene, an unknown name lists them.
    #[arg(long, global = true, value_name = "NAME")]
    pub scene: Option<String>,
    /// Film: pictures per second; a divisor of 60, since the walk itself is always stepped 60 times a second.
    #[arg(long, global = true, default_value_t = 30, value_name = "FPS", value_parser = parse_fps)]
    pub fps: u32,
}

/// Smallest and largest side of a picture: below nothing can be seen, above no card has such textures.
const SIDES: std::ops::RangeInclusive<u32> = 64..=8192;

fn parse_size(text: &str) -> Result<UVec2, String> {
    let sides = text.split_once(['x', 'X']).and_then(|(width, height)| {
        let size = UVec2::new(width.trim().parse().ok()?, height.trim().parse().ok()?);
        (SIDES.contains(&size.x) && SIDES.contains(&size.y)).then_some(size)
    });
    sides.ok_or_else(|| format!("wants WxH, each {} to {} pixels, such as 960x540", SIDES.start(), SIDES.end()))
}

fn parse_seconds(text: &str) -> Result<f32, String> {
    let seconds = text.parse().ok().filter(|seconds: &f32| (0.1..=600.0).contains(seconds));
    seconds.ok_or_else(|| "wants seconds from 0.1 to 600".to_owned())
}

fn parse_fps(text: &str) -> Result<u32, String> {
    let fps = text.parse().ok().filter(|fps: &u32| (1..=60).contains(fps) && 60 % fps == 0);
    fps.ok_or_else(|| "wants a divisor of 60: 60, 30, 20, 15, 12, 10, 6, 5, 4, 3, 2 or 1".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn flags_work_before_and_after_the_command() {
        for line in [["surefoot", "--size=320x180", "film"], ["surefoot", "film", "--size=320x180"]] {
            let cli = Cli::try_parse_from(line).unwrap();
            assert_eq!(cli.command, Some(Command::Film));
            assert_eq!(cli.options.size, Some(UVec2::new(320, 180)), "from {line:?}");
        }
    }

    #[test]
    fn sizes_that_cannot_be_drawn_are_refused() {
        for size in ["0x10", "960", "960x", "-1x5", "99999x99999", "axb"] {
            assert!(parse_size(size).is_err(), "{size} was taken");
        }
    }

    #[test]
    fn only_whole_steps_fit_between_two_pictures() {
        for (fps, good) in [("30", true), ("60", true), ("24", false), ("0", false), ("61", false)] {
            assert_eq!(parse_fps(fps).is_ok(), good, "{fps} pictures a second");
        }
    }

    #[test]
    fn a_film_of_no_length_is_refused() {
        for seconds in ["0", "-1", "NaN", "inf", "601"] {
            assert!(parse_seconds(seconds).is_err(), "{seconds} s was taken");
        }
    }
}
