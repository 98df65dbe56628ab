//! Draws characters: a [`Character`] whose file is loaded gets its [`SkinnedModel`].
//!
//! A character that brings its own [`SkinnedModel`] keeps it until its file changes.

use bevy::{platform::collections::HashMap, prelude::*};

use super::model::SkinnedModel;
use crate::{
    character::{Character, bind::CharacterAssets},
    rig::{Rig, character::CharacterAsset},
};

/// Gives every [`Character`] its skin.
pub(super) struct DressPlugin;

impl Plugin for DressPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Wardrobe>().add_systems(Update, dress.run_if(resource_exists::<Assets<CharacterAsset>>));
    }
}

/// One rig for all characters of a file.
#[derive(Resource, Default)]
struct Wardrobe(HashMap<AssetId<CharacterAsset>, Handle<Rig>>);

fn dress(
    mut commands: Commands,
    mut events: MessageReader<AssetEvent<CharacterAsset>>,
    mut wardrobe: ResMut<Wardrobe>,
    mut rigs: ResMut<Assets<Rig>>,
    assets: CharacterAssets,
    server: Res<AssetServer>,
    naked: Query<(Entity, &Character), Without<SkinnedModel>>,
    dressed: Query<(Entity, &Character), With<SkinnedModel>>,
) {
    let mut give = |entity: Entity, character: &Character, wardrobe: &mut Wardrobe| {
        let Some(asset) = assets.get(character) else { return };
        let rig = wardrobe.0.entry(character.0.id()).or_insert_with(|| rigs.add(Rig::clone(&asset.rig))).clone();
        commands.entity(entity).insert(SkinnedModel { gltf: server.load(asset.model.clone()), rig });
    };
    for event in events.read() {
        let (AssetEvent::Modified { id } | AssetEvent::Removed { id }) = event else { continue };
        wardrobe.0.remove(id);
        for (entity, character) in dressed.iter().filter(|(_, character)| character.0.id() == *id) {
            give(entity, character, &mut wardrobe);
        }
    }
    for (entity, character) in &naked {
        give(entity, character, &mut wardrobe);
    }
}
