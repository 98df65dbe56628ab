//! The engine as the game needs it: with a window, or drawing into a picture only.

use std::path::Path;

use bevy::{
    app::{PluginGroupBuilder, PluginsState},
    gilrs::GilrsPlugin,
    log::{Level, LogPlugin},
    prelude::*,
    render::{
        RenderPlugin,
        pipelined_rendering::PipelinedRenderingPlugin,
        settings::{Backends, RenderCreation, WgpuSettings},
    },
    window::{ExitCondition, MonitorSelection, WindowMode, WindowResolution},
    winit::WinitPlugin,
};

/// Fixed ticks a second, whatever the frame rate.
pub const TICKS_PER_SECOND: u32 = 60;

/// How the window opens.
#[derive(Clone, Copy, Debug)]
pub struct WindowShape {
    /// Width and height in pixels.
    pub size: UVec2,
    /// Fills the screen instead.
    pub fullscreen: bool,
}

/// An app with a window.
pub fn windowed(assets: &Path, shape: WindowShape) -> App {
    windowed_from(App::new(), assets, shape)
}

/// As [`windowed`], from an app that has asset sources of its own already.
pub fn windowed_from(mut app: App, assets: &Path, shape: WindowShape) -> App {
    let mode = if shape.fullscreen {
        WindowMode::BorderlessFullscreen(MonitorSelection::Current)
    } else {
        WindowMode::Windowed
    };
    let window = Window {
        title: "Surefoot".to_owned(),
        name: Some("surefoot".to_owned()),
        resolution: WindowResolution::new(shape.size.x, shape.size.y),
        mode,
        ..default()
    };
    app.add_plugins(
        DefaultPlugins
            .set(assets_from(assets))
            .set(WindowPlugin { primary_window: Some(window), ..default() })
            .set(LogPlugin { filter: format!("{QUIET},info"), ..default() })
            .set(RenderPlugin { render_creation: renderer(), ..default() }),
    )
    .insert_resource(Time::<Fixed>::from_hz(TICKS_PER_SECOND.into()));
    app
}

/// An app that needs no display, whose `update` finishes the picture it draws.
pub fn headless(assets: &Path) -> App {
    headless_from(App::new(), assets)
}

/// As [`headless`], from an app that has asset sources of its own already.
pub fn headless_from(mut app: App, assets: &Path) -> App {
    app.add_plugins(headless_plugins(assets)).insert_resource(Time::<Fixed>::from_hz(TICKS_PER_SECOND.into()));
    app
}

/// As [`headless`], beside another app of this process, which logs for both.
pub fn headless_beside(assets: &Path) -> App {
    let mut app = App::new();
    app.add_plugins(headless_plugins(assets).disable::<LogPlugin>())
        .insert_resource(Time::<Fixed>::from_hz(TICKS_PER_SECOND.into()));
    app
}

fn headless_plugins(assets: &Path) -> PluginGroupBuilder {
    DefaultPlugins
        .set(assets_from(assets))
        .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() })
        .set(LogPlugin { level: Level::WARN, filter: format!("{QUIET},warn"), ..default() })
        .set(RenderPlugin { render_creation: renderer(), synchronous_pipeline_compilation: true, ..default() })
        .disable::<WinitPlugin>()
        .disable::<GilrsPlugin>()
        .disable::<PipelinedRenderingPlugin>()
}

/// Finishes the plugins of an app that is driven by hand.
pub fn finish(app: &mut App) {
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
}

/// Targets that warn about what nobody can change here, such as drawing by software.
const QUIET: &str = "wgpu=error,naga=warn,bevy_render::renderer=error,bevy_render::gpu_readback=error,winit=error";

fn assets_from(folder: &Path) -> AssetPlugin {
    AssetPlugin { file_path: folder.to_string_lossy().into_owned(), ..default() }
}

/// The backends that [`preflight`](super::preflight) looked for.
fn renderer() -> RenderCreation {
    RenderCreation::Automatic(Box::new(WgpuSettings { backends: Some(Backends::PRIMARY), ..default() }))
}
