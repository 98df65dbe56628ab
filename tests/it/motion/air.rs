//! Jumps and falls.

use bevy::prelude::*;
use surefoot::{character::intent::MoveIntent, rig::tuning::motion::MotionConfig};

use crate::support::*;

const HZ: f64 = 64.0;

fn jump(velocity: Vec3, held: bool) -> MoveIntent {
    MoveIntent { velocity, jump: held, ..default() }
}

/// The highest root in the next `ticks`.
fn apex(app: &mut App, walker: Entity, ticks: usize) -> f32 {
    let mut highest = f32::MIN;
    for _ in 0..ticks {
        app.update();
        highest = highest.max(root(app, walker).y);
    }
    highest
}

#[test]
fn a_jump_is_as_high_as_the_config_says() {
    for hz in [30.0, 64.0, 144.0] {
        for (height, velocity) in [(0.9f32, Vec3::ZERO), (0.5, Vec3::NEG_Z * 3.0), (2.0, Vec3::X)] {
            let mut app = world(hz);
            flat(&mut app);
            let walker = walker(&mut app, Vec3::ZERO);
            app.world_mut().entity_mut(walker).insert(MotionConfig { jump_height: height, ..default() });
            updates(&mut app, 10);
            intend(&mut app, walker, jump(velocity, true));
            let top = apex(&mut app, walker, hz as usize * 2);
            assert!((top - height).abs() < 0.02, "{hz} Hz: rose {top} m instead of {height} m");
            assert!(state(&app, walker).ground.is_some(), "did not land");
        }
    }
}

#[test]
fn a_tapped_jump_is_lower() {
    let mut app = world(HZ);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 10);
    intend(&mut app, walker, jump(Vec3::ZERO, true));
    let first = apex(&mut app, walker, 1);
    intend(&mut app, walker, jump(Vec3::ZERO, false));
    let top = apex(&mut app, walker, 96).max(first);
    let wanted = MotionConfig::default().jump_tap_height;
    assert!((top - wanted).abs() < 0.06, "a tap rose {top} m instead of {wanted} m");
}

#[test]
fn a_jump_just_after_the_ledge_counts_and_a_later_one_does_not() {
    for (ticks, rises) in [(6usize, true), (12, false)] {
        let mut app = world(HZ);
        block(&mut app, Vec3::new(0.0, -0.5, 5.0), Vec3::new(4.0, 1.0, 10.0), Quat::IDENTITY);
        let walker = walker(&mut app, Vec3::Z * 2.0);
        updates(&mut app, 10);
        go(&mut app, walker, Vec3::NEG_Z * 3.5);
        for _ in 0..200 {
            app.update();
            if state(&app, walker).ground.is_none() {
                break;
            }
        }
        updates(&mut app, ticks - 1);
        intend(&mut app, walker, jump(Vec3::NEG_Z * 3.5, true));
        updates(&mut app, 2);
        let speed = state(&app, walker).velocity.y;
        assert_eq!(speed > 2.0, rises, "{ticks} ticks after the ledge: moves at {speed} m/s upward");
    }
}

#[test]
fn a_jump_just_before_landing_counts_once_landed() {
    let mut app = world(HZ);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::Y * 2.0);
    for _ in 0..200 {
        app.update();
        // About 0.1 s before it lands.
        if root(&app, walker).y < 0.65 {
            break;
        }
    }
    assert!(state(&app, walker).ground.is_none(), "landed too soon for the test");
    intend(&mut app, walker, jump(Vec3::ZERO, true));
    updates(&mut app, 1);
    intend(&mut app, walker, jump(Vec3::ZERO, true));
    let top = apex(&mut app, walker, 64);
    assert!(top > 0.7, "the early press was lost: rose {top} m");
}

#[test]
fn a_ceiling_ends_a_jump() {
    let mut app = world(HZ);
    flat(&mut app);
    block(&mut app, Vec3::Y * 2.6, Vec3::new(4.0, 1.0, 4.0), Quat::IDENTITY);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 10);
    intend(&mut app, walker, jump(Vec3::ZERO, true));
    let top = apex(&mut app, walker, 20);
    assert!((0.25..0.31).contains(&top), "rose {top} m under 0.3 m of headroom");
    updates(&mut app, 44);
    assert!(state(&app, walker).ground.is_some(), "did not come down");
}

#[test]
fn a_ceilings_edge_in_the_way_by_a_hand_does_not_end_a_jump() {
    let rise = |overlap: f32| {
        let mut app = world(HZ);
        flat(&mut app);
        let edge = MotionConfig::default().radius - overlap;
        block(&mut app, Vec3::new(edge + 2.0, 2.6, 0.0), Vec3::new(4.0, 1.0, 8.0), Quat::IDENTITY);
        let walker = walker(&mut app, Vec3::ZERO);
        updates(&mut app, 10);
        intend(&mut app, walker, jump(Vec3::ZERO, true));
        apex(&mut app, walker, 64)
    };
    let whole = MotionConfig::default().jump_height;
    for overlap in [0.02f32, 0.05, 0.08] {
        let top = rise(overlap);
        assert!(top > 0.85 * whole, "an edge {overlap} m in the way: rose {top} m of {whole} m");
    }
    let top = rise(0.25);
    assert!(top < 0.5, "an edge 0.25 m in the way: rose {top} m of {whole} m");
}

