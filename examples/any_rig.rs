//! Any glTF model, posed and drawn by this crate without a character: `cargo run --example any_rig -- FILE.glb`.
//!
//! The space bar goes on to the next clip. `surefoot view FILE.glb` shows more of a model, and walks it.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use surefoot::{
    anim::pose::Pose,
    rig::{Rig, loader::RigPlugin},
    skinning::{SkinPose, SkinnedModel, SkinningPlugin},
};

/// What is shown when no file is named.
const MANNEQUIN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/mannequin.glb");

/// The file's name in the folder of assets.
#[derive(Resource)]
struct File(String);

/// Index of the clip that plays, and its time in seconds.
#[derive(Resource, Default)]
struct Playing {
    clip: usize,
    time: f32,
}

fn main() {
    let file = std::env::args_os().nth(1).map_or_else(|| PathBuf::from(MANNEQUIN), PathBuf::from);
    let folder = std::path::absolute(file.parent().unwrap_or(Path::new("."))).unwrap_or_default();
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    App::new()
        .add_plugins((
            DefaultPlugins.set(AssetPlugin { file_path: folder.to_string_lossy().into_owned(), ..default() }),
            RigPlugin,
            SkinningPlugin::default(),
        ))
        .insert_resource(File(name))
        .init_resource::<Playing>()
        .add_systems(Startup, setup)
        .add_systems(Update, (choose, play, look_at).chain())
        .run();
}

fn setup(mut commands: Commands, assets: Res<AssetServer>, file: Res<File>) {
    // One file, read twice: meshes and materials by Bevy, skeleton and clips by this crate.
    let model = SkinnedModel { gltf: assets.load(file.0.clone()), rig: assets.load(file.0.clone()) };
    commands.spawn((model, SkinPose::default()));
    commands.spawn((Camera3d::default(), AmbientLight { brightness: 600.0, ..default() }, Transform::default()));
    commands.spawn((DirectionalLight::default(), Transform::default().looking_to(Vec3::new(-0.4, -0.8, 0.6), Vec3::Y)));
}

fn choose(keys: Res<ButtonInput<KeyCode>>, mut playing: ResMut<Playing>) {
    if keys.just_pressed(KeyCode::Space) {
        *playing = Playing { clip: playing.clip + 1, time: 0.0 };
    }
}

fn play(
    time: Res<Time>,
    rigs: Res<Assets<Rig>>,
    mut playing: ResMut<Playing>,
    mut models: Query<(&SkinnedModel, &mut SkinPose)>,
) {
    playing.time += time.delta_secs();
    for (model, mut pose) in &mut models {
        let Some(rig) = rigs.get(&model.rig) else { continue };
        if pose.0.is_empty() {
            pose.0 = Pose::rest(&rig.skeleton);
        }
        if let Some(clip) = rig.clips.get(playing.clip % rig.clips.len().max(1)) {
            clip.sample(&rig.skeleton, playing.time, pose.0.locals_mut());
            pose.0.update_model(&rig.skeleton);
        }
    }
}

/// Steps back until the whole skeleton is in view.
fn look_at(poses: Query<&SkinPose>, mut cameras: Query<&mut Transform, With<Camera3d>>) {
    for (SkinPose(pose), mut camera) in poses.iter().zip(&mut cameras) {
        let joints = || pose.positions();
        let (Some(low), Some(high)) = (joints().reduce(Vec3::min), joints().reduce(Vec3::max)) else { continue };
        let (middle, size) = (0.5 * (low + high), (high - low).length().max(1.0));
        *camera = Transform::from_translation(middle + Vec3::new(0.4, 0.3, -1.5) * size).looking_at(middle, Vec3::Y);
    }
}
