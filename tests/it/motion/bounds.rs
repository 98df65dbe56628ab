//! Nonsense, sameness, teleports.

use bevy::prelude::*;
use surefoot::{character::intent::MoveIntent, rig::tuning::motion::MotionConfig};

use crate::support::*;

const HZ: f64 = 64.0;

#[test]
fn an_intent_of_nonsense_is_harmless() {
    let mut app = world(HZ);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 10);
    for nonsense in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        let vector = Vec3::new(nonsense, nonsense, 1.0);
        intend(&mut app, walker, MoveIntent { velocity: vector, facing: Some(vector), jump: true, ..default() });
        updates(&mut app, 30);
        let (at, state) = (root(&app, walker), state(&app, walker));
        assert!(at.is_finite() && state.velocity.is_finite() && state.yaw_rate.is_finite(), "{nonsense}: at {at}");
    }
    let reached = root(&app, walker);
    assert!(reached.length() < 20.0, "went to {reached}");
    go(&mut app, walker, Vec3::ZERO);
    updates(&mut app, 120);
    let start = root(&app, walker);
    go(&mut app, walker, Vec3::NEG_Z);
    updates(&mut app, 64);
    assert!(root(&app, walker).distance(start) > 0.8, "does not walk any more");
}

#[test]
fn a_config_of_nonsense_is_harmless() {
    let nonsense = [f32::NAN, f32::INFINITY, -1.0, 0.0];
    for value in nonsense {
        let configs = [
            MotionConfig { radius: value, height: value, crouch_height: value, ..default() },
            MotionConfig { step_up: value, step_down: value, slope_limit: value, step_half_life: value, ..default() },
            MotionConfig { gravity: value, fall_speed: value, jump_height: value, jump_tap_height: value, ..default() },
            MotionConfig { acceleration: value, braking: value, turn_rate: value, turn_half_life: value, ..default() },
            MotionConfig { sprint_speed: value, air_acceleration: value, push_force: value, mass: value, ..default() },
        ];
        for (index, config) in configs.into_iter().enumerate() {
            let mut app = world(HZ);
            flat(&mut app);
            let walker = walker(&mut app, Vec3::Y);
            app.world_mut().entity_mut(walker).insert(config);
            intend(&mut app, walker, MoveIntent { velocity: Vec3::X, jump: true, ..default() });
            updates(&mut app, 60);
            let at = root(&app, walker);
            assert!(at.is_finite() && at.length() < 1e3, "config {index} of {value}: at {at}");
        }
    }
}

#[test]
fn a_transform_of_nonsense_is_put_right() {
    let mut app = world(HZ);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::X);
    updates(&mut app, 10);
    app.world_mut().entity_mut(walker).insert(Transform::from_translation(Vec3::NAN));
    updates(&mut app, 10);
    let at = root(&app, walker);
    assert!(at.distance(Vec3::X) < 1e-3, "at {at}");
}

/// A tape over a little of everything; gives all roots.
fn tape(hz: f64) -> Vec<Vec3> {
    let mut app = world(hz);
    flat(&mut app);
    stairs(&mut app, 6, 0.17, 0.29);
    block(&mut app, Vec3::new(3.0, 1.0, 0.0), Vec3::new(1.0, 2.0, 6.0), Quat::from_rotation_y(0.4));
    let walkers = [Vec3::new(0.0, 0.0, 2.0), Vec3::new(1.0, 0.0, 2.5), Vec3::new(-1.0, 0.5, 3.0)];
    let walkers = walkers.map(|at| walker(&mut app, at));
    let mut roots = Vec::new();
    for second in 0..6u8 {
        for (index, &entity) in walkers.iter().enumerate() {
            let angle = f32::from(second) * 0.7 + index as f32;
            let velocity = Quat::from_rotation_y(angle) * Vec3::NEG_Z * (1.0 + index as f32);
            intend(&mut app, entity, MoveIntent { velocity, jump: second % 2 == 1, ..default() });
        }
        for _ in 0..hz as usize {
            app.update();
            roots.extend(walkers.iter().map(|&entity| root(&app, entity)));
        }
    }
    roots
}

#[test]
fn two_runs_of_one_tape_are_the_same_to_the_bit() {
    let (first, second) = (tape(HZ), tape(HZ));
    let bits = |roots: &[Vec3]| roots.iter().flat_map(|root| root.to_array().map(f32::to_bits)).collect::<Vec<_>>();
    let differs = bits(&first).iter().zip(bits(&second)).position(|(a, b)| *a != b);
    assert_eq!(differs, None, "of {} numbers", first.len() * 3);
}

#[test]
fn the_frame_rate_changes_nothing() {
    let end = |frame_rate: f64| {
        let mut app = world(HZ);
        flat(&mut app);
        ramp(&mut app, 20.0, 20.0);
        let walker = walker(&mut app, Vec3::Z * 2.0);
        updates(&mut app, 10);
        frames_of(&mut app, 1.0 / frame_rate);
        let press = |mut intents: Query<&mut MoveIntent>, mut tick: Local<u32>| {
            *tick += 1;
            for mut intent in &mut intents {
                let turn = if *tick < 128 { 0.0 } else { 0.5 };
                let speed = if *tick < 256 { 3.0 } else { 0.0 };
                intent.velocity = Quat::from_rotation_y(turn) * Vec3::NEG_Z * speed;
            }
        };
        app.add_systems(FixedUpdate, press.in_set(surefoot::character::schedule::MotionSystems::Decide));
        updates(&mut app, (frame_rate * 5.0) as usize);
        root(&app, walker)
    };
    let reference = end(60.0);
    for frame_rate in [30.0, 144.0] {
        let difference = end(frame_rate).distance(reference);
        assert!(difference < 0.01, "{frame_rate} frames a second end {difference} m off");
    }
}

#[test]
fn frames_between_ticks_are_smooth() {
    let mut app = world(30.0);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 10);
    frames_of(&mut app, 1.0 / 240.0);
    go(&mut app, walker, Vec3::NEG_Z * 3.0);
    updates(&mut app, 240);
    let mut last = shown(&app, walker);
    let (mut least, mut most) = (f32::MAX, 0f32);
    for _ in 0..240 {
        app.update();
        let now = shown(&app, walker);
        (least, most) = (least.min(now.distance(last)), most.max(now.distance(last)));
        last = now;
    }
    let even = 3.0 / 240.0;
    assert!(least > 0.9 * even && most < 1.1 * even, "frames move between {least} and {most} m instead of {even} m");
}

#[test]
fn a_teleport_counts_and_takes_effect_at_once() {
    let mut app = world(HZ);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 20);
    let before = state(&app, walker).teleports;
    app.world_mut().entity_mut(walker).insert(Transform::from_xyz(30.0, 0.0, -20.0));
    updates(&mut app, 4);
    let (at, seen) = (root(&app, walker), shown(&app, walker));
    assert!(seen.distance(at) < 0.02, "shown at {seen} while at {at}");
    assert_eq!(state(&app, walker).teleports, before + 1);
    assert!(at.distance(Vec3::new(30.0, 0.0, -20.0)) < 0.02, "at {at}");
}
