//! Ground and course: what is seen is what is stood on.

use avian3d::prelude::*;
use bevy::{ecs::system::RunSystemOnce, prelude::*, time::TimeUpdateStrategy};
use surefoot::{
    math::dice::Dice,
    terrain::{
        Heightfield, MovingPlatform, Piece, TerrainPlugin, collider, course,
        landscape::{Cover, Landscape},
        mesh::{self, Paint},
        shape::Shape,
    },
};

/// A headless world with the terrain and what `add` adds, physics ready for queries.
pub(crate) fn app(add: impl FnOnce(&mut App)) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, PhysicsPlugins::default(), TerrainPlugin::default()))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    add(&mut app);
    app.finish();
    app.cleanup();
    app.update();
    app.update();
    app
}

fn plain(_: f32, _: f32) -> Paint {
    Paint { cover: Cover { path: 0.0, bare: 0.0 }, shade: 0.0, patch: 0.0 }
}

/// Height of the mesh's upward triangles at a place.
fn mesh_height(mesh: &Mesh, x: f32, z: f32) -> Option<f32> {
    let positions = mesh.attribute(Mesh::ATTRIBUTE_POSITION)?.as_float3()?;
    let indices: Vec<usize> = mesh.indices()?.iter().collect();
    indices.chunks(3).find_map(|triangle| {
        let [a, b, c] = [0, 1, 2].map(|corner| Vec3::from(positions[triangle[corner]]));
        let normal = (b - a).cross(c - a);
        let side = |from: Vec3, to: Vec3| (to.z - from.z) * (x - from.x) - (to.x - from.x) * (z - from.z);
        let inside = [side(a, b), side(b, c), side(c, a)].into_iter().all(|side| side >= -1e-6);
        (normal.y > 1e-6 && inside).then(|| a.y - (normal.x * (x - a.x) + normal.z * (z - a.z)) / normal.y)
    })
}

#[test]
fn mesh_collider_and_heights_agree_within_a_centimetre() {
    let field = Landscape::new(7).heightfield();
    let collider = collider::collider(&field);
    let chunks: Vec<_> = mesh::chunks(&field, 64, 1).collect();
    let meshes: Vec<_> = chunks.iter().map(|chunk| mesh::chunk_mesh(&field, *chunk, Vec3::ZERO, plain)).collect();
    let mut dice = Dice::new(3);
    let mut worst = 0.0f32;
    for _ in 0..1000 {
        let (x, z) = (dice.between(-127.0, 127.0), dice.between(-127.0, 127.0));
        let cast = collider.cast_ray(Vec3::ZERO, Quat::IDENTITY, Vec3::new(x, 80.0, z), Vec3::NEG_Y, 200.0, true);
        let (distance, normal) = cast.unwrap_or_else(|| panic!("a ray at {x}, {z} misses the collider"));
        let cell = |at: f32| ((at + 128.0) / 0.5) as usize;
        let seen = chunks
            .iter()
            .position(|chunk| (chunk.x..chunk.x + 64).contains(&cell(x)) && (chunk.z..chunk.z + 64).contains(&cell(z)));
        let mesh = seen.and_then(|chunk| mesh_height(&meshes[chunk], x, z));
        let mesh = mesh.unwrap_or_else(|| panic!("no triangle of the mesh at {x}, {z}"));
        let (hit, height) = (80.0 - distance, field.height(x, z));
        worst = worst.max((hit - height).abs()).max((hit - mesh).abs());
        let lean = normal.dot(field.normal(x, z));
        assert!(lean > 0.999, "normals differ by a cosine of {lean} at {x}, {z}");
    }
    assert!(worst < 0.01, "mesh, collider and height differ by up to {:.2} mm", worst * 1000.0);
}

#[test]
fn every_piece_looks_like_its_collider() {
    let field = Landscape::new(7).heightfield();
    for piece in course::pieces(&field) {
        if matches!(piece.shape, Shape::Pine { .. }) {
            continue;
        }
        let collider = piece.shape.collider();
        let mut worst = 0.0f32;
        for [a, b, c] in piece.shape.facets(piece.tint).triangles() {
            let (middle, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero());
            let hidden = collider.contains_point(Vec3::ZERO, Quat::IDENTITY, middle + normal * 0.012);
            if normal == Vec3::ZERO || hidden {
                continue;
            }
            let from = middle + normal * 0.02;
            let hit = collider.cast_ray(Vec3::ZERO, Quat::IDENTITY, from, -normal, 0.2, true);
            worst = worst.max(hit.map_or(1.0, |(distance, _)| (distance - 0.02).abs()));
        }
        assert!(
            worst < 0.01,
            "{} at {}: {:.1} mm between mesh and collider",
            piece.name,
            piece.position,
            worst * 1000.0
        );
    }
}

