//! How arms point where a character aims.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::ranges::{RangeError, Ranges};

/// How arms point where a character aims. The head follows within the limits of [`LookConfig`](super::look::LookConfig).
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AimConfig {
    /// Whether they do. Default true.
    pub enabled: bool,
    /// Which ones: `Left`, `Right` or `Both`. Default `Right`.
    pub arms: AimingArms,
    /// Seconds in which arms rise to the level, and sink again; higher takes longer. Default 0.4.
    pub fade: f32,
    /// Half-life in which arms follow the aim, seconds. Default 0.05.
    ///
    /// 0: rigid. Long: they trail behind.
    pub half_life: f32,
    /// Fastest that arms turn to an aim that jumps, degrees per second in RON. Default 270°.
    ///
    /// Small: a new target is reached late. Large: the arm whips.
    #[serde(with = "super::degrees")]
    pub fastest: f32,
    /// Share of the turn to a side and up that the spine takes. Default 0.25.
    ///
    /// 0: the arm alone points. Large: the chest turns to all that is aimed at.
    pub trunk: f32,
    /// Share of it that the shoulder of the arm takes. Default 0.12.
    pub shoulder: f32,
    /// Distance from shoulder to wrist as a share of the arm's length. Default 0.96.
    ///
    /// Small: the elbow bends. 1: the arm is straight.
    pub reach: f32,
    /// Most that arms turn to a side from where the body faces, degrees in RON. Default 75°.
    #[serde(with = "super::degrees")]
    pub side_limit: f32,
    /// Most that arms turn up or down, degrees in RON. Default 60°.
    #[serde(with = "super::degrees")]
    pub up_limit: f32,
}

/// The arms that aim.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum AimingArms {
    /// The left one.
    Left,
    /// The right one.
    #[default]
    Right,
    /// Both.
    Both,
}

impl AimingArms {
    /// Whether the arm of this side, 0 left and 1 right, is one of them.
    #[must_use]
    pub fn contain(self, side: usize) -> bool {
        match self {
            Self::Left => side == 0,
            Self::Right => side == 1,
            Self::Both => true,
        }
    }
}

impl Default for AimConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            arms: AimingArms::Right,
            fade: 0.4,
            half_life: 0.05,
            fastest: 270f32.to_radians(),
            trunk: 0.25,
            shoulder: 0.12,
            reach: 0.96,
            side_limit: 75f32.to_radians(),
            up_limit: 60f32.to_radians(),
        }
    }
}

impl AimConfig {
    /// Checks every range.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        ranges.within("fade", self.fade, 0.0..=5.0, " s")?;
        ranges.within("half_life", self.half_life, 0.0..=5.0, " s")?;
        ranges.degrees("fastest", self.fastest, 1.0..=3600.0)?;
        ranges.within("trunk", self.trunk, 0.0..=1.0, "")?;
        ranges.within("shoulder", self.shoulder, 0.0..=1.0, "")?;
        ranges.within("reach", self.reach, 0.3..=1.0, "")?;
        ranges.degrees("side_limit", self.side_limit, 0.0..=120.0)?;
        ranges.degrees("up_limit", self.up_limit, 0.0..=85.0)
    }
}
