//! A scene of one's own with a mannequin that walks in a circle over a step: what a Bevy developer has to write.

use avian3d::prelude::*;
use bevy::prelude::*;
use surefoot::{
    SurefootPlugins,
    character::{Character, intent::MoveIntent, schedule::MotionSystems},
};

/// Radius of the circle in metres, and the walking speed in m/s.
const CIRCLE: f32 = 2.5;
const SPEED: f32 = 1.4;

fn main() {
    App::new()
        .add_plugins((DefaultPlugins, PhysicsPlugins::default(), SurefootPlugins))
        .add_systems(Startup, setup)
        .add_systems(FixedUpdate, walk_in_a_circle.in_set(MotionSystems::Decide))
        .run();
}

fn setup(
    mut commands: Commands,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut solid = |size: Vec3, position: Vec3, color: Color| {
        commands.spawn((
            RigidBody::Static,
            Collider::cuboid(size.x, size.y, size.z),
            Mesh3d(meshes.add(Cuboid::from_size(size))),
            MeshMaterial3d(materials.add(color)),
            Transform::from_translation(position),
        ));
    };
    solid(Vec3::new(20.0, 1.0, 20.0), Vec3::NEG_Y * 0.5, Color::srgb(0.5, 0.55, 0.5));
    solid(Vec3::new(2.0, 0.2, 2.0), Vec3::new(CIRCLE, 0.1, 0.0), Color::srgb(0.75, 0.6, 0.4));

    commands.spawn((Character(assets.load("mannequin.character.ron")), Transform::from_xyz(0.0, 0.0, CIRCLE)));
    commands.spawn((Camera3d::default(), Transform::from_xyz(4.0, 3.0, 6.0).looking_at(Vec3::Y * 0.8, Vec3::Y)));
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        Transform::from_xyz(3.0, 6.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

fn walk_in_a_circle(mut walkers: Query<(&Transform, &mut MoveIntent)>) {
    for (root, mut intent) in &mut walkers {
        let out = root.translation.with_y(0.0).normalize_or(Vec3::Z);
        let along = Vec3::Y.cross(out);
        // Pulled in or pushed out a little, to stay on the circle.
        let back = out * (CIRCLE - root.translation.with_y(0.0).length());
        intent.velocity = (along + back).normalize_or_zero() * SPEED;
    }
}
