//! Surefoot's stages beside the engine's own, in one process on one core: the same body, the same clips.
//!
//! `cargo bench --bench versus`. First what other instructions, a second core and 16-bit clips make of it, and what comes
//! from the heap; then rows `STAGE N SUREFOOT_NS BUILTIN_NS RATIO`, nanoseconds for a character and frame. `full` is all
//! stages before it; `frame` is a whole frame without rendering, with locomotion, physics and feet on hills on our side
//! and animation alone on the engine's. See `benches/README.md`.

mod body;
#[cfg(feature = "render")]
mod built_in;
#[path = "../mannequins.rs"]
mod mannequins;
mod ours;
mod watch;

use surefoot::anim::{
    block::{Instructions, Precision, Until, Workspace},
    matrix::JointMatrix,
};

use body::Body;
#[cfg(feature = "render")]
use built_in::{BuiltIn, Part};
use mannequins::{Mannequins, Palettes, Viewer};
use ours::Ours;
#[cfg(feature = "render")]
use watch::thread_time;
use watch::{allocations, bytes_in_use, median, time, wall_time};

/// Characters of each row.
const COUNTS: [usize; 4] = [1, 100, 1_000, 10_000];
/// Both sides take turns so often; the median counts.
const TURNS: usize = 5;
/// Character frames that one turn measures.
const WORK: usize = 200_000;
/// The same of sides that take tens of times as long.
const SLOW_WORK: usize = 4_000;

/// Nanoseconds a character of one stage. NaN where a side has no such stage.
struct Row {
    stage: &'static str,
    ours: f64,
    theirs: f64,
}

fn main() {
    // Cargo asks benches for their tests too.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    let body = Body::new();
    println!("{} joints, walk and run at 30 Hz, two legs with IK (built-in: none)\n", body.skeleton.len());
    #[cfg(feature = "render")]
    if BuiltIn::new(&body, 1, 1).is_none() {
        println!("no GPU driver: the built-in is left out");
    }
    let ours = Ours::new(&body, Precision::Float);
    // First of all, for pools of threads are made once.
    let table: Vec<_> = COUNTS.iter().map(|count| (*count, rows(&body, &ours, *count))).collect();
    instructions(&ours);
    cores(&ours);
    shorts(&body);
    heap(&ours);
    memory();
    let full = |rows: &[Row]| rows.iter().find(|row| row.stage == "full").map_or(f64::NAN, |row| row.ours);
    if let [_, (_, hundred), _, (_, ten_thousand)] = &table[..] {
        println!("from N = 100 to 10,000 a character costs {:.2} times as much", full(ten_thousand) / full(hundred));
    }
    println!("\n{:<8} {:>6} {:>12} {:>12} {:>8}", "STAGE", "N", "SUREFOOT_NS", "BUILTIN_NS", "RATIO");
    for (count, rows) in table {
        for row in rows {
            let cell = |value: f64, digits| if value.is_nan() { "-".to_owned() } else { format!("{value:.digits$}") };
            let (ours, theirs, ratio) = (cell(row.ours, 0), cell(row.theirs, 0), cell(row.theirs / row.ours, 1));
            println!("{:<8} {count:>6} {ours:>12} {theirs:>12} {ratio:>8}", row.stage);
        }
    }
}

/// All stages of one crowd, both sides taking turns.
fn rows(body: &Body, ours: &Ours, count: usize) -> Vec<Row> {
    let rounds = WORK.div_ceil(count);
    let mut work = Workspace::default();
    let (mut one, mut two) = (ours.crowd(count, 1), ours.crowd(count, 2));
    let mut times: [Vec<f64>; 5] = Default::default();
    let mut theirs = Theirs::new(body, count);
    let (mut mannequins, mut frames) = (Mannequins::new(count, Viewer::None, 1, |_| ()), Vec::new());
    for _ in 0..TURNS {
        let mut of =
            |crowd: &mut ours::Crowd, until| time(rounds, || ours.frame(crowd, &mut work, until)) / count as f64;
        let laps = [
            of(&mut one, Until::Sampled),
            of(&mut two, Until::Sampled),
            of(&mut two, Until::Modelled),
            of(&mut two, Until::Reached),
            of(&mut two, Until::Written),
        ];
        times.iter_mut().zip(laps).for_each(|(times, lap)| times.push(lap));
        let slow_rounds = SLOW_WORK.div_ceil(count);
        theirs.measure(slow_rounds, count);
        // Longer, and they would walk off their hills.
        frames.push(time(slow_rounds.min(40), || mannequins.frame()) / count as f64);
    }
    let [sample, blend, model, reach, written] = times.each_mut().map(|times| median(times));
    let [their_sample, animate, propagate, extract, their_frame] = theirs.medians();
    vec![
        Row { stage: "sample", ours: sample, theirs: their_sample },
        Row { stage: "blend", ours: blend, theirs: animate },
        Row { stage: "model", ours: model - blend, theirs: propagate },
        Row { stage: "ik", ours: reach - model, theirs: f64::NAN },
        Row { stage: "palette", ours: written - reach, theirs: extract },
        Row { stage: "full", ours: written, theirs: animate + propagate + extract },
        Row { stage: "frame", ours: median(&mut frames), theirs: their_frame },
    ]
}

