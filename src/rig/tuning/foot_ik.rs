//! How feet find the ground, hold it and let go.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// How feet find the ground, hold it and let go.
///
/// Lengths are for a leg of 0.875 m (the mannequin's) and scale with the leg.
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FootIkConfig {
    /// Whether feet are placed at all. Default true.
    pub enabled: bool,
    /// How far above the root plane a ground probe starts, metres. Default 0.5.
    ///
    /// Small: high steps are missed. Large: the underside of a low ceiling may be taken for ground.
    pub probe_up: f32,
    /// How far below the root plane a ground probe ends, metres. Default 0.7.
    pub probe_down: f32,
    /// Steepest ground a foot stands on, degrees in RON. Default 50°.
    #[serde(with = "super::degrees")]
    pub walkable: f32,
    /// Metres the clip may carry a planted foot away before it steps. Default 0.2.
    ///
    /// Small: many small corrections. Large: the leg stretches before it steps.
    pub unplant_radius: f32,
    /// Turn of the body over a planted foot before it steps, degrees in RON. Default 40°.
    #[serde(with = "super::degrees")]
    pub unplant_yaw: f32,
    /// Metres a foot may stand off its idle place before it steps back. Default 0.08.
    pub restep_distance: f32,
    /// Seconds of a correcting step. Default 0.5.
    pub step_time: f32,
    /// Metres that a correcting step lifts the foot. Default 0.05.
    pub step_height: f32,
    /// Metres of clearance over what lies in a swinging foot's way. Default 0.03.
    pub clearance: f32,
    /// Metres by which a landing may move to find room for the whole sole. Default 0.2.
    pub landing_shift: f32,
    /// Most that the pelvis sinks so that the lower foot reaches, metres. Default 0.4.
    pub pelvis_drop: f32,
    /// Half-life of the pelvis' spring, seconds. Default 0.065.
    ///
    /// Short: the body follows every stone. Long: it floats, and legs stretch.
    pub pelvis_half_life: f32,
    /// Leg extension, as a fraction of the leg, that the pelvis keeps in reserve. Default 0.97.
    pub pelvis_extension: f32,
    /// Extension from which a leg resists, and the most it reaches. Defaults 0.98 and 0.995.
    pub extension: (f32, f32),
    /// Half-life of the foot's turn to the ground's slope, seconds. Default 0.06.
    pub align_half_life: f32,
    /// Most that a foot pitches to the slope, toes down and toes up, degrees in RON. Default 35°.
    #[serde(with = "super::degrees")]
    pub pitch_limit: f32,
    /// Most that a foot rolls to the slope, degrees in RON. Default 20°.
    #[serde(with = "super::degrees")]
    pub roll_limit: f32,
    /// Half-life of the whole effect fading out in the air and in again on landing, seconds. Default 0.05.
    pub air_half_life: f32,
}

impl Default for FootIkConfig {
    fn default() -> Self {
        Self {
            enabled: true,
            probe_up: 0.5,
            probe_down: 0.7,
            walkable: 50f32.to_radians(),
            unplant_radius: 0.2,
            unplant_yaw: 40f32.to_radians(),
            restep_distance: 0.08,
            step_time: 0.5,
            step_height: 0.05,
            clearance: 0.03,
            landing_shift: 0.2,
            pelvis_drop: 0.4,
            pelvis_half_life: 0.065,
            pelvis_extension: 0.97,
            extension: (0.98, 0.995),
            align_half_life: 0.06,
            pitch_limit: 35f32.to_radians(),
            roll_limit: 20f32.to_radians(),
            air_half_life: 0.05,
        }
    }
}

/// Leg length in metres that the lengths are meant for.
pub const TUNED_LEG: f32 = 0.875;

impl FootIkConfig {
    /// The same tuning for a leg of `length` metres: lengths scale, times and angles stay.
    #[must_use]
    pub fn for_leg(&self, length: f32) -> Self {
        let mut config = self.clone();
        for metres in [
            &mut config.probe_up,
            &mut config.probe_down,
            &mut config.unplant_radius,
            &mut config.restep_distance,
            &mut config.step_height,
            &mut config.clearance,
            &mut config.landing_shift,
            &mut config.pelvis_drop,
        ] {
            *metres *= length / TUNED_LEG;
        }
        config
    }
}
