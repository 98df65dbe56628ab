//! Films scenes on flat ground: for each one sheet of pictures, from the side and from ahead.

use std::path::Path;

use avian3d::prelude::*;
use bevy::{camera::Viewport, light::CascadeShadowConfigBuilder, prelude::*};

use super::{
    FilmError, PATIENCE, frames, load,
    scenes::{self, PICTURES, Scene},
    sheet::ContactSheet,
    shutter::{Canvas, ShutterPlugin, developed, expose},
    walk,
};
use crate::{
    SurefootPlugins,
    character::{Character, animator::Actions, intent::MoveIntent, schedule::MotionSystems},
    game::{
        cli::Options,
        engine::{self, TICKS_PER_SECOND},
        level::{HERO, Hero, Loading, watch_loading},
    },
    measure::{
        record::{MeasurePlugin, Recorder},
        summary::summarize,
    },
};

/// Width and height of a picture, pixels: two upright views beside each other.
const SIZE: UVec2 = UVec2::new(480, 360);
/// Metres from the cameras to the actor, and their height above its feet.
const DISTANCE: f32 = 4.4;
const HEIGHT: f32 = 0.95;
/// Direction in which the light shines.
const LIGHT: Vec3 = Vec3::new(0.6, -0.9, 0.45);
/// Metres between the lines on the ground.
const LINES: f32 = 0.5;

/// The scene that plays, and its clock in seconds.
#[derive(Resource)]
struct Now {
    scene: Scene,
    clock: f32,
}

/// Where a camera stands, from the actor.
#[derive(Component)]
struct View(Vec3);

/// Films the scene of this name, or all of them for `all`, into one sheet each.
///
/// # Errors
/// [`FilmError`]: no such scene, nothing loaded, or nothing could be written.
pub(super) fn run(name: &str, options: &Options, assets: &Path) -> Result<(), FilmError> {
    let mut scenes = scenes::all();
    let known: Vec<_> = scenes.iter().map(|scene| scene.name).collect();
    scenes.retain(|scene| name == "all" || scene.name == name);
    let Some(first) = scenes.first() else {
        return Err(FilmError::Scene(format!("`{name}`; there are {}", known.join(", "))));
    };
    std::fs::create_dir_all(&options.out).map_err(|error| FilmError::file(&options.out, error))?;
    let mut app = studio(options.size.unwrap_or(SIZE), assets, first.clone());
    for scene in scenes {
        let file = options.out.join(format!("{}.png", scene.name));
        film(&mut app, scene, &file)?;
    }
    Ok(())
}

fn studio(size: UVec2, assets: &Path, scene: Scene) -> App {
    let mut app = engine::headless(assets);
    app.insert_resource(Now { scene, clock: 0.0 })
        .init_resource::<Loading>()
        .add_plugins((ShutterPlugin { size }, PhysicsPlugins::default(), SurefootPlugins, MeasurePlugin))
        .insert_resource(ClearColor(Color::srgb(0.62, 0.70, 0.78)))
        .add_systems(Startup, (lay_ground, set_cameras))
        .add_systems(Update, watch_loading.run_if(resource_equals(Loading::Waiting)))
        .add_systems(FixedUpdate, act.in_set(MotionSystems::Decide))
        .add_systems(PostUpdate, follow.before(TransformSystems::Propagate));
    engine::finish(&mut app);
    app
}

/// Begins the scene's action.
fn begin(scene: &Scene, world: &mut World, actor: Entity) {
    if let (Some(action), Some(mut actions)) = (scene.action, world.get_mut::<Actions>(actor)) {
        actions.play(action);
    }
}

