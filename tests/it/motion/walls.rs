//! Walls, corners, ceilings, crates, and starting inside of things.

use avian3d::prelude::*;
use bevy::prelude::*;
use surefoot::{character::intent::MoveIntent, rig::tuning::motion::MotionConfig};

use crate::support::*;

const HZ: f64 = 64.0;

#[test]
fn a_wall_stops_the_walker_and_lets_it_slide_along() {
    let mut app = world(HZ);
    flat(&mut app);
    block(&mut app, Vec3::new(0.0, 1.5, -3.0), Vec3::new(40.0, 3.0, 1.0), Quat::IDENTITY);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 10);
    go(&mut app, walker, Vec3::NEG_Z * 6.0);
    let mut nearest = f32::MAX;
    for _ in 0..128 {
        app.update();
        nearest = nearest.min(root(&app, walker).z + 2.5);
    }
    let radius = MotionConfig::default().radius;
    let at = root(&app, walker);
    assert!(nearest > radius - 1e-3 && at.z + 2.5 < radius + 0.03, "came as near as {nearest} m, stands at {at}");
    assert!(at.y.abs() < 1e-3, "rose to {at}");
    assert!(state(&app, walker).velocity.length() < 0.01, "still moves at {}", state(&app, walker).velocity);
    go(&mut app, walker, Vec3::new(2.0, 0.0, -2.0));
    updates(&mut app, 128);
    let start = root(&app, walker);
    updates(&mut app, 64);
    let slid = root(&app, walker) - start;
    assert!((slid.x - 2.0).abs() < 0.02 && slid.z.abs() < 1e-3, "slid {slid} in a second");
}

#[test]
fn leaning_walls_are_not_climbed() {
    for degrees in [50f32, 65.0, 80.0, 88.0, 95.0, 120.0] {
        let mut app = world(HZ);
        flat(&mut app);
        let rotation = Quat::from_rotation_x((degrees - 90.0).to_radians());
        block(&mut app, Vec3::new(0.0, 0.0, -4.0), Vec3::new(40.0, 8.0, 2.0), rotation);
        let walker = walker(&mut app, Vec3::Z * 0.5);
        updates(&mut app, 10);
        go(&mut app, walker, Vec3::new(1.0, 0.0, -3.0));
        let mut highest = 0f32;
        for _ in 0..256 {
            app.update();
            highest = highest.max(root(&app, walker).y);
        }
        let start = root(&app, walker);
        updates(&mut app, 64);
        let slid = root(&app, walker) - start;
        assert!(highest < 0.02, "{degrees}°: climbed {highest} m");
        assert!((slid.x - 1.0).abs() < 0.1 && slid.z.abs() < 0.01, "{degrees}°: went {slid} along it in a second");
    }
}

#[test]
fn corners_and_corridors_hold_still() {
    // Walls 90°, 60° and 20° apart, and a corridor hardly wider than the body.
    for degrees in [90f32, 60.0, 20.0, 0.5] {
        let mut app = world(HZ);
        flat(&mut app);
        for side in [-1.0f32, 1.0] {
            let turn = Quat::from_rotation_y(side * degrees.to_radians() * 0.5);
            let offset = if degrees < 1.0 { 0.3 } else { 0.0 };
            let middle = turn * Vec3::new(side * 0.5, 1.5, 5.0) + Vec3::X * (side * offset);
            block(&mut app, middle, Vec3::new(1.0, 3.0, 12.0), turn);
        }
        let walker = walker(&mut app, Vec3::Z * 4.0);
        updates(&mut app, 10);
        go(&mut app, walker, Vec3::new(0.3, 0.0, -3.5));
        updates(&mut app, 192);
        if degrees < 1.0 {
            continue;
        }
        let start = root(&app, walker);
        let mut wander = 0f32;
        for _ in 0..128 {
            app.update();
            wander = wander.max(root(&app, walker).distance(start));
        }
        assert!(wander < 2e-4, "{degrees}° corner: wanders {wander} m at {start}");
    }
}

#[test]
fn a_low_ceiling_keeps_the_walker_crouched() {
    let mut app = world(HZ);
    flat(&mut app);
    block(&mut app, Vec3::new(0.0, 1.9, -4.0), Vec3::new(6.0, 1.0, 4.0), Quat::IDENTITY);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 10);
    go(&mut app, walker, Vec3::NEG_Z * 1.4);
    updates(&mut app, 192);
    let upright = root(&app, walker);
    assert!(upright.z > -2.0, "walked upright under 1.4 m to {upright}");
    let crouch = MoveIntent { velocity: Vec3::NEG_Z * 3.0, crouch: true, ..default() };
    intend(&mut app, walker, crouch);
    updates(&mut app, 96);
    let crouched = root(&app, walker);
    assert!(crouched.z < -2.4, "did not come under the ceiling crouched: {crouched}");
    let speed = state(&app, walker).velocity.length();
    assert!((speed - MotionConfig::default().crouch_speed).abs() < 1e-3, "crouches at {speed} m/s");
    go(&mut app, walker, Vec3::ZERO);
    updates(&mut app, 32);
    assert!(state(&app, walker).crouched, "stood up into the ceiling");
    go(&mut app, walker, Vec3::NEG_Z * 1.2);
    updates(&mut app, 320);
    assert!(!state(&app, walker).crouched, "stayed crouched at {}", root(&app, walker));
}

