//! Without the feature `render` there is no Bevy animation to compare with.

use bevy::prelude::*;

use super::run::Runner;
use crate::testing::{
    stage::{Stage, StageError},
    world::World as Ground,
};

pub(super) fn stage(_: &Ground, runner: &Runner, _: &[Transform]) -> Result<(Stage, Vec<Entity>), StageError> {
    let reason = "comparing with Bevy's own animation needs the feature `render`".to_owned();
    Err(StageError::Load { path: runner.character.model.to_string(), reason })
}
