//! Stairs, curbs, ledges and rubble.

use bevy::{math::ops, prelude::*};

use crate::support::*;

const HZ: f64 = 64.0;
const RISE: f32 = 0.17;
const RUN: f32 = 0.29;
const STEPS: usize = 12;

/// What a walk over stairs looked like.
#[derive(Debug, Default)]
struct Walk {
    seconds: f32,
    airborne: usize,
    /// Fastest vertical movement, m/s.
    fastest: f32,
    /// Greatest vertical acceleration, m/s².
    jerkiest: f32,
    /// Vertical way against the walk's direction, metres.
    backward: f32,
    stepped: f32,
    end: Vec3,
}

fn over_stairs(speed: f32, up: bool) -> Walk {
    let mut app = world(HZ);
    flat(&mut app);
    stairs(&mut app, STEPS, RISE, RUN);
    let top = STEPS as f32 * RISE;
    let (start, far) = (2.0, -(STEPS as f32) * RUN - 2.0);
    let at = if up { Vec3::new(0.0, 0.0, start) } else { Vec3::new(0.0, top, far) };
    let walker = runner(&mut app, at);
    updates(&mut app, 16);
    let direction = if up { Vec3::NEG_Z } else { Vec3::Z };
    go(&mut app, walker, direction * speed);
    let mut walk = Walk::default();
    let (mut last, mut last_rate) = (root(&app, walker).y, 0.0);
    let first_stepped = state(&app, walker).stepped;
    while walk.seconds < 20.0 {
        app.update();
        walk.seconds += 1.0 / HZ as f32;
        let at = root(&app, walker);
        let rate = (at.y - last) * HZ as f32;
        walk.airborne += usize::from(state(&app, walker).ground.is_none());
        walk.fastest = walk.fastest.max(rate.abs());
        walk.jerkiest = walk.jerkiest.max(((rate - last_rate) * HZ as f32).abs());
        let upward = at.y - last;
        walk.backward += if up { (-upward).max(0.0) } else { upward.max(0.0) };
        (last, last_rate) = (at.y, rate);
        if (up && at.z < far) || (!up && at.z > start) {
            break;
        }
    }
    walk.stepped = state(&app, walker).stepped - first_stepped;
    walk.end = root(&app, walker);
    walk
}

#[test]
fn stairs_are_walked_and_run_up_and_down_without_a_hop() {
    let top = STEPS as f32 * RISE;
    let way = STEPS as f32 * RUN + 4.0;
    for speed in [1.4f32, 3.5, 6.0] {
        for up in [true, false] {
            let walk = over_stairs(speed, up);

            let pace = way / (walk.seconds - 0.5 * speed / 8.0);
            let height = if up { top } else { 0.0 };
            assert_eq!(walk.airborne, 0, "{speed} m/s, up: {up}: {walk:?}");
            assert!((pace - speed).abs() < 0.06 * speed, "{pace} m/s instead of {speed}, up: {up}: {walk:?}");
            assert!((walk.end.y - height).abs() < 0.01, "ended at {} instead of {height} m", walk.end.y);
            assert!(walk.backward < 0.01, "{speed} m/s, up: {up}: bobbed by {} m", walk.backward);
            let mean = speed * RISE / RUN;
            assert!(walk.fastest < 2.2 * mean, "{speed} m/s, up: {up}: {} m/s against a mean of {mean}", walk.fastest);
            // The pelvis may have 30 m/s² at most, and has a spring of its own behind this.
            let most = if speed < 5.0 { 30.0 } else { 60.0 };
            assert!(walk.jerkiest < most, "{speed} m/s, up: {up}: {} m/s² up or down", walk.jerkiest);
            let stepped = if up { top } else { -top };
            assert!((walk.stepped - stepped).abs() < 0.05, "{speed} m/s, up: {up}: stepped {} m", walk.stepped);
        }
    }
}

