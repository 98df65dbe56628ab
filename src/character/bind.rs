//! Gives a spawned [`Character`] its pose, state machine and tuning once its file is loaded, and again when it changes.

use avian3d::prelude::SpatialQueryFilter;
use bevy::{ecs::system::SystemParam, platform::collections::HashMap, prelude::*};

use super::{
    Character,
    aim::Aiming,
    animator::{Actions, Balance, Blink, CharacterPose},
    foot_ik::{FootIk, GroundFilter},
    locomotion::Locomotion,
    look::Look,
};
use crate::rig::character::CharacterAsset;

/// Looks up the loaded file of a character.
#[derive(SystemParam)]
pub struct CharacterAssets<'w> {
    assets: Res<'w, Assets<CharacterAsset>>,
}

impl CharacterAssets<'_> {
    /// The character's file; `None` while it loads or when it could not be loaded.
    #[must_use]
    pub fn get(&self, character: &Character) -> Option<&CharacterAsset> {
        self.assets.get(&character.0)
    }
}

/// Binds characters to their files.
pub struct BindPlugin;

impl Plugin for BindPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PreUpdate, bind);
    }
}

fn bind(
    mut commands: Commands,
    mut events: MessageReader<AssetEvent<CharacterAsset>>,
    assets: CharacterAssets,
    fresh: Query<(Entity, &Character), Without<CharacterPose>>,
    bound: Query<(Entity, &Character, &Locomotion, &Aiming), With<CharacterPose>>,
    mut patterns: Local<HashMap<AssetId<CharacterAsset>, Locomotion>>,
) {
    let events: Vec<AssetEvent<CharacterAsset>> = events.read().copied().collect();
    for event in &events {
        if let AssetEvent::Modified { id } | AssetEvent::Removed { id } = event {
            patterns.remove(id);
        }
    }
    let mut give =
        |entity: Entity, asset: &CharacterAsset, character: &Character, before: Option<(&Locomotion, &Aiming)>| {
            let mut pose = CharacterPose::new(&asset.skeleton);
            // All characters of one file share what never changes.
            let pattern = patterns.entry(character.0.id()).or_insert_with(|| Locomotion::new(asset, &mut pose.pose));
            let mut locomotion = pattern.clone();
            let mut aiming = Aiming::new(asset);
            if let Some((before, aimed)) = before {
                locomotion.take_over(before, asset);
                aiming.take_over(aimed);
            }
            // What is seen until the first tick.
            pose.begin(asset, &locomotion);
            let ground = GroundFilter(SpatialQueryFilter::from_excluded_entities([entity]));
            let own = (pose, locomotion, aiming, FootIk::new(asset), asset.file.motion.clone());
            let unless_given =
                (ground, Actions::default(), Balance::default(), Look::default(), Blink::new(entity.index_u32()));
            // Boxed: the queue of commands never gives memory back, and a crowd would leave it several kilobytes a head.
            let components = Box::new((own, unless_given));
            commands.entity(entity).queue(move |mut character: EntityWorldMut| {
                let (own, unless_given) = *components;
                character.insert(own).insert_if_new(unless_given);
            });
        };
    for event in events {
        let AssetEvent::Modified { id } = event else { continue };
        for (entity, character, locomotion, aiming) in bound.iter().filter(|bound| bound.1.0.id() == id) {
            if let Some(asset) = assets.get(character) {
                give(entity, asset, character, Some((locomotion, aiming)));
            }
        }
    }
    for (entity, character) in &fresh {
        if let Some(asset) = assets.get(character) {
            give(entity, asset, character, None);
        }
    }
}