/// Plays one scene with a fresh actor and writes its sheet.
fn film(app: &mut App, scene: Scene, file: &Path) -> Result<(), FilmError> {
    let start = Transform::from_translation(Vec3::Y * scene.height);
    let world = app.world_mut();
    let character: Handle<_> = world.resource::<AssetServer>().load(HERO);
    let actor = world.spawn((Hero, Character(character), start, Recorder::default())).id();
    world.insert_resource(Loading::default());
    world.insert_resource(Now { scene: scene.clone(), clock: 0.0 });
    load(app)?;
    let mut sheet = ContactSheet::new(PICTURES);
    let mut captions = Vec::new();
    let mut ticks = 0;
    let mut taken = 0;
    for picture in 0..PICTURES {
        let due = ((scene.time_of(picture) * TICKS_PER_SECOND as f32).round() as u32).max(ticks + 1);
        expose(app, picture, due - ticks);
        ticks = due;
        captions.push(walk::caption(app.world_mut(), ticks as f32 / TICKS_PER_SECOND as f32 - scene.from));
        taken += keep(app, &mut sheet, &captions);
        if picture == 0 {
            begin(&scene, app.world_mut(), actor);
        }
    }
    for _ in 0..PATIENCE {
        if taken < PICTURES {
            app.update();
            taken += keep(app, &mut sheet, &captions);
        }
    }
    if let Some(recorder) = app.world().get::<Recorder>(actor) {
        let measures = summarize(&recorder.frames);
        println!(
            "{:<18} drift {:5.1} mm  sinks {:4.1} mm  pops {:4.1} / {:4.1} of clips  leg {:.3}",
            scene.name,
            measures.drift_max,
            measures.penetration_max,
            measures.pop_speed,
            measures.pop_jump,
            measures.extension_max,
        );
    }
    app.world_mut().despawn(actor);
    match sheet.compose() {
        Some(sheet) if taken == PICTURES => frames::save(file, &sheet),
        _ => Err(FilmError::NoPicture(taken)),
    }
}

/// Puts finished pictures on the sheet; returns how many.
fn keep(app: &mut App, sheet: &mut ContactSheet, captions: &[String]) -> usize {
    let pictures = developed(app);
    let count = pictures.len();
    for (picture, image) in pictures {
        sheet.add(picture, image, captions[picture].clone());
    }
    count
}

fn act(mut now: ResMut<Now>, mut actors: Query<&mut MoveIntent, With<Hero>>, time: Res<Time>) {
    for mut intent in &mut actors {
        *intent = now.scene.intent_at(now.clock);
    }
    now.clock += time.delta_secs();
}

fn lay_ground(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut paint = |shade: f32| {
        materials.add(StandardMaterial { perceptual_roughness: 1.0, ..Color::srgb(shade, shade, shade).into() })
    };
    commands.spawn((
        DirectionalLight { illuminance: 9_000.0, shadow_maps_enabled: true, ..default() },
        CascadeShadowConfigBuilder { num_cascades: 1, maximum_distance: 9.0, ..default() }.build(),
        Transform::default().looking_to(LIGHT, Vec3::Y),
    ));
    let (ground, line) = (paint(0.42), paint(0.3));
    let size = Vec3::new(120.0, 1.0, 120.0);
    commands.spawn((
        RigidBody::Static,
        Collider::cuboid(size.x, size.y, size.z),
        Transform::from_xyz(0.0, -0.5, 0.0),
        Mesh3d(meshes.add(Cuboid::from_size(size))),
        MeshMaterial3d(ground),
    ));
    let (along, across) = (
        meshes.add(Plane3d::default().mesh().size(0.02, 60.0)),
        meshes.add(Plane3d::default().mesh().size(60.0, 0.02)),
    );
    for index in -60..=60 {
        let place = index as f32 * LINES;
        commands.spawn((Mesh3d(along.clone()), MeshMaterial3d(line.clone()), Transform::from_xyz(place, 0.001, 0.0)));
        commands.spawn((Mesh3d(across.clone()), MeshMaterial3d(line.clone()), Transform::from_xyz(0.0, 0.001, place)));
    }
}

/// One camera to the actor's left, one ahead and to its right.
fn set_cameras(mut commands: Commands, canvas: Res<Canvas>, images: Res<Assets<Image>>) {
    let Some(size) = images.get(canvas.image()).map(Image::size) else { return };
    let half = UVec2::new(size.x / 2, size.y);
    for (order, from) in [(0, Vec3::NEG_X), (1, Vec3::new(0.5, 0.15, -0.85))] {
        let corner = UVec2::new(half.x * order, 0);
        commands.spawn((
            Camera3d::default(),
            AmbientLight { brightness: 900.0, ..default() },
            Msaa::Off,
            canvas.target(),
            Camera {
                order: order as isize,
                viewport: Some(Viewport { physical_position: corner, physical_size: half, ..default() }),
                ..default()
            },
            Projection::from(PerspectiveProjection { fov: 30f32.to_radians(), ..default() }),
            View(from.normalize() * DISTANCE),
        ));
    }
}

fn follow(actors: Query<&Transform, With<Hero>>, mut cameras: Query<(&View, &mut Transform), Without<Hero>>) {
    let Ok(actor) = actors.single() else { return };
    let middle = actor.translation + Vec3::Y * HEIGHT;
    for (view, mut camera) in &mut cameras {
        *camera = Transform::from_translation(middle + view.0).looking_at(middle, Vec3::Y);
    }
}