#[test]
fn a_step_of_step_height_is_climbed_and_a_higher_one_is_a_wall() {
    for (height, climbs) in [(0.1f32, true), (0.34, true), (0.37, false), (0.5, false), (0.9, false)] {
        let mut app = world(HZ);
        flat(&mut app);
        block(&mut app, Vec3::new(0.0, height * 0.5, -3.0), Vec3::new(4.0, height, 4.0), Quat::IDENTITY);
        let walker = walker(&mut app, Vec3::Z);
        updates(&mut app, 10);
        go(&mut app, walker, Vec3::NEG_Z * 1.4);
        updates(&mut app, 160);
        let at = root(&app, walker);
        let stands = if climbs { height } else { 0.0 };
        assert!((at.y - stands).abs() < 2e-3, "a step of {height} m: stands at {at}");
        assert_eq!(at.z < -1.0, climbs, "a step of {height} m: stands at {at}");
    }
}

#[test]
fn a_ledge_is_stood_on_to_its_edge_and_left_without_jitter() {
    let mut app = world(HZ);
    block(&mut app, Vec3::new(0.0, -1.0, 0.0), Vec3::new(4.0, 2.0, 4.0), Quat::IDENTITY);
    block(&mut app, Vec3::new(0.0, -8.5, 0.0), Vec3::new(80.0, 1.0, 80.0), Quat::IDENTITY);
    for step in 0..12u8 {
        // Each a little further over the edge.
        let over = 1.85 + f32::from(step) * 0.025;
        let stander = walker(&mut app, Vec3::new(0.0, 0.0, over));
        updates(&mut app, 64);
        let start = root(&app, stander);
        let mut wander = 0f32;
        for _ in 0..64 {
            app.update();
            wander = wander.max(root(&app, stander).distance(start));
        }
        assert!(wander < 1e-4, "{over} m: wandered {wander} m from {start}");
        assert!(start.y.abs() < 2e-3 || start.y < -7.9, "{over} m: stands at {start}");
        app.world_mut().despawn(stander);
    }
    let runner = walker(&mut app, Vec3::new(0.0, 0.0, -1.0));
    updates(&mut app, 10);
    go(&mut app, runner, Vec3::Z * 3.5);
    let mut last = root(&app, runner).y;
    for _ in 0..160 {
        app.update();
        let now = root(&app, runner).y;
        assert!(now < last + 1e-3, "rose by {} m while falling off a ledge", now - last);
        last = now;
    }
    assert!((last + 8.0).abs() < 2e-3, "landed at {last}");
}

#[test]
fn rubble_never_stops_a_walker() {
    let mut app = world(HZ);
    flat(&mut app);
    // Boxes up to 15 cm, turned and tilted every way.
    for index in 0..160u16 {
        let seed = f32::from(index);
        let spin =
            Quat::from_euler(EulerRot::YXZ, seed * 2.4, 0.35 * ops::sin(seed * 1.7), 0.35 * ops::cos(seed * 0.9));
        let at = Vec3::new((seed * 0.618).fract() * 3.0 - 1.5, 0.0, -0.06 * seed);
        block(&mut app, at, Vec3::new(0.45, 0.2, 0.35), spin);
    }
    for (lane, speed) in [(-0.7f32, 1.4f32), (0.0, 1.4), (0.6, 3.5), (0.9, 3.5)] {
        let walker = runner(&mut app, Vec3::new(lane, 0.0, 1.5));
        updates(&mut app, 10);
        go(&mut app, walker, Vec3::NEG_Z * speed);
        let ticks = (11.5 / speed * HZ as f32) as usize;
        let mut airborne = 0;
        for _ in 0..ticks {
            app.update();
            airborne += usize::from(state(&app, walker).ground.is_none());
        }
        let at = root(&app, walker);
        assert!(at.z < -9.0, "lane {lane}: at {speed} m/s only came to {at}");
        assert_eq!(airborne, 0, "lane {lane}: ticks in the air at {speed} m/s");
        app.world_mut().despawn(walker);
    }
}
