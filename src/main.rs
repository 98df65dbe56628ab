//! The game: `surefoot` plays, or films a walk where there is no display. `surefoot --help` explains all.

use std::process::ExitCode;

fn main() -> ExitCode {
    surefoot::game::run()
}
