//! The same scene through this crate's skinning and through the engine's: the same pixels.

use bevy::{
    asset::RenderAssetUsages,
    core_pipeline::prepass::{DeferredPrepass, DepthPrepass},
    math::{Affine3A, ops},
    mesh::{
        VertexAttributeValues,
        morph::{MeshMorphWeights, MorphAttributes},
    },
    pbr::DefaultOpaqueRendererMethod,
    prelude::*,
    render::render_resource::{Extent3d, TextureDimension, TextureFormat},
};
use surefoot::skinning::SkinningPlugin;

use super::{EDGE_PIXELS, JOINTS, Stock, floor, pose, spawn_built_in, standard, test_tube};
use crate::{render_support::Studio, tube::tube_palette};

/// Three tubes, uneven in place, turn and size, and one moment of their lives.
fn scene() -> [(Transform, Vec<Affine3A>); 3] {
    [-1.2, 0.0, 1.3].map(|x: f32| {
        let place = Transform::from_xyz(x, 0.0, 0.3 * x)
            .with_rotation(Quat::from_rotation_y(x))
            .with_scale(Vec3::splat(1.0 - 0.2 * x.abs()));
        (place, tube_palette(JOINTS, 0.8 + x, x * 3.0))
    })
}

/// What both draw.
struct Comparison {
    name: &'static str,
    source: Mesh,
    morph_weights: Option<Vec<f32>>,
    /// Runs first; gives the material.
    prepare: fn(&mut Studio) -> StandardMaterial,
}

impl Default for Comparison {
    fn default() -> Self {
        Self { name: "forward", source: test_tube(), morph_weights: None, prepare: |_| standard() }
    }
}

impl Comparison {
    fn hold(self) {
        let Self { name, source, morph_weights, prepare } = self;
        let mut studio = Studio::new(SkinningPlugin::default());
        let material = prepare(&mut studio);
        floor(&mut studio);
        let morph = |studio: &mut Studio, entity: Entity| {
            if let Some(weights) = morph_weights.clone() {
                studio.world().entity_mut(entity).insert(MeshMorphWeights::Value { weights });
            }
        };
        let stock = Stock::of(&mut studio, &source, material.clone());
        let mut owners = vec![];
        for (place, palette) in scene() {
            let owner = stock.spawn(&mut studio, place);
            pose(&mut studio, owner, &palette);
            let mesh = studio.world().get::<Children>(owner).expect("it has a mesh")[0];
            morph(&mut studio, mesh);
            owners.push(owner);
        }
        let ours = studio.picture();
        ours.save(&format!("{name}_ours"));
        for owner in owners {
            studio.world().despawn(owner);
        }
        let bare = studio.picture();
        for (place, palette) in scene() {
            let mesh = spawn_built_in(&mut studio, &source, material.clone(), place, &palette);
            morph(&mut studio, mesh);
        }
        let engine = studio.picture();
        engine.save(&format!("{name}_engine"));
        let seen = engine.difference(&bare, 20);
        assert!(seen.beyond > 2_000, "{name}: the tubes cover only {} pixels", seen.beyond);
        let difference = ours.difference(&engine, 2);
        assert!(difference.beyond <= EDGE_PIXELS, "{name}: {difference:?}");
    }
}

#[test]
fn looks_the_same_as_the_engines_skinning_with_shadows() {
    Comparison::default().hold();
}

#[test]
fn looks_the_same_in_the_prepass_and_the_deferred_pass() {
    let prepare = |studio: &mut Studio| {
        let camera = studio.camera;
        studio.world().entity_mut(camera).insert((DepthPrepass, DeferredPrepass));
        studio.world().insert_resource(DefaultOpaqueRendererMethod::deferred());
        standard()
    };
    Comparison { name: "deferred", prepare, ..default() }.hold();
}

#[test]
fn looks_the_same_with_morph_targets() {
    let mut source = test_tube();
    let bulge = |v: usize| {
        let out = if v % 22 < 11 { 0.2 } else { 0.0 };
        MorphAttributes::new(Vec3::new(out, 0.0, 0.0), Vec3::new(0.1, 0.0, 0.0), Vec3::ZERO)
    };
    let lift = |_| MorphAttributes::new(Vec3::Y * 0.3, Vec3::ZERO, Vec3::ZERO);
    let count = source.count_vertices();
    source.set_morph_targets((0..count).map(bulge).chain((0..count).map(lift)).collect());
    Comparison { name: "morphs", source, morph_weights: Some(vec![0.7, 0.4]), ..default() }.hold();
}

#[test]
fn looks_the_same_with_vertex_colours() {
    let mut source = test_tube();
    let count = source.count_vertices();
    source.insert_attribute(Mesh::ATTRIBUTE_COLOR, vec![[0.2, 1.0, 0.3, 1.0]; count]);
    Comparison { name: "colours", source, ..default() }.hold();
}

/// Waves that run along the texture's U.
fn waves() -> Image {
    let texel = |x: u32| {
        let slope = Vec3::new(0.7 * ops::sin(x as f32 * core::f32::consts::TAU / 16.0), 0.0, 1.0).normalize();
        let [x, y, z] = (slope * 127.0 + 128.0).to_array().map(|channel| channel as u8);
        [x, y, z, 255]
    };
    let data: Vec<u8> = (0..64 * 64).flat_map(|i| texel(i % 64)).collect();
    let size = Extent3d { width: 64, height: 64, depth_or_array_layers: 1 };
    Image::new(size, TextureDimension::D2, data, TextureFormat::Rgba8Unorm, RenderAssetUsages::default())
}

#[test]
fn looks_the_same_with_a_normal_map() {
    let mut source = test_tube();
    let Some(VertexAttributeValues::Float32x3(normals)) = source.attribute(Mesh::ATTRIBUTE_NORMAL) else {
        panic!("tubes have normals");
    };
    let around: Vec<[f32; 4]> =
        normals.iter().map(|n| Vec3::new(-n[2], 0.0, n[0]).normalize().extend(1.0).to_array()).collect();
    source.insert_attribute(Mesh::ATTRIBUTE_TANGENT, around);
    let prepare =
        |studio: &mut Studio| StandardMaterial { normal_map_texture: Some(studio.add(waves())), ..standard() };
    Comparison { name: "normal_map", source, prepare, ..default() }.hold();
}
