//! A headless world that steps by hand.

use std::time::Duration;

use avian3d::prelude::*;
use bevy::{math::ops, prelude::*, time::TimeUpdateStrategy};
use surefoot::{
    character::{
        intent::MoveIntent,
        motion::{CharacterMotion, MotionPlugin, MotionState},
    },
    measure::summary::Measures,
    rig::tuning::motion::MotionConfig,
};

/// The world with physics and the controller, `hz` fixed steps a second, one step per update.
pub fn world(hz: f64) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, PhysicsPlugins::default(), MotionPlugin))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1))
        .insert_resource(Time::<Fixed>::from_hz(hz));
    app.finish();
    app.cleanup();
    app
}

/// Lets frames of `frame` seconds pass instead of fixed steps.
pub fn frames_of(app: &mut App, frame: f64) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(frame)));
}

/// Updates `count` times.
pub fn updates(app: &mut App, count: usize) {
    for _ in 0..count {
        app.update();
    }
}

/// A box that doesn't move.
pub fn block(app: &mut App, centre: Vec3, size: Vec3, rotation: Quat) -> Entity {
    let place = Transform::from_translation(centre).with_rotation(rotation);
    app.world_mut().spawn((RigidBody::Static, Collider::cuboid(size.x, size.y, size.z), place)).id()
}

/// Ground at height 0, 200 m square.
pub fn flat(app: &mut App) -> Entity {
    block(app, Vec3::Y * -0.5, Vec3::new(200.0, 1.0, 200.0), Quat::IDENTITY)
}

/// A ramp that rises toward -Z from z = 0 at height 0, `length` m long in plan.
pub fn ramp(app: &mut App, degrees: f32, length: f32) -> Entity {
    let angle = degrees.to_radians();
    let rotation = Quat::from_rotation_x(angle);
    let slope = length / ops::cos(angle);
    let middle = rotation * Vec3::new(0.0, -0.5, -slope * 0.5);
    block(app, middle, Vec3::new(10.0, 1.0, slope), rotation)
}

/// Stairs of `count` steps up toward -Z from z = 0, and a landing behind them.
pub fn stairs(app: &mut App, count: usize, rise: f32, run: f32) {
    for step in 1..=count {
        let (height, front) = (step as f32 * rise, -(step as f32 - 1.0) * run);
        let depth = if step == count { 10.0 } else { run };
        let centre = Vec3::new(0.0, height * 0.5, front - depth * 0.5);
        block(app, centre, Vec3::new(6.0, height, depth), Quat::IDENTITY);
    }
}

/// A character with nothing but the controller.
pub fn walker(app: &mut App, at: Vec3) -> Entity {
    app.world_mut().spawn((CharacterMotion, Transform::from_translation(at))).id()
}

/// A character with nothing but the controller, that no slope slows.
pub fn runner(app: &mut App, at: Vec3) -> Entity {
    let walker = walker(app, at);
    app.world_mut().entity_mut(walker).insert(MotionConfig { climb_slowing: 0.0, ..default() });
    walker
}

/// What the character shall want from now on.
pub fn intend(app: &mut App, walker: Entity, intent: MoveIntent) {
    app.world_mut().entity_mut(walker).insert(intent);
}

/// Walk with this velocity from now on.
pub fn go(app: &mut App, walker: Entity, velocity: Vec3) {
    intend(app, walker, MoveIntent { velocity, ..default() });
}

/// The root as the last tick left it.
pub fn root(app: &App, walker: Entity) -> Vec3 {
    app.world().entity(walker).get::<Position>().map_or(Vec3::NAN, |position| position.0)
}

/// The root as the last frame showed it, eased between two ticks.
pub fn shown(app: &App, walker: Entity) -> Vec3 {
    app.world().entity(walker).get::<Transform>().map_or(Vec3::NAN, |transform| transform.translation)
}

/// What the controller did last.
pub fn state(app: &App, walker: Entity) -> MotionState {
    app.world().entity(walker).get::<MotionState>().cloned().unwrap_or_default()
}

/// No joint turns or starts more than twice as fast as in the clips that play: nothing seems to jump.
pub fn assert_no_pop(what: &str, measures: &Measures) {
    let (speed, jump) = (measures.pop_speed, measures.pop_jump);
    println!("{what}: pops {speed:.2} and {jump:.2}");
    assert!(
        speed <= 2.0 && jump <= 2.0,
        "{what} turns a joint {speed:.2} times as fast as the clips, with {jump:.2} times their jump"
    );
}
