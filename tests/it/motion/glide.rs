//! Bodies that look where they go only now and then.

use avian3d::prelude::*;
use bevy::prelude::*;
use surefoot::{
    character::{intent::MoveIntent, motion::Glide},
    rig::tuning::motion::MotionConfig,
    testing::{Stage, World},
};

use crate::support::*;

const HZ: f64 = 64.0;
/// Seconds without a look.
const GLIDE: f32 = 0.25;

fn glider(app: &mut App, place: Vec3, hops: bool) -> Entity {
    let walker = walker(app, place);
    app.world_mut().entity_mut(walker).insert(Glide { seconds: GLIDE, hops });
    walker
}

/// Where somebody is every 50 ms on a way over hills.
fn way_over_hills(glide: Glide) -> Vec<Vec3> {
    let mut stage = Stage::on(&World::hills());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    stage.app().world_mut().entity_mut(walker).insert(glide);
    stage.walk(walker, Vec3::new(0.6, 0.0, -1.4));
    let places = (0..120).map(|_| stage.run_for(0.05).get::<Transform>(walker).expect("it is there").translation);
    places.collect()
}

#[test]
fn who_looks_seldom_goes_the_same_way_over_hills_and_stays_on_the_ground() {
    let way = |seconds: f32| way_over_hills(Glide { seconds, ..default() });
    let (looking, gliding) = (way(0.0), way(GLIDE));
    let apart = looking.iter().zip(&gliding).map(|(a, b)| (*a - *b).with_y(0.0).length()).fold(0.0, f32::max);
    let higher = looking.iter().zip(&gliding).map(|(a, b)| (a.y - b.y).abs()).fold(0.0, f32::max);
    let (climbed, same) = (looking.iter().map(|at| at.y).fold(f32::MIN, f32::max), looking == gliding);
    assert!(!same, "it looked in every tick");
    assert!(apart < 0.1, "{apart} m beside the way of who looks");
    assert!(higher < 0.06, "{higher} m above or below who looks, on hills of {climbed} m");
}

#[test]
fn who_hops_goes_the_same_way_a_little_later() {
    let looking = way_over_hills(Glide::default());
    let hopping = way_over_hills(Glide { seconds: GLIDE, hops: true });
    let stays = hopping.windows(2).filter(|pair| pair[0] == pair[1]).count();
    assert!(stays > 35, "it moved in {} of 119 steps", 119 - stays);
    for (index, at) in hopping.iter().enumerate() {
        // It may be behind by as long as it doesn't look, and by the tick that is shown late.
        let since = index.saturating_sub(6);
        let passed = looking[since..=index].windows(2);
        let beside = passed.map(|leg| {
            let (from, way) = (leg[0], leg[1] - leg[0]);
            let share = ((*at - from).dot(way) / way.length_squared().max(1e-9)).clamp(0.0, 1.0);
            at.distance(from + way * share)
        });
        let beside = beside.fold(f32::MAX, f32::min);
        assert!(index == 0 || beside < 0.1, "{beside} m beside the way of who looks, in step {index}");
    }
}

#[test]
fn who_hops_no_more_is_where_it_would_be() {
    let [mut gliding, mut hopping] = [false, true].map(|hops| {
        let mut app = world(HZ);
        flat(&mut app);
        let walker = glider(&mut app, Vec3::ZERO, hops);
        go(&mut app, walker, Vec3::NEG_Z * 3.0);
        updates(&mut app, 90);
        (app, walker)
    });
    let behind = |gliding: &(App, Entity), hopping: &(App, Entity)| {
        root(&gliding.0, gliding.1).distance(root(&hopping.0, hopping.1))
    };
    // To some moment between two looks.
    let mut waited = 0;
    while behind(&gliding, &hopping) < 0.2 {
        updates(&mut gliding.0, 1);
        updates(&mut hopping.0, 1);
        waited += 1;
        assert!(waited < HZ as usize, "it never stays behind by more than {} m", behind(&gliding, &hopping));
    }
    for (app, walker) in [&mut gliding, &mut hopping] {
        app.world_mut().get_mut::<Glide>(*walker).expect("it glides").hops = false;
        updates(app, 2);
    }
    let off = behind(&gliding, &hopping);
    assert!(off < 0.05, "{off} m from where it would be");
}

