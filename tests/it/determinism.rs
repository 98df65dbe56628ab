//! The same tape gives the same motion: bit for bit on one machine whatever its threads, and nearly so at every frame rate.

use core::hash::Hasher;
use std::{env, hash::DefaultHasher, process::Command, sync::OnceLock};

use bevy::{
    prelude::*,
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use surefoot::{
    character::animator::CharacterPose,
    measure::{
        frame::Frame,
        summary::{Measures, summarize_all},
    },
    rig::character::CharacterAsset,
    testing::{Stage, Tape, World},
};

/// The mannequin, loaded once.
fn mannequin() -> CharacterAsset {
    static MANNEQUIN: OnceLock<CharacterAsset> = OnceLock::new();
    let load = || Stage::on(&World::flat()).load_character("mannequin.character.ron").unwrap();
    MANNEQUIN.get_or_init(load).clone()
}

/// A hash of every joint of eight walkers in every frame of a tape.
fn hash_of_all_poses() -> u64 {
    let world = World::rubble();
    let places: Vec<Transform> = (0..8u8).map(|i| Transform::from_xyz(f32::from(i) * 0.7 - 2.5, 0.0, 0.0)).collect();
    let mut stage = Stage::on(&world);
    let walkers = stage.spawn_loaded(mannequin(), &world.on_ground(&places));
    let tape = Tape::change_gait();
    let mut hasher = DefaultHasher::new();
    for frame in 0..(tape.seconds * 60.0) as usize {
        for walker in &walkers {
            stage.intend(*walker, tape.intent_at(frame as f32 / 60.0));
        }
        stage.run_for(1.0 / 60.0);
        for walker in &walkers {
            let pose = &stage.get::<CharacterPose>(*walker).unwrap().pose;
            for joint in pose.locals() {
                let bits = joint.rotation.to_array().into_iter().chain(joint.translation.to_array()).map(f32::to_bits);
                bits.for_each(|bits| hasher.write_u32(bits));
            }
            stage.root(*walker).to_array().map(f32::to_bits).iter().for_each(|bits| hasher.write_u32(*bits));
        }
    }
    hasher.finish()
}

/// Threads that the process below computes with.
const THREADS: &str = "SUREFOOT_TEST_THREADS";
/// What stands before the hash in its output.
const MARK: &str = "hash of all poses: ";

#[test]
#[ignore = "not a test by itself: the one below runs it in processes of its own, since a process has one pool of threads"]
fn prints_the_hash_of_all_poses() {
    if let Some(threads) = env::var(THREADS).ok().and_then(|threads| threads.parse().ok()) {
        ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(threads).build());
    }
    println!("\n{MARK}{:016x}", hash_of_all_poses());
}

#[test]
fn the_same_tape_gives_the_same_poses_on_any_number_of_threads() {
    let hash = |threads: usize| {
        let output = Command::new(env::current_exe().unwrap())
            .args(["--ignored", "--exact", "determinism::prints_the_hash_of_all_poses", "--nocapture"])
            .env(THREADS, threads.to_string())
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let hash = text.lines().find_map(|line| line.strip_prefix(MARK)).map(str::to_owned);
        hash.unwrap_or_else(|| {
            panic!("no hash from {threads} threads: {text}{}", String::from_utf8_lossy(&output.stderr))
        })
    };
    let one = hash(1);
    assert_eq!(hash(1), one, "two runs on one thread differ");
    for threads in [2, 7] {
        assert_eq!(hash(threads), one, "{threads} threads give other poses than one");
    }
}

/// Where a tape ends at a frame rate, and the figures of all runs together, measured at moments `every` so many seconds apart.
///
/// The tape begins between those moments, in each run elsewhere: what is quick looks another way half a frame later.
fn outcome(world: &World, tape: &Tape, hertz: f32, every: f32) -> (Vec3, Measures) {
    let runs: Vec<(Vec3, Vec<Frame>)> = (0..RUNS)
        .map(|run| {
            let mut stage = Stage::on(world);
            let walker = stage.spawn_loaded(mannequin(), &[Transform::IDENTITY])[0];
            stage.set_frame_rate(hertz);
            stage.run_for(0.5).record_every(walker, every).start_recording(walker);
            stage.play(walker, &tape.later(every * run as f32 / RUNS as f32));
            (stage.root(walker), stage.frames(walker).to_vec())
        })
        .collect();
    let frames: Vec<&[Frame]> = runs.iter().map(|(_, frames)| &frames[..]).collect();
    (runs[0].0, summarize_all(&frames))
}

/// Runs of a tape at each frame rate.
const RUNS: usize = 4;
/// Metres by which the end of a tape may differ.
const END: f32 = 0.01;
/// Share by which a measure may differ.
const SHARE: f32 = 0.2;
/// Share of its bar below which a difference of a measure can't be told: poses between two frames are blended, and what falls
/// into one frame at one rate falls between two at another.
const NOISE: f32 = 0.1;
/// Seconds of the controller's ticks.
const TICK: f32 = 1.0 / 64.0;

/// Both sides are measured at the same moments, 60 in a second, or as many as the slower one has.
fn assert_alike_at_all_frame_rates(world: &World, tape: &Tape) {
    let case = format!("{} / {}", world.name, tape.name);
    let mut wrong = Vec::new();
    for hertz in [30.0f32, 144.0] {
        let every = 1.0 / hertz.min(60.0);
        let (usual_end, usual) = outcome(world, tape, 60.0, every);
        let (end, other) = outcome(world, tape, hertz, every);
        let away = end.distance(usual_end);
        println!("{case} at {hertz} Hz: ends {:.1} mm away", away * 1000.0);
        if away > END {
            wrong.push(format!("at {hertz} Hz it ends {:.1} mm away", away * 1000.0));
        }
        for (usual, other) in world.bars().rows(&usual).iter().zip(world.bars().rows(&other)) {
            let (Some(a), Some(b)) = (usual.value, other.value) else { continue };
            let mut allowed = (SHARE * a.max(b)).max(NOISE * usual.limit);
            if usual.key == "start_frames" {
                // An intent waits for the next tick, and what came of it for the next moment that is measured.
                allowed = allowed.max(((TICK + every) / every).round());
            }
            // Whether the last frame before a landing counts as sliding depends on how high it finds the foot: only more is worse.
            let differs = if usual.key == "skate_cm_s" { b - a } else { (a - b).abs() } > allowed;
            println!("  {:<28} {a:>9.3} {b:>9.3}{}", usual.name, if differs { "  differs" } else { "" });
            if differs {
                wrong.push(format!("{} is {a:.3} {} at 60 Hz and {b:.3} at {hertz} Hz", usual.name, usual.unit));
            }
        }
    }
    assert!(wrong.is_empty(), "{case}: {}", wrong.join("; "));
}

#[test]
fn a_walk_on_the_flat_is_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates(&World::flat(), &Tape::walk());
    assert_alike_at_all_frame_rates(&World::flat(), &Tape::start_stop());
}

#[test]
fn a_run_on_the_flat_is_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates(&World::flat(), &Tape::run());
}

#[test]
fn a_walk_on_stairs_is_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates(&World::stairs_up(12, 0.17, 0.29), &Tape::walk());
}

#[test]
fn a_walk_on_hills_is_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates(&World::hills(), &Tape::s_curve());
}
