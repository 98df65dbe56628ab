//! The command line.

use std::path::PathBuf;

use bevy::math::UVec2;
use clap::{Parser, ValueEnum};

/// Measures crowds.
#[derive(Parser, Clone, Debug)]
#[command(
    name = "crowd",
    about = "A crowd of mannequins beside the same crowd as the engine alone draws it, measured."
)]
pub(crate) struct Flags {
    /// How many characters; several numbers are measured one after the other.
    #[arg(long, value_delimiter = ',', default_value = "100,1000", value_name = "N")]
    pub(crate) count: Vec<usize>,
    /// Who animates and skins them; all, unless told otherwise.
    #[arg(long, value_enum, value_delimiter = ',', default_value = "surefoot,poses,levels,built-in")]
    pub(crate) way: Vec<Way>,
    /// Frames that are measured of each.
    #[arg(long, default_value_t = 20, value_name = "FRAMES")]
    pub(crate) frames: usize,
    /// The sun casts shadows: everyone is drawn once more for each cascade.
    #[arg(long)]
    pub(crate) shadows: bool,
    /// Surefoot's characters have their level of detail by size on the screen.
    #[arg(long)]
    pub(crate) detail: bool,
    /// Width and height of the picture.
    #[arg(long, default_value = "640x360", value_name = "WxH", value_parser = size)]
    pub(crate) size: UVec2,
    /// Folder for `crowd.svg` and the pictures; made if it does not exist.
    #[arg(long, default_value = "target/crowd", value_name = "DIR")]
    pub(crate) out: PathBuf,
    /// Shows the first crowd in a window, and prints what it took when that is closed.
    #[arg(long)]
    pub(crate) window: bool,
}

/// Who animates and skins a crowd.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// All of Surefoot: controller, physics, locomotion, feet on the ground, skinning.
    Surefoot,
    /// Surefoot's blocks of poses and its skinning, without controller and feet: what the engine does.
    Poses,
    /// The same, and those who are seen small are drawn with fewer triangles.
    Levels,
    /// The engine's animation and skinning.
    BuiltIn,
}

impl Way {
    /// For tables, plots and names of files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Surefoot => "surefoot",
            Self::Poses => "poses",
            Self::Levels => "levels",
            Self::BuiltIn => "built-in",
        }
    }
}

fn size(text: &str) -> Result<UVec2, String> {
    let sides = text.split_once('x').and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
    sides.map(UVec2::from).filter(|size| size.min_element() > 0).ok_or_else(|| "wants WxH, such as 640x360".to_owned())
}
