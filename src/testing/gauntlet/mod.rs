//! The gauntlet: many tapes on many worlds, measured with foot IK, without, and as Bevy's own player animates.
//!
//! ```no_run
//! use surefoot::testing::gauntlet::{Feet, Runner, courses, jobs, run};
//!
//! let runner = Runner::mannequin().expect("it loads");
//! for row in run(&jobs(&courses(), &[Feet::Placed, Feet::AsClips]), &runner, || ()).expect("it loads") {
//!     println!("{} / {}: {} bars broken", row.world, row.tape, row.breaches.len());
//! }
//! ```

#[cfg(feature = "render")]
mod built_in;
#[cfg(not(feature = "render"))]
#[path = "no_built_in.rs"]
mod built_in;
mod courses;
pub mod rates;
mod run;

pub use courses::{Course, courses};
pub use run::{Feet, Job, Row, Runner, assert_within, jobs, run};
