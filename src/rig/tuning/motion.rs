//! How the controller moves a character.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// How the controller moves a character.
#[derive(Component, Reflect, Clone, Debug, Serialize, Deserialize)]
#[reflect(Component)]
#[serde(default, deny_unknown_fields)]
pub struct MotionConfig {
    /// Walking speed in m/s. Default 1.4.
    pub walk_speed: f32,
    /// Running speed in m/s. Default 3.5.
    pub run_speed: f32,
}

impl Default for MotionConfig {
    fn default() -> Self {
        Self { walk_speed: 1.4, run_speed: 3.5 }
    }
}
