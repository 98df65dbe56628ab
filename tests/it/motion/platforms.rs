//! Ground that moves and turns.

use avian3d::prelude::*;
use bevy::prelude::*;
use surefoot::character::intent::MoveIntent;

use crate::support::*;

const HZ: f64 = 64.0;

fn platform(app: &mut App, at: Vec3, linear: Vec3, angular: Vec3) -> Entity {
    app.world_mut()
        .spawn((
            RigidBody::Kinematic,
            Collider::cuboid(6.0, 0.5, 6.0),
            Transform::from_translation(at),
            LinearVelocity(linear),
            AngularVelocity(angular),
        ))
        .id()
}

/// Where the rider stands on its platform.
fn place_on(app: &App, platform: Entity, rider: Entity) -> Vec3 {
    let ground = app.world().entity(platform).get::<Transform>().copied().unwrap_or_default();
    ground.to_matrix().inverse().transform_point3(root(app, rider))
}

#[test]
fn riders_do_not_drift_on_platforms_that_move_and_turn() {
    for (linear, angular) in [
        (Vec3::new(3.0, 0.0, 0.0), Vec3::ZERO),
        (Vec3::new(0.0, 2.0, 0.0), Vec3::ZERO),
        (Vec3::new(0.0, -2.0, 0.0), Vec3::ZERO),
        (Vec3::ZERO, Vec3::Y * 1.5),
        (Vec3::new(1.0, 0.5, -2.0), Vec3::Y * -0.8),
    ] {
        let mut app = world(HZ);
        let platform = platform(&mut app, Vec3::Y * -0.25, linear, angular);
        let rider = walker(&mut app, Vec3::new(1.5, 0.0, 0.5));
        updates(&mut app, 64);
        let start = place_on(&app, platform, rider);
        let facing = |app: &App| {
            let of =
                |entity: Entity| app.world().entity(entity).get::<Transform>().map_or(Quat::IDENTITY, |t| t.rotation);
            of(platform).inverse() * of(rider)
        };
        let faced = facing(&app);
        let mut worst = 0f32;
        for _ in 0..640 {
            app.update();
            worst = worst.max(place_on(&app, platform, rider).distance(start));
            assert!(state(&app, rider).ground.is_some(), "{linear} {angular}: in the air");
        }
        let turned = facing(&app).angle_between(faced).to_degrees();
        assert!(worst < 2e-3, "{linear} {angular}: drifted {worst} m in 10 s");
        assert!(turned < 0.5, "{linear} {angular}: turned {turned}° on it");
        let relative = state(&app, rider).ground_velocity.length();
        assert!(relative < 1e-3, "{linear} {angular}: moves at {relative} m/s over it");
    }
}

#[test]
fn a_platform_moved_by_its_transform_carries_as_well() {
    let mut app = world(HZ);
    let carrier = (RigidBody::Kinematic, Collider::cuboid(6.0, 0.5, 6.0), Transform::from_xyz(0.0, -0.25, 0.0));
    let carrier = app.world_mut().spawn((carrier, Name::new("carrier"))).id();
    app.add_systems(
        FixedUpdate,
        (|mut carriers: Query<&mut Transform, With<Name>>, time: Res<Time>| {
            for mut transform in &mut carriers {
                transform.translation.x += 2.0 * time.delta_secs();
                transform.rotate_y(0.5 * time.delta_secs());
            }
        })
        .in_set(surefoot::character::schedule::MotionSystems::Decide),
    );
    let rider = walker(&mut app, Vec3::new(1.0, 0.0, 0.0));
    updates(&mut app, 16);
    let start = place_on(&app, carrier, rider);
    let mut worst = 0f32;
    for _ in 0..320 {
        app.update();
        worst = worst.max(place_on(&app, carrier, rider).distance(start));
    }
    assert!(root(&app, rider).x > 5.0, "was not carried: {}", root(&app, rider));
    assert!(worst < 5e-3, "drifted {worst} m in 5 s");
}

#[test]
fn a_walk_on_a_platform_is_as_fast_as_on_the_ground() {
    let mut app = world(HZ);
    let platform = platform(&mut app, Vec3::Y * -0.25, Vec3::X * 4.0, Vec3::ZERO);
    let rider = walker(&mut app, Vec3::new(0.0, 0.0, 2.5));
    updates(&mut app, 16);
    go(&mut app, rider, Vec3::NEG_Z * 1.4);
    updates(&mut app, 32);
    let start = place_on(&app, platform, rider);
    updates(&mut app, 64);
    let gone = place_on(&app, platform, rider) - start;
    assert!((gone.z + 1.4).abs() < 0.01 && gone.x.abs() < 2e-3, "went {gone} over it in a second");
}

#[test]
fn a_jump_takes_the_platforms_velocity_along() {
    let mut app = world(HZ);
    let platform = platform(&mut app, Vec3::Y * -0.25, Vec3::X * 3.0, Vec3::ZERO);
    let rider = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 32);
    let start = place_on(&app, platform, rider);
    intend(&mut app, rider, MoveIntent { jump: true, ..default() });
    updates(&mut app, 10);
    let speed = state(&app, rider).velocity.x;
    assert!((speed - 3.0).abs() < 0.01, "flies at {speed} m/s with a platform of 3 m/s");
    updates(&mut app, 90);
    let landed = place_on(&app, platform, rider).distance(start);
    assert!(state(&app, rider).ground.is_some() && landed < 0.02, "landed {landed} m off its place");
}

#[test]
fn a_platform_pushes_whoever_stands_in_its_way() {
    let mut app = world(HZ);
    flat(&mut app);
    let ram = (RigidBody::Kinematic, Collider::cuboid(1.0, 2.0, 4.0), Transform::from_xyz(-3.0, 1.1, 0.0));
    app.world_mut().spawn((ram, LinearVelocity(Vec3::X * 1.5)));
    let walker = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 192);
    let at = root(&app, walker);
    let front = -3.0 + 0.5 + 1.5 * (191.0 / 64.0);
    assert!(at.x > front + 0.22 && at.y.abs() < 0.01, "stands at {at}, the ram's front at {front}");
}

#[test]
fn ground_that_vanishes_lets_the_rider_fall() {
    let mut app = world(HZ);
    let platform = platform(&mut app, Vec3::Y * -0.25, Vec3::X, Vec3::ZERO);
    let rider = walker(&mut app, Vec3::ZERO);
    updates(&mut app, 32);
    app.world_mut().despawn(platform);
    updates(&mut app, 32);
    let at = root(&app, rider);
    assert!(at.y < -0.5 && at.is_finite(), "stands on nothing at {at}");
}
