//! What is filmed: the hero on the scripted walk over the course, by a camera low beside it that shows both feet.

use core::f32::consts::TAU;

use bevy::{
    light::ShadowFilteringMethod,
    math::{Vec3Swizzles, ops},
    prelude::*,
};

use super::{
    route::{Leg, Route},
    table, target,
};
use crate::{
    camera::{CameraPlugin, CameraSystems, OrbitCamera, OrbitCameraConfig},
    character::{intent::MoveIntent, locomotion::Locomotion, motion::MotionState, schedule::MotionSystems},
    game::level::Hero,
    math::spring::damp,
    measure::record::{MeasurePlugin, Recorder},
    terrain::{Heightfield, SkyView, course},
};

/// Seconds the hero stands still before the walk.
const PAUSE: f32 = 1.0;
/// Metres from the camera to the hero: the whole body in view with some ground before it.
const DISTANCE: f32 = 3.2;
/// Metres above the hero's feet of the picture's middle: low, since the film is about feet.
const AIM_HEIGHT: f32 = 0.8;
/// Pitch of the camera in radians: over handrails and boulders, so that it need not come near to see past them.
const PITCH: f32 = 0.36;
/// Seconds in which the camera makes up half of a turn of the hero.
const TURN_HALF_LIFE: f32 = 0.9;
/// The camera swings from beside the hero to before it and back: middle and width of the swing in radians, and seconds for one.
const SWING_MIDDLE: f32 = 1.75;
const SWING_WIDTH: f32 = 0.55;
const SWING_TIME: f32 = 12.0;

/// The way of the hero.
#[derive(Component)]
struct OnRoute(Route);

/// The heading that the camera films, radians about +Y; behind the hero's own in every turn.
#[derive(Component, Default)]
struct Filmed(f32);

pub(super) fn plugin(app: &mut App) {
    app.add_plugins((CameraPlugin, MeasurePlugin))
        .add_observer(begin)
        .add_systems(FixedUpdate, lead.in_set(MotionSystems::Decide))
        .add_systems(PostUpdate, swing.before(CameraSystems::Follow));
}

fn begin(
    hero: On<Add, Hero>,
    roots: Query<&Transform>,
    field: Res<Heightfield>,
    canvas: Res<super::Canvas>,
    mut commands: Commands,
) {
    let route = course::route(&field);
    let legs = route.windows(2).map(|pair| Leg { to: pair[1].position.xz(), speed: pair[0].speed }).collect();
    let root = roots.get(hero.entity).copied().unwrap_or_default();
    commands.entity(hero.entity).insert((OnRoute(Route::new(root.translation, legs)), Recorder::default()));
    commands.spawn((
        SkyView,
        // Drawing by software: smooth edges would double the time of a picture.
        Msaa::Off,
        ShadowFilteringMethod::Hardware2x2,
        target(&canvas),
        OrbitCamera { pitch: PITCH, distance: DISTANCE, ..OrbitCamera::around(hero.entity) },
        OrbitCameraConfig { pivot_height: AIM_HEIGHT, shoulder: 0.0, ..default() },
        Filmed(yaw_of(&root)),
    ));
}

fn lead(mut heroes: Query<(&Transform, &mut OnRoute, &mut MoveIntent)>, time: Res<Time>) {
    for (root, mut route, mut intent) in &mut heroes {
        let heading = if time.elapsed_secs() < PAUSE { None } else { route.0.heading(root.translation) };
        intent.velocity = heading.map_or(Vec3::ZERO, |heading| heading.direction * heading.speed);
    }
}

fn swing(mut cameras: Query<(&mut OrbitCamera, &mut Filmed)>, heroes: Query<&Transform, With<Hero>>, time: Res<Time>) {
    for (mut camera, mut filmed) in &mut cameras {
        let Ok(root) = heroes.get(camera.target) else { continue };
        // The shortest way round: the nearest yaw that means the same heading.
        let turn = (yaw_of(root) - filmed.0 + TAU * 0.5).rem_euclid(TAU) - TAU * 0.5;
        filmed.0 = damp(filmed.0, filmed.0 + turn, TURN_HALF_LIFE, time.delta_secs());
        let swing = ops::sin(time.elapsed_secs() * TAU / SWING_TIME);
        camera.yaw = filmed.0 + SWING_MIDDLE + SWING_WIDTH * swing;
    }
}

fn yaw_of(root: &Transform) -> f32 {
    root.rotation.to_euler(EulerRot::YXZ).0
}

/// What the contact sheet says below the picture at `seconds`.
pub(super) fn caption(world: &mut World, seconds: f32) -> String {
    let mut heroes = world.query_filtered::<(&MotionState, Option<&Locomotion>), With<Hero>>();
    heroes.single(world).map_or_else(
        |_| format!("{seconds:.1} s"),
        |(motion, locomotion)| {
            let state = locomotion.map_or("", Locomotion::state);
            format!("{seconds:4.1} s  {state}  {:.1} m/s", motion.ground_velocity.with_y(0.0).length())
        },
    )
}

/// The measures of the walk.
pub(super) fn measures(world: &mut World) -> String {
    let mut heroes = world.query_filtered::<&Recorder, With<Hero>>();
    heroes.single(world).map_or_else(|_| String::new(), |recorder| table::of(&recorder.frames))
}
