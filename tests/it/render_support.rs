//! A headless app that draws into a small image and reads it back frame by frame; works on a software driver.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, Once},
    time::Duration,
};

use bevy::{
    app::{Plugins, PluginsState},
    asset::RenderAssetUsages,
    camera::RenderTarget,
    core_pipeline::{core_3d::Opaque3d, tonemapping::Tonemapping},
    light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    log::LogPlugin,
    math::{Affine3A, ops},
    mesh::{Indices, PrimitiveTopology, VertexAttributeValues},
    pbr::Shadow,
    prelude::*,
    render::{
        Render, RenderApp, RenderPlugin, RenderSystems,
        gpu_readback::{Readback, ReadbackComplete},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_phase::{BinnedRenderPhase, ViewBinnedRenderPhases},
        render_resource::{Extent3d, TextureDimension, TextureFormat, TextureUsages},
    },
    time::TimeUpdateStrategy,
    window::ExitCondition,
};
use surefoot::{
    rig::loader::RigPlugin,
    skinning::{SkinUpload, SkinningPlugin},
};

/// Pixels of every picture. A row of 4-byte pixels fills whole 256-byte units, as copies from the GPU ask for.
pub(crate) const WIDTH: u32 = 320;
pub(crate) const HEIGHT: u32 = 180;

/// What is to be installed where no driver is found.
const NO_DRIVER: &str = "no Vulkan driver found: `apt-get install mesa-vulkan-drivers` brings one that needs no GPU";

/// A wgpu adapter, or a panic that names what to install.
pub(crate) fn adapter() -> wgpu::Adapter {
    let backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    bevy::tasks::block_on(instance.enumerate_adapters(backends)).into_iter().next().expect(NO_DRIVER)
}

/// A picture of linear rows, top first, four bytes a pixel.
#[derive(Clone, PartialEq, Eq)]
pub(crate) struct Picture(pub(crate) Vec<u8>);

/// How far apart two pictures are.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Difference {
    /// Largest difference of any channel, of 255.
    pub(crate) most: u8,
    /// Pixels where some channel differs by more than the tolerance.
    pub(crate) beyond: usize,
}

impl Picture {
    pub(crate) fn difference(&self, other: &Self, tolerance: u8) -> Difference {
        let pixels = self.0.chunks_exact(4).zip(other.0.chunks_exact(4));
        let each = pixels.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0));
        each.fold(Difference { most: 0, beyond: 0 }, |sum, pixel| Difference {
            most: sum.most.max(pixel),
            beyond: sum.beyond + usize::from(pixel > tolerance),
        })
    }

    /// Pixels that are not of the colour in the upper left corner.
    pub(crate) fn drawn(&self) -> usize {
        let ground = &self.0[..4];
        self.0.chunks_exact(4).filter(|pixel| *pixel != ground).count()
    }

    /// Mean of each channel over the pixels that are not of the colour in the upper left corner.
    pub(crate) fn mean_drawn(&self) -> [f32; 3] {
        let ground = &self.0[..4];
        let mut sum = [0.0; 3];
        for pixel in self.0.chunks_exact(4).filter(|pixel| *pixel != ground) {
            for (sum, channel) in sum.iter_mut().zip(pixel) {
                *sum += f32::from(*channel);
            }
        }
        let count = self.drawn().max(1) as f32;
        sum.map(|channel| channel / count)
    }

    /// Writes a PNG for people to look at.
    pub(crate) fn save(&self, name: &str) {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pictures");
        std::fs::create_dir_all(&folder).unwrap();
        let size = Extent3d { width: WIDTH, height: HEIGHT, depth_or_array_layers: 1 };
        let format = TextureFormat::Rgba8UnormSrgb;
        let image = Image::new(size, TextureDimension::D2, self.0.clone(), format, RenderAssetUsages::MAIN_WORLD);
        image.try_into_dynamic().unwrap().to_rgb8().save(folder.join(name).with_extension("png")).unwrap();
    }
}

/// How many draw calls a frame took, at most, in any one view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct DrawSets {
    pub(crate) opaque: usize,
    pub(crate) shadow: usize,
}

#[derive(Resource, Clone, Default)]
struct Frames(Arc<Mutex<Vec<Vec<u8>>>>);

#[derive(Resource, Clone, Default)]
struct Report(Arc<Mutex<(DrawSets, SkinUpload)>>);

/// A headless app with a camera, a sun and its shadow.
pub(crate) struct Studio {
    pub(crate) app: App,
    pub(crate) camera: Entity,
    updates: usize,
}

