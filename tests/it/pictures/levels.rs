//! Fewer triangles for who is seen small, and nobody sees the difference.

use core::f32::consts::PI;
use std::{
    collections::HashSet,
    time::{Duration, Instant},
};

use avian3d::parry::{query::PointQuery, shape::Triangle};
use bevy::{mesh::VertexAttributeValues, prelude::*};
use surefoot::{
    rig::Rig,
    skinning::{
        DetailLevels, MeshLevels, ScreenDetail, SkinPose, SkinnedMeshes, SkinnedModel, SkinningPlugin,
        mesh::{ATTRIBUTE_SKIN_SLOTS, ATTRIBUTE_SKIN_WEIGHTS},
        model::{ModelPart, ModelParts},
        simplify::{SHARES, Simplified, simplified},
    },
};

use super::mannequin::bent;
use crate::render_support::{HEIGHT, Studio};

/// A studio with a mannequin whose triangles go by its size, once its levels are there.
fn mannequin() -> (Studio, Entity) {
    let mut studio = Studio::new(SkinningPlugin::default());
    studio.world().resource_mut::<DetailLevels>().mesh_error = 0.0;
    let server = studio.world().resource::<AssetServer>().clone();
    let model = SkinnedModel { gltf: server.load("mannequin.glb"), rig: server.load("mannequin.glb") };
    let turned = Transform::from_rotation(Quat::from_rotation_y(PI));
    let character = studio.world().spawn((model, turned, ScreenDetail::default())).id();
    let deadline = Instant::now() + Duration::from_secs(60);
    while studio.world().get::<MeshLevels>(character).is_none() {
        assert!(Instant::now() < deadline, "the mannequin has no levels after a minute");
        studio.step();
    }
    (studio, character)
}

/// Its meshes, and where the joints of their slots are when bound.
fn meshes(studio: &mut Studio, character: Entity) -> Vec<(Entity, Vec<Vec3>)> {
    let world = studio.world();
    let parts: Vec<Entity> = world.get::<ModelParts>(character).unwrap().iter().collect();
    let rigs = world.resource::<Assets<Rig>>();
    let rig = rigs.iter().next().expect("the mannequin's rig is loaded").1;
    let mut meshes = Vec::new();
    for part in parts {
        let Some(ModelPart::Skin(skin)) = world.get::<ModelPart>(part) else { continue };
        let homes: Vec<Vec3> = rig.skins[*skin].inverse_bind.iter().map(|bind| bind.inverse().translation()).collect();
        meshes.extend(world.get::<SkinnedMeshes>(part).unwrap().iter().map(|mesh| (mesh, homes.clone())));
    }
    meshes
}

fn positions(mesh: &Mesh) -> Vec<Vec3> {
    let Some(VertexAttributeValues::Float32x3(positions)) = mesh.attribute(Mesh::ATTRIBUTE_POSITION) else {
        panic!("a mesh has positions")
    };
    positions.iter().copied().map(Vec3::from_array).collect()
}

fn triangles(mesh: &Mesh) -> Vec<[usize; 3]> {
    let corners: Vec<usize> = mesh.indices().expect("triangles have indices").iter().collect();
    corners.as_chunks().0.to_vec()
}

/// Bits of a vertex: place, slots and weights.
fn vertices(mesh: &Mesh) -> Vec<([u32; 3], [u16; 4], [u16; 4])> {
    let (Some(VertexAttributeValues::Uint16x4(slots)), Some(VertexAttributeValues::Unorm16x4(weights))) =
        (mesh.attribute(ATTRIBUTE_SKIN_SLOTS), mesh.attribute(ATTRIBUTE_SKIN_WEIGHTS))
    else {
        panic!("a skinned mesh has slots and weights")
    };
    let places = positions(mesh).into_iter().map(|place| place.to_array().map(f32::to_bits));
    places.zip(slots.iter().zip(weights)).map(|(place, (slots, weights))| (place, *slots, *weights)).collect()
}

/// Metres from a point to the nearest of these triangles.
fn distance(point: Vec3, places: &[Vec3], triangles: &[[usize; 3]]) -> f32 {
    let to = |corners: &[usize; 3]| {
        let [a, b, c] = corners.map(|corner| places[corner]);
        Triangle::new(a, b, c).distance_to_local_point(point, true)
    };
    triangles.iter().map(to).fold(f32::INFINITY, f32::min)
}

