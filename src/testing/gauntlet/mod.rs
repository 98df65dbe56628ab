//! The gauntlet: many tapes on many worlds, each measured with and without foot IK.
//!
//! ```no_run
//! use surefoot::testing::{Stage, World, gauntlet};
//!
//! let mannequin = Stage::on(&World::flat()).load_character("mannequin.character.ron").expect("it loads");
//! for row in gauntlet::run(&gauntlet::with_and_without(gauntlet::courses()), &mannequin, |_| ()) {
//!     println!("{} / {}: {} bars broken", row.world, row.tape, row.breaches.len());
//! }
//! ```

mod courses;
mod run;

pub use courses::{Course, courses};
pub use run::{Job, Row, assert_within, run, with_and_without};
