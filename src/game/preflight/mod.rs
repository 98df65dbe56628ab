//! What the machine must have, looked for before the engine starts, which would panic instead of explaining.

pub mod assets;
pub mod display;
pub mod gpu;

use thiserror::Error;

/// Something the machine lacks. One line that says what, and the command that mends it.
#[derive(Error, Clone, Debug, PartialEq, Eq)]
pub enum Missing {
    /// No driver that can draw.
    #[error("no Vulkan driver found{detail}. {mend}")]
    Driver {
        /// What was looked at, or nothing.
        detail: String,
        /// What to do about it.
        mend: &'static str,
    },
    /// The display that the environment names does not answer.
    #[error(
        "no X server answers at DISPLAY={display} ({reason}). Start one, or unset DISPLAY, or run `surefoot film`, which needs none"
    )]
    Server {
        /// The value of `DISPLAY`.
        display: String,
        /// What connecting to it said.
        reason: String,
    },
    /// A Wayland session that offers no X11.
    #[error(
        "this Wayland session offers no X11 display (DISPLAY is not set). Install it: sudo apt-get install -y xwayland"
    )]
    Xwayland,
    /// The window could not be made.
    #[error("no window could be opened ({reason}). {mend}")]
    Window {
        /// What the window library said, in one line.
        reason: String,
        /// What to do about it.
        mend: String,
    },
    /// The folder with the mannequin.
    #[error(
        "no assets folder with {file} in any of: {looked}. Run from the source folder, or set BEVY_ASSET_ROOT to it"
    )]
    Assets {
        /// A file that it must hold.
        file: &'static str,
        /// The folders looked at.
        looked: String,
    },
}