#[test]
fn simplified_meshes_keep_some_vertices_and_the_shape() {
    let (mut studio, character) = mannequin();
    let mut left = [0; SHARES.len() + 1];
    for (entity, homes) in meshes(&mut studio, character) {
        let handle = studio.world().get::<Mesh3d>(entity).unwrap().0.clone();
        let whole = studio.world().resource::<Assets<Mesh>>().get(&handle).unwrap().clone();
        let known: HashSet<_> = vertices(&whole).into_iter().collect();
        let targets = whole.get_morph_targets().map_or(0, <[_]>::len) / whole.count_vertices();
        left[0] += triangles(&whole).len();
        for (level, share) in SHARES.into_iter().enumerate() {
            let Simplified { mesh, error } = simplified(&whole, &homes, share).expect("it can lose triangles");
            let (places, faces) = (positions(&mesh), triangles(&mesh));
            left[level + 1] += faces.len();
            let strange = vertices(&mesh).iter().filter(|vertex| !known.contains(*vertex)).count();
            assert_eq!(strange, 0, "vertices of level {} that the whole mesh hasn't", level + 1);
            let moved = mesh.get_morph_targets().map_or(0, <[_]>::len);
            assert_eq!(moved, targets * mesh.count_vertices(), "a value for each vertex and morph target");
            let off = positions(&whole).into_iter().map(|place| distance(place, &places, &faces)).fold(0.0, f32::max);
            assert!((off - error).abs() < 1e-4, "level {} is {off} m off and says {error}", level + 1);
        }
    }
    // A third, an eighth, and some more of what is small by itself.
    for (level, most) in [(1, 0.36), (2, 0.14)] {
        let share = left[level] as f32 / left[0] as f32;
        assert!(share < most, "level {level} keeps {share} of the triangles: {left:?}");
    }
}

#[test]
fn who_is_seen_small_has_fewer_triangles_and_looks_the_same() {
    let (mut studio, character) = mannequin();
    let pose = bent(&mut studio);
    studio.world().entity_mut(character).insert(SkinPose(pose));
    // Nobody shall be posed differently.
    studio.world().resource_mut::<DetailLevels>().levels.truncate(1);
    let mut see = |away: f32, error: f32| {
        studio.world().resource_mut::<DetailLevels>().mesh_error = error;
        studio.look(Vec3::new(0.0, 1.0, away), Vec3::new(0.0, 0.95, 0.0));
        let picture = studio.picture();
        let level = studio.world().get::<MeshLevels>(character).unwrap().level();
        picture.save(&format!("levels_{away}_{level}"));
        (picture, level)
    };
    // Half a pixel of this picture.
    let error = 0.5 / HEIGHT as f32;
    let mut last = 0;
    for (away, wanted) in [(2.4, 0), (6.0, 1), (14.0, 2), (25.0, 2)] {
        let ((whole, none), (few, level)) = (see(away, 0.0), see(away, error));
        assert_eq!((none, level), (0, wanted), "levels {away} m away, without and with an error");
        let outline = whole.outline_difference(&few) as f32 / whole.drawn() as f32;
        let [before, after] = [&whole, &few].map(|picture| Vec3::from(picture.mean_drawn()));
        assert!(outline < 0.1, "{away} m away level {level} has another outline by {outline} of its pixels");
        let change = (after - before).abs().max_element();
        assert!(change < 16.0, "{away} m away level {level} is of the colour {after}, the whole of {before}, of 255");
        assert!(level >= last, "level {level} after {last}, further away");
        last = level;
    }
    let ((near, level), (whole, _)) = (see(2.4, error), see(2.4, 0.0));
    assert_eq!((level, near.difference(&whole, 0).beyond), (0, 0), "near again it has all its triangles");
    let ((whole, _), (_, level)) = (see(14.0, 0.0), see(14.0, error));
    assert!(level > 0, "far again it has few triangles");
    let errors = |studio: &mut Studio| studio.world().get::<MeshLevels>(character).map(|it| it.errors().to_vec());
    let before = errors(&mut studio);
    studio.world().get_mut::<ModelParts>(character).unwrap().set_changed();
    studio.picture();
    assert_eq!(errors(&mut studio), before, "levels made anew are those of whole meshes");
    studio.world().entity_mut(character).remove::<ScreenDetail>();
    let restored = studio.picture();
    assert_eq!(restored.difference(&whole, 0).beyond, 0, "pixels that differ once nothing follows its size");
}
