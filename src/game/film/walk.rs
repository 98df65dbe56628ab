//! What is filmed: the hero on the scripted walk over the course, by a camera that shows all of it, feet above all.

use bevy::{math::Vec3Swizzles, prelude::*};

use super::{
    operator::{self, Operator},
    route::{Leg, Route},
    shutter::Canvas,
    table,
};
use crate::{
    character::{intent::MoveIntent, locomotion::Locomotion, motion::MotionState, schedule::MotionSystems},
    game::level::Hero,
    measure::record::{MeasurePlugin, Recorder},
    rig::tuning::motion::MotionConfig,
    terrain::{Heightfield, SkyView, course},
};

/// Seconds the hero stands still before the walk.
const PAUSE: f32 = 1.0;
/// The way of the hero.
#[derive(Component)]
pub(super) struct OnRoute(pub(super) Route);

pub(super) fn plugin(app: &mut App) {
    app.add_plugins((MeasurePlugin, operator::plugin))
        .add_observer(begin)
        .add_systems(FixedUpdate, lead.in_set(MotionSystems::Decide));
}

fn begin(
    hero: On<Add, Hero>,
    roots: Query<&Transform>,
    field: Res<Heightfield>,
    canvas: Res<Canvas>,
    mut commands: Commands,
) {
    let route = course::route(&field);
    let legs = route.windows(2).map(|pair| Leg { to: pair[1].position.xz(), speed: pair[0].speed }).collect();
    let root = roots.get(hero.entity).copied().unwrap_or_default();
    commands.entity(hero.entity).insert((OnRoute(Route::new(root.translation, legs)), Recorder::default()));
    commands.spawn((SkyView, canvas.target(), Operator::default()));
}

fn lead(mut heroes: Query<(&Transform, &MotionConfig, &mut OnRoute, &mut MoveIntent)>, time: Res<Time>) {
    for (root, config, mut route, mut intent) in &mut heroes {
        let heading = if time.elapsed_secs() < PAUSE { None } else { route.0.heading(root.translation) };
        // Short legs take longer.
        let pace = config.walk_speed / MotionConfig::default().walk_speed;
        intent.velocity = heading.map_or(Vec3::ZERO, |heading| heading.direction * (heading.speed * pace));
    }
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