#[test]
fn a_jump_takes_the_run_along() {
    for degrees in [0.0f32, 20.0, 45.0, 70.0, 135.0, 250.0] {
        let way = Quat::from_rotation_y(degrees.to_radians()) * Vec3::NEG_Z * 3.5;
        for ticks in [60, 77, 94, 111] {
            let mut app = world(HZ);
            block(&mut app, Vec3::Y * -0.5, Vec3::new(200.0, 1.0, 200.0), Quat::IDENTITY);
            let walker = walker(&mut app, Vec3::ZERO);
            intend(&mut app, walker, jump(way, false));
            updates(&mut app, ticks);
            intend(&mut app, walker, jump(way, true));
            updates(&mut app, 5);
            let velocity = state(&app, walker).velocity;
            let lost = velocity.with_y(0.0).distance(way);
            assert!(
                lost < 0.01,
                "jumping {degrees}° aside in tick {ticks} changed the run by {lost:.2} m/s: {velocity}"
            );
        }
    }
}

#[test]
fn the_air_steers_a_little() {
    let mut app = world(HZ);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 10);
    intend(&mut app, walker, jump(Vec3::ZERO, true));
    updates(&mut app, 2);
    intend(&mut app, walker, jump(Vec3::X * 3.0, true));
    updates(&mut app, 32);
    let speed = state(&app, walker).velocity.x;
    let wanted = MotionConfig::default().air_acceleration * 0.5;
    assert!((speed - wanted).abs() < 0.1, "{speed} m/s sideways after half a second in the air");
}

#[test]
fn falls_at_any_rate_never_go_through_the_floor() {
    let sheet = vec![
        Vec3::new(-9.0, 0.0, -9.0),
        Vec3::new(9.0, 0.0, -9.0),
        Vec3::new(9.0, 0.0, 9.0),
        Vec3::new(-9.0, 0.0, 9.0),
    ];
    use avian3d::prelude::{Collider, RigidBody};
    let floors = [
        ("a sheet of triangles", Collider::trimesh(sheet, vec![[0, 2, 1], [0, 3, 2]])),
        ("a heightfield", Collider::heightfield(vec![vec![0.0; 9]; 9], Vec3::new(18.0, 1.0, 18.0))),
        ("a slab of 2 cm", Collider::cuboid(18.0, 0.02, 18.0)),
    ];
    for (name, floor) in floors {
        for hz in [30.0, 64.0, 144.0, 240.0] {
            let mut app = world(hz);
            app.world_mut().spawn((RigidBody::Static, floor.clone(), Transform::IDENTITY));
            // High enough for the top speed of 50 m/s.
            let walker = walker(&mut app, Vec3::new(0.3, 100.0, 0.2));
            go(&mut app, walker, Vec3::X * 0.4);
            let (mut lowest, mut fastest) = (f32::MAX, 0f32);
            for _ in 0..(hz * 6.0) as usize {
                app.update();
                lowest = lowest.min(root(&app, walker).y);
                fastest = fastest.max(-state(&app, walker).velocity.y);
            }
            let at = root(&app, walker);
            assert!(fastest > 49.9, "{name}, {hz} Hz: fell at no more than {fastest} m/s");
            assert!(lowest > -0.005, "{name}, {hz} Hz: came down to {lowest} m");
            assert!(at.y.abs() < 0.012 && state(&app, walker).ground.is_some(), "{name}, {hz} Hz: ended at {at}");
            assert!((state(&app, walker).landing_speed - 50.0).abs() < 0.1, "{}", state(&app, walker).landing_speed);
        }
    }
}

#[test]
fn who_is_wedged_between_steep_walls_can_jump_out() {
    let mut app = world(HZ);
    for side in [-1.0f32, 1.0] {
        let tilt = Quat::from_rotation_z(side * 60f32.to_radians());
        block(&mut app, tilt * Vec3::new(0.0, -0.5, 0.0), Vec3::new(20.0, 1.0, 20.0), tilt);
    }
    let walker = walker(&mut app, Vec3::new(0.4, 3.0, 0.0));
    updates(&mut app, 192);
    let low = root(&app, walker).y;
    assert!(state(&app, walker).ground.is_some(), "hangs at {low} m");
    intend(&mut app, walker, jump(Vec3::ZERO, true));
    let top = apex(&mut app, walker, 64);
    assert!(top > low + 0.5, "jumped from {low} m only to {top} m");
}
