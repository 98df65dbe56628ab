//! What a character carries: a lantern that hangs from its hand, a pack on its back; the free hand glides along a handrail.
//!
//! `cargo run --example sockets -- --film DIR` needs no display: it writes a contact sheet.

use core::f32::consts::FRAC_PI_2;
use std::{error::Error, path::Path};

use avian3d::prelude::*;
use bevy::prelude::*;
use surefoot::{
    SurefootPlugins,
    character::{
        Character,
        attach::Attach,
        intent::MoveIntent,
        schedule::{MotionSystems, PoseSystems},
    },
    debug::{ChainDebugPlugin, ChainGizmos},
    game::{
        engine::{self, WindowShape},
        film::{
            frames,
            sheet::ContactSheet,
            shutter::{Canvas, ShutterPlugin, developed, expose},
        },
        preflight::assets,
        touch::{TouchPlugin, Touchable, Touches},
    },
    math::spring::damp_vec3,
    rig::humanoid::HumanoidRole::{RightHand, UpperChest},
    skinning::model::ModelStatus,
    terrain::{SkyPlugin, SkyView, material::CourseMaterial, palette::Tint, shape::Shape},
};

/// The rail beside the way, metres: it goes along X, to the left of who walks toward +X.
const RAIL: Shape = Shape::Rail { length: 5.0, height: 0.95 };
const RAIL_ASIDE: f32 = 0.46;
/// Where the walk begins, and where it starts again, along X.
const START: f32 = -4.4;
const END: f32 = 4.6;
const SPEED: f32 = 1.2;
/// The camera's place and what it looks at, relative to the walker; seconds in which it makes up half of the way.
const EYE: Vec3 = Vec3::new(2.3, 1.55, 2.1);
const AIM: Vec3 = Vec3::new(0.15, 0.98, -0.1);
const FOLLOW_HALF_LIFE: f32 = 0.1;
/// Seconds into the walk of the pictures on the contact sheet; their width and height.
const MOMENTS: [f32; 8] = [0.8, 1.5, 1.9, 2.6, 3.3, 4.0, 5.6, 6.6];
const PICTURE: UVec2 = UVec2::new(960, 960);

/// Hangs straight down from where it is attached.
#[derive(Component)]
struct Hangs;

fn main() -> Result<(), Box<dyn Error>> {
    let assets = assets::find()?;
    let mut arguments = std::env::args().skip_while(|argument| argument != "--film");
    if let Some(folder) = arguments.nth(1) {
        let mut app = engine::headless(&assets);
        app.add_plugins((ShutterPlugin { size: PICTURE }, scene));
        return film(app, Path::new(&folder));
    }
    let mut app = engine::windowed(&assets, WindowShape { size: UVec2::new(960, 720), fullscreen: false });
    app.add_plugins(scene).add_systems(Update, toggle).run();
    Ok(())
}

fn scene(app: &mut App) {
    app.add_plugins((PhysicsPlugins::default(), SurefootPlugins, SkyPlugin, TouchPlugin, ChainDebugPlugin))
        .add_plugins(MaterialPlugin::<CourseMaterial>::default())
        .add_systems(Startup, (build, enter, open_view))
        .add_systems(FixedUpdate, walk.in_set(MotionSystems::Decide))
        .add_systems(Update, follow)
        // After the hand that carries it, and still in the same frame.
        .add_systems(PostUpdate, hang.after(PoseSystems::Attach).before(TransformSystems::Propagate));
}

fn build(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut course: ResMut<Assets<CourseMaterial>>,
) {
    let ground = StandardMaterial { perceptual_roughness: 0.95, ..Color::srgb(0.5, 0.55, 0.5).into() };
    commands.spawn((
        RigidBody::Static,
        Collider::half_space(Vec3::Y),
        Mesh3d(meshes.add(Plane3d::default().mesh().size(60.0, 60.0))),
        MeshMaterial3d(materials.add(ground)),
        Transform::default(),
    ));
    let mut rail = commands.spawn((
        RigidBody::Static,
        RAIL.collider(),
        Mesh3d(meshes.add(RAIL.facets(Tint::Steel).mesh())),
        MeshMaterial3d(course.add(CourseMaterial::default())),
        Transform::from_xyz(0.0, 0.0, -RAIL_ASIDE),
    ));
    if let Some(touchable) = Touchable::of(&RAIL) {
        rail.insert(touchable);
    }
}

