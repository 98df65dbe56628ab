//! A headless app that draws into a small image and reads it back frame by frame; works on a software driver.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, Once},
    time::{Duration, Instant},
};

use bevy::{
    app::{PluginGroupBuilder, Plugins, PluginsState},
    asset::RenderAssetUsages,
    camera::RenderTarget,
    core_pipeline::{core_3d::Opaque3d, tonemapping::Tonemapping},
    light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap},
    log::LogPlugin,
    pbr::Shadow,
    prelude::*,
    render::{
        Render, RenderApp, RenderPlugin, RenderSystems,
        gpu_readback::{Readback, ReadbackComplete},
        pipelined_rendering::PipelinedRenderingPlugin,
        render_phase::{BinnedRenderPhase, ViewBinnedRenderPhases},
        render_resource::{Extent3d, PipelineCache, TextureDimension, TextureFormat, TextureUsages},
        settings::{RenderCreation, WgpuSettings},
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

    /// Pixels that are of the colour in the upper left corner in one of the two pictures alone.
    pub(crate) fn outline_difference(&self, other: &Self) -> usize {
        let ground = &self.0[..4];
        let pixels = self.0.chunks_exact(4).zip(other.0.chunks_exact(4));
        pixels.filter(|(a, b)| (*a == ground) != (*b == ground)).count()
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
        std::fs::create_dir_all(&folder).expect("the target folder can be written");
        let size = Extent3d { width: WIDTH, height: HEIGHT, depth_or_array_layers: 1 };
        let format = TextureFormat::Rgba8UnormSrgb;
        let image = Image::new(size, TextureDimension::D2, self.0.clone(), format, RenderAssetUsages::MAIN_WORLD);
        let image = image.try_into_dynamic().expect("a format that PNG knows").to_rgb8();
        image.save(folder.join(name).with_extension("png")).expect("the target folder can be written");
    }
}

/// How many draw calls a frame took, at most, in any one view.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct DrawSets {
    pub(crate) opaque: usize,
    pub(crate) shadow: usize,
}

/// Why a lock is always there.
const POISONED: &str = "whoever panics under a lock has failed the test";

#[derive(Resource, Clone, Default)]
struct Frames(Arc<Mutex<Vec<Vec<u8>>>>);

#[derive(Resource, Clone, Default)]
struct Report(Arc<Mutex<Reported>>);

/// What the last frame drew, and what it could not draw yet.
#[derive(Clone, Copy, Default)]
struct Reported {
    sets: DrawSets,
    upload: SkinUpload,
    /// Pipelines known so far.
    pipelines: usize,
    /// Those among them that wait for a shader, which loads while frames go by.
    waiting: usize,
}

/// How long a busy machine may take over a picture.
const PATIENCE: Duration = Duration::from_secs(60);

/// Frames in a row in which no new pipeline was asked for and none waits, before a picture is taken.
const SETTLED: usize = 4;

/// The folder of this crate's assets.
const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");

/// The engine without a window, drawing by one of `backends`, or not at all.
pub(crate) fn headless_plugins(backends: Option<wgpu::Backends>) -> PluginGroupBuilder {
    plugins_in(Path::new(ASSETS), backends)
}

/// As [`headless_plugins`], with the assets of another folder.
fn plugins_in(folder: &Path, backends: Option<wgpu::Backends>) -> PluginGroupBuilder {
    let render_creation = RenderCreation::Automatic(Box::new(WgpuSettings { backends, ..default() }));
    let mut plugins = DefaultPlugins
        .build()
        .disable::<PipelinedRenderingPlugin>()
        .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
        .set(RenderPlugin { synchronous_pipeline_compilation: true, render_creation, ..default() })
        .set(AssetPlugin { file_path: folder.to_string_lossy().into_owned(), ..default() });
    #[cfg(feature = "game")]
    {
        plugins = plugins.disable::<bevy::winit::WinitPlugin>().disable::<GilrsPlugin>();
    }
    // One log for all tests of the process.
    static LOG: Once = Once::new();
    let mut first = false;
    LOG.call_once(|| first = true);
    if first {
        plugins.set(LogPlugin { filter: "warn,bevy_render=error,wgpu=error,naga=error".into(), ..default() })
    } else {
        plugins.disable::<LogPlugin>()
    }
}

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
        Self::in_folder(Path::new(ASSETS), more)
    }

    /// As [`Studio::with`], with the assets of another folder.
    pub(crate) fn in_folder<M>(folder: &Path, more: impl Plugins<M>) -> Self {
        adapter();
        let mut app = App::new();
        app.add_plugins(plugins_in(folder, WgpuSettings::default().backends)).add_plugins(more);
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
            |complete: On<ReadbackComplete>, frames: Res<Frames>| {
                frames.0.lock().expect(POISONED).push(complete.data.clone());
            },
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
        let deadline = Instant::now() + PATIENCE;
        loop {
            let frames = self.app.world().resource::<Frames>().clone();
            if let Some(frame) = frames.0.lock().expect(POISONED).get(number) {
                return Picture(frame.clone());
            }
            assert!(Instant::now() < deadline, "frame {number} was not read back within {PATIENCE:?}");
            self.step();
        }
    }

    /// The picture of the scene as it is now, once everything in it can be drawn: new meshes and materials are in their
    /// third frame on an idle machine, and later where their shaders still load.
    pub(crate) fn picture(&mut self) -> Picture {
        let deadline = Instant::now() + PATIENCE;
        let (mut known, mut settled) = (usize::MAX, 0);
        loop {
            let number = self.step();
            let report = self.report();
            let ready = report.waiting == 0 && report.pipelines == known;
            (known, settled) = (report.pipelines, if ready { settled + 1 } else { 0 });
            if settled == SETTLED {
                return self.frame(number);
            }
            assert!(Instant::now() < deadline, "{} pipelines still wait after {PATIENCE:?}", report.waiting);
        }
    }

    fn report(&self) -> Reported {
        *self.app.world().resource::<Report>().0.lock().expect(POISONED)
    }

    pub(crate) fn draw_sets(&self) -> DrawSets {
        self.report().sets
    }

    pub(crate) fn last_upload(&self) -> SkinUpload {
        self.report().upload
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
    pipelines: Res<PipelineCache>,
    report: Res<Report>,
) {
    fn sets<I: bevy::render::render_phase::BinnedPhaseItem>(phase: &BinnedRenderPhase<I>) -> usize {
        phase.multidrawable_meshes.len() + phase.batchable_meshes.len() + phase.unbatchable_meshes.len()
    }
    let most = |sets: &mut dyn Iterator<Item = usize>| sets.max().unwrap_or(0);
    let sets =
        DrawSets { opaque: most(&mut opaque.0.values().map(sets)), shadow: most(&mut shadow.0.values().map(sets)) };
    *report.0.lock().expect(POISONED) = Reported {
        sets,
        upload: *upload,
        pipelines: pipelines.pipelines().count(),
        waiting: pipelines.waiting_pipelines().count(),
    };
}
