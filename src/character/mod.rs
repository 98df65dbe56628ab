//! Layer 3: the ECS, one module per stage in the order the data flows; `schedule` is the spine.

pub mod aim;
pub mod animator;
pub mod attach;
pub mod bind;
pub mod chains;
pub mod crowd;
pub mod detail;
pub mod ease;
pub mod foot_ik;
pub mod intent;
pub mod legs;
pub mod levels;
pub mod locomotion;
pub mod look;
pub mod motion;
pub mod schedule;
pub mod show;
pub mod sole;

use bevy::prelude::*;

use crate::rig::character::CharacterAsset;

/// A character of this file: the one component to spawn, everything else follows.
///
/// Its `Transform` is the point on the ground between its feet; it faces -Z. Steer it by
/// [`MoveIntent`](intent::MoveIntent).
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
#[require(intent::MoveIntent, motion::CharacterMotion, Transform)]
pub struct Character(pub Handle<CharacterAsset>);

impl From<Handle<CharacterAsset>> for Character {
    fn from(handle: Handle<CharacterAsset>) -> Self {
        Self(handle)
    }
}
