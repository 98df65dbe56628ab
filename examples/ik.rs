//! Each IK solver with a target of its own: a limb with a pole, CCD with a hinge and a cone, FABRIK with cones, an aim.
//!
//! Drag a target with the left mouse button; F3 hides the limits. `cargo run --example ik -- --film DIR` needs no display:
//! it writes a contact sheet, a row for each solver.

use std::{error::Error, path::Path};

use avian3d::prelude::*;
use bevy::{camera::PerspectiveProjection, math::ops, prelude::*};
use image::imageops::crop_imm;
use surefoot::{
    SurefootPlugins,
    anim::leg::RIGHT,
    character::{
        Character,
        chains::{ChainJointSetup, ChainOf, IkChain, IkTarget, Pole, RestLimit},
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
    },
    rig::humanoid::HumanoidRole::{Head, LeftHand, RightHand, RightUpperArm},
    skinning::model::ModelStatus,
    terrain::{SkyPlugin, SkyView},
};

/// Metres from one character to the next.
const APART: f32 = 1.7;
/// The solvers, from left to right, and the middle of each target's way from its character's feet: right, up, forward.
const NAMES: [&str; 4] = ["two bones and a pole", "CCD: cone, hinge", "FABRIK: cones", "aim, shared"];
const MIDDLES: [Vec3; 4] =
    [Vec3::new(0.32, 1.2, 0.3), Vec3::new(0.3, 1.2, 0.34), Vec3::new(-0.35, 1.15, 0.5), Vec3::new(0.0, 1.5, 1.0)];
/// How far targets go to each side.
const SWAYS: [Vec3; 4] =
    [Vec3::new(0.24, 0.34, 0.16), Vec3::new(0.3, 0.4, 0.14), Vec3::new(0.3, 0.42, 0.2), Vec3::new(0.6, 0.4, 0.2)];
/// Radians a second of a target's way along each axis.
const PACE: Vec3 = Vec3::new(1.1, 1.7, 0.7);
/// Metres from the cursor at which a target is taken.
const GRIP: f32 = 0.15;
/// The camera: where it is, what it looks at, and its field of view in radians.
const EYE: Vec3 = Vec3::new(0.0, 1.5, 9.0);
const AIM: Vec3 = Vec3::new(0.0, 1.0, 0.0);
const FIELD: f32 = 0.25;
/// Seconds of the pictures on the contact sheet, four beside each other; width and height of all solvers together.
const MOMENTS: [f32; 4] = [1.0, 2.2, 3.1, 4.6];
const PICTURE: UVec2 = UVec2::new(1920, 640);

/// A ball that a character reaches for: which one's, and the seconds of its way.
#[derive(Component, Clone, Copy)]
struct Ball {
    lane: usize,
    clock: f32,
}

/// The ball in the player's hand.
#[derive(Resource, Default)]
struct Held(Option<Entity>);

fn main() -> Result<(), Box<dyn Error>> {
    let assets = assets::find()?;
    let mut arguments = std::env::args().skip_while(|argument| argument != "--film");
    if let Some(folder) = arguments.nth(1) {
        let mut app = engine::headless(&assets);
        app.add_plugins((ShutterPlugin { size: PICTURE }, scene));
        return film(app, Path::new(&folder));
    }
    let mut app = engine::windowed(&assets, WindowShape { size: UVec2::new(1440, 540), fullscreen: false });
    app.add_plugins(scene).add_systems(Update, (drag, toggle)).run();
    Ok(())
}

fn scene(app: &mut App) {
    app.add_plugins((PhysicsPlugins::default(), SurefootPlugins, SkyPlugin, ChainDebugPlugin))
        .init_resource::<Held>()
        .add_systems(Startup, (build, open_view))
        .add_systems(Update, sway);
    app.world_mut().resource_mut::<GizmoConfigStore>().config_mut::<ChainGizmos>().0.enabled = true;
}

fn build(
    mut commands: Commands,
    server: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let ground = StandardMaterial { perceptual_roughness: 0.95, ..Color::srgb(0.55, 0.58, 0.6).into() };
    commands.spawn((
        RigidBody::Static,
        Collider::half_space(Vec3::Y),
        Mesh3d(meshes.add(Plane3d::default().mesh().size(60.0, 60.0))),
        MeshMaterial3d(materials.add(ground)),
        Transform::default(),
    ));
    let ball = meshes.add(Sphere::new(0.035));
    let glow = StandardMaterial { unlit: true, ..Color::srgb(1.0, 0.35, 0.02).into() };
    let glow = materials.add(glow);
    for lane in 0..NAMES.len() {
        // They face the camera.
        let place =
            Transform::from_translation(origin(lane)).with_rotation(Quat::from_rotation_y(core::f32::consts::PI));
        let character = commands.spawn((Character(server.load("mannequin.character.ron")), place)).id();
        let ball = commands.spawn((
            Ball { lane, clock: 0.7 * lane as f32 },
            Mesh3d(ball.clone()),
            MeshMaterial3d(glow.clone()),
            Transform::default(),
        ));
        let target = IkTarget::Entity(ball.id(), Vec3::ZERO);
        commands.spawn((chain(lane).toward(target), ChainOf(character)));
    }
}

