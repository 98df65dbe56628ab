//! The camera in the world: never in a wall, never under the ground, and as far away as asked.

use avian3d::prelude::*;
use bevy::{ecs::system::RunSystemOnce, prelude::*};
use surefoot::{
    camera::{CameraInput, CameraPlugin, OrbitCamera},
    terrain::{Heightfield, course},
};

fn app() -> (App, Entity, Entity) {
    let mut app = super::terrain::app(|app| {
        app.add_plugins(CameraPlugin);
    });
    let body = (RigidBody::Kinematic, Transform::default());
    let capsule = (Collider::capsule(0.3, 1.2), Transform::from_xyz(0.0, 0.9, 0.0));
    let target = app.world_mut().spawn((body, children![capsule])).id();
    let camera = app.world_mut().spawn(OrbitCamera::around(target)).id();
    (app, target, camera)
}

fn put(app: &mut App, target: Entity, at: Vec3) {
    app.world_mut().get_mut::<Transform>(target).expect("the target has a place").translation = at;
}

fn eye(app: &App, camera: Entity) -> Vec3 {
    app.world().get::<Transform>(camera).expect("the camera has a place").translation
}

#[derive(Resource)]
struct Place(Vec3, Entity);

/// Height of what one would stand on at a place, the target apart.
fn ground_under(query: SpatialQuery, at: Res<Place>, bodies: Query<&ColliderOf>) -> f32 {
    let others = |hit: Entity| bodies.get(hit).is_ok_and(|of| of.body != at.1);
    let from = at.0 + Vec3::Y * 4.0;
    let hit = query.cast_ray_predicate(from, Dir3::NEG_Y, 10.0, true, &SpatialQueryFilter::default(), &others);
    hit.map_or(at.0.y, |hit| from.y - hit.distance)
}

/// What a ball of 15 cm around the eye touches, the target apart.
fn touched(query: SpatialQuery, eye: Res<Place>, names: Query<&Name>, bodies: Query<&ColliderOf>) -> Vec<String> {
    let hits =
        query.shape_intersections(&Collider::sphere(0.15), eye.0, Quat::IDENTITY, &SpatialQueryFilter::default());
    let others = hits.into_iter().filter(|hit| bodies.get(*hit).is_ok_and(|of| of.body != eye.1));
    others.map(|hit| names.get(hit).map_or("?", Name::as_str).to_owned()).collect()
}

#[test]
fn the_eye_is_never_in_a_wall_or_under_the_ground() {
    let (mut app, target, camera) = app();
    let field = app.world().resource::<Heightfield>().clone();
    let points = course::waypoints(&field);
    put(&mut app, target, points[0]);
    for frame in 0..450u16 {
        let along = f32::from(frame) / 450.0 * (points.len() - 1) as f32;
        let from = (along as usize).min(points.len() - 2);
        let mut at = points[from].lerp(points[from + 1], along - from as f32);
        at.y = field.height(at.x, at.z);
        app.insert_resource(Place(at, target));
        at.y = app.world_mut().run_system_once(ground_under).unwrap();
        put(&mut app, target, at);
        let orbit = Vec2::new(0.05, 0.02 * ((f32::from(frame) * 0.03).rem_euclid(2.0) - 1.0));
        app.world_mut().get_mut::<CameraInput>(camera).unwrap().orbit += orbit;
        app.update();
        let eye = eye(&app, camera);
        let above = eye.y - field.height(eye.x, eye.z);
        assert!(above > 0.2, "frame {frame}: {above:.2} m above the ground at {eye}");
        app.insert_resource(Place(eye, target));
        let touched = app.world_mut().run_system_once(touched).unwrap();
        assert!(touched.is_empty(), "frame {frame}: the eye at {eye} touches {touched:?}");
    }
}

#[test]
fn an_open_plaza_leaves_the_arm_its_length() {
    let (mut app, target, camera) = app();
    put(&mut app, target, Vec3::new(-2.0, 0.0, -6.0));
    for _ in 0..60 {
        app.update();
    }
    let eye = eye(&app, camera);
    let pivot = Vec3::new(-2.0, 1.45, -6.0);
    let length = eye.distance(pivot);
    assert!((length - 4.0).abs() < 0.1, "{length} m from the target, the eye at {eye}");
}

#[test]
fn zoom_steps_reach_the_nearest_and_the_farthest() {
    let (mut app, target, camera) = app();
    put(&mut app, target, Vec3::new(-2.0, 0.0, -6.0));
    for (zoom, limit) in [(50.0, 1.5), (-50.0, 12.0)] {
        app.world_mut().get_mut::<CameraInput>(camera).unwrap().zoom = zoom;
        for _ in 0..180 {
            app.update();
        }
        let length = eye(&app, camera).distance(Vec3::new(-2.0, 1.45, -6.0));
        assert!((length - limit).abs() < 0.12, "{length} m, not {limit}");
    }
    let left = *app.world().get::<CameraInput>(camera).unwrap();
    assert_eq!(left, CameraInput::default(), "the camera leaves no input behind");
}

#[test]
fn a_wall_behind_the_target_pulls_the_camera_in() {
    let (mut app, target, camera) = app();
    // Level behind the foot of the stairs the eye would stand inside them.
    app.world_mut().get_mut::<OrbitCamera>(camera).unwrap().pitch = 0.0;
    put(&mut app, target, Vec3::new(-10.0, 0.0, 3.6));
    for _ in 0..60 {
        app.update();
    }
    let length = eye(&app, camera).distance(Vec3::new(-10.0, 1.45, 3.6));
    assert!(length < 3.0, "{length} m away, in the stairs");
}

/// Metres from the camera to a target that stands 2 m before a post `width` metres wide, the camera beyond the post.
fn arm_behind_a_post(width: f32) -> f32 {
    let (mut app, target, camera) = app();
    let post = (RigidBody::Static, Collider::cuboid(width, 4.0, 0.3), Transform::from_xyz(-2.0, 2.0, -4.0));
    app.world_mut().spawn(post);
    put(&mut app, target, Vec3::new(-2.0, 0.0, -6.0));
    for _ in 0..60 {
        app.update();
    }
    eye(&app, camera).distance(Vec3::new(-2.0, 1.45, -6.0))
}

#[test]
fn a_post_does_not_pull_the_camera_in_and_a_wall_does() {
    let (post, wall) = (arm_behind_a_post(0.3), arm_behind_a_post(3.0));
    assert!((post - 4.0).abs() < 0.1, "{post} m away behind a post");
    assert!(wall < 2.2, "{wall} m away, behind a wall");
}
