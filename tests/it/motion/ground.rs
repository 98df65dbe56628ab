//! Flat ground, slopes and hills.

use avian3d::prelude::*;
use bevy::{math::ops, prelude::*};
use surefoot::character::intent::MoveIntent;

use crate::support::*;

const HZ: f64 = 64.0;

#[test]
fn the_root_stands_exactly_on_flat_ground() {
    let mut app = world(HZ);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::Y * 0.2);
    updates(&mut app, 64);
    let height = root(&app, walker).y;
    assert!(height.abs() < 1e-4, "stands {height} m above the ground");
    go(&mut app, walker, Vec3::NEG_Z * 1.4);
    let mut worst = 0f32;
    for _ in 0..128 {
        app.update();
        worst = worst.max(root(&app, walker).y.abs());
    }
    assert!(worst < 1e-3, "left flat ground by {worst} m");
    assert!(state(&app, walker).ground.is_some());
}

#[test]
fn speed_arrives_and_ends_in_time() {
    for (speed, most_63, most_90) in [(1.4, 0.2, 0.4), (3.5, 0.35, 0.6)] {
        let mut app = world(HZ);
        flat(&mut app);
        let walker = walker(&mut app, Vec3::ZERO);
        updates(&mut app, 10);
        go(&mut app, walker, Vec3::NEG_Z * speed);
        let time_to = |app: &mut App, reached: &dyn Fn(f32) -> bool| {
            let mut ticks = 0;
            while !reached(state(app, walker).velocity.length()) && ticks < 200 {
                app.update();
                ticks += 1;
            }
            ticks as f32 / HZ as f32
        };
        let to_63 = time_to(&mut app, &|now| now >= 0.63 * speed);
        let to_90 = to_63 + time_to(&mut app, &|now| now >= 0.9 * speed);
        assert!(to_63 <= most_63 && to_90 <= most_90, "{speed} m/s: 63 % after {to_63} s, 90 % after {to_90} s");
        updates(&mut app, 64);
        let there = state(&app, walker).velocity;
        assert!((there.length() - speed).abs() < 1e-3, "moves at {there}");
        go(&mut app, walker, Vec3::ZERO);
        let to_rest = time_to(&mut app, &|now| now < 1e-3);
        assert!(to_rest < 0.35, "{speed} m/s: stood after {to_rest} s");
    }
}

#[test]
fn slopes_are_climbed_at_the_commanded_speed_and_the_root_stays_on_them() {
    for degrees in [10f32, 20.0, 30.0, 40.0] {
        for speed in [1.4f32, 3.5] {
            let mut app = world(HZ);
            flat(&mut app);
            ramp(&mut app, degrees, 30.0);
            let walker = runner(&mut app, Vec3::Z * 1.0);
            updates(&mut app, 10);
            go(&mut app, walker, Vec3::NEG_Z * speed);
            let mut worst = 0f32;
            for _ in 0..192 {
                app.update();
                let at = root(&app, walker);
                let ground = (-at.z).max(0.0) * ops::tan(degrees.to_radians());
                worst = worst.max((at.y - ground).abs());
                assert!(state(&app, walker).ground.is_some(), "{degrees}° at {speed} m/s: in the air at {at}");
            }
            let start = root(&app, walker);
            updates(&mut app, 64);
            let gone = root(&app, walker) - start;
            let pace = Vec2::new(gone.x, gone.z).length();
            assert!((pace - speed).abs() < 0.01 * speed, "{degrees}°: {pace} m/s instead of {speed} m/s");
            assert!(worst < 0.012, "{degrees}° at {speed} m/s: root {worst} m off the slope");
            // And down again.
            go(&mut app, walker, Vec3::Z * speed);
            updates(&mut app, 64);
            let start = root(&app, walker);
            for _ in 0..64 {
                app.update();
                assert!(state(&app, walker).ground.is_some(), "{degrees}° down at {speed} m/s: in the air");
            }
            let gone = root(&app, walker) - start;
            let pace = Vec2::new(gone.x, gone.z).length();
            assert!((pace - speed).abs() < 0.01 * speed, "{degrees}° down: {pace} m/s instead of {speed} m/s");
        }
    }
}

#[test]
fn nobody_slides_while_standing_on_a_slope() {
    let mut app = world(HZ);
    ramp(&mut app, 40.0, 30.0);
    let walker = walker(&mut app, Vec3::new(0.0, 4.3, -5.0));
    updates(&mut app, 32);
    let start = root(&app, walker);
    updates(&mut app, 640);
    let slid = root(&app, walker).distance(start);
    assert!(slid < 1e-4, "slid {slid} m in 10 s");
}

#[test]
fn sixty_degrees_are_slid_down_and_never_climbed() {
    let mut app = world(HZ);
    flat(&mut app);
    ramp(&mut app, 60.0, 12.0);
    let high = Vec3::new(0.0, 10.0 * ops::tan(60f32.to_radians()) + 0.3, -10.0);
    let slider = walker(&mut app, high);
    let climber = walker(&mut app, Vec3::new(2.0, 0.0, 3.0));
    go(&mut app, climber, Vec3::NEG_Z * 6.0);
    updates(&mut app, 64);
    let (now, speed) = (root(&app, slider), state(&app, slider).velocity);
    assert!(now.y < high.y - 2.0 && speed.y < -3.0, "fell from {high} only to {now} at {speed}");
    assert!(state(&app, slider).ground.is_none(), "stands on 60°");
    let mut highest = 0f32;
    for _ in 0..256 {
        app.update();
        highest = highest.max(root(&app, climber).y);
    }
    assert!(highest < 0.05, "climbed {highest} m up a 60° slope");
    let landed = root(&app, slider);
    assert!(landed.y.abs() < 0.05 && state(&app, slider).ground.is_some(), "did not land: {landed}");
}

