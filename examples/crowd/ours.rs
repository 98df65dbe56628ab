//! The crowd by Surefoot: whole characters, or poses alone.

use avian3d::prelude::*;
use bevy::prelude::*;
use surefoot::{
    SurefootPlugins,
    anim::block::{Actor, Layer, Play, Precision, RowSource, Species, SpeciesParts, Workspace, pose},
    character::{
        Character,
        bind::CharacterAssets,
        intent::MoveIntent,
        schedule::{MotionSystems, PoseClock, PoseSystems},
    },
    rig::{Rig, character::CharacterAsset},
    skinning::{
        MeshLevels, Palette, ScreenDetail, SkinArena, SkinnedModel,
        model::{ModelParts, ModelStatus},
    },
};

use super::scene::{Hills, Scene, Walker};

/// Characters with all that belongs to them.
pub(crate) fn characters(app: &mut App) {
    app.add_plugins((PhysicsPlugins::default(), SurefootPlugins))
        .insert_resource(PoseClock::at_most(1))
        .add_systems(Startup, spawn_characters)
        .add_systems(FixedUpdate, steer.in_set(MotionSystems::Decide));
}

fn spawn_characters(mut commands: Commands, assets: Res<AssetServer>, scene: Res<Scene>, hills: Res<Hills>) {
    let file: Handle<CharacterAsset> = assets.load(HERO);
    for walker in scene.walkers() {
        let mut character = commands.spawn((Character(file.clone()), walker.place(&hills.0, 0.0), walker));
        if scene.detail {
            character.insert(ScreenDetail::default());
        }
    }
}

fn steer(mut walkers: Query<(&Walker, &Transform, &mut MoveIntent)>) {
    for (walker, root, mut intent) in &mut walkers {
        intent.velocity = walker.velocity(root.translation);
    }
}

/// The mannequin.
pub(crate) const HERO: &str = "mannequin.character.ron";
/// The two clips that play, and how much of each.
pub(crate) const CLIPS: [(&str, f32); 2] = [("walk", 0.6), ("run", 0.4)];

/// Poses by blocks of characters, written to their palettes; nobody has a controller or feet on the ground.
/// With `levels` triangles go by size on the screen.
pub(crate) fn poses(app: &mut App, levels: bool) {
    app.add_plugins((PhysicsPlugins::default(), SurefootPlugins))
        .insert_resource(Levels(levels))
        .insert_resource(Pattern::Waiting(Handle::default()))
        .add_systems(Startup, load)
        .add_systems(Update, (spawn_puppets, walk_circles).chain())
        .add_systems(PostUpdate, play.in_set(PoseSystems::Show));
}

/// What everyone is made of.
#[derive(Resource)]
enum Pattern {
    Waiting(Handle<CharacterAsset>),
    Ready { species: Box<Species>, durations: [f32; 2] },
}

/// Whether meshes have levels.
#[derive(Resource)]
struct Levels(bool);

/// The clips that one plays.
#[derive(Component, Clone, Copy)]
struct Puppet([Play; 2]);

fn load(assets: Res<AssetServer>, mut pattern: ResMut<Pattern>) {
    *pattern = Pattern::Waiting(assets.load(HERO));
}

fn spawn_puppets(
    mut commands: Commands,
    server: Res<AssetServer>,
    assets: CharacterAssets,
    mut rigs: ResMut<Assets<Rig>>,
    mut pattern: ResMut<Pattern>,
    (scene, levels): (Res<Scene>, Res<Levels>),
) {
    let Pattern::Waiting(file) = &*pattern else { return };
    let Some(asset) = assets.get(&Character(file.clone())) else { return };
    let (Some(skin), Some(species)) = (asset.rig.skins.first(), species(asset)) else { return };
    debug_assert_eq!(skin.joints.len(), species.slot_count(), "blocks write the palette of the model's skin");
    let durations = CLIPS.map(|(name, _)| asset.clip(name).map_or(1.0, |clip| clip.clip.duration));
    let model = SkinnedModel { gltf: server.load(asset.model.clone()), rig: rigs.add(Rig::clone(&asset.rig)) };
    for walker in scene.walkers() {
        let play = |clip: usize| Play { clip, time: walker.phase() * durations[clip], weight: CLIPS[clip].1 };
        let mut puppet = commands.spawn((model.clone(), walker, Puppet([play(0), play(1)])));
        if levels.0 {
            puppet.insert(ScreenDetail::default());
        }
    }
    *pattern = Pattern::Ready { species: Box::new(species), durations };
}

fn species(asset: &CharacterAsset) -> Option<Species> {
    let clips: Vec<_> = CLIPS.iter().filter_map(|(name, _)| asset.clip(name)).collect();
    let sources: Vec<_> = clips.iter().map(|clip| RowSource::new(&clip.clip, Precision::default())).collect();
    let parts = SpeciesParts {
        skeleton: &asset.skeleton,
        skin: asset.rig.skins.first()?,
        limbs: &[],
        clips: &sources,
        masks: &[],
    };
    Species::new(&parts).inspect_err(|error| error!("{error}")).ok()
}

/// Moves everyone along their circle: for crowds without a controller.
pub(crate) fn walk_circles(time: Res<Time>, hills: Res<Hills>, mut walkers: Query<(&Walker, &mut Transform)>) {
    let seconds = time.elapsed_secs();
    walkers.par_iter_mut().for_each(|(walker, mut root)| *root = walker.place(&hills.0, seconds));
}

/// Characters that are posed at once.
const CHUNK: usize = 64;

fn play(
    time: Res<Time>,
    pattern: Res<Pattern>,
    mut arena: ResMut<SkinArena>,
    mut puppets: Query<(&mut Puppet, &ModelParts)>,
    palettes: Query<&Palette>,
    mut work: Local<Workspace>,
    mut batch: Local<Vec<([Play; 2], usize)>>,
) {
    let Pattern::Ready { species, durations } = &*pattern else { return };
    batch.clear();
    for (mut puppet, parts) in &mut puppets {
        for play in &mut puppet.0 {
            play.time = (play.time + time.delta_secs()) % durations[play.clip];
        }
        let whole = |palette: &&Palette| palette.range().len() == species.slot_count();
        if let Some(palette) = palettes.iter_many(parts.iter()).find(whole) {
            batch.push((puppet.0, palette.range().first()));
        }
    }
    if batch.is_empty() {
        return;
    }
    let matrices = arena.all_matrices_mut();
    for chunk in batch.chunks(CHUNK) {
        let mut layers = [[Layer::default()]; CHUNK];
        for (layer, (plays, _)) in layers.iter_mut().zip(chunk) {
            layer[0] = Layer { weight: 1.0, clips: plays, ..Layer::default() };
        }
        let mut actors = [Actor::default(); CHUNK];
        for ((actor, layers), (_, palette)) in actors.iter_mut().zip(&layers).zip(chunk) {
            *actor = Actor { layers, palette: *palette, ..Actor::default() };
        }
        pose(species, &actors[..chunk.len()], &mut work, matrices);
    }
}

/// How many models are there with their levels.
pub(crate) fn ready_with_levels(world: &mut World) -> usize {
    world.query::<&MeshLevels>().iter(world).count()
}

/// How many models are there.
pub(crate) fn ready(world: &mut World) -> usize {
    world.query::<&ModelStatus>().iter(world).filter(|model| model.is_ready()).count()
}
