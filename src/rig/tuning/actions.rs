//! Actions: clips laid over whatever else plays, by name.

use std::collections::BTreeMap;

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::ranges::{RangeError, Ranges};
use crate::rig::{humanoid::HumanoidRole, joint_ref::JointRef};

/// A clip that is laid over whatever else plays.
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ActionConfig {
    /// The clip. Default: the one that is called as the action.
    pub clip: Option<String>,
    /// The joint that takes part with all below it: `Role(rightShoulder)` or `Name("Bip01 Spine")`. Default: the lowest
    /// joint of the spine above the hips.
    pub root: Option<JointRef>,
    /// Over how many joints, from the root on, the action comes in by and by. Default 3.
    ///
    /// 0: the root takes part in full, and a sharp bend may show there. Large: a long way up it still moves as below.
    pub feather: u32,
    /// How much of it shows, 0..=1. Default 1.
    pub weight: f32,
    /// Seconds in which it comes. Default 0.25.
    pub fade_in: f32,
    /// Seconds in which it goes; played once, it is gone when the clip ends. Default 0.3.
    pub fade_out: f32,
    /// Whether it is added to what plays, as the clip's difference from its reference, rather than put in its place.
    /// Default false.
    pub additive: bool,
    /// The clip whose first pose an additive one differs from. Default: the clip itself.
    pub reference: Option<String>,
    /// Whether it starts again at its end, until it is stopped. Default false.
    pub looping: bool,
}

impl Default for ActionConfig {
    fn default() -> Self {
        Self {
            clip: None,
            root: None,
            feather: 3,
            weight: 1.0,
            fade_in: 0.25,
            fade_out: 0.3,
            additive: false,
            reference: None,
            looping: false,
        }
    }
}

impl ActionConfig {
    /// Checks every range.
    ///
    /// # Errors
    /// With the first value out of range.
    pub fn check(&self, ranges: &Ranges) -> Result<(), RangeError> {
        ranges.within("weight", self.weight, 0.0..=1.0, "")?;
        ranges.within("fade_in", self.fade_in, 0.0..=10.0, " s")?;
        ranges.within("fade_out", self.fade_out, 0.0..=10.0, " s")
    }
}

/// The standard actions: what a character knows whose file lists none, as far as it has their clips and joints.
#[must_use]
pub fn standard() -> BTreeMap<String, ActionConfig> {
    let arm = JointRef::Role(HumanoidRole::RightShoulder);
    let wave = ActionConfig { clip: Some("wave".to_owned()), root: Some(arm), feather: 1, ..ActionConfig::default() };
    BTreeMap::from([("wave".to_owned(), wave)])
}