#[test]
fn a_crate_is_pushed_and_a_heavy_one_is_a_wall() {
    for (density, moves) in [(0.05f32, true), (40.0, false)] {
        let mut app = world(HZ);
        flat(&mut app);
        let cube = (
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 1.0, 1.0),
            ColliderDensity(density * 1000.0),
            Transform::from_xyz(0.0, 0.5, -2.0),
        );
        let cube = app.world_mut().spawn(cube).id();
        let walker = walker(&mut app, Vec3::ZERO);
        updates(&mut app, 10);
        go(&mut app, walker, Vec3::NEG_Z * 1.4);
        updates(&mut app, 256);
        let (pushed, at) = (root(&app, cube).z + 2.0, root(&app, walker));
        assert_eq!(pushed < -0.5, moves, "a crate of {} kg moved {pushed} m", density * 1000.0);
        assert!(at.z - root(&app, cube).z > 0.7, "walker at {at} inside the crate at {}", root(&app, cube));
        assert!(at.y.abs() < 2e-3, "rose to {at}");
    }
}

#[test]
fn who_starts_inside_a_box_gets_out() {
    for offset in [Vec3::ZERO, Vec3::new(0.7, 0.0, 0.1), Vec3::new(-0.2, -0.3, 0.6)] {
        let mut app = world(HZ);
        flat(&mut app);
        block(&mut app, Vec3::Y, Vec3::splat(2.0), Quat::IDENTITY);
        let walker = walker(&mut app, Vec3::Y * 0.3 + offset);
        updates(&mut app, 128);
        let at = root(&app, walker);
        let out = at.x.abs() > 1.27 || at.z.abs() > 1.27 || (at.y - 2.0).abs() < 2e-3;
        assert!(out && at.is_finite(), "from {offset} only came to {at}");
        assert!(state(&app, walker).teleports > 0, "the way out was not told");
        go(&mut app, walker, Vec3::new(2.0, 0.0, 1.0));
        updates(&mut app, 64);
        assert!(root(&app, walker).distance(at) > 1.0, "can't walk from {at}");
    }
}

#[test]
fn who_starts_below_the_terrain_comes_up() {
    let mut app = world(HZ);
    let hills = Collider::heightfield(vec![vec![3.0; 17]; 17], Vec3::new(40.0, 1.0, 40.0));
    app.world_mut().spawn((RigidBody::Static, hills, Transform::IDENTITY));
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 64);
    let at = root(&app, walker);
    assert!((at.y - 3.0).abs() < 2e-3, "stands at {at}");
}

#[test]
fn two_characters_do_not_walk_through_each_other() {
    let mut app = world(HZ);
    flat(&mut app);
    let a = walker(&mut app, Vec3::Z * 2.0);
    let b = walker(&mut app, Vec3::Z * -2.0);
    updates(&mut app, 10);
    go(&mut app, a, Vec3::NEG_Z * 3.0);
    go(&mut app, b, Vec3::Z * 3.0);
    let mut nearest = f32::MAX;
    for _ in 0..192 {
        app.update();
        nearest = nearest.min(root(&app, a).distance(root(&app, b)));
    }
    let radius = MotionConfig::default().radius;
    assert!(nearest > 2.0 * radius - 0.1, "came as near as {nearest} m");
    assert!(root(&app, a).y < 0.4 && root(&app, b).y < 0.4, "climbed onto each other");
}

#[test]
fn sensors_and_masked_layers_are_walked_through() {
    let mut app = world(HZ);
    flat(&mut app);
    let gate = block(&mut app, Vec3::new(0.0, 1.0, -1.0), Vec3::new(2.0, 2.0, 0.2), Quat::IDENTITY);
    app.world_mut().entity_mut(gate).insert(Sensor);
    let ghost = block(&mut app, Vec3::new(0.0, 1.0, -3.0), Vec3::new(2.0, 2.0, 0.2), Quat::IDENTITY);
    app.world_mut().entity_mut(ghost).insert(CollisionLayers::new(LayerMask(2), LayerMask::ALL));
    let walker = walker(&mut app, Vec3::ZERO);
    app.world_mut().entity_mut(walker).insert(CollisionLayers::new(LayerMask(1), LayerMask(1)));
    updates(&mut app, 10);
    go(&mut app, walker, Vec3::NEG_Z * 3.0);
    updates(&mut app, 128);
    let at = root(&app, walker);
    assert!(at.z < -4.0, "stopped at {at}");
}
