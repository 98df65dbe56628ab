//! The crowd by the engine alone: its glTF scenes, animation player and skinning, as any game without this crate has them.

use bevy::{prelude::*, world_serialization::WorldInstanceReady};

use super::{
    ours::{CLIPS, walk_circles},
    scene::{Hills, Scene, Walker},
};

const MODEL: &str = "mannequin.glb";

/// Adds the crowd.
pub(crate) fn characters(app: &mut App) {
    app.add_systems(Startup, load).add_systems(Update, (spawn, walk_circles).chain());
}

/// The model, and once it is there, what plays.
#[derive(Resource)]
struct Model(Handle<Gltf>);

#[derive(Component)]
struct Playing {
    graph: Handle<AnimationGraph>,
    clips: [(AnimationNodeIndex, f32); 2],
}

/// Goes on a character that plays.
#[derive(Component)]
struct Plays;

fn load(mut commands: Commands, assets: Res<AssetServer>) {
    commands.insert_resource(Model(assets.load(MODEL)));
}

fn spawn(
    mut commands: Commands,
    model: Res<Model>,
    gltfs: Res<Assets<Gltf>>,
    clips: Res<Assets<AnimationClip>>,
    mut graphs: ResMut<Assets<AnimationGraph>>,
    scene: Res<Scene>,
    hills: Res<Hills>,
    walkers: Query<(), With<Walker>>,
) {
    let Some(gltf) = gltfs.get(&model.0).filter(|_| walkers.is_empty()) else { return };
    let mut graph = AnimationGraph::new();
    let nodes = CLIPS.map(|(name, weight)| {
        let clip = gltf.named_animations.get(name).cloned().unwrap_or_default();
        let duration = clips.get(&clip).map_or(1.0, AnimationClip::duration);
        (graph.add_clip(clip, weight, graph.root), duration)
    });
    let graph = graphs.add(graph);
    let Some(root) = gltf.default_scene.clone() else { return };
    for walker in scene.walkers() {
        let playing = Playing { graph: graph.clone(), clips: nodes };
        commands.spawn((WorldAssetRoot(root.clone()), walker, playing, walker.place(&hills.0, 0.0))).observe(begin);
    }
}

fn begin(
    ready: On<WorldInstanceReady>,
    mut commands: Commands,
    characters: Query<(&Playing, &Walker)>,
    children: Query<&Children>,
    mut players: Query<&mut AnimationPlayer>,
) {
    let Ok((playing, walker)) = characters.get(ready.entity) else { return };
    for child in children.iter_descendants(ready.entity) {
        let Ok(mut player) = players.get_mut(child) else { continue };
        for (node, duration) in playing.clips {
            player.play(node).repeat().seek_to(walker.phase() * duration);
        }
        commands.entity(child).insert(AnimationGraphHandle(playing.graph.clone()));
        commands.entity(ready.entity).insert(Plays);
    }
}

/// How many play.
pub(crate) fn ready(world: &mut World) -> usize {
    world.query::<&Plays>().iter(world).count()
}