/// Hills of 12 × 9 cells, so that a scrambled heightfield would show.
fn hills(x: f32, z: f32) -> f32 {
    0.6 * ops::sin(x * 0.9) * ops::cos(z * 0.7) + 0.1 * x
}

#[test]
fn hills_of_a_heightfield_are_followed_exactly() {
    let (columns, rows, width, depth) = (97usize, 65usize, 24.0f32, 16.0f32);
    let mut heights = Vec::new();
    for column in 0..columns {
        for row in 0..rows {
            let x = (column as f32 / (columns - 1) as f32 - 0.5) * width;
            let z = (row as f32 / (rows - 1) as f32 - 0.5) * depth;
            heights.push(hills(x, z));
        }
    }
    let mut app = world(HZ);
    let heights = avian3d::parry::utils::Array2::new(rows, columns, heights);
    let scale = avian3d::parry::math::Vector::new(width, 1.0, depth);
    let shape = avian3d::parry::shape::SharedShape::heightfield(heights, scale);
    app.world_mut().spawn((RigidBody::Static, Collider::from(shape), Transform::IDENTITY));
    let walker = runner(&mut app, Vec3::new(-10.0, hills(-10.0, -5.0), -5.0));
    updates(&mut app, 10);
    go(&mut app, walker, Vec3::new(3.0, 0.0, 1.6));
    let mut worst = 0f32;
    for _ in 0..360 {
        app.update();
        let at = root(&app, walker);
        worst = worst.max((at.y - hills(at.x, at.z)).abs());
        assert!(state(&app, walker).ground.is_some(), "in the air at {at}");
    }
    let at = root(&app, walker);
    assert!(at.x > 4.0, "only came to {at}");
    assert!(worst < 0.02, "root {worst} m off the hills");
}

#[test]
fn the_body_turns_to_where_it_goes_or_is_told_to_face() {
    let mut app = world(HZ);
    flat(&mut app);
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 10);
    go(&mut app, walker, Vec3::X * 1.4);
    updates(&mut app, 48);
    let forward = |app: &App| app.world().entity(walker).get::<Transform>().map_or(Vec3::ZERO, |t| *t.forward());
    let along = forward(&app).dot(Vec3::X);
    assert!(along > 0.999, "faces {} while going along X", forward(&app));
    intend(&mut app, walker, MoveIntent { velocity: Vec3::X, facing: Some(Vec3::Z), ..default() });
    updates(&mut app, 48);
    assert!(forward(&app).dot(Vec3::Z) > 0.999, "faces {} instead of Z", forward(&app));
    assert!(state(&app, walker).velocity.distance(Vec3::X) < 1e-3);
}

#[test]
fn every_kind_of_collider_bears_a_walker() {
    let half = 10.0;
    let corners = vec![
        Vec3::new(-half, 0.0, -half),
        Vec3::new(half, 0.0, -half),
        Vec3::new(half, 0.0, half),
        Vec3::new(-half, 0.0, half),
    ];
    let slab = Collider::cuboid(10.0, 1.0, 20.0);
    let kinds = [
        ("trimesh", Collider::trimesh(corners, vec![[0, 2, 1], [0, 3, 2]])),
        ("half space", Collider::half_space(Vec3::Y)),
        (
            "compound",
            Collider::compound(vec![
                (Vec3::new(-5.0, -0.5, 0.0), Quat::IDENTITY, slab.clone()),
                (Vec3::new(5.0, -0.5, 0.0), Quat::IDENTITY, slab),
            ]),
        ),
        ("heightfield", Collider::heightfield(vec![vec![0.0; 33]; 33], Vec3::new(20.0, 1.0, 20.0))),
    ];
    for (name, collider) in kinds {
        let mut app = world(HZ);
        app.world_mut().spawn((RigidBody::Static, collider, Transform::IDENTITY));
        let walker = walker(&mut app, Vec3::new(-4.0, 0.5, 0.1));
        updates(&mut app, 64);
        go(&mut app, walker, Vec3::new(3.0, 0.0, 0.4));
        let mut worst = 0f32;
        for _ in 0..128 {
            app.update();
            worst = worst.max(root(&app, walker).y.abs());
        }
        let at = root(&app, walker);
        assert!(at.x > 1.0 && worst < 2e-3, "{name}: at {at}, {worst} m off the ground at worst");
    }
}

#[test]
fn slopes_slow_a_run_and_no_walk() {
    let pace = |degrees: f32, speed: f32, way: Vec3| {
        let mut app = world(HZ);
        flat(&mut app);
        ramp(&mut app, degrees, 30.0);
        let walker = walker(&mut app, Vec3::new(0.0, 10.0 * ops::tan(degrees.to_radians()), -10.0));
        updates(&mut app, 10);
        go(&mut app, walker, way * speed);
        updates(&mut app, 96);
        state(&app, walker).ground_velocity.with_y(0.0).length()
    };
    for way in [Vec3::Z, Vec3::NEG_Z] {
        let (gentle, steep, walk) = (pace(10.0, 3.5, way), pace(30.0, 3.5, way), pace(30.0, 1.4, way));
        assert!((2.8..3.4).contains(&gentle), "runs at {gentle} m/s on 10°");
        assert!((2.0..2.5).contains(&steep), "runs at {steep} m/s on 30°");
        assert!((walk - 1.4).abs() < 0.02, "walks at {walk} m/s on 30°");
    }
}
