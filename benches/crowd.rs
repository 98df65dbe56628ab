//! How long a thousand walking mannequins take on one core: two clips sampled and blended, feet placed on a heightfield,
//! skinning matrices written.
//!
//! Run by `cargo bench`; `cargo bench --bench crowd -- 500` takes another number. Prints the median time of a frame,
//! of the pose stages together and of one character, then that of each part of a frame. At last ten thousand before a camera,
//! with level of detail and two threads; `-- lod 5000` prints that alone.

mod mannequins;

use std::time::{Duration, Instant};

use avian3d::prelude::PhysicsSystems;
use bevy::{
    ecs::schedule::{Schedules, SingleThreadedExecutor},
    prelude::*,
};
use surefoot::{
    character::{detail::Detail, locomotion::Locomotion, schedule::MotionSystems},
    testing::laps::{STAGES, lap_stages},
};

use mannequins::{Mannequins, Viewer};

/// When the last part of a frame ended, and how long each took.
#[derive(Resource, Default)]
struct Watch {
    last: Option<Instant>,
    laps: [Vec<Duration>; PARTS],
}

/// Parts of a frame before its poses: what leads up to the controller, the controller, what leads up to physics, physics,
/// the interpolation of what they moved.
const BEFORE: [&str; 5] = ["First", "Move", "Between", "Physics", "Interpolate"];

/// Parts of a frame: those before, the stages of its poses, and what comes last.
const PARTS: usize = BEFORE.len() + STAGES.len() + 1;

fn main() {
    println!("{:>10} {:>10} {:>10} {:>13}", "characters", "frame ms", "poses ms", "µs/character");
    let asked: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    let detail = std::env::args().any(|argument| argument == "lod");
    let mut runs: Vec<_> = asked.iter().map(|count| (*count, detail)).collect();
    if asked.is_empty() {
        runs = if detail { vec![] } else { vec![(1, false), (100, false), (1_000, false)] };
        runs.push((10_000, true));
    }
    for (count, detail) in runs {
        let (frame, parts) = measure(count, detail);
        let poses: Duration = parts[BEFORE.len()..PARTS - 1].iter().sum();
        let each = poses.as_secs_f64() * 1e6 / count as f64;
        println!("{count:>10} {:>10.3} {:>10.3} {each:>13.2}", millis(frame), millis(poses));
        let stages = STAGES.map(|stage| format!("{stage:?}"));
        let names = BEFORE.iter().copied().chain(stages.iter().map(String::as_str)).chain(["Last"]);
        for (name, part) in names.zip(parts) {
            println!("{:>10} {:>10.3} {name}", "", millis(part));
        }
    }
}

fn millis(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Median of a whole frame and of each of its parts; with level of detail on two threads, else on one.
fn measure(count: usize, detail: bool) -> (Duration, [Duration; PARTS]) {
    let (viewer, threads) = if detail { (Viewer::Camera, 2) } else { (Viewer::None, 1) };
    let mut crowd = Mannequins::new(count, viewer, threads, watch);
    let heard = |locomotion: &Locomotion| {
        (0..locomotion.machine.len()).filter(|state| locomotion.machine.weight(*state) > 0.0).count()
    };
    let world = crowd.app.world_mut();
    let blended = world.query::<&Locomotion>().iter(world).filter(|locomotion| heard(locomotion) >= 2).count();
    if detail {
        let details: Vec<Detail> = world.query::<&Detail>().iter(world).copied().collect();
        let counts =
            [false, true].map(|near| details.iter().filter(|it| it.posed && (!it.clips_only || !near)).count());
        println!("level of detail, two threads: {} of {count} in view, {} of them near", counts[0], counts[1]);
    } else if blended < count {
        println!("{blended} of {count} characters blend two clips, the others have met an obstacle");
    }
    world.resource_mut::<Watch>().laps = Default::default();
    let mut frames: Vec<Duration> = (0..60)
        .map(|_| {
            let begun = Instant::now();
            crowd.frame();
            begun.elapsed()
        })
        .collect();
    let mut laps = crowd.app.world_mut().resource_mut::<Watch>().laps.clone();
    (median(&mut frames), laps.each_mut().map(|laps| median(laps)))
}

/// Notes the time between the parts of a frame; all of them run on this thread.
fn watch(app: &mut App) {
    let lap = |part: usize| move |mut watch: ResMut<Watch>| watch.lap(part);
    app.init_resource::<Watch>()
        .add_systems(First, |mut watch: ResMut<Watch>| watch.last = Some(Instant::now()))
        .add_systems(FixedUpdate, (lap(0).before(MotionSystems::Decide), lap(1).after(MotionSystems::Move)))
        .add_systems(FixedPostUpdate, (lap(2).before(PhysicsSystems::First), lap(3).after(PhysicsSystems::Last)))
        .add_systems(Last, lap(PARTS - 1));
    lap_stages(app, lap(4), |stage| lap(BEFORE.len() + stage));
    for (_, schedule) in app.world_mut().resource_mut::<Schedules>().iter_mut() {
        schedule.set_executor(SingleThreadedExecutor::new());
    }
}

impl Watch {
    fn lap(&mut self, part: usize) {
        let now = Instant::now();
        if let Some(last) = self.last.replace(now) {
            self.laps[part].push(now - last);
        }
    }
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort();
    times.get(times.len() / 2).copied().unwrap_or_default()
}
