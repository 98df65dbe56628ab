//! What every crowd has in common: hills, light, a camera, and circles that everyone walks.

use core::f32::consts::TAU;

use avian3d::prelude::*;
use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::tonemapping::Tonemapping,
    light::CascadeShadowConfigBuilder,
    math::ops,
    mesh::{Indices, PrimitiveTopology},
    prelude::*,
};
use surefoot::{
    game::film::shutter::Canvas,
    terrain::{Heightfield, collider::collider},
};

use super::flags::Flags;

/// Metres between neighbours, radius of everyone's circle, and walking speed in m/s.
const APART: f32 = 2.0;
const RADIUS: f32 = 0.8;
const SPEED: f32 = 1.4;

/// How big the crowd is, and how it is lit.
#[derive(Resource, Clone, Copy, Debug)]
pub(crate) struct Scene {
    pub(crate) count: usize,
    pub(crate) shadows: bool,
    pub(crate) detail: bool,
}

/// The ground.
#[derive(Resource)]
pub(crate) struct Hills(pub(crate) Heightfield);

/// Someone who walks round a circle.
#[derive(Component, Clone, Copy, Debug)]
pub(crate) struct Walker {
    centre: Vec2,
    /// Radians along the circle at the start.
    start: f32,
}

/// The scene of `count` characters without them.
pub(crate) fn build(app: &mut App, count: usize, flags: &Flags) {
    let scene = Scene { count, shadows: flags.shadows, detail: flags.detail };
    let cells = (scene.side() + 20.0) as usize;
    let height = |x: f32, z: f32| 0.35 * ops::sin(0.45 * x) * ops::cos(0.38 * z);
    app.insert_resource(scene)
        .insert_resource(Hills(Heightfield::from_fn(cells, 1.0, height)))
        .insert_resource(ClearColor(Color::srgb(0.62, 0.70, 0.78)))
        .add_systems(Startup, set);
}

impl Scene {
    /// Metres along one side of the crowd.
    fn side(&self) -> f32 {
        (self.count as f32).sqrt().ceil() * APART
    }

    /// Everyone's circle.
    pub(crate) fn walkers(&self) -> impl Iterator<Item = Walker> {
        let row = (self.count as f32).sqrt().ceil() as usize;
        let middle = 0.5 * (self.side() - APART);
        (0..self.count).map(move |index| Walker {
            centre: Vec2::new((index % row) as f32, (index / row) as f32) * APART - middle,
            start: (index as f32 * 0.618_034).fract() * TAU,
        })
    }
}

impl Walker {
    /// From 0 to 1: everyone is at another moment of the walk.
    pub(crate) fn phase(&self) -> f32 {
        self.start / TAU
    }

    /// Where it is after `seconds`, if nothing is in its way.
    pub(crate) fn place(&self, hills: &Heightfield, seconds: f32) -> Transform {
        let angle = self.start + SPEED / RADIUS * seconds;
        let (sin, cos) = ops::sin_cos(angle);
        let at = self.centre + RADIUS * Vec2::new(cos, -sin);
        Transform::from_translation(hills.point(at.x, at.y)).with_rotation(Quat::from_rotation_y(angle))
    }

    /// The velocity that keeps it on its circle from `root`.
    pub(crate) fn velocity(&self, root: Vec3) -> Vec3 {
        let centre = Vec3::new(self.centre.x, root.y, self.centre.y);
        let out = (root - centre).normalize_or(Vec3::Z);
        let back = out * (RADIUS - root.distance(centre));
        (Vec3::Y.cross(out) + back).normalize_or_zero() * SPEED
    }
}

fn set(
    mut commands: Commands,
    scene: Res<Scene>,
    hills: Res<Hills>,
    canvas: Option<Res<Canvas>>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let grass = StandardMaterial { perceptual_roughness: 1.0, ..Color::srgb(0.42, 0.52, 0.34).into() };
    commands.spawn((
        RigidBody::Static,
        collider(&hills.0),
        Mesh3d(meshes.add(mesh(&hills.0))),
        MeshMaterial3d(materials.add(grass)),
    ));
    let side = scene.side();
    commands.spawn((
        DirectionalLight { illuminance: 8_000.0, shadow_maps_enabled: scene.shadows, ..default() },
        CascadeShadowConfigBuilder { num_cascades: 1, maximum_distance: 2.5 * side, ..default() }.build(),
        Transform::default().looking_to(Vec3::new(0.6, -0.9, -0.45), Vec3::Y),
    ));
    // All of the crowd is in the picture.
    let eye = Vec3::new(0.0, 0.42, 0.86) * (side + 4.0);
    let mut camera = commands.spawn((
        Camera3d::default(),
        Msaa::Off,
        Tonemapping::Reinhard,
        Transform::from_translation(eye).looking_at(Vec3::Z * (0.12 * side), Vec3::Y),
    ));
    if let Some(canvas) = canvas {
        camera.insert(canvas.target());
    }
}

fn mesh(hills: &Heightfield) -> Mesh {
    let lines = hills.cells() as u32 + 1;
    let corners = || (0..=hills.cells()).flat_map(|x| (0..=hills.cells()).map(move |z| (x, z)));
    let quads = (0..lines - 1).flat_map(|x| (0..lines - 1).map(move |z| x * lines + z));
    let indices = quads.flat_map(|at| [at, at + 1, at + lines, at + 1, at + lines + 1, at + lines]).collect();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::RENDER_WORLD)
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_POSITION,
            corners().map(|(x, z)| hills.vertex(x, z).to_array()).collect::<Vec<_>>(),
        )
        .with_inserted_attribute(
            Mesh::ATTRIBUTE_NORMAL,
            corners().map(|(x, z)| hills.smooth_normal(x, z).to_array()).collect::<Vec<_>>(),
        )
        .with_inserted_indices(Indices::U32(indices))
}
