//! Spawns the world: [`TerrainPlugin`] what one can stand on, [`TerrainLookPlugin`] what one can see.

use avian3d::prelude::{Collider, RigidBody, TransformInterpolation};
use bevy::{camera::visibility::VisibilityRange, light::NotShadowCaster, prelude::*};

use super::{
    Heightfield, Piece, collider, course,
    landscape::{CELL_SIZE, CELLS, Landscape},
    material::{CourseMaterial, GroundMaterial, embed_shaders},
    mesh::{self, Paint},
    palette::Tint,
    platform::{self, MovingPlatform, PlatformSystems},
    scatter,
    shade::Shade,
    shape::Shape,
};

/// Cells along one side of a chunk of the ground's mesh.
const CHUNK: usize = 32;
/// Cells per quad, and from how many to how many metres between camera and chunk: fine wherever feet can be looked at, coarse where
/// triangles would be smaller than a few pixels.
const LEVELS: [(usize, f32, f32); 4] = [(1, 0.0, 28.0), (2, 28.0, 50.0), (4, 50.0, 92.0), (8, 92.0, f32::MAX)];
/// Height of the unseen walls around the land, metres.
const FENCE: f32 = 60.0;

/// The land's ground; its collider is the [`Heightfield`].
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Ground;

/// The shape of the land, kept for painting it.
#[derive(Resource)]
struct Land(Landscape);

/// Ground, course and moving platforms as colliders. Needs no GPU.
///
/// Inserts the [`Heightfield`] resource; spawns everything in `Startup`.
pub struct TerrainPlugin {
    /// From which the hills grow. Default 7.
    pub seed: i32,
}

impl Default for TerrainPlugin {
    fn default() -> Self {
        Self { seed: 7 }
    }
}

impl Plugin for TerrainPlugin {
    fn build(&self, app: &mut App) {
        let land = Landscape::new(self.seed);
        app.insert_resource(land.heightfield())
            .insert_resource(Land(land))
            .register_type::<MovingPlatform>()
            .add_systems(Startup, (spawn_ground, spawn_pieces))
            .add_systems(FixedPreUpdate, platform::drive.in_set(PlatformSystems::Drive));
    }
}

/// Meshes and materials for what [`TerrainPlugin`] spawned.
pub struct TerrainLookPlugin;

impl Plugin for TerrainLookPlugin {
    fn build(&self, app: &mut App) {
        embed_shaders(app);
        app.add_plugins((MaterialPlugin::<GroundMaterial>::default(), MaterialPlugin::<CourseMaterial>::default()))
            .add_systems(PostStartup, (paint_ground, dress_pieces));
    }
}

fn spawn_ground(mut commands: Commands, field: Res<Heightfield>) {
    commands.spawn((
        Name::new("ground"),
        Ground,
        RigidBody::Static,
        collider::collider(&field),
        Transform::default(),
        Visibility::default(),
    ));
    let half = CELLS as f32 * CELL_SIZE * 0.5;
    for (index, out) in [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].into_iter().enumerate() {
        let size = if index < 2 { Vec3::new(1.0, FENCE, 2.0 * half) } else { Vec3::new(2.0 * half, FENCE, 1.0) };
        commands.spawn((
            Name::new("fence"),
            RigidBody::Static,
            Collider::cuboid(size.x, size.y, size.z),
            Transform::from_translation(out * half + Vec3::Y * FENCE * 0.3),
        ));
    }
}

fn spawn_pieces(mut commands: Commands, field: Res<Heightfield>, land: Res<Land>) {
    let mut made: Vec<(Shape, Collider)> = Vec::new();
    for piece in course::pieces(&field).into_iter().chain(scatter::scatter(&land.0, &field)) {
        let known = made.iter().find(|(shape, _)| *shape == piece.shape).map(|(_, collider)| collider.clone());
        let collider = known.unwrap_or_else(|| {
            let collider = piece.shape.collider();
            made.push((piece.shape.clone(), collider.clone()));
            collider
        });
        let place = Transform::from_translation(piece.position).with_rotation(piece.rotation);
        let mut entity = commands.spawn((Name::new(piece.name), collider, place, Visibility::default()));
        match piece.motion.clone() {
            Some(platform) => entity.insert((platform, TransformInterpolation)),
            None => entity.insert(RigidBody::Static),
        };
        entity.insert(piece);
    }
}

fn dress_pieces(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<CourseMaterial>>,
    pieces: Query<(Entity, &Piece)>,
) {
    let material = materials.add(CourseMaterial::default());
    let mut made: Vec<(Shape, Tint, Handle<Mesh>)> = Vec::new();
    for (entity, piece) in &pieces {
        let known = made.iter().find(|(shape, tint, _)| *tint == piece.tint && *shape == piece.shape);
        let mesh = known.map(|(_, _, mesh)| mesh.clone()).unwrap_or_else(|| {
            let mesh = meshes.add(piece.shape.facets(piece.tint).mesh());
            made.push((piece.shape.clone(), piece.tint, mesh.clone()));
            mesh
        });
        commands.entity(entity).insert((Mesh3d(mesh), MeshMaterial3d(material.clone())));
    }
}

fn paint_ground(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<GroundMaterial>>,
    field: Res<Heightfield>,
    land: Res<Land>,
    pieces: Query<&Piece>,
    ground: Single<Entity, With<Ground>>,
) {
    let material = materials.add(GroundMaterial::default());
    let shade = Shade::of(pieces, &field);
    let paint = |x: f32, z: f32| Paint { cover: land.0.cover(x, z), shade: shade.at(x, z), patch: land.0.patch(x, z) };
    for (stride, from, to) in LEVELS {
        for chunk in mesh::chunks(&field, CHUNK, stride) {
            let origin = mesh::centre(&field, chunk);
            commands.spawn((
                Name::new("chunk of ground"),
                ChildOf(*ground),
                Mesh3d(meshes.add(mesh::chunk_mesh(&field, chunk, origin, paint))),
                MeshMaterial3d(material.clone()),
                Transform::from_translation(origin),
                VisibilityRange::abrupt(from, to),
                // Gentle hills under a high sun shade themselves by their slope alone.
                NotShadowCaster,
            ));
        }
    }
}
