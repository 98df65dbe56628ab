//! Where the head turns to.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// Where the head turns to: ahead of a turn, along the slope, or at a point of one's choice.
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LookConfig {
    /// Whether it does any of this. Default true.
    pub enabled: bool,
    /// Half-life in which the gaze arrives, seconds. Default 0.09.
    pub half_life: f32,
    /// Fastest that the gaze turns, degrees per second in RON. Default 600°.
    ///
    /// Small: the head comes late. Large: it snaps round to what comes into sight.
    #[serde(with = "super::degrees")]
    pub fastest: f32,
    /// Seconds by which the gaze runs ahead of a turn of the body. Default 0.25.
    ///
    /// 0: the head turns with the chest. Large: it looks over its shoulder in every curve.
    pub ahead: f32,
    /// Most that the gaze turns to a side, degrees in RON. Default 60°.
    #[serde(with = "super::degrees")]
    pub side_limit: f32,
    /// Most that the gaze turns up or down, degrees in RON. Default 30°.
    #[serde(with = "super::degrees")]
    pub up_limit: f32,
    /// Turn of the gaze up or down per degree of the way's slope, degrees. Default 0.5.
    pub slope: f32,
    /// Share of the body's lean that is taken out of the head. Default 0.7.
    pub level: f32,
    /// Share of the turn that the chest takes. Default 0.15.
    pub chest: f32,
    /// Share of the turn that the neck takes; the head takes the rest. Default 0.35.
    pub neck: f32,
}

impl Default for LookConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            half_life: 0.09,
            fastest: 600f32.to_radians(),
            ahead: 0.25,
            side_limit: 60f32.to_radians(),
            up_limit: 30f32.to_radians(),
            slope: 0.5,
            level: 0.7,
            chest: 0.15,
            neck: 0.35,
        }
    }
}