fn enter(
    mut commands: Commands,
    server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let place = Transform::from_xyz(START, 0.0, 0.0).looking_to(Vec3::X, Vec3::Y);
    let hero =
        commands.spawn((Character(server.load("mannequin.character.ron")), Touches, Visibility::default(), place)).id();

    let brass = materials.add(StandardMaterial {
        metallic: 0.8,
        perceptual_roughness: 0.35,
        ..Color::srgb(0.55, 0.42, 0.16).into()
    });
    let flame = materials
        .add(StandardMaterial { emissive: LinearRgba::rgb(14.0, 7.0, 1.5), ..Color::srgb(1.0, 0.8, 0.4).into() });
    let mut part = |mesh: Mesh, material: &Handle<StandardMaterial>, at: Transform| {
        (Mesh3d(meshes.add(mesh)), MeshMaterial3d(material.clone()), at)
    };
    let ring = Torus { minor_radius: 0.006, major_radius: 0.045 };
    let upright = Transform::from_xyz(0.0, -0.03, 0.0).with_rotation(Quat::from_rotation_x(FRAC_PI_2));
    let lantern = [
        part(ring.into(), &brass, upright),
        part(Cone { radius: 0.07, height: 0.06 }.into(), &brass, Transform::from_xyz(0.0, -0.105, 0.0)),
        part(Cylinder::new(0.045, 0.13).into(), &flame, Transform::from_xyz(0.0, -0.2, 0.0)),
        part(Cylinder::new(0.068, 0.03).into(), &brass, Transform::from_xyz(0.0, -0.28, 0.0)),
    ];
    let light = PointLight { color: Color::srgb(1.0, 0.7, 0.35), intensity: 60_000.0, range: 6.0, ..default() };
    // In the bend of the fingers.
    let fist = Attach::to(RightHand).at(Transform::from_xyz(-0.095, -0.03, 0.01));
    commands.spawn((fist, Hangs, Visibility::default(), ChildOf(hero))).with_children(|lamp| {
        for part in lantern {
            lamp.spawn(part);
        }
        lamp.spawn((light, Transform::from_xyz(0.0, -0.2, 0.0)));
    });

    let canvas = StandardMaterial { perceptual_roughness: 0.9, ..Color::srgb(0.13, 0.2, 0.3).into() };
    let leather = StandardMaterial { perceptual_roughness: 0.7, ..Color::srgb(0.4, 0.24, 0.12).into() };
    let (canvas, leather) = (materials.add(canvas), materials.add(leather));
    let mut part = |mesh: Mesh, material: &Handle<StandardMaterial>, at: Transform| {
        (Mesh3d(meshes.add(mesh)), MeshMaterial3d(material.clone()), at)
    };
    let across = Quat::from_rotation_z(FRAC_PI_2);
    let pack = [
        part(Cuboid::new(0.3, 0.38, 0.15).into(), &canvas, Transform::default()),
        part(Cuboid::new(0.2, 0.16, 0.06).into(), &leather, Transform::from_xyz(0.0, -0.08, -0.1)),
        part(Capsule3d::new(0.065, 0.3).into(), &leather, Transform::from_xyz(0.0, 0.25, -0.01).with_rotation(across)),
    ];
    // The mannequin's own joints face +Z, so its back is -Z.
    let back = Attach::to(UpperChest).at(Transform::from_xyz(0.0, -0.06, -0.22));
    commands.spawn((back, Visibility::default(), ChildOf(hero))).with_children(|bag| {
        for part in pack {
            bag.spawn(part);
        }
    });
}

/// Upright in the world, whichever way the hand is turned; it looks where the character looks.
fn hang(mut things: Query<&mut Transform, With<Hangs>>) {
    for mut place in &mut things {
        place.rotation = Quat::IDENTITY;
    }
}

/// To the end, and from the start again.
fn walk(mut walkers: Query<(&mut Transform, &mut MoveIntent)>) {
    for (mut root, mut intent) in &mut walkers {
        if root.translation.x > END {
            root.translation.x = START;
        }
        intent.velocity = (Vec3::X - Vec3::Z * root.translation.z).normalize_or_zero() * SPEED;
    }
}

fn open_view(mut commands: Commands, canvas: Option<Res<Canvas>>) {
    let mut view = commands.spawn((SkyView, Transform::from_translation(EYE).looking_at(AIM, Vec3::Y)));
    if let Some(canvas) = canvas {
        view.insert(canvas.target());
    }
}

fn follow(
    mut view: Single<&mut Transform, (With<Camera>, Without<Character>)>,
    walker: Single<&Transform, With<Character>>,
    time: Res<Time>,
) {
    view.translation = damp_vec3(view.translation, walker.translation + EYE, FOLLOW_HALF_LIFE, time.delta_secs());
}

fn toggle(keys: Res<ButtonInput<KeyCode>>, mut gizmos: ResMut<GizmoConfigStore>) {
    if keys.just_pressed(KeyCode::F3) {
        let config = gizmos.config_mut::<ChainGizmos>().0;
        config.enabled = !config.enabled;
    }
}

fn film(mut app: App, folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    engine::finish(&mut app);
    while !app.world_mut().query::<&ModelStatus>().iter(app.world()).any(ModelStatus::is_ready) {
        app.update();
    }
    let mut sheet = ContactSheet::new(MOMENTS.len());
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
        sheet.add(moment, picture, format!("{seconds:.1} s"));
    }
    if let Some(sheet) = sheet.compose() {
        frames::save(&folder.join("sockets.png"), &sheet)?;
    }
    Ok(())
}
