//! Layer 4: the public headless harness: hold your own characters and levels to the same measures.
//!
//! [`Stage`] is an app without window or GPU, stepped frame by frame; [`World`] is ground to walk on; [`Tape`] is what a
//! player would press; [`gauntlet`] plays many tapes on many
//! worlds and holds what it measures to bars. With feature `render`, `peer` holds a file's motion against the engine's own.

pub mod gauntlet;
mod grounds;
pub mod laps;
#[cfg(feature = "render")]
pub mod peer;
mod stage;
mod tape;
mod world;

pub use stage::{Stage, StageError};
pub use tape::{Cue, Tape};
pub use world::{Piece, Shape, World};
