//! When the eyes blink.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::ranges::{RangeError, Ranges};

/// When the eyes blink, whatever else a character does. Clips may close them, too: the farther counts.
///
/// People at rest blink 17 times a minute ([Bentivoglio et al. 1997](https://doi.org/10.1002/mds.870120629)), with more short
/// intervals than long ones; a blink takes 0.1 to 0.4 s, and lids fall faster than they rise
/// ([Sforza et al. 2008](https://doi.org/10.1111/j.1475-1313.2008.00577.x)).
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BlinkConfig {
    /// Whether they do. Default true.
    pub enabled: bool,
    /// Names of the morph targets or expressions that shut the eyes. Default `None`: a VRM model's expression `blink`, else a
    /// target called `blink`, `Fcl_EYE_Close`, `eyeBlinkLeft` with `eyeBlinkRight`, or another common name; a model without
    /// one doesn't blink.
    pub targets: Option<Vec<String>>,
    /// Seconds from one blink to the next, on average. Default 3.5.
    ///
    /// Each interval is drawn anew, from [`BlinkConfig::SHORTEST`] to [`BlinkConfig::LONGEST`] of it. Small: nervous. Large: a
    /// stare.
    pub interval: f32,
    /// Seconds that a blink takes. Default 0.27.
    ///
    /// Small: hardly seen. Large: sleepy.
    pub duration: f32,
}

impl BlinkConfig {
    /// Shortest interval, as a share of the average.
    pub const SHORTEST: f32 = 0.4;
    /// Longest interval, as a share of the average.
    pub const LONGEST: f32 = 2.2;

    /// Checks every range.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        if self.targets.as_ref().is_some_and(Vec::is_empty) {
            let valid = "names of morph targets, or None; `enabled: false` stops the blinks".to_owned();
            return Err(ranges.fail("targets", "empty".to_owned(), valid));
        }
        ranges.within("interval", self.interval, 0.5..=600.0, " s")?;
        // The eyes are open again before the next blink; whole milliseconds read better.
        let longest = (900.0 * Self::SHORTEST * self.interval).round().min(2000.0) / 1000.0;
        ranges.within("duration", self.duration, 0.05..=longest, " s")
    }
}

impl Default for BlinkConfig {
    fn default() -> Self {
        Self { enabled: true, targets: None, interval: 3.5, duration: 0.27 }
    }
}
