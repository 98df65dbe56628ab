//! A crowd of walking mannequins on hills, without rendering: what `crowd` and `versus` measure.

use std::{hint::black_box, path::Path, time::Duration};

use avian3d::prelude::*;
use bevy::{
    asset::{AssetPlugin, LoadState},
    prelude::*,
    time::TimeUpdateStrategy,
};
use surefoot::{
    SurefootPlugins,
    anim::skin::JointMatrix,
    character::{Character, animator::CharacterPose, intent::MoveIntent, schedule::PoseSystems},
    rig::{Rig, character::CharacterAsset},
    testing::World as Ground,
};

/// Mannequins in a row, two metres apart, so that nobody walks off the hills in the seconds of a measurement; as many rows.
const ROW: usize = 30;
/// From one hills to the next.
const HILLS: Vec3 = Vec3::new(100.0, 0.0, 0.0);

/// The crowd, all of them changing from walk to run for as long as anyone looks: two clips in every blend.
pub(crate) struct Mannequins {
    pub(crate) app: App,
}

/// Skinning matrices of everyone.
#[derive(Resource, Default)]
struct Palettes(Vec<JointMatrix>);

#[derive(Resource)]
struct Skin(Handle<Rig>);

impl Mannequins {
    /// `count` of them; `watch` may add systems of its own.
    pub(crate) fn new(count: usize, watch: impl FnOnce(&mut App)) -> Self {
        let mut app = stage(count);
        watch(&mut app);
        app.finish();
        app.cleanup();
        let (character, rig) = load(&mut app);
        app.insert_resource(Skin(rig));
        let side = (count as f32).sqrt().ceil().min(ROW as f32) as usize;
        for index in 0..count {
            let (hills, index_on_hills) = (index / (ROW * ROW), index % (ROW * ROW));
            let (column, row) = ((index_on_hills % side) as f32, (index_on_hills / side) as f32);
            let half = side as f32 * 0.5;
            let place = HILLS * hills as f32 + Vec3::new(column - half, 0.5, row - half) * 2.0;
            let heading = Quat::from_rotation_y(index as f32);
            app.world_mut().spawn((
                Character(character.clone()),
                Transform::from_translation(place).with_rotation(heading),
                MoveIntent { velocity: heading * Vec3::NEG_Z * 1.4, ..default() },
            ));
        }
        for _ in 0..60 {
            app.update();
        }
        let mut intents = app.world_mut().query::<&mut MoveIntent>();
        for mut intent in intents.iter_mut(app.world_mut()) {
            intent.velocity *= 2.5;
        }
        for _ in 0..40 {
            app.update();
        }
        Self { app }
    }

    /// 1/60 s of everything: physics, locomotion, probes, plants, poses, palettes.
    pub(crate) fn frame(&mut self) {
        self.app.update();
    }
}

fn stage(count: usize) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins.set(TaskPoolPlugin { task_pool_options: TaskPoolOptions::with_num_threads(1) }),
        TransformPlugin,
        AssetPlugin { file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").to_owned(), ..default() },
        PhysicsPlugins::default(),
        SurefootPlugins,
    ))
    .init_resource::<Palettes>()
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)))
    .add_systems(PostUpdate, palettes.in_set(PoseSystems::Palette));
    for hills in 0..count.div_ceil(ROW * ROW) {
        for piece in Ground::hills().pieces {
            let place = piece.transform.with_translation(piece.transform.translation + HILLS * hills as f32);
            app.world_mut().spawn((RigidBody::Static, piece.collider(), place));
        }
    }
    app
}

fn load(app: &mut App) -> (Handle<CharacterAsset>, Handle<Rig>) {
    let server = app.world().resource::<AssetServer>().clone();
    let character: Handle<CharacterAsset> = server.load(Path::new("mannequin.character.ron"));
    let rig: Handle<Rig> = server.load(Path::new("mannequin.glb"));
    let loaded = |state| matches!(state, Some(LoadState::Loaded));
    while !loaded(server.get_load_state(&character)) || !loaded(server.get_load_state(&rig)) {
        if let Some(LoadState::Failed(error)) = server.get_load_state(&character) {
            panic!("{error}");
        }
        app.update();
    }
    let mut assets = app.world_mut().resource_mut::<Assets<CharacterAsset>>();
    if let Some(asset) = assets.get_mut_untracked(&character) {
        for transition in
            asset.file.locomotion.transitions.iter_mut().flatten().filter(|transition| transition.to == "run")
        {
            transition.fade = 1000.0;
        }
    }
    (character, rig)
}

fn palettes(
    skin: Option<Res<Skin>>,
    rigs: Res<Assets<Rig>>,
    poses: Query<&CharacterPose>,
    mut palettes: ResMut<Palettes>,
) {
    let Some(rig) = skin.and_then(|skin| rigs.get(&skin.0)) else { return };
    let Some(skin) = rig.skins.first() else { return };
    palettes.0.resize(poses.iter().len() * skin.joints.len(), JointMatrix::IDENTITY);
    for (pose, out) in poses.iter().zip(palettes.0.chunks_mut(skin.joints.len())) {
        skin.write_palette(&pose.pose, out);
    }
    black_box(&palettes.0);
}