/// The same frames with AVX2, and with the instructions of every machine.
fn instructions(ours: &Ours) {
    let mut crowd = ours.crowd(1_000, 2);
    let mut full = |instructions: Instructions| {
        let mut work = Workspace::with(instructions);
        let lap = |_| time(WORK / 1_000, || ours.frame(&mut crowd, &mut work, Until::Written)) / 1_000.0;
        median(&mut (0..TURNS).map(lap).collect::<Vec<_>>())
    };
    let [best, baseline] = [Instructions::best(), Instructions::baseline()].map(&mut full);
    let avx2 = Instructions::avx2().map_or(f64::NAN, full);
    println!(
        "full, N = 1,000: {best:.0} ns with the best instructions, {avx2:.0} with AVX2, {baseline:.0} with the least"
    );
}

fn cores(ours: &Ours) {
    let mut crowd = ours.crowd(10_000, 2);
    let mut works = [Workspace::default(), Workspace::default()];
    let (mut one, mut two) = (Vec::new(), Vec::new());
    for _ in 0..2 * TURNS {
        one.push(wall_time(4, || ours.frame(&mut crowd, &mut works[0], Until::Written)));
        two.push(wall_time(4, || ours.frame_on_two(&mut crowd, &mut works)));
    }
    println!("full, N = 10,000, wall time: {:.2} times as fast on two cores", median(&mut one) / median(&mut two));
}

fn shorts(body: &Body) {
    let ours = Ours::new(body, Precision::Short);
    let (short, float) = (ours.walk_report(), Ours::new(body, Precision::Float).walk_report());
    let (mut crowd, mut work) = (ours.crowd(1_000, 2), Workspace::default());
    let lap = |_| time(WORK / 1_000, || ours.frame(&mut crowd, &mut work, Until::Written)) / 1_000.0;
    let nanoseconds = median(&mut (0..TURNS).map(lap).collect::<Vec<_>>());
    let error = short.max_error * 1e3;
    println!(
        "walk: {} bytes in floats, {} in 16 bits, {error:.3} mm off at 3 cm from its joints; full, N = 1,000: {nanoseconds:.0} ns",
        float.bytes, short.bytes,
    );
}

fn heap(ours: &Ours) {
    let (mut crowd, mut work) = (ours.crowd(1_000, 2), Workspace::default());
    ours.frame(&mut crowd, &mut work, Until::Written);
    let mut mannequins = [10, 1_000].map(|count| Mannequins::new(count, Viewer::None, 1, |_| ()));
    let taken = |frame: &mut dyn FnMut()| {
        let before = allocations();
        (0..10).for_each(|_| frame());
        allocations() - before
    };
    let full = taken(&mut || ours.frame(&mut crowd, &mut work, Until::Written));
    let [few, many] = mannequins.each_mut().map(|crowd| taken(&mut || crowd.frame()));
    println!("heap allocations in ten frames: full, N = 1,000: {full}; frame, N = 10: {few}, N = 1,000: {many}");
}

/// What the app takes for a mannequin, physics and the engine's own records included.
fn memory() {
    let [few, many] = [24, 1_024].map(|count| {
        let before = bytes_in_use();
        let crowd = Mannequins::new(count, Viewer::None, 1, |_| ());
        let palettes = crowd.app.world().resource::<Palettes>().0.capacity() * size_of::<JointMatrix>();
        bytes_in_use() - before - palettes
    });
    println!(
        "memory: {} bytes a mannequin beyond its palette, physics and the engine's records included",
        (many - few) / 1_000
    );
}

/// The engine's side: with one clip, and with two.
#[cfg(feature = "render")]
struct Theirs {
    sides: Option<[BuiltIn; 2]>,
    times: [Vec<f64>; 5],
}

#[cfg(feature = "render")]
impl Theirs {
    fn new(body: &Body, count: usize) -> Self {
        let [one, two] = [1, 2].map(|clips| BuiltIn::new(body, count, clips));
        Self { sides: one.zip(two).map(|(one, two)| [one, two]), times: Default::default() }
    }

    fn measure(&mut self, rounds: usize, count: usize) {
        let Some([one, two]) = &mut self.sides else { return };
        for _ in 0..rounds {
            let sample = thread_time(|| one.run(Part::Animate));
            let [animate, propagate, extract] =
                [Part::Animate, Part::Propagate, Part::Extract].map(|part| thread_time(|| two.run(part)));
            for (times, lap) in self.times.iter_mut().zip([sample, animate, propagate, extract]) {
                times.push(lap / count as f64);
            }
        }
        self.times[4].push(time(rounds, || two.frame()) / count as f64);
    }

    fn medians(&mut self) -> [f64; 5] {
        self.times.each_mut().map(|times| median(times))
    }
}

/// Without the `render` feature there is nothing to compare with.
#[cfg(not(feature = "render"))]
struct Theirs;

#[cfg(not(feature = "render"))]
impl Theirs {
    fn new(_: &Body, _: usize) -> Self {
        Self
    }

    fn measure(&mut self, _: usize, _: usize) {}

    fn medians(&mut self) -> [f64; 5] {
        [f64::NAN; 5]
    }
}
