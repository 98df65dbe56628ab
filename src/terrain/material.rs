//! Materials of ground, course and sky, and their shaders.
//!
//! Ground and course are rough: sun, sky and haze of [`super::sky`] light them, and no other lamp.

use std::path::{Path, PathBuf};

use bevy::{
    asset::{Asset, io::embedded::EmbeddedAssetRegistry},
    color::{LinearRgba, Srgba},
    math::Vec4,
    mesh::MeshVertexBufferLayoutRef,
    pbr::{MaterialPipeline, MaterialPipelineKey},
    prelude::*,
    reflect::TypePath,
    render::render_resource::{AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError},
    shader::ShaderRef,
};

use super::{
    landscape::{PLAZA, PLAZA_CORNER},
    sky::SkyLight,
};

/// Material of the ground: colours that its shader blends by slope, height and the mesh's paint.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct GroundMaterial {
    /// Grass in the dips.
    #[uniform(0)]
    pub grass: LinearRgba,
    /// Drier grass on the heights.
    #[uniform(0)]
    pub dry_grass: LinearRgba,
    /// Paths and bare ground.
    #[uniform(0)]
    pub dirt: LinearRgba,
    /// Steep banks.
    #[uniform(0)]
    pub rock: LinearRgba,
    /// Slabs of the plaza.
    #[uniform(0)]
    pub paving: LinearRgba,
    /// The plaza: half extents along X and Z, corner radius, side of a slab; metres.
    #[uniform(0)]
    pub plaza: Vec4,
    /// The sky's light on it.
    #[uniform(0)]
    pub sky: SkyLight,
}

impl Default for GroundMaterial {
    fn default() -> Self {
        Self {
            grass: Srgba::rgb_u8(0x6B, 0x8A, 0x3F).into(),
            dry_grass: Srgba::rgb_u8(0xA3, 0x9B, 0x55).into(),
            dirt: Srgba::rgb_u8(0x9C, 0x7D, 0x5B).into(),
            rock: Srgba::rgb_u8(0x84, 0x7F, 0x77).into(),
            paving: Srgba::rgb_u8(0xA4, 0xA2, 0x9C).into(),
            plaza: PLAZA.extend(PLAZA_CORNER).extend(1.0),
            sky: SkyLight::default(),
        }
    }
}

impl Material for GroundMaterial {
    fn fragment_shader() -> ShaderRef {
        "embedded://surefoot/shaders/terrain.wgsl".into()
    }
}

/// Material of everything built or scattered: the mesh's colours with a little grain, darker where they see less sky.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct CourseMaterial {
    /// How much the grain lightens and darkens, 0..=1. Default 0.16.
    #[uniform(0)]
    pub grain: f32,
    /// The sky's light on it.
    #[uniform(0)]
    pub sky: SkyLight,
}

impl Default for CourseMaterial {
    fn default() -> Self {
        Self { grain: 0.16, sky: SkyLight::default() }
    }
}

impl Material for CourseMaterial {
    fn fragment_shader() -> ShaderRef {
        "embedded://surefoot/shaders/course.wgsl".into()
    }
}

/// The sky's colours, drawn on the inside of a dome.
#[derive(Asset, AsBindGroup, TypePath, Clone, Debug)]
pub struct SkyMaterial {
    /// Colour at the horizon, the same as the fog's.
    #[uniform(0)]
    pub horizon: LinearRgba,
    /// Colour straight up.
    #[uniform(0)]
    pub zenith: LinearRgba,
    /// Colour of the sun's halo.
    #[uniform(0)]
    pub sun: LinearRgba,
    /// Direction toward the sun, world space, unit length; the fourth number is unused.
    #[uniform(0)]
    pub to_sun: Vec4,
}

impl Material for SkyMaterial {
    fn fragment_shader() -> ShaderRef {
        "embedded://surefoot/shaders/sky.wgsl".into()
    }

    fn enable_prepass() -> bool {
        false
    }

    fn enable_shadows() -> bool {
        false
    }

    fn specialize(
        _pipeline: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        _layout: &MeshVertexBufferLayoutRef,
        _key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        // The dome is seen from inside.
        descriptor.primitive.cull_mode = None;
        Ok(())
    }
}

/// Keeps shader modules that are only imported.
#[derive(Resource)]
struct ImportedShaders {
    _modules: [Handle<Shader>; 2],
}

/// Puts the shaders of `shaders/` into the binary.
pub(super) fn embed_shaders(app: &mut App) {
    let registry = app.world().resource::<EmbeddedAssetRegistry>();
    let embed = |name: &str, bytes: &'static [u8]| {
        let path = Path::new("surefoot/shaders").join(name);
        registry.insert_asset(PathBuf::from("shaders").join(name), &path, bytes);
    };
    embed("light.wgsl", include_bytes!("../../shaders/light.wgsl"));
    embed("noise.wgsl", include_bytes!("../../shaders/noise.wgsl"));
    embed("terrain.wgsl", include_bytes!("../../shaders/terrain.wgsl"));
    embed("course.wgsl", include_bytes!("../../shaders/course.wgsl"));
    embed("sky.wgsl", include_bytes!("../../shaders/sky.wgsl"));
    let assets = app.world().resource::<AssetServer>();
    let modules = ["light", "noise"].map(|name| assets.load(format!("embedded://surefoot/shaders/{name}.wgsl")));
    app.insert_resource(ImportedShaders { _modules: modules });
}
