//! The engine's own import of a glTF file, its scenes spawned and its `AnimationPlayer` moving them.
//!
//! No renderer: meshes and materials are left out, nodes and clips are not. Nodes by glTF index, in the file's space.

use std::path::Path;

use bevy::{
    animation::AnimatedBy,
    asset::{LoadState, RenderAssetUsages},
    gltf::{GltfLoaderSettings, GltfPlugin},
    image::ImagePlugin,
    mesh::{MeshPlugin, morph::MorphWeights},
    prelude::*,
    world_serialization::{WorldInstance, WorldSerializationPlugin},
};
use gltf::scene::Node;

use super::PeerError;

/// Longest wait for the file, in updates of about a millisecond.
const PATIENCE: usize = 20_000;

/// The file as the engine plays it.
pub(super) struct Engine {
    app: App,
    /// Entities by node; `None` where no scene holds the node.
    nodes: Vec<Option<Entity>>,
    /// Transforms that clips start from.
    rest: Vec<(Entity, Transform)>,
    players: Vec<Entity>,
    /// Places of the clips in the graph.
    clips: Vec<AnimationNodeIndex>,
}

impl Engine {
    /// Loads `name` from `folder` and spawns all its scenes.
    pub(super) fn load(folder: &Path, name: &str) -> Result<Self, PeerError> {
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins,
            TransformPlugin,
            AssetPlugin { file_path: folder.to_string_lossy().into_owned(), ..default() },
            ImagePlugin::default(),
            MeshPlugin,
            WorldSerializationPlugin,
            AnimationPlugin,
            GltfPlugin::default(),
        ));
        app.finish();
        app.cleanup();
        let file = load(&mut app, name)?;
        let world = app.world_mut();
        let gltf = world.resource_mut::<Assets<Gltf>>().remove(&file);
        let gltf = gltf.ok_or_else(|| PeerError::Engine("the file vanished".to_owned()))?;
        let roots: Vec<_> = gltf.scenes.iter().map(|scene| world.spawn(WorldAssetRoot(scene.clone())).id()).collect();
        let mut graph = AnimationGraph::new();
        let clips = gltf.animations.iter().map(|clip| graph.add_clip(clip.clone(), 1.0, graph.root)).collect();
        let graph = world.resource_mut::<Assets<AnimationGraph>>().add(graph);
        wait(&mut app, |world| roots.iter().all(|root| world.get::<WorldInstance>(*root).is_some()))?;
        app.update();

        let document = gltf.source.as_ref().ok_or_else(|| PeerError::Engine("it kept no source".to_owned()))?;
        let mut nodes = vec![None; document.nodes().len()];
        for (scene, root) in document.scenes().zip(roots) {
            // The engine puts an entity of its own between what is spawned and the scene's nodes.
            let own = children(app.world(), root).first().copied().unwrap_or(root);
            collect(app.world(), own, scene.nodes(), &mut nodes)?;
        }
        let world = app.world_mut();
        for node in document.nodes() {
            let targets = node.mesh().and_then(|mesh| Some(mesh.primitives().next()?.morph_targets().len()));
            // Left out with the meshes, but clips write to it.
            if let (Some(entity), Some(count @ 1..)) = (nodes[node.index()], targets)
                && let Ok(weights) = MorphWeights::new(vec![0.0; count], None)
            {
                world.entity_mut(entity).insert(weights);
            }
        }
        let of_node = |node: &Entity| Some((*node, *world.get::<Transform>(*node)?));
        let rest = nodes.iter().flatten().filter_map(of_node).collect();
        let mut players: Vec<Entity> =
            nodes.iter().flatten().filter_map(|node| Some(world.get::<AnimatedBy>(*node)?.0)).collect();
        players.sort();
        players.dedup();
        for player in &players {
            world.entity_mut(*player).insert(AnimationGraphHandle(graph.clone()));
        }
        Ok(Self { app, nodes, rest, players, clips })
    }

    /// Poses all nodes at `time` seconds of clip number `clip`, or at rest.
    pub(super) fn pose(&mut self, clip: Option<usize>, time: f32) {
        let clip = clip.and_then(|clip| self.clips.get(clip));
        let world = self.app.world_mut();
        for (node, rest) in &self.rest {
            if let Some(mut transform) = world.get_mut::<Transform>(*node) {
                *transform = *rest;
            }
        }
        for player in &self.players {
            if let Some(mut player) = world.get_mut::<AnimationPlayer>(*player) {
                player.stop_all();
                if let Some(clip) = clip {
                    player.play(*clip).seek_to(time).pause();
                }
            }
        }
        self.app.update();
    }

    /// Morph weights of the node's mesh.
    pub(super) fn weights(&self, node: usize) -> Option<&[f32]> {
        let entity = self.nodes.get(node).copied()??;
        self.app.world().get::<MorphWeights>(entity).map(MorphWeights::weights)
    }

    /// Where the node is, in the file's space; `None` where no scene holds it.
    pub(super) fn node(&self, node: usize) -> Option<GlobalTransform> {
        let entity = self.nodes.get(node).copied()??;
        self.app.world().get::<GlobalTransform>(entity).copied()
    }
}

fn load(app: &mut App, name: &str) -> Result<Handle<Gltf>, PeerError> {
    let settings = |settings: &mut GltfLoaderSettings| {
        settings.load_meshes = RenderAssetUsages::empty();
        settings.load_materials = RenderAssetUsages::empty();
        settings.load_cameras = false;
        settings.load_lights = false;
        settings.include_source = true;
        // It would refuse files over extensions that say nothing about motion; this crate's import has checked the rest.
        settings.validate = false;
    };
    let server = app.world().resource::<AssetServer>();
    let file: Handle<Gltf> = server.load_builder().with_settings(settings).load(name.to_owned());
    let state = |world: &World| world.resource::<AssetServer>().load_state(&file);
    wait(app, |world| matches!(state(world), LoadState::Loaded | LoadState::Failed(_)))?;
    match state(app.world()) {
        LoadState::Failed(error) => Err(PeerError::Engine(error.to_string())),
        _ => Ok(file),
    }
}

fn wait(app: &mut App, done: impl Fn(&World) -> bool) -> Result<(), PeerError> {
    for _ in 0..PATIENCE {
        app.update();
        if done(app.world()) {
            return Ok(());
        }
        std::thread::sleep(core::time::Duration::from_millis(1));
    }
    Err(PeerError::Engine("the file did not load in time".to_owned()))
}

fn children(world: &World, entity: Entity) -> Vec<Entity> {
    world.get::<Children>(entity).map_or_else(Vec::new, |children| children.iter().collect())
}

/// Walks the document and the spawned tree side by side; without meshes, cameras and lights they have the same shape.
fn collect<'a>(
    world: &World,
    parent: Entity,
    nodes: impl Iterator<Item = Node<'a>>,
    entities: &mut [Option<Entity>],
) -> Result<(), PeerError> {
    let spawned = children(world, parent);
    for (place, node) in nodes.enumerate() {
        let entity = spawned.get(place).copied();
        let entity =
            entity.ok_or_else(|| PeerError::Engine(format!("node {} was not spawned in its place", node.index())))?;
        entities[node.index()].get_or_insert(entity);
        collect(world, entity, node.children(), entities)?;
    }
    Ok(())
}