#[test]
fn who_looks_seldom_stops_at_walls() {
    [false, true].into_iter().for_each(stops_at_walls);
}

fn stops_at_walls(hops: bool) {
    let mut app = world(HZ);
    flat(&mut app);
    block(&mut app, Vec3::new(0.0, 1.5, -4.0), Vec3::new(40.0, 3.0, 1.0), Quat::IDENTITY);
    let walker = glider(&mut app, Vec3::ZERO, hops);
    updates(&mut app, 10);
    go(&mut app, walker, Vec3::NEG_Z * 3.0);
    let mut nearest = f32::MAX;
    for _ in 0..160 {
        app.update();
        nearest = nearest.min(root(&app, walker).z + 3.5);
    }
    let radius = MotionConfig::default().radius;
    assert!(nearest > radius - 1e-3, "came as near as {nearest} m, its radius is {radius} m");
    assert!(root(&app, walker).z + 3.5 < radius + 0.05, "stopped {} m away", root(&app, walker).z + 3.5);
}

#[test]
fn who_looks_seldom_walks_off_ledges_and_jumps_at_once() {
    [false, true].into_iter().for_each(walks_off_ledges);
}

fn walks_off_ledges(hops: bool) {
    let mut app = world(HZ);
    flat(&mut app);
    block(&mut app, Vec3::new(0.0, 1.0, 0.0), Vec3::new(4.0, 2.0, 4.0), Quat::IDENTITY);
    let walker = glider(&mut app, Vec3::Y * 2.0, hops);
    updates(&mut app, 10);
    go(&mut app, walker, Vec3::NEG_Z * 3.0);
    for _ in 0..128 {
        app.update();
        let at = root(&app, walker);
        let over = at.z < -2.0 - MotionConfig::default().radius;
        assert!(!over || at.y < 1.99, "walks on air at {at}");
    }
    assert!(root(&app, walker).y.abs() < 0.01, "ended at {}", root(&app, walker));
    updates(&mut app, 5);
    app.world_mut().get_mut::<MoveIntent>(walker).expect("it has one").jump = true;
    updates(&mut app, 2);
    assert_eq!(state(&app, walker).jumps, 1, "a jump waited");
}

#[test]
fn who_looks_seldom_rides_what_moves() {
    let mut app = world(HZ);
    flat(&mut app);
    let place = Transform::from_xyz(0.0, 0.25, 0.0);
    let lift = app.world_mut().spawn((RigidBody::Kinematic, Collider::cuboid(6.0, 0.5, 6.0), place)).id();
    let walker = glider(&mut app, Vec3::Y * 0.5, true);
    updates(&mut app, 64);
    app.world_mut().entity_mut(lift).insert(LinearVelocity(Vec3::new(0.5, 0.5, 0.0)));
    updates(&mut app, 64);
    let at = root(&app, walker);
    assert!((at - Vec3::new(0.5, 1.0, 0.0)).length() < 0.15, "rides to {at} on what went to (0.5, 1.0, 0)");
}

#[test]
fn who_looks_seldom_falls_as_soon_as_the_ground_is_gone() {
    let mut app = world(HZ);
    flat(&mut app);
    let floor = block(&mut app, Vec3::new(0.0, 1.0, 0.0), Vec3::new(40.0, 2.0, 40.0), Quat::IDENTITY);
    let walker = glider(&mut app, Vec3::Y * 2.0, true);
    go(&mut app, walker, Vec3::NEG_Z * 1.5);
    updates(&mut app, 64);
    app.world_mut().despawn(floor);
    updates(&mut app, 4);
    assert!(state(&app, walker).ground.is_none(), "stands on {:?}", state(&app, walker).ground);
}
