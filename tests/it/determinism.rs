//! The same tape gives the same motion: bit for bit on one machine whatever its threads, and nearly so at every frame rate.

use core::hash::Hasher;
use std::{env, hash::DefaultHasher, process::Command, sync::OnceLock};

use bevy::{
    prelude::*,
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use surefoot::{
    character::animator::CharacterPose,
    measure::bars::Row,
    rig::character::CharacterAsset,
    testing::{
        Stage, Tape, World,
        gauntlet::{Runner, courses, rates::compare_all},
    },
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

/// Metres by which the end of a tape may differ.
const END: f32 = 0.01;
/// Runs of a tape at each frame rate.
const STARTS: usize = 4;

fn assert_alike_at_all_frame_rates(world: &str, tapes: &[&str]) {
    let runner = Runner::mannequin().unwrap();
    let courses: Vec<_> =
        courses().into_iter().filter(|at| at.world.name == world && tapes.contains(&&*at.tape.name)).collect();
    assert_eq!(courses.len(), tapes.len(), "not every one of {tapes:?} is on {world}");
    let mut wrong = Vec::new();
    for alike in compare_all(&courses, &runner, &[30.0, 144.0], STARTS, || ()).unwrap() {
        let case = format!("{} / {} at {} Hz", alike.world, alike.tape, alike.hertz);
        println!("{case}: ends {:.1} mm away", alike.away * 1000.0);
        if alike.away > END {
            wrong.push(format!("{case} ends {:.1} mm away", alike.away * 1000.0));
        }
        for pair in &alike.pairs {
            let Row { name, unit, .. } = pair.row;
            println!("  {name:<28} {:>9.3} {:>9.3}", pair.usual, pair.other);
            if pair.differs() {
                wrong.push(format!("{case}: {name} is {:.3} {unit}, {:.3} at 60 Hz", pair.other, pair.usual));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("; "));
}

#[test]
fn walks_and_runs_on_the_flat_are_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates("flat", &["walk", "run", "start and stop"]);
}

#[test]
fn a_walk_on_stairs_is_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates("stairs up", &["walk"]);
}

#[test]
fn a_walk_on_hills_is_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates("hills", &["S-curve"]);
}

#[test]
fn walks_over_curbs_are_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates("curb", &["walk"]);
}

#[test]
fn standing_on_a_slope_is_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates("slope 30°", &["stand in 12 places"]);
}

#[test]
fn rides_are_alike_at_30_60_and_144_hertz() {
    assert_alike_at_all_frame_rates("moving platform", &["walk", "stand"]);
}
