//! Runs crowds: without a display and measured, or in a window.

use std::{error::Error, fs, time::Instant};

use bevy::{
    diagnostic::{DiagnosticMeasurement, DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
    time::TimeUpdateStrategy,
};
use surefoot::game::{
    engine::{self, WindowShape},
    film::{
        frames,
        shutter::{ShutterPlugin, developed, expose},
    },
    preflight::{assets, gpu},
};

use super::{
    built_in,
    counts::{self, Counter},
    flags::{Flags, Way},
    meter::{self, CPU, FRAME, MeterPlugin},
    ours, plot,
    report::{self, Row},
    scene,
};

/// Frames before anything is measured, once everyone is there: buffers grow, pipelines are made, everyone walks.
const WARM_UP: usize = 40;
/// The last of them that are drawn.
const DRAWN: usize = 4;
/// Frames of one crowd before the next one has its turn; the first of them isn't measured.
const TURN: usize = 5;
/// Updates that loading may take.
const PATIENCE: usize = 100_000;

/// Measures every crowd that the flags ask for, prints the table and writes the plot.
pub(crate) fn measure(flags: &Flags) -> Result<(), Box<dyn Error>> {
    gpu::check()?;
    fs::create_dir_all(&flags.out)?;
    let mut rows = Vec::new();
    report::head();
    for &count in &flags.count {
        // All at once, so that they take turns and share whatever else the machine does.
        let mut crowds = flags
            .way
            .iter()
            .enumerate()
            .map(|(index, way)| Crowd::new(*way, count, flags, rows.is_empty() && index == 0))
            .collect::<Result<Vec<_>, _>>()?;
        for _ in 0..flags.frames.div_ceil(TURN - 1) {
            crowds.iter_mut().for_each(Crowd::turn);
        }
        for crowd in &mut crowds {
            let row = crowd.row();
            report::line(&row);
            rows.push(row);
            crowd.picture(flags)?;
        }
    }
    report::tail(&rows);
    let file = flags.out.join("crowd.svg");
    fs::write(&file, plot::figure(&rows)?)?;
    println!("\nwritten: {}, and a picture of each crowd beside it", file.display());
    Ok(())
}

/// Shows one crowd.
pub(crate) fn show(flags: &Flags) -> Result<(), Box<dyn Error>> {
    let (Some(&way), Some(&count)) = (flags.way.first(), flags.count.first()) else { return Ok(()) };
    let shape = WindowShape { size: flags.size.max(UVec2::new(640, 360)), fullscreen: false };
    let mut app = engine::windowed(&assets::find()?, shape);
    app.add_plugins((FrameTimeDiagnosticsPlugin::default(), bevy::diagnostic::LogDiagnosticsPlugin::default()));
    populate(&mut app, way, count, flags);
    app.run();
    Ok(())
}

fn populate(app: &mut App, way: Way, count: usize, flags: &Flags) {
    scene::build(app, count, flags);
    match way {
        Way::Surefoot => ours::characters(app),
        Way::Poses => ours::poses(app, false),
        Way::Levels => ours::poses(app, true),
        Way::BuiltIn => built_in::characters(app),
    }
    app.add_plugins((MeterPlugin, counts::plugin));
}

/// Lets the camera draw or not: who only loads and walks needs no pictures.
fn draws(app: &mut App, open: bool) {
    let mut cameras = app.world_mut().query::<&mut Camera>();
    cameras.iter_mut(app.world_mut()).for_each(|mut camera| camera.is_active = open);
}

/// A crowd that draws into a picture.
struct Crowd {
    app: App,
    way: Way,
    count: usize,
    /// What was there when measuring began.
    before: counts::Counts,
}

impl Crowd {
    /// Ready to be measured. The first one logs for all.
    fn new(way: Way, count: usize, flags: &Flags, first: bool) -> Result<Self, Box<dyn Error>> {
        let assets = assets::find()?;
        let mut app = if first { engine::headless(&assets) } else { engine::headless_beside(&assets) };
        app.add_plugins(ShutterPlugin { size: flags.size }).insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
        populate(&mut app, way, count, flags);
        engine::finish(&mut app);
        draws(&mut app, false);
        let ready = match way {
            Way::BuiltIn => built_in::ready,
            Way::Levels => ours::ready_with_levels,
            _ => ours::ready,
        };
        for _ in 0..PATIENCE {
            app.update();
            draws(&mut app, false);
            if ready(app.world_mut()) == count {
                break;
            }
        }
        for frame in 0..WARM_UP {
            draws(&mut app, frame + DRAWN >= WARM_UP);
            app.update();
        }
        let there = ready(app.world_mut());
        if there < count {
            return Err(format!("{there} of {count} characters of `{}` could be loaded", way.name()).into());
        }
        meter::reset(app.world_mut());
        let before = app.world().resource::<Counter>().read();
        Ok(Self { app, way, count, before })
    }

    /// Some frames.
    fn turn(&mut self) {
        draws(&mut self.app, true);
        self.app.update();
        for _ in 1..TURN {
            let (begun, cpu) = (Instant::now(), meter::cpu_time());
            self.app.update();
            let time = Instant::now();
            let frame = (time - begun).as_secs_f64() * 1e3;
            let cpu = cpu.and_then(|before| Some(meter::cpu_time()? - before));
            let mut store = self.app.world_mut().resource_mut::<DiagnosticsStore>();
            for (path, value) in [(&FRAME, Some(frame)), (&CPU, cpu)] {
                if let (Some(diagnostic), Some(value)) = (store.get_mut(path), value) {
                    diagnostic.add_measurement(DiagnosticMeasurement { time, value });
                }
            }
        }
    }

    fn row(&mut self) -> Row {
        let triangles = counts::triangles(self.app.world_mut());
        let after = self.app.world().resource::<Counter>().read();
        let store = self.app.world().resource::<DiagnosticsStore>();
        Row::new(self.way, self.count, triangles, store, (&self.before, after))
    }

    /// Writes what the crowd looks like.
    fn picture(&mut self, flags: &Flags) -> Result<(), Box<dyn Error>> {
        expose(&mut self.app, 0, 1);
        for _ in 0..10 {
            self.app.update();
            if let Some((_, picture)) = developed(&mut self.app).pop() {
                let name = format!("{}-{}.png", self.way.name(), self.count);
                frames::save(&flags.out.join(name), &picture)?;
                return Ok(());
            }
        }
        Err(format!("no picture of `{}` came back", self.way.name()).into())
    }
}
