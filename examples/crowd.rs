//! A crowd of mannequins, and beside it the same crowd as the engine alone animates and skins it: what a frame of each takes.
//!
//! `cargo run --release --example crowd` needs no display: it measures crowds of several sizes and prints, for each, the frame
//! time and its split, draws per pass, triangles, bytes written to the GPU, and what was made anew while nothing changed. Besides it
//! writes `crowd.svg` and a picture of each crowd. `--window` shows one crowd instead.

/// The parts of this example.
mod crowd {
    pub(crate) mod built_in;
    pub(crate) mod counts;
    pub(crate) mod flags;
    pub(crate) mod meter;
    pub(crate) mod ours;
    pub(crate) mod plot;
    pub(crate) mod report;
    pub(crate) mod run;
    pub(crate) mod scene;
}

use std::error::Error;

use clap::Parser;

use crowd::{flags::Flags, run};

fn main() -> Result<(), Box<dyn Error>> {
    let flags = Flags::parse();
    if flags.window { run::show(&flags) } else { run::measure(&flags) }
}
