//! How long a thousand walking mannequins take on one core: two clips sampled and blended, feet placed on a heightfield,
//! skinning matrices written.
//!
//! Run by `cargo bench`; `cargo bench --bench crowd -- 500` takes another number. Prints the median time of a frame,
//! of the pose stages together and each alone, and of one character.

mod mannequins;

use std::time::{Duration, Instant};

use bevy::prelude::*;
use surefoot::{
    character::{locomotion::Locomotion, schedule::PoseSystems},
    testing::laps::lap_stages,
};

use mannequins::Mannequins;

/// When the last pose stage ended, and how long each took.
#[derive(Resource, Default)]
struct Watch {
    last: Option<Instant>,
    laps: [Vec<Duration>; STAGES],
}

/// Stages of a frame's poses.
const STAGES: usize = PoseSystems::ALL.len();

fn main() {
    let titles: String = PoseSystems::ALL.iter().map(|stage| format!("{:>10}", format!("{stage:?}"))).collect();
    println!("{:>10} {:>10} {:>10} {:>13} |{titles} ms", "characters", "frame ms", "poses ms", "µs/character");
    let asked: Vec<usize> = std::env::args().filter_map(|argument| argument.parse().ok()).collect();
    for count in if asked.is_empty() { vec![1, 100, 1_000] } else { asked } {
        let (frame, stages) = measure(count);
        let poses: Duration = stages.iter().sum();
        let each = poses.as_secs_f64() * 1e6 / count as f64;
        let stages: String = stages.iter().map(|stage| format!("{:>10.3}", stage.as_secs_f64() * 1e3)).collect();
        let (frame, poses) = (frame.as_secs_f64() * 1e3, poses.as_secs_f64() * 1e3);
        println!("{count:>10} {frame:>10.3} {poses:>10.3} {each:>13.2} |{stages}");
    }
}

/// Median of a whole frame and of each of its pose stages.
fn measure(count: usize) -> (Duration, [Duration; STAGES]) {
    let mut crowd = Mannequins::new(count, watch);
    let heard = |locomotion: &Locomotion| {
        (0..locomotion.machine.len()).filter(|state| locomotion.machine.weight(*state) > 0.0).count()
    };
    let world = crowd.app.world_mut();
    let blended = world.query::<&Locomotion>().iter(world).filter(|locomotion| heard(locomotion) >= 2).count();
    if blended < count {
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

fn watch(app: &mut App) {
    app.init_resource::<Watch>();
    let start = |mut watch: ResMut<Watch>| watch.last = Some(Instant::now());
    lap_stages(app, start, |stage| move |mut watch: ResMut<Watch>| watch.lap(stage));
}

impl Watch {
    fn lap(&mut self, stage: usize) {
        let now = Instant::now();
        if let Some(last) = self.last.replace(now) {
            self.laps[stage].push(now - last);
        }
    }
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort();
    times.get(times.len() / 2).copied().unwrap_or_default()
}
