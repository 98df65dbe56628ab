//! Skins in pictures: this crate's skinning and the engine's draw the same pixels of the same file and moment.

use std::{
    path::Path,
    time::{Duration, Instant},
};

use bevy::prelude::*;
use surefoot::{
    anim::pose::Pose,
    rig::{Rig, loader::RigPlugin},
    skinning::{Morphs, SkinPose, SkinnedModel, SkinningPlugin, model::ModelStatus},
    testing::peer::load_rig,
};

use super::{rigs, written};
use crate::render_support::{Difference, Studio};

/// Two renderers may round an edge differently: this many pixels of 57,600.
const EDGE_PIXELS: usize = 30;
/// Share of the first clip at which pictures are taken.
const MOMENT: f32 = 0.4;
/// Longest wait for a file.
const PATIENCE: Duration = Duration::from_secs(60);

/// What two pictures have in common.
struct Seen {
    difference: Difference,
    drawn: usize,
}

/// Draws `path` by both, in the same place.
fn seen(name: &str, path: &Path) -> Seen {
    let rig = load_rig(path).unwrap_or_else(|error| panic!("{name}: {error}"));
    let time = rig.clips.first().map_or(0.0, |clip| clip.duration * MOMENT);
    let folder = path.parent().expect("it lies in a folder");
    let file = path.file_name().expect("it has a name").to_string_lossy().into_owned();
    let mut studio = Studio::in_folder(folder, (RigPlugin, SkinningPlugin::default()));
    let bounds = frame(&mut studio, &rig, time);
    let empty = studio.picture();

    let server = studio.world().resource::<AssetServer>().clone();
    let model = SkinnedModel { gltf: server.load(file.clone()), rig: server.load(file.clone()) };
    let ours = studio.world().spawn((model, SkinPose(posed(&rig, time)))).id();
    until(&mut studio, name, |world| world.get::<ModelStatus>(ours).is_some_and(ModelStatus::is_ready));
    if let (Some(clip), Some(mut morphs)) = (rig.clips.first(), studio.world().get_mut::<Morphs>(ours)) {
        let names = morphs.names().to_vec();
        for mesh in rig.meshes.iter().filter(|mesh| mesh.morph_weights.len() == names.len()) {
            let mut weights = mesh.morph_weights.clone();
            clip.morph_weights(mesh.joint, time, &mut weights);
            for (name, weight) in names.iter().zip(weights) {
                assert!(morphs.set(name, weight), "{name} is one of its own");
            }
        }
    }
    let own = studio.picture();
    own.save(&format!("peer_{name}_ours"));
    studio.world().despawn(ours);

    let scene = GltfAssetLabel::Scene(0).from_asset(file.clone());
    let clip = GltfAssetLabel::Animation(0).from_asset(file);
    let place = Transform::from_matrix(Mat4::from(rig.skeleton.model_from_root));
    let theirs = studio.world().spawn((WorldAssetRoot(server.load(scene)), place)).id();
    until(&mut studio, name, |world| world.get::<Children>(theirs).is_some());
    if !rig.clips.is_empty() {
        let clip: Handle<AnimationClip> = server.load(clip);
        // A clip that nobody held is loaded anew, on a busy machine after the picture.
        until(&mut studio, name, |world| world.resource::<Assets<AnimationClip>>().contains(&clip));
        let (graph, node) = AnimationGraph::from_clip(clip);
        let graph = studio.add(graph);
        let players: Vec<Entity> = {
            let world = studio.world();
            world.query_filtered::<Entity, With<AnimationPlayer>>().iter(world).collect()
        };
        for player in players {
            let mut entity = studio.world().entity_mut(player);
            entity.insert(AnimationGraphHandle(graph.clone()));
            let mut player = entity.get_mut::<AnimationPlayer>().expect("it is one");
            player.play(node).seek_to(time).pause();
        }
    }
    let engine = studio.picture();
    engine.save(&format!("peer_{name}_engine"));
    assert!(bounds > 0.0, "{name} has no size");
    Seen { difference: own.difference(&engine, 2), drawn: engine.difference(&empty, 20).beyond }
}

fn posed(rig: &Rig, time: f32) -> Pose {
    let mut pose = Pose::rest(&rig.skeleton);
    if let Some(clip) = rig.clips.first() {
        clip.sample(&rig.skeleton, time, pose.locals_mut());
        pose.update_model(&rig.skeleton);
    }
    pose
}

/// Looks at all joints of the pose from behind and above, where the sun is; returns their extent in metres.
fn frame(studio: &mut Studio, rig: &Rig, time: f32) -> f32 {
    let pose = posed(rig, time);
    let places: Vec<Vec3> = rig.skeleton.joints().map(|joint| pose.position(joint)).collect();
    let low = places.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = places.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    let (middle, size) = (0.5 * (low + high), (high - low).length().max(0.5));
    studio.look(middle + Vec3::new(0.5, 0.4, 1.2).normalize() * 1.4 * size, middle);
    size
}

fn until(studio: &mut Studio, name: &str, done: impl Fn(&World) -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !done(studio.world()) {
        assert!(Instant::now() < deadline, "{name} is not there after {PATIENCE:?}");
        studio.step();
    }
}

#[test]
fn skins_look_as_in_the_engine() {
    let shown = [
        "byte_weights",
        "short_weights",
        "matrices",
        "many_skins",
        "one_skin_many_meshes",
        "no_inverse_binds",
        "mirrored_centimetres",
        "sparse_values",
        "splines",
        "shared_buffers",
    ];
    for (name, file) in rigs::all().into_iter().filter(|(name, _)| shown.contains(name)) {
        let Seen { difference, drawn } = seen(name, &written(&format!("drawn_{name}"), &file));
        assert!(drawn > 500, "{name} covers only {drawn} pixels");
        assert!(difference.beyond <= EDGE_PIXELS, "{name}: {difference:?} of {drawn} pixels");
    }
}

#[test]
fn three_hundred_joints_look_as_in_the_engine() {
    let (name, file) = rigs::all().into_iter().find(|(name, _)| *name == "three_hundred_joints").expect("it is there");
    let Seen { difference, drawn } = seen(name, &written("drawn_three_hundred", &file));
    assert!(drawn > 500, "{name} covers only {drawn} pixels");
    assert!(difference.beyond <= EDGE_PIXELS, "{name}: {difference:?} of {drawn} pixels");
}

#[test]
fn the_mannequin_looks_as_in_the_engine() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/mannequin.glb");
    let Seen { difference, drawn } = seen("mannequin", &path);
    assert!(drawn > 1_000, "it covers only {drawn} pixels");
    assert!(difference.beyond <= EDGE_PIXELS, "{difference:?} of {drawn} pixels");
}
