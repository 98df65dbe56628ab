//! The table of measures below a film. Pure.

use crate::measure::{bars::Bars, frame::Frame, summary::summarize, table::Table};

/// The measures of a walk as lines of text: what was measured, the bar it is held to, and whether it stays below.
#[must_use]
pub fn of(frames: &[Frame]) -> String {
    let measures = summarize(frames);
    let table = Table(&Bars::default().rows(&measures)).to_string();
    format!("{table}from {} frames with {} stances", frames.len(), measures.stances)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_walk_of_no_frames_still_makes_a_table() {
        let table = of(&[]);
        assert!(table.contains("plant drift") && table.contains("from 0 frames"), "{table}");
    }
}
