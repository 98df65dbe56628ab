//! How the body leans into what it does.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// How the body leans into what it does. Feet stay where they are.
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BalanceConfig {
    /// Whether it does any of this. Default true.
    pub enabled: bool,
    /// Lean into speeding up and slowing down, as a share of the lean that would balance it. Default 0.35.
    ///
    /// 0: upright as on wheels. 1: as a sprinter out of the blocks, at every step.
    pub forward: f32,
    /// The same for turns. Default 0.65.
    pub side: f32,
    /// Half-life in which an acceleration is felt, seconds. Default 0.16.
    ///
    /// Short: every change of mind shakes the body. Long: it leans when the turn is over.
    pub half_life: f32,
    /// Most that it leans forward, degrees in RON. Default 12°.
    #[serde(with = "super::degrees")]
    pub forward_limit: f32,
    /// Most that it leans backward, degrees in RON. Default 8°.
    #[serde(with = "super::degrees")]
    pub backward_limit: f32,
    /// Most that it leans to a side, degrees in RON. Default 15°.
    #[serde(with = "super::degrees")]
    pub side_limit: f32,
    /// Lean of the trunk toward the slope per degree of the way up, degrees. Default 0.45.
    pub uphill: f32,
    /// Lean of the trunk away from the slope per degree of the way down, degrees. Default 0.22.
    pub downhill: f32,
    /// Share of the lean into accelerations that the whole body takes from the ankles up; the spine takes the rest.
    /// Default 0.25.
    pub from_ankles: f32,
}

impl Default for BalanceConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            forward: 0.35,
            side: 0.65,
            half_life: 0.16,
            forward_limit: 12f32.to_radians(),
            backward_limit: 8f32.to_radians(),
            side_limit: 15f32.to_radians(),
            uphill: 0.45,
            downhill: 0.22,
            from_ankles: 0.25,
        }
    }
}
