//! How clips of another body become this one's.

use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

use super::ranges::{RangeError, Ranges};

/// How clips of another body become this one's: those of other files, and the mannequin's.
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RetargetConfig {
    /// Share of the spine's turns against the pelvis that is taken. Default 1.
    pub spine: f32,
    /// Share of the turns of neck and head against the trunk. Default 1.
    pub head: f32,
    /// Share of the arms' turns against the trunk. Default 1.
    ///
    /// Small: arms hang still. Above 1: they swing wide.
    pub arms: f32,
    /// Share of the hands' turns against the forearms. Default 1.
    pub hands: f32,
    /// Share of the turns of legs against the pelvis, and of feet against level ground. Default 1. Where feet are held, it
    /// only shows in the feet.
    pub legs: f32,
    /// Share of the pelvis' motion, which is scaled by the legs' length. Default 1.
    pub pelvis: f32,
    /// Whether arms point where the source's point, whatever the rest poses: makes up for arms held out in one and down in
    /// the other. Default true. False: they turn by as much from where they are at rest.
    pub align_arms: bool,
    /// The same for legs, default true; for bodies that rest with knees bent or feet apart.
    pub align_legs: bool,
    /// How much farther out the arms are held, degrees in RON. Default 0. For broad bodies, whose hands would pass through
    /// them.
    #[serde(with = "super::degrees")]
    pub arm_spread: f32,
    /// Whether feet are held on their contacts by IK: each ball goes the source's way, scaled, its sole as high. Default true.
    ///
    /// False: legs turn as the source's do, and feet slide as far as the legs are shaped differently.
    pub hold_feet: bool,
}

impl Default for RetargetConfig {
    fn default() -> Self {
        Self {
            spine: 1.0,
            head: 1.0,
            arms: 1.0,
            hands: 1.0,
            legs: 1.0,
            pelvis: 1.0,
            align_arms: true,
            align_legs: true,
            arm_spread: 0.0,
            hold_feet: true,
        }
    }
}

impl RetargetConfig {
    /// Checks every range.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        for (field, share) in [
            ("spine", self.spine),
            ("head", self.head),
            ("arms", self.arms),
            ("hands", self.hands),
            ("legs", self.legs),
            ("pelvis", self.pelvis),
        ] {
            ranges.within(field, share, 0.0..=2.0, "")?;
        }
        ranges.degrees("arm_spread", self.arm_spread, -90.0..=90.0)
    }
}