impl Studio {
    pub(crate) fn new(skinning: SkinningPlugin) -> Self {
        Self::with((RigPlugin, skinning))
    }

    /// A studio with other plugins than those of rigs and skinning; they must bring skinning along.
    pub(crate) fn with<M>(more: impl Plugins<M>) -> Self {
        adapter();
        let mut app = App::new();
        let mut plugins = DefaultPlugins
            .build()
            .disable::<PipelinedRenderingPlugin>()
            .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
            .set(RenderPlugin { synchronous_pipeline_compilation: true, ..default() })
            .set(AssetPlugin { file_path: concat!(env!("CARGO_MANIFEST_DIR"), "/assets").into(), ..default() });
        #[cfg(feature = "game")]
        {
            plugins = plugins.disable::<bevy::winit::WinitPlugin>().disable::<bevy::gilrs::GilrsPlugin>();
        }
        // One log for all tests of the process.
        static LOG: Once = Once::new();
        let mut first = false;
        LOG.call_once(|| first = true);
        plugins = if first {
            plugins.set(LogPlugin { filter: "warn,bevy_render=error,wgpu=error,naga=error".into(), ..default() })
        } else {
            plugins.disable::<LogPlugin>()
        };
        app.add_plugins(plugins).add_plugins(more);
        app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)))
            .insert_resource(DirectionalLightShadowMap { size: 512 })
            .init_resource::<Frames>();
        let report = Report::default();
        app.insert_resource(report.clone());
        app.sub_app_mut(RenderApp).insert_resource(report).add_systems(Render, count.in_set(RenderSystems::Cleanup));
        while app.plugins_state() == PluginsState::Adding {
            bevy::tasks::tick_global_task_pools_on_main_thread();
        }
        app.finish();
        app.cleanup();
        let (camera, target) = furnish(&mut app);
        // Copies begin when there is something to copy, so that the first one is of frame 0.
        app.update();
        app.update();
        app.world_mut().spawn(Readback::texture(target)).observe(
            |complete: On<ReadbackComplete>, frames: Res<Frames>| frames.0.lock().unwrap().push(complete.data.clone()),
        );
        Self { app, camera, updates: 0 }
    }

    /// Puts the camera at `eye`, looking at `target`; both in metres.
    pub(crate) fn look(&mut self, eye: Vec3, target: Vec3) {
        let place = Transform::from_translation(eye).looking_at(target, Vec3::Y);
        self.app.world_mut().entity_mut(self.camera).insert(place);
    }

    pub(crate) fn world(&mut self) -> &mut World {
        self.app.world_mut()
    }

    pub(crate) fn add<A: Asset>(&mut self, asset: A) -> Handle<A> {
        self.world().resource_mut::<Assets<A>>().add(asset)
    }

    /// Draws a frame; returns its number.
    pub(crate) fn step(&mut self) -> usize {
        self.app.update();
        self.updates += 1;
        self.updates - 1
    }

    /// The picture of a frame already drawn. Draws further ones until the copy arrives.
    pub(crate) fn frame(&mut self, number: usize) -> Picture {
        for _ in 0..20 {
            let frames = self.app.world().resource::<Frames>().clone();
            if let Some(frame) = frames.0.lock().unwrap().get(number) {
                return Picture(frame.clone());
            }
            self.step();
        }
        panic!("frame {number} was not read back within 20 updates");
    }

    /// The picture of the scene as it is now. New meshes and materials are drawn in their third frame.
    pub(crate) fn picture(&mut self) -> Picture {
        self.step();
        self.step();
        let number = self.step();
        self.frame(number)
    }

    pub(crate) fn draw_sets(&self) -> DrawSets {
        self.app.world().resource::<Report>().0.lock().unwrap().0
    }

    pub(crate) fn last_upload(&self) -> SkinUpload {
        self.app.world().resource::<Report>().0.lock().unwrap().1
    }
}

