//! How long a thousand walking mannequins take on one core: two clips sampled and blended, feet placed on a heightfield,
//! skinning matrices written.
//!
//! Run by `cargo bench`; `cargo bench --bench crowd -- 500` takes another number. Prints the median time of a frame,
//! of the pose stages together and each alone, and of one character.

use std::{
    hint::black_box,
    path::Path,
    time::{Duration, Instant},
};

use avian3d::prelude::*;
use bevy::{
    asset::{AssetPlugin, LoadState},
    math::Affine3A,
    prelude::*,
    time::TimeUpdateStrategy,
};
use surefoot::{
    SurefootPlugins,
    character::{
        Character, animator::CharacterPose, intent::MoveIntent, locomotion::Locomotion, schedule::PoseSystems,
    },
    rig::{Rig, character::CharacterAsset},
    testing::World as Ground,
};

/// When the last pose stage ended, and how long each took.
#[derive(Resource, Default)]
struct Watch {
    last: Option<Instant>,
    laps: [Vec<Duration>; STAGES.len()],
}

/// What is timed, in order.
const STAGES: [&str; 6] = ["locomote", "sample", "plant", "look", "model", "palette"];

/// Skinning matrices of everyone.
#[derive(Resource, Default)]
struct Palettes(Vec<Affine3A>);

#[derive(Resource)]
struct Skin(Handle<Rig>);

fn main() {
    let titles: String = STAGES.iter().map(|stage| format!("{stage:>10}")).collect();
    println!("{:>10} {:>10} {:>10} {:>13} |{titles} ms", "characters", "frame ms", "poses ms", "µs/character");
    let asked: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    for count in if asked.is_empty() { vec![1, 100, 1_000] } else { asked } {
        let (frame, stages) = measure(count);
        let poses: Duration = stages.iter().sum();
        let each = poses.as_secs_f64() * 1e6 / count as f64;
        let stages: String = stages.iter().map(|stage| format!("{:>10.3}", stage.as_secs_f64() * 1e3)).collect();
        let (frame, poses) = (frame.as_secs_f64() * 1e3, poses.as_secs_f64() * 1e3);
        println!("{count:>10} {frame:>10.3} {poses:>10.3} {each:>13.2} |{stages}");
    }
}

/// Median of a whole frame and of each of its pose stages.
fn measure(count: usize) -> (Duration, [Duration; STAGES.len()]) {
    let mut app = stage();
    let (character, rig) = load(&mut app);
    app.insert_resource(Skin(rig));
    let side = (count as f32).sqrt().ceil() as usize;
    for index in 0..count {
        let (column, row) = ((index % side) as f32, (index / side) as f32);
        let place = Vec3::new(column * 2.0 - side as f32, 1.0, row * 2.0 - side as f32);
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
    // From now on everyone runs, and the change of gait lasts: two clips in every blend.
    let mut intents = app.world_mut().query::<&mut MoveIntent>();
    for mut intent in intents.iter_mut(app.world_mut()) {
        intent.velocity *= 2.5;
    }
    for _ in 0..40 {
        app.update();
    }
    let heard = |locomotion: &Locomotion| {
        (0..locomotion.machine.len()).filter(|state| locomotion.machine.weight(*state) > 0.0).count()
    };
    let mut machines = app.world_mut().query::<&Locomotion>();
    let blended = machines.iter(app.world()).filter(|locomotion| heard(locomotion) >= 2).count();
    app.world_mut().resource_mut::<Watch>().laps = Default::default();
    let mut frames: Vec<Duration> = (0..60)
        .map(|_| {
            let begun = Instant::now();
            app.update();
            begun.elapsed()
        })
        .collect();
    let mut laps = app.world_mut().resource_mut::<Watch>().laps.clone();
    if blended < count {
        println!("{blended} of {count} characters blend two clips, the others have met an obstacle");
    }
    (median(&mut frames), laps.each_mut().map(|laps| median(laps)))
}

fn stage() -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins.set(TaskPoolPlugin { task_pool_options: TaskPoolOptions::with_num_threads(1) }),
        TransformPlugin,
        AssetPlugin { file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").to_owned(), ..default() },
        PhysicsPlugins::default(),
        SurefootPlugins,
    ))
    .init_resource::<Watch>()
    .init_resource::<Palettes>()
    .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)))
    .add_systems(
        PostUpdate,
        (
            start.before(PoseSystems::Locomote),
            lap::<0>.after(PoseSystems::Locomote).before(PoseSystems::Sample),
            lap::<1>.after(PoseSystems::Sample).before(PoseSystems::Plant),
            lap::<2>.after(PoseSystems::Plant).before(PoseSystems::Look),
            lap::<3>.after(PoseSystems::Look).before(PoseSystems::Model),
            lap::<4>.after(PoseSystems::Model).before(PoseSystems::Reach),
            palettes.in_set(PoseSystems::Palette),
            lap::<5>.after(PoseSystems::Palette).before(TransformSystems::Propagate),
        ),
    );
    for piece in Ground::hills().pieces {
        app.world_mut().spawn((RigidBody::Static, piece.collider(), piece.transform));
    }
    app.finish();
    app.cleanup();
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
    palettes.0.resize(poses.iter().len() * skin.joints.len(), Affine3A::IDENTITY);
    for (pose, out) in poses.iter().zip(palettes.0.chunks_mut(skin.joints.len())) {
        for ((matrix, joint), inverse_bind) in out.iter_mut().zip(&skin.joints).zip(&skin.inverse_bind) {
            *matrix = pose.pose.model(*joint) * *inverse_bind;
        }
    }
    black_box(&palettes.0);
}

fn start(mut watch: ResMut<Watch>) {
    watch.last = Some(Instant::now());
}

fn lap<const STAGE: usize>(mut watch: ResMut<Watch>) {
    let now = Instant::now();
    if let Some(last) = watch.last.replace(now) {
        watch.laps[STAGE].push(now - last);
    }
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort();
    times.get(times.len() / 2).copied().unwrap_or_default()
}
