//! What foot IK adds: the same walk over stairs and rubble twice, on the left without it, on the right with it.
//!
//! F3 shows how the feet are placed. `cargo run --example feet -- --film DIR` needs no display: it writes a contact sheet with
//! each moment without foot IK above the same moment with it.

use std::{error::Error, path::PathBuf};

use avian3d::prelude::*;
use bevy::{
    camera::{ClearColorConfig, Viewport},
    prelude::*,
};
use image::imageops::crop_imm;
use surefoot::{
    SurefootPlugins,
    character::{Character, intent::MoveIntent, schedule::MotionSystems},
    debug::{FootDebugPlugin, FootGizmos},
    game::{
        engine::{self, WindowShape},
        film::{
            frames,
            sheet::ContactSheet,
            shutter::{Canvas, ShutterPlugin, developed, expose},
        },
        preflight::assets,
    },
    math::spring::damp_vec3,
    rig::character::CharacterAsset,
    skinning::model::ModelStatus,
    terrain::{Heightfield, Piece, SkyPlugin, SkyView, course, material::CourseMaterial, palette::Tint, shape::Shape},
};

/// Metres that the second course lies below the first, which hides it.
const APART: f32 = 200.0;
/// Where the walk begins, and the line at which it turns round, along Z; metres.
const START: f32 = 13.2;
const END: f32 = -3.0;
const SPEED: f32 = 1.4;
/// The camera's place and what it looks at, relative to the walker; seconds in which it makes up half of the way.
const EYE: Vec3 = Vec3::new(1.5, 0.85, -0.85);
const AIM: Vec3 = Vec3::new(0.0, 0.3, -0.08);
const FOLLOW_HALF_LIFE: f32 = 0.1;
/// Seconds into the walk of the pictures on the contact sheet, four beside each other; width and height of both views.
const MOMENTS: [f32; 8] = [1.18, 2.8, 4.96, 5.32, 7.84, 9.28, 10.18, 10.36];
const PICTURE: UVec2 = UVec2::new(1920, 640);

/// One of the two walks: 0 without foot IK, 1 with it.
#[derive(Component, Clone, Copy)]
struct Side(usize);

fn main() -> Result<(), Box<dyn Error>> {
    let assets = assets::find()?;
    let mut arguments = std::env::args().skip_while(|argument| argument != "--film");
    if let Some(folder) = arguments.nth(1) {
        let mut app = engine::headless(&assets);
        app.add_plugins((ShutterPlugin { size: PICTURE }, scene));
        return film(app, &folder.into());
    }
    let mut app = engine::windowed(&assets, WindowShape { size: UVec2::new(1280, 640), fullscreen: false });
    app.add_plugins(scene).run();
    Ok(())
}

fn scene(app: &mut App) {
    app.add_plugins((PhysicsPlugins::default(), SurefootPlugins, SkyPlugin, FootDebugPlugin))
        .add_plugins(MaterialPlugin::<CourseMaterial>::default())
        .add_systems(Startup, (build, open_views))
        .add_systems(FixedUpdate, walk.in_set(MotionSystems::Decide))
        .add_systems(Update, (enter, split, follow, toggle));
}

/// Stairs as they stand on the game's course, then its rubble right behind them, on plain ground; twice.
fn build(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<CourseMaterial>>) {
    let material = materials.add(CourseMaterial::default());
    let mut pieces: Vec<Piece> = course::pieces(&Heightfield::from_fn(1, 1.0, |_, _| 0.0));
    pieces.retain(|piece| ["stairs up", "landing", "top of the stairs", "stairs down", "rubble"].contains(&piece.name));
    for piece in &mut pieces {
        if piece.name == "rubble" {
            let (across, along) = (piece.position.z, piece.position.x - 3.5);
            piece.position = Vec3::new(across, piece.position.y, 2.2 - along);
        } else {
            piece.position.x += 10.0;
        }
    }
    let ground = Shape::Block { size: Vec3::new(60.0, 1.0, 60.0) };
    pieces.push(Piece { shape: ground, tint: Tint::DarkConcrete, position: Vec3::NEG_Y, ..pieces[0].clone() });
    for piece in &pieces {
        let mesh = meshes.add(piece.shape.facets(piece.tint).mesh());
        for side in 0..2 {
            let place = Transform::from_translation(piece.position + origin(side)).with_rotation(piece.rotation);
            let look = (Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()));
            commands.spawn((RigidBody::Static, piece.shape.collider(), look, place));
        }
    }
}

