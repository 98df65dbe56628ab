//! How long a thousand walking mannequins take on one core: two clips sampled and blended, feet placed on a heightfield,
//! skinning matrices written.
//!
//! Run by `cargo bench`; `cargo bench --bench crowd -- 500` takes another number. Prints the median time of a frame,
//! of the pose stages together and each alone, and of one character.

mod mannequins;

use std::time::{Duration, Instant};

use bevy::prelude::*;
use surefoot::character::{locomotion::Locomotion, schedule::PoseSystems};

use mannequins::Mannequins;

/// When the last pose stage ended, and how long each took.
#[derive(Resource, Default)]
struct Watch {
    last: Option<Instant>,
    laps: [Vec<Duration>; STAGES.len()],
}

/// What is timed, in order.
const STAGES: [&str; 6] = ["locomote", "sample", "plant", "look", "model", "palette"];

fn main() {
    let titles: String = STAGES.iter().map(|stage| format!("{stage:>10}")).collect();
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
fn measure(count: usize) -> (Duration, [Duration; STAGES.len()]) {
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
    app.init_resource::<Watch>().add_systems(
        PostUpdate,
        (
            start.before(PoseSystems::Locomote),
            lap::<0>.after(PoseSystems::Locomote).before(PoseSystems::Sample),
            lap::<1>.after(PoseSystems::Sample).before(PoseSystems::Plant),
            lap::<2>.after(PoseSystems::Plant).before(PoseSystems::Look),
            lap::<3>.after(PoseSystems::Look).before(PoseSystems::Model),
            lap::<4>.after(PoseSystems::Model).before(PoseSystems::Reach),
            lap::<5>.after(PoseSystems::Palette).before(TransformSystems::Propagate),
        ),
    );
}

fn start(mut watch: ResMut<Watch>) {
    watch.last = Some(Instant::now());
}

fn lap<const STAGE: usize>(mut watch: ResMut<Watch>) {
    let now = Instant::now();
    if let Some(last) = watch.last.replace(now) {
        watch.laps[STAGE].push(now - last);
    }
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort();
    times.get(times.len() / 2).copied().unwrap_or_default()
}
