//! Layer 3: shows what characters do, for the eyes of who tunes them. Reads their components; changes nothing.

pub mod chains;
pub mod feet;
mod shown;
mod words;

pub use chains::{ChainDebugPlugin, ChainGizmos};
pub use feet::{FootDebugPlugin, FootGizmos, LEGEND};
pub use words::{describe, reason};