/// Both walkers come in together, once their file is there.
fn enter(
    mut commands: Commands,
    server: Res<AssetServer>,
    mut assets: ResMut<Assets<CharacterAsset>>,
    mut hero: Local<Handle<CharacterAsset>>,
    walkers: Query<(), With<Character>>,
) {
    *hero = server.load("mannequin.character.ron");
    let Some(mut without) = assets.get(&*hero).cloned().filter(|_| walkers.is_empty()) else { return };
    without.file.foot_ik.enabled = false;
    for (side, file) in [assets.add(without), hero.clone()].into_iter().enumerate() {
        commands.spawn((Side(side), Character(file), Transform::from_translation(origin(side) + Vec3::Z * START)));
    }
}

fn origin(side: usize) -> Vec3 {
    Vec3::NEG_Y * (APART * side as f32)
}

/// To the end, and from the start again.
fn walk(mut walkers: Query<(&mut Transform, &mut MoveIntent)>) {
    for (mut root, mut intent) in &mut walkers {
        if root.translation.z < END {
            root.translation.z = START;
        }
        // Pushed aside, it comes back to the middle.
        intent.velocity = (Vec3::NEG_Z - Vec3::X * root.translation.x).normalize_or_zero() * SPEED;
    }
}

fn open_views(mut commands: Commands, canvas: Option<Res<Canvas>>) {
    for side in 0..2 {
        // The second camera must not wipe what the first one drew.
        let clear_color = if side == 0 { ClearColorConfig::Default } else { ClearColorConfig::None };
        let camera = Camera { order: side as isize, clear_color, ..default() };
        let place = Transform::from_translation(EYE).looking_at(AIM, Vec3::Y);
        let mut view = commands.spawn((SkyView, Side(side), camera, place));
        if let Some(canvas) = &canvas {
            view.insert(canvas.target());
        }
    }
}

fn split(mut views: Query<(&Side, &mut Camera)>) {
    for (side, mut camera) in &mut views {
        let Some(size) = camera.physical_target_size() else { continue };
        let half = UVec2::new(size.x / 2, size.y);
        let physical_position = UVec2::new(half.x * side.0 as u32, 0);
        camera.viewport = Some(Viewport { physical_position, physical_size: half, ..default() });
    }
}

fn follow(
    mut views: Query<(&Side, &mut Transform), With<Camera>>,
    walkers: Query<(&Side, &Transform), Without<Camera>>,
    time: Res<Time>,
) {
    for (side, mut view) in &mut views {
        let Some((_, root)) = walkers.iter().find(|(other, _)| other.0 == side.0) else { continue };
        view.translation = damp_vec3(view.translation, root.translation + EYE, FOLLOW_HALF_LIFE, time.delta_secs());
    }
}

fn toggle(keys: Option<Res<ButtonInput<KeyCode>>>, mut gizmos: ResMut<GizmoConfigStore>) {
    if keys.is_some_and(|keys| keys.just_pressed(KeyCode::F3)) {
        let config = gizmos.config_mut::<FootGizmos>().0;
        config.enabled = !config.enabled;
    }
}

/// Rows of four moments without foot IK, each above the same moments with it.
fn film(mut app: App, folder: &PathBuf) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    app.world_mut().resource_mut::<GizmoConfigStore>().config_mut::<FootGizmos>().0.enabled = true;
    engine::finish(&mut app);
    while app.world_mut().query::<&ModelStatus>().iter(app.world()).filter(|model| model.is_ready()).count() < 2 {
        app.update();
    }
    let mut sheet = ContactSheet::new(2 * MOMENTS.len());
    let mut ticks = 0;
    for (moment, seconds) in MOMENTS.into_iter().enumerate() {
        let until = (seconds * engine::TICKS_PER_SECOND as f32) as u32;
        expose(&mut app, moment, until - ticks);
        ticks = until;
        let picture = loop {
            app.update();
            if let Some((_, picture)) = developed(&mut app).pop() {
                break picture;
            }
        };
        for (side, words) in ["without", "with"].into_iter().enumerate() {
            let half = PICTURE / UVec2::new(2, 1);
            let view = crop_imm(&picture, half.x * side as u32, 0, half.x, half.y).to_image();
            let place = moment / 4 * 8 + side * 4 + moment % 4;
            sheet.add(place, view, format!("{seconds:.1} s {words} foot IK"));
        }
    }
    if let Some(sheet) = sheet.compose() {
        frames::save(&folder.join("feet.png"), &sheet)?;
    }
    Ok(())
}
