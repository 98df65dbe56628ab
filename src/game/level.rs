//! The level: physics, the land with its course and sky, and the hero at its start.

use avian3d::prelude::PhysicsPlugins;
use bevy::{asset::LoadState, prelude::*};

use crate::{
    SurefootPlugins,
    character::{Character, schedule::MotionSystems},
    rig::character::CharacterAsset,
    skinning::{SkinnedModel, model::ModelStatus},
    terrain::{Heightfield, SkyPlugin, TerrainLookPlugin, TerrainPlugin, course},
};

/// The hero's file.
pub(super) const HERO: &str = "mannequin.character.ron";
/// Metres below the lowest ground at which a fall ends.
const FALL: f32 = 15.0;

/// Seed of the hills. Needed before the plugin is added.
#[derive(Resource, Clone, Copy, Debug)]
pub(super) struct Seed(pub(super) i32);

/// The character that the game is about.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(super) struct Hero;

/// Who the hero is. Put in place of the mannequin before the app begins.
#[derive(Resource, Clone, Default)]
pub(super) enum Cast {
    /// The mannequin.
    #[default]
    Mannequin,
    /// Another character.
    Character(Handle<CharacterAsset>),
    /// A model that is drawn and cannot walk.
    Model(SkinnedModel),
}

/// Whether all that the level needs is there.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub(super) enum Loading {
    /// Some files are on their way.
    #[default]
    Waiting,
    /// The hero stands ready.
    Done,
    /// A file is missing or broken; why.
    Failed(String),
}

/// Where a hero who fell off the land comes back to, and the height below which that happens.
#[derive(Resource, Clone, Copy, Debug)]
struct Home {
    start: Transform,
    floor: f32,
}

pub(super) fn plugin(app: &mut App) {
    let seed = app.world().resource::<Seed>().0;
    app.init_resource::<Loading>()
        .init_resource::<Cast>()
        .add_plugins((PhysicsPlugins::default(), SurefootPlugins, TerrainPlugin { seed }, TerrainLookPlugin, SkyPlugin))
        .add_systems(Startup, spawn_hero)
        .add_systems(Update, watch_loading.run_if(resource_equals(Loading::Waiting)))
        .add_systems(FixedUpdate, bring_home.before(MotionSystems::Move));
}

fn spawn_hero(mut commands: Commands, field: Res<Heightfield>, assets: Res<AssetServer>, cast: Res<Cast>) {
    let points = course::waypoints(&field);
    let start = points.first().copied().unwrap_or_else(|| field.point(0.0, 0.0));
    let ahead = points.get(1).map_or(Vec3::NEG_Z, |next| (*next - start).with_y(0.0));
    let start = Transform::from_translation(start).looking_to(ahead, Vec3::Y);
    let lowest = field.heights().iter().copied().fold(f32::INFINITY, f32::min);
    commands.insert_resource(Home { start, floor: lowest - FALL });
    let mut hero = commands.spawn((Name::new("hero"), start));
    match &*cast {
        Cast::Mannequin => hero.insert(Character(assets.load(HERO))),
        Cast::Character(character) => hero.insert(Character(character.clone())),
        Cast::Model(model) => hero.insert(model.clone()),
    };
    hero.insert(Hero);
}

pub(super) fn watch_loading(
    mut loading: ResMut<Loading>,
    heroes: Query<(Option<&Character>, Option<&SkinnedModel>, Option<&ModelStatus>), With<Hero>>,
    assets: Res<AssetServer>,
) {
    let Ok((character, model, status)) = heroes.single() else { return };
    let character = character.and_then(|character| assets.get_load_state(&character.0));
    let model = model.and_then(|model| assets.get_load_state(&model.gltf));
    if let Some(LoadState::Failed(error)) = [character, model].into_iter().flatten().find(LoadState::is_failed) {
        // The first line says it all; a backtrace may follow.
        let reason = error.to_string().lines().next().unwrap_or_default().to_owned();
        error!("{reason}");
        *loading = Loading::Failed(reason);
    } else if status.is_some_and(ModelStatus::is_ready) {
        *loading = Loading::Done;
    }
}

/// Who falls off the land, or is nowhere at all, starts again.
fn bring_home(mut heroes: Query<&mut Transform, With<Hero>>, home: Option<Res<Home>>) {
    let Some(home) = home else { return };
    for mut root in &mut heroes {
        if !root.translation.is_finite() || root.translation.y < home.floor {
            *root = home.start;
        }
    }
}