fn furnish(app: &mut App) -> (Entity, Handle<Image>) {
    let mut image = Image::new_target_texture(WIDTH, HEIGHT, TextureFormat::Rgba8UnormSrgb, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    let target = app.world_mut().resource_mut::<Assets<Image>>().add(image);
    app.world_mut().spawn((
        DirectionalLight { illuminance: 6_000.0, shadow_maps_enabled: true, ..default() },
        CascadeShadowConfigBuilder { num_cascades: 1, maximum_distance: 20.0, ..default() }.build(),
        Transform::from_xyz(3.0, 6.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
    let camera = (
        Camera3d::default(),
        Camera { clear_color: Color::srgb(0.5, 0.65, 0.8).into(), ..default() },
        RenderTarget::Image(target.clone().into()),
        Transform::from_xyz(0.0, 2.0, 5.0).looking_at(Vec3::Y, Vec3::Y),
        Tonemapping::None,
        Msaa::Off,
    );
    (app.world_mut().spawn(camera).id(), target)
}

fn count(
    opaque: Res<ViewBinnedRenderPhases<Opaque3d>>,
    shadow: Res<ViewBinnedRenderPhases<Shadow>>,
    upload: Res<SkinUpload>,
    report: Res<Report>,
) {
    fn sets<I: bevy::render::render_phase::BinnedPhaseItem>(phase: &BinnedRenderPhase<I>) -> usize {
        phase.multidrawable_meshes.len() + phase.batchable_meshes.len() + phase.unbatchable_meshes.len()
    }
    let most = |sets: &mut dyn Iterator<Item = usize>| sets.max().unwrap_or(0);
    let sets =
        DrawSets { opaque: most(&mut opaque.0.values().map(sets)), shadow: most(&mut shadow.0.values().map(sets)) };
    *report.0.lock().unwrap() = (sets, *upload);
}

/// A tube along +Y, 2 m long, whose joints are evenly spaced; the engine's own joint attributes, up to four per vertex.
pub(crate) fn tube(rings: usize, sides: usize, joint_count: usize) -> Mesh {
    let mut mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
    let (mut positions, mut normals, mut uvs, mut slots, mut weights) = (vec![], vec![], vec![], vec![], vec![]);
    for ring in 0..=rings {
        let along = ring as f32 / rings as f32;
        let at = along * (joint_count - 1) as f32;
        let low = (at.floor() as usize).min(joint_count - 2);
        let part = at - low as f32;
        let first = low.saturating_sub(1);
        let last = (low + 2).min(joint_count - 1);
        let shares = [0.2 * (1.0 - part), 0.8 * (1.0 - part) + 0.1, 0.8 * part + 0.1, 0.2 * part];
        let total: f32 = shares.iter().sum();
        for side in 0..=sides {
            let angle = side as f32 / sides as f32 * core::f32::consts::TAU;
            let out = Vec3::new(ops::cos(angle), 0.1, ops::sin(angle)).normalize();
            let radius = 0.25 * (1.0 - 0.6 * along);
            positions.push([out.x * radius, along * 2.0, out.z * radius]);
            normals.push(out.to_array());
            uvs.push([side as f32 / sides as f32, along]);
            slots.push([first, low, low + 1, last].map(|slot| slot as u16));
            weights.push(shares.map(|share| share / total));
        }
    }
    let mut indices = vec![];
    for ring in 0..rings {
        for side in 0..sides {
            let i = (ring * (sides + 1) + side) as u32;
            let above = i + sides as u32 + 1;
            indices.extend([i, above, i + 1, i + 1, above, above + 1]);
        }
    }
    mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, positions);
    mesh.insert_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
    mesh.insert_attribute(Mesh::ATTRIBUTE_UV_0, uvs);
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, VertexAttributeValues::Uint16x4(slots));
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, weights);
    mesh.insert_indices(Indices::U32(indices));
    mesh
}

/// A palette that bends, twists and slightly swells a [`tube`]; `time` in seconds.
pub(crate) fn tube_palette(joint_count: usize, time: f32, phase: f32) -> Vec<Affine3A> {
    let step = 2.0 / (joint_count - 1) as f32;
    let mut model_from_joint = Affine3A::IDENTITY;
    (0..joint_count)
        .map(|joint| {
            let bend =
                2.2 / joint_count as f32 * ops::sin(time * 2.0 + phase + joint as f32 * 2.8 / joint_count as f32);
            let twist = 1.2 / joint_count as f32 * ops::cos(time + phase);
            let swell = Vec3::new(1.0 + 0.2 / joint_count as f32 * ops::sin(phase + joint as f32), 1.0, 1.0);
            let turn = Quat::from_euler(EulerRot::XYZ, bend * ops::cos(phase), twist, bend * ops::sin(phase));
            let place = if joint == 0 { Vec3::ZERO } else { Vec3::Y * step };
            model_from_joint = model_from_joint * Affine3A::from_scale_rotation_translation(swell, turn, place);
            model_from_joint * Affine3A::from_translation(Vec3::Y * (-step * joint as f32))
        })
        .collect()
}
