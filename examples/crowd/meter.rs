//! A stopwatch through the engine's schedules: what each part of a frame takes, kept by the engine's diagnostics.

use std::{
    fs,
    sync::{Arc, Mutex, PoisonError},
    time::Instant,
};

use bevy::{
    app::{AnimationSystems, RunFixedMainLoop, RunFixedMainLoopSystems},
    diagnostic::{Diagnostic, DiagnosticPath, Diagnostics, DiagnosticsStore, RegisterDiagnostic},
    prelude::*,
    render::{Render, RenderApp, RenderSystems, diagnostic::RenderDiagnosticsPlugin, renderer::RenderDevice},
    transform::TransformSystems,
};
use surefoot::character::schedule::PoseSystems;
use wgpu::PollType;

/// A whole frame, by the clock.
pub(crate) const FRAME: DiagnosticPath = DiagnosticPath::const_new("crowd/frame");

/// The processor's time for a frame, all threads together: other programs don't count. Where the processor draws, too, that is
/// all there is.
pub(crate) const CPU: DiagnosticPath = DiagnosticPath::const_new("crowd/cpu");

/// Parts of a frame in order, and what each is.
pub(crate) const PARTS: [(&str, &str); 7] = [
    ("crowd/ticks", "fixed ticks: intents, controllers, physics, animation, feet"),
    ("crowd/poses", "poses between ticks or by blocks, palettes, transforms"),
    ("crowd/world", "the rest of the main world: culling, loading, culling boxes"),
    ("crowd/extract", "extraction to the render world, palettes to the staging memory"),
    ("crowd/prepare", "render world: specialize, queue, prepare, bind groups"),
    ("crowd/draw", "render passes recorded and submitted"),
    ("crowd/wait", "until the GPU is done"),
];
const TICKS: usize = 0;
const POSES: usize = 1;
const WORLD: usize = 2;
const EXTRACT: usize = 3;
const PREPARE: usize = 4;
const DRAW: usize = 5;
const WAIT: usize = 6;

/// Most frames that a diagnostic remembers.
const HISTORY: usize = 4096;

/// Milliseconds of the parts of the frame so far; shared by main and render world, each with a clock of its own.
#[derive(Resource, Clone)]
struct Meter<const SIDE: usize>(Arc<Mutex<Laps>>);

struct Laps {
    last: [Instant; 2],
    parts: [f64; PARTS.len()],
}

const MAIN: usize = 0;
const RENDERER: usize = 1;

/// Times frames into [`PARTS`].
pub(crate) struct MeterPlugin;

impl Plugin for MeterPlugin {
    fn build(&self, app: &mut App) {
        let laps = Arc::new(Mutex::new(Laps { last: [Instant::now(); 2], parts: [0.0; PARTS.len()] }));
        app.add_plugins(RenderDiagnosticsPlugin).insert_resource(Meter::<MAIN>(laps.clone()));
        for path in PARTS.map(|(path, _)| DiagnosticPath::const_new(path)).into_iter().chain([FRAME, CPU]) {
            app.register_diagnostic(Diagnostic::new(path).with_max_history_length(HISTORY));
        }
        app.add_systems(First, publish)
            .add_systems(
                RunFixedMainLoop,
                (
                    lap::<MAIN, WORLD>.before(RunFixedMainLoopSystems::FixedMainLoop),
                    lap::<MAIN, TICKS>
                        .after(RunFixedMainLoopSystems::FixedMainLoop)
                        .before(RunFixedMainLoopSystems::AfterFixedMainLoop),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    lap::<MAIN, WORLD>.before(PoseSystems::Show).before(AnimationSystems),
                    lap::<MAIN, POSES>.after(TransformSystems::Propagate).after(PoseSystems::Palette),
                ),
            )
            .add_systems(Last, lap::<MAIN, WORLD>);
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
        render_app.insert_resource(Meter::<RENDERER>(laps.clone())).add_systems(
            Render,
            (
                lap::<RENDERER, EXTRACT>.before(RenderSystems::ExtractCommands),
                lap::<RENDERER, PREPARE>.after(RenderSystems::Prepare).before(RenderSystems::Render),
                (lap::<RENDERER, DRAW>, wait, lap::<RENDERER, WAIT>)
                    .chain()
                    .after(RenderSystems::Render)
                    .before(RenderSystems::Cleanup),
            ),
        );
        if let Some(mut extract) = render_app.take_extract() {
            render_app.set_extract(move |main, render| {
                laps.lock().unwrap_or_else(PoisonError::into_inner).last[RENDERER] = Instant::now();
                extract(main, render);
            });
        }
    }
}

/// The part that has gone on until now was `PART`.
fn lap<const SIDE: usize, const PART: usize>(meter: Res<Meter<SIDE>>) {
    let mut laps = meter.0.lock().unwrap_or_else(PoisonError::into_inner);
    let now = Instant::now();
    let last = std::mem::replace(&mut laps.last[SIDE], now);
    laps.parts[PART] += (now - last).as_secs_f64() * 1e3;
}

/// Frames are measured with all of their drawing.
fn wait(device: Res<RenderDevice>) {
    if let Err(error) = device.poll(PollType::wait_indefinitely()) {
        warn!("the GPU can't be waited for: {error}");
    }
}

/// Hands the last frame to the diagnostics.
fn publish(meter: Res<Meter<MAIN>>, mut diagnostics: Diagnostics) {
    let mut laps = meter.0.lock().unwrap_or_else(PoisonError::into_inner);
    laps.last[MAIN] = Instant::now();
    for ((path, _), part) in PARTS.iter().zip(&mut laps.parts) {
        let milliseconds = std::mem::take(part);
        diagnostics.add_measurement(&DiagnosticPath::const_new(path), || milliseconds);
    }
}

/// Milliseconds that all threads of this program have run; `None` where the system doesn't tell.
pub(crate) fn cpu_time() -> Option<f64> {
    let tasks = fs::read_dir("/proc/self/task").ok()?;
    let run = |task: fs::DirEntry| -> Option<f64> {
        fs::read_to_string(task.path().join("schedstat")).ok()?.split_whitespace().next()?.parse().ok()
    };
    Some(tasks.flatten().filter_map(run).sum::<f64>() * 1e-6)
}

/// The middle of what a diagnostic has measured.
pub(crate) fn median(store: &DiagnosticsStore, path: &DiagnosticPath) -> Option<f64> {
    let mut values: Vec<f64> = store.get(path)?.values().copied().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Forgets what was measured so far.
pub(crate) fn reset(world: &mut World) {
    for diagnostic in world.resource_mut::<DiagnosticsStore>().iter_mut() {
        diagnostic.clear_history();
    }
}