fn chain(lane: usize) -> IkChain {
    let ball = |joint: &str, swing: f32, give: f32| ChainJointSetup::new(joint, RestLimit::cone(swing)).giving(give);
    match lane {
        0 => IkChain::two_bone(RightUpperArm, RightHand).with_pole(Pole::Direction(Vec3::new(1.0, -0.6, 0.4))),
        1 => IkChain::arm(RIGHT),
        2 => IkChain::fabrik("chest", LeftHand)
            .with_joint(ball("chest", 0.35, 0.2))
            .with_joint(ball("upperChest", 0.25, 0.2))
            .with_joint(ball("leftShoulder", 0.4, 0.5))
            .with_joint(ball("leftUpperArm", 1.9, 1.0))
            .with_joint(ball("leftLowerArm", 2.3, 1.0)),
        _ => IkChain::aim("chest", Head, Vec3::NEG_Z)
            .with_effector(Vec3::new(0.0, 0.085, -0.072))
            .with_joint(ball("chest", 0.3, 0.2))
            .with_joint(ball("upperChest", 0.25, 0.2))
            .with_joint(ball("neck", 0.7, 0.5))
            .with_joint(ball("head", 0.9, 1.0)),
    }
}

fn origin(lane: usize) -> Vec3 {
    Vec3::X * (APART * (lane as f32 - 0.5 * (NAMES.len() - 1) as f32))
}

/// Balls go their ways, but for the one that is held.
fn sway(time: Res<Time>, held: Res<Held>, mut balls: Query<(Entity, &mut Ball, &mut Transform)>) {
    for (entity, mut ball, mut place) in &mut balls {
        if held.0 == Some(entity) {
            continue;
        }
        ball.clock += time.delta_secs();
        let phase = PACE * ball.clock;
        let away = Vec3::new(ops::sin(phase.x), ops::sin(phase.y), ops::cos(phase.z)) * SWAYS[ball.lane];
        // To the character's right is to the camera's left.
        place.translation = origin(ball.lane) + (MIDDLES[ball.lane] + away) * Vec3::new(-1.0, 1.0, 1.0);
    }
}

fn drag(
    buttons: Res<ButtonInput<MouseButton>>,
    window: Single<&Window>,
    view: Single<(&Camera, &GlobalTransform)>,
    mut held: ResMut<Held>,
    mut balls: Query<(Entity, &mut Transform), With<Ball>>,
) {
    if !buttons.pressed(MouseButton::Left) {
        held.0 = None;
        return;
    }
    let (camera, eye) = *view;
    let ray = window.cursor_position().and_then(|cursor| camera.viewport_to_world(eye, cursor).ok());
    let Some(ray) = ray else { return };
    let onto = |place: Vec3| {
        // In the plane that faces the camera, so that a ball keeps its distance.
        let depth = (place - ray.origin).dot(*eye.forward()) / ray.direction.dot(*eye.forward());
        ray.get_point(depth)
    };
    if buttons.just_pressed(MouseButton::Left) {
        let away = |place: &Transform| onto(place.translation).distance(place.translation);
        let nearest = balls.iter().map(|(entity, place)| (entity, away(place)));
        held.0 = nearest.filter(|ball| ball.1 < GRIP).min_by(|a, b| a.1.total_cmp(&b.1)).map(|ball| ball.0);
    }
    if let Some((_, mut place)) = held.0.and_then(|ball| balls.get_mut(ball).ok()) {
        place.translation = onto(place.translation);
    }
}

fn open_view(mut commands: Commands, canvas: Option<Res<Canvas>>) {
    let projection = Projection::from(PerspectiveProjection { fov: FIELD, ..default() });
    let mut view = commands.spawn((SkyView, projection, Transform::from_translation(EYE).looking_at(AIM, Vec3::Y)));
    if let Some(canvas) = canvas {
        view.insert(canvas.target());
    }
}

fn toggle(keys: Res<ButtonInput<KeyCode>>, mut gizmos: ResMut<GizmoConfigStore>) {
    if keys.just_pressed(KeyCode::F3) {
        let config = gizmos.config_mut::<ChainGizmos>().0;
        config.enabled = !config.enabled;
    }
}

/// A row for each solver, a column for each moment.
fn film(mut app: App, folder: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(folder)?;
    engine::finish(&mut app);
    let ready = |app: &mut App| {
        app.world_mut().query::<&ModelStatus>().iter(app.world()).filter(|model| model.is_ready()).count()
    };
    while ready(&mut app) < NAMES.len() {
        app.update();
    }
    let mut sheet = ContactSheet::new(NAMES.len() * MOMENTS.len());
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
        let width = PICTURE.x / NAMES.len() as u32;
        for (lane, name) in NAMES.into_iter().enumerate() {
            let view = crop_imm(&picture, width * lane as u32, 0, width, PICTURE.y).to_image();
            sheet.add(lane * MOMENTS.len() + moment, view, format!("{name}, {seconds:.1} s"));
        }
    }
    if let Some(sheet) = sheet.compose() {
        frames::save(&folder.join("ik.png"), &sheet)?;
    }
    Ok(())
}
