//! The same tape gives the same motion, bit for bit on one machine: whatever its threads, and in every tick at every frame rate.

use core::hash::Hasher;
use std::{
    env,
    hash::DefaultHasher,
    process::Command,
    sync::{
        OnceLock,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

use bevy::{
    prelude::*,
    tasks::{ComputeTaskPool, TaskPoolBuilder},
};
use surefoot::{
    character::{animator::CharacterPose, schedule::PoseSystems},
    measure::bars::Row,
    rig::character::CharacterAsset,
    testing::{
        Stage, Tape, World,
        gauntlet::{Course, Runner, courses, rates::compare_all},
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

/// Hash of all that the ticks so far made of everyone: roots and poses.
#[derive(Resource, Default)]
struct Ticks(DefaultHasher, usize);

fn hash_tick(characters: Query<(&Transform, &CharacterPose)>, mut ticks: ResMut<Ticks>) {
    ticks.1 += 1;
    for (root, pose) in &characters {
        let joints = pose
            .pose
            .locals()
            .iter()
            .flat_map(|joint| joint.rotation.to_array().into_iter().chain(joint.translation.to_array()));
        joints.chain(root.translation.to_array()).for_each(|number| ticks.0.write_u32(number.to_bits()));
    }
}

/// Ticks of a course at `hertz` frames a second, and their hash.
fn ticks_of(course: &Course, runner: &Runner, hertz: f32) -> (usize, u64) {
    let mut stage = Stage::with(&course.world, &runner.assets, |app| {
        app.add_systems(FixedPostUpdate, hash_tick.after(PoseSystems::Ease).run_if(resource_exists::<Ticks>));
    });
    let walkers = stage.spawn_loaded(runner.character.clone(), &course.starts);
    stage.set_frame_rate(hertz);
    // Ends within a tick, so that all frame rates have had as many of them.
    stage.run_for(2.0 / 3.0).app().init_resource::<Ticks>();
    stage.play_all(&walkers, &course.tape);
    let Ticks(hash, count) = stage.app().world_mut().remove_resource().unwrap();
    (count, hash.finish())
}

#[test]
fn frames_change_nothing_every_tick_is_the_same_at_30_60_and_144_hertz() {
    let runner = Runner::mannequin().unwrap();
    let courses = courses();
    let next = AtomicUsize::new(0);
    let check = || {
        let mut wrong = Vec::new();
        while let Some(course) = courses.get(next.fetch_add(1, Ordering::Relaxed)) {
            let usual = ticks_of(course, &runner, 60.0);
            for hertz in [30.0, 144.0] {
                let other = ticks_of(course, &runner, hertz);
                if other != usual {
                    let case = format!("{} / {}", course.world.name, course.tape.name);
                    wrong.push(format!("{case}: {usual:x?} at 60 Hz, {other:x?} at {hertz}"));
                }
            }
        }
        wrong
    };
    let wrong: Vec<String> = thread::scope(|scope| {
        let halves = [scope.spawn(check), scope.spawn(check)];
        halves.into_iter().flat_map(|half| half.join().unwrap()).collect()
    });
    assert!(wrong.is_empty(), "ticks and their hash differ on {}", wrong.join("; "));
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
