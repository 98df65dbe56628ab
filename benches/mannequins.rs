//! A crowd of walking mannequins on hills, without rendering: what `crowd` and `versus` measure.

use std::{f32::consts::FRAC_PI_8, hint::black_box, path::Path, time::Duration};

use avian3d::prelude::*;
use bevy::{
    app::TaskPoolThreadAssignmentPolicy,
    asset::{AssetPlugin, LoadState},
    math::ops,
    prelude::*,
    time::TimeUpdateStrategy,
};
use surefoot::{
    SurefootPlugins,
    anim::matrix::JointMatrix,
    character::{
        Character,
        animator::CharacterPose,
        crowd::{Crowd, PaletteJob},
        detail::{Detail, Pacing},
        intent::MoveIntent,
        levels::DetailLevels,
        schedule::{PoseClock, PoseSystems},
    },
    rig::{Rig, character::CharacterAsset},
    testing::World as Ground,
};

/// Mannequins in a row, two metres apart, so that nobody walks off the hills in the seconds of a measurement; as many rows.
const ROW: usize = 30;
/// Hills side by side, and from one to the next; more lie behind them.
const HILLS_IN_A_ROW: usize = 4;
const APART: f32 = 100.0;

/// The crowd, all of them changing from walk to run for as long as anyone looks: two clips in every blend.
pub(crate) struct Mannequins {
    pub(crate) app: App,
}

/// Who looks on: nobody, when everyone has everything; or a camera, and as many threads that work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Viewer {
    /// Everyone has everything.
    None,
    /// Stands on the field's near edge, looks over it, and everyone has the level of detail of their size in its view.
    Camera,
}

/// Skinning matrices of everyone.
#[derive(Resource, Default)]
pub(crate) struct Palettes(pub(crate) Vec<JointMatrix>);

#[derive(Resource)]
struct Skin(Handle<Rig>);

impl Mannequins {
    /// `count` of them on so many threads; `watch` may add systems of its own.
    pub(crate) fn new(count: usize, viewer: Viewer, threads: usize, watch: impl FnOnce(&mut App)) -> Self {
        let mut app = stage(count, threads);
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
            let place = place_of(hills) + Vec3::new(column - half, 0.5, row - half) * 2.0;
            let heading = Quat::from_rotation_y(index as f32);
            let mut mannequin = app.world_mut().spawn((
                Character(character.clone()),
                Transform::from_translation(place).with_rotation(heading),
                MoveIntent { velocity: heading * Vec3::NEG_Z * 1.4, ..default() },
            ));
            if viewer == Viewer::Camera {
                mannequin.insert((Detail::default(), Level(0)));
            }
        }
        if viewer == Viewer::Camera {
            app.insert_resource(PoseClock::at_most(1)).add_systems(PostUpdate, look_on);
        }
        for _ in 0..60 {
            app.update();
        }
        let mut intents = app.world_mut().query::<&mut MoveIntent>();
        for mut intent in intents.iter_mut(app.world_mut()) {
            intent.velocity *= 2.5;
        }
        // With a viewer until everyone has settled on a level.
        for _ in 0..if viewer == Viewer::Camera { 150 } else { 40 } {
            app.update();
        }
        Self { app }
    }

    /// 1/60 s of everything: physics, locomotion, probes, plants, poses, palettes.
    pub(crate) fn frame(&mut self) {
        self.app.update();
    }
}

/// Index of a mannequin's level.
#[derive(Component)]
struct Level(usize);

/// Half the angle that the camera sees, up and down; across it is 16 to 9.
const HALF_VIEW: f32 = FRAC_PI_8;

/// What [`ScreenDetail`](surefoot::skinning::ScreenDetail) does where there is a camera.
fn look_on(mut levels: Local<DetailLevels>, mut crowd: Query<(&Transform, &mut Level, &mut Detail)>) {
    let levels = &mut *levels;
    let eye = Vec3::new(0.5 * (HILLS_IN_A_ROW - 1) as f32 * APART, 3.0, 0.5 * APART);
    let (up, across) = (ops::tan(HALF_VIEW), ops::tan(HALF_VIEW) * 16.0 / 9.0);
    for (place, mut level, mut detail) in &mut crowd {
        let away = place.translation - eye;
        let margin = 1.8 + levels.margin;
        let seen =
            -away.z > -margin && away.x.abs() < -away.z * across + margin && away.y.abs() < -away.z * up + margin;
        let wanted = if seen {
            level.0 = levels.level(0.9 / (-away.z * up).max(0.1), level.0);
            levels.levels[level.0].detail
        } else {
            levels.unseen(*detail)
        };
        detail.set_if_neq(wanted);
    }
}

fn place_of(hills: usize) -> Vec3 {
    let (column, row) = (hills % HILLS_IN_A_ROW, hills / HILLS_IN_A_ROW);
    Vec3::new(column as f32, 0.0, -(row as f32)) * APART
}

fn stage(count: usize, threads: usize) -> App {
    let mut app = App::new();
    let compute = TaskPoolThreadAssignmentPolicy {
        min_threads: threads,
        max_threads: threads,
        ..TaskPoolOptions::default().compute
    };
    let task_pool_options = TaskPoolOptions { compute, ..TaskPoolOptions::with_num_threads(1) };
    app.add_plugins((
        MinimalPlugins.set(TaskPoolPlugin { task_pool_options }),
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
            let place = piece.transform.with_translation(piece.transform.translation + place_of(hills));
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
    poses: Query<(Entity, &Character, Option<&Pacing>, Ref<CharacterPose>)>,
    crowd: Crowd,
    mut palettes: ResMut<Palettes>,
    mut jobs: Local<Vec<PaletteJob>>,
) {
    let Some(rig) = skin.and_then(|skin| rigs.get(&skin.0)) else { return };
    let Some(skin) = rig.skins.first() else { return };
    let len = skin.joints.len();
    palettes.0.resize(poses.iter().len() * len, JointMatrix::IDENTITY);
    // As skinning does: who wasn't posed keeps its matrices.
    jobs.clear();
    jobs.extend(poses.iter().enumerate().filter_map(|(index, (entity, character, pacing, pose))| {
        let kind = Crowd::kind(character, pacing);
        let job = PaletteJob { first: index * len, len, character: entity, part: 0, kind };
        let shown_anew = kind.is_some() && pacing.is_some_and(|pacing| crowd.is_due(entity, pacing));
        (shown_anew || pose.is_changed()).then_some(job)
    }));
    crowd.write(&mut jobs, &mut palettes.0, |job, out| {
        if let Ok((_, _, _, pose)) = poses.get(job.character) {
            skin.write_palette(&pose.pose, out);
        }
    });
    black_box(&palettes.0);
}