/// Height of the highest surface under a place 1 m above the land or what stands on it.
fn surface(query: &SpatialQuery, at: Vec3) -> f32 {
    let hit = query.cast_ray(at + Vec3::Y * 4.0, Dir3::NEG_Y, 10.0, true, &SpatialQueryFilter::default());
    hit.map_or(f32::NAN, |hit| at.y + 4.0 - hit.distance)
}

fn walk(query: SpatialQuery, field: Res<Heightfield>) -> (f32, Vec<(Vec3, f32)>) {
    let points = course::waypoints(&field);
    let (mut climbed, mut blocked) = (0.0f32, Vec::new());
    let body = Collider::capsule(0.28, 0.9);
    for ends in points.windows(2) {
        let count = (ends[0].distance(ends[1]) / 0.05).ceil();
        for step in 0..count as u32 {
            let mut at = ends[0].lerp(ends[1], step as f32 / count);
            at.y = field.height(at.x, at.z);
            let height = surface(&query, at);
            climbed = climbed.max(height);
            // The body above what feet step over: 0.35 m.
            let middle = at.with_y(height + 0.36 + 0.28 + 0.45);
            if !query.shape_intersections(&body, middle, Quat::IDENTITY, &SpatialQueryFilter::default()).is_empty() {
                blocked.push((at, height));
            }
        }
    }
    (climbed, blocked)
}

#[test]
fn nothing_blocks_the_scripted_walk() {
    let mut app = app(|_| ());
    let (climbed, blocked) = app.world_mut().run_system_once(walk).unwrap();
    assert!(blocked.is_empty(), "{} places are blocked, the first at {:?}", blocked.len(), blocked[0]);
    assert!(climbed > 1.6, "the walk climbs only {climbed} m: it misses the stairs");
}

#[test]
fn platforms_go_where_they_say_and_their_velocity_says_so() {
    let mut app = app(|_| ());
    let mut before: Vec<(Vec3, Vec3)> = Vec::new();
    for tick in 0..640 {
        app.update();
        let time = app.world().resource::<Time<Fixed>>().elapsed_secs_f64();
        let mut query = app.world_mut().query::<(&MovingPlatform, &Position, &LinearVelocity)>();
        let after: Vec<(Vec3, Vec3)> = query.iter(app.world()).map(|(_, at, velocity)| (at.0, velocity.0)).collect();
        for (platform, at, _) in query.iter(app.world()) {
            let off = at.0.distance(platform.position(time));
            assert!(off < 2e-3, "tick {tick}: a platform is {off} m off its path");
        }
        for ((at, velocity), (was, _)) in after.iter().zip(&before) {
            let off = (*at - *was).distance(*velocity / 64.0);
            assert!(off < 1e-4, "tick {tick}: moved {off} m more than its velocity says");
        }
        before = after;
    }
    let mut query = app.world_mut().query::<(&MovingPlatform, &Rotation)>();
    let turned = query.iter(app.world()).map(|(_, turned)| turned.0.angle_between(Quat::IDENTITY)).fold(0.0, f32::max);
    assert!(turned > 0.5, "the turntable turned by {turned} rad in 10 s");
}

#[test]
fn the_course_has_every_kind_of_obstacle() {
    let mut app = app(|_| ());
    let mut query = app.world_mut().query::<&Piece>();
    let names: Vec<&str> = query.iter(app.world()).map(|piece| piece.name).collect();
    for kind in [
        "stairs up",
        "stairs down",
        "ramp of 10 degrees",
        "ramp of 20 degrees",
        "ramp of 30 degrees",
        "rubble",
        "boulder",
        "ledge",
        "curb",
        "stepping stone",
        "low wall",
        "ridge",
        "turntable",
        "glider",
        "handrail",
        "beacon",
    ] {
        assert!(names.contains(&kind), "no {kind} among {} pieces", names.len());
    }
}
