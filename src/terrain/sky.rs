//! Sun, sky and haze.
//!
//! [`SkyPlugin`] spawns the sun and the sky's dome; a camera with [`SkyView`] sees through the matching haze and gets the sky's
//! light from all sides.

use core::f32::consts::FRAC_PI_4;

use bevy::{
    camera::visibility::NoFrustumCulling,
    color::{LinearRgba, Srgba},
    core_pipeline::{prepass::DepthPrepass, tonemapping::Tonemapping},
    light::{
        CascadeShadowConfigBuilder, DirectionalLightShadowMap, EnvironmentMapLight, NotShadowCaster, NotShadowReceiver,
        ShadowFilteringMethod,
    },
    math::Vec3,
    pbr::{DistanceFog, FogFalloff},
    prelude::*,
    render::{render_resource::ShaderType, renderer::RenderAdapterInfo},
};
use wgpu::DeviceType;

use super::material::{SkyMaterial, embed_shaders};

/// Radius of the sky's dome, metres: inside the camera's usual 1,000 m from anywhere on the land.
const DOME: f32 = 700.0;
/// Metres at which shadows end.
const SHADOW_REACH: f32 = 45.0;
/// Metres at which the haze has taken all but a twentieth of a thing's contrast.
const VISIBILITY: f32 = 330.0;
/// Light of the sun in lux, for the engine's default exposure.
const SUN: f32 = 10_500.0;
/// Light of the sky in cd/m² for a white sky.
const SKY: f32 = 1_150.0;
/// Colours of what shines on a thing from above, from around and from the ground below.
const ABOVE: Srgba = Srgba::rgb(0.612, 0.765, 0.918);
const AROUND: Srgba = Srgba::rgb(0.847, 0.878, 0.878);
const BELOW: Srgba = Srgba::rgb(0.549, 0.525, 0.408);

/// Direction in which the sun shines: from the south-west, 42° high, so that the walk north shows lit and shaded sides.
#[must_use]
pub fn sunlight() -> Vec3 {
    Vec3::new(0.62, -0.86, -0.55).normalize()
}

/// Tonemapping darkens what stands for light itself; this much brings the sky back to its colours.
const GLOW: f32 = 1.45;

fn horizon() -> LinearRgba {
    LinearRgba::from(Srgba::rgb_u8(0xD2, 0xE4, 0xEE)) * GLOW
}

fn zenith() -> LinearRgba {
    LinearRgba::from(Srgba::rgb_u8(0x55, 0xA2, 0xEA)) * GLOW
}

fn haze() -> DistanceFog {
    DistanceFog {
        color: horizon().into(),
        falloff: FogFalloff::from_visibility_squared(VISIBILITY),
        ..Default::default()
    }
}

/// The sky's light as shaders of rough matter want it: cd/m² from above, from around and from below.
#[derive(ShaderType, Clone, Copy, Debug)]
pub struct SkyLight {
    /// On what looks up.
    pub above: LinearRgba,
    /// On what looks aside.
    pub around: LinearRgba,
    /// On what looks down.
    pub below: LinearRgba,
}

impl Default for SkyLight {
    fn default() -> Self {
        let [above, around, below] = [ABOVE, AROUND, BELOW].map(|color| LinearRgba::from(color) * SKY);
        Self { above, around, below }
    }
}

/// A camera that sees the sky, its haze and its light.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(Camera3d, DistanceFog = haze(), Tonemapping::TonyMcMapface)]
pub struct SkyView;

/// Sun, sky dome, and what [`SkyView`] needs.
pub struct SkyPlugin;

impl Plugin for SkyPlugin {
    fn build(&self, app: &mut App) {
        embed_shaders(app);
        app.add_plugins(MaterialPlugin::<SkyMaterial>::default())
            .insert_resource(DirectionalLightShadowMap { size: 2048 })
            .insert_resource(GlobalAmbientLight::NONE)
            .add_observer(light_view)
            .add_systems(Startup, spawn_sky);
    }
}

fn spawn_sky(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut skies: ResMut<Assets<SkyMaterial>>) {
    commands.spawn((
        Name::new("sun"),
        DirectionalLight {
            color: Srgba::rgb_u8(0xFF, 0xF3, 0xDF).into(),
            illuminance: SUN,
            shadow_maps_enabled: true,
            ..Default::default()
        },
        CascadeShadowConfigBuilder {
            num_cascades: 2,
            first_cascade_far_bound: 9.0,
            maximum_distance: SHADOW_REACH,
            ..Default::default()
        }
        .build(),
        Transform::default().looking_to(sunlight(), Vec3::Y),
    ));
    let sky = SkyMaterial {
        horizon: horizon(),
        zenith: zenith(),
        sun: Srgba::rgb_u8(0xFF, 0xE9, 0xC4).into(),
        to_sun: (-sunlight()).extend(0.0),
    };
    commands.spawn((
        Name::new("sky"),
        Mesh3d(meshes.add(Sphere::new(DOME).mesh().ico(3).unwrap_or_else(|_| Cuboid::from_length(DOME).into()))),
        MeshMaterial3d(skies.add(sky)),
        NoFrustumCulling,
        NotShadowCaster,
        NotShadowReceiver,
    ));
}

/// Gives a new [`SkyView`] the sky's light: blue from above, warm from the ground. Where the processor draws, it also gets what
/// spares it work: a depth prepass, so that hidden ground is not lit, and shadows and edges of one sample. Soft edges alone would
/// take three times as long.
fn light_view(
    added: On<Add, SkyView>,
    mut commands: Commands,
    images: Option<ResMut<Assets<Image>>>,
    adapter: Option<Res<RenderAdapterInfo>>,
) {
    if adapter.is_some_and(|adapter| adapter.device_type == DeviceType::Cpu) {
        commands.entity(added.entity).insert((DepthPrepass, ShadowFilteringMethod::Hardware2x2, Msaa::Off));
    }
    let Some(mut images) = images else { return };
    let light = EnvironmentMapLight::hemispherical_gradient(&mut images, ABOVE, AROUND, BELOW);
    commands.entity(added.entity).insert(EnvironmentMapLight {
        intensity: SKY,
        rotation: Quat::from_rotation_y(FRAC_PI_4),
        ..light
    });
}
