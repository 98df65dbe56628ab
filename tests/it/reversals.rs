//! Whoever turns back, anywhere in a stride or a fade, never seems to jump: feet placed, all joints measured.

use core::f32::consts::FRAC_PI_4;
use std::sync::OnceLock;

use bevy::prelude::*;
use proptest::{prelude::*, strategy::ValueTree, test_runner::TestRunner};
use surefoot::testing::{
    Tape,
    gauntlet::{Course, Feet, Job, Runner, courses, run},
};

use crate::support::assert_no_pop;

const WALK: f32 = 1.4;
const RUN: f32 = 3.5;

/// Plays tapes on the world of a course of that name; none may pop.
fn assert_none_pops(world: &str, tapes: Vec<Tape>) {
    static MANNEQUIN: OnceLock<Runner> = OnceLock::new();
    let mannequin = MANNEQUIN.get_or_init(|| Runner::mannequin().unwrap());
    let course = courses().into_iter().find(|course| course.world.name == world && course.tape.name == "walk");
    let course = course.unwrap_or_else(|| panic!("no walk on {world}"));
    let job = |tape| Job { course: Course { tape, ..course.clone() }, feet: Feet::Placed };
    for row in run(&tapes.into_iter().map(job).collect::<Vec<_>>(), mannequin, || ()).unwrap() {
        assert_no_pop(&format!("{world}, {}", row.tape), &row.measures);
    }
}

#[test]
fn turning_back_once_never_pops() {
    let times = [0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.6, 0.9, 1.2];
    let tapes = [WALK, RUN].into_iter().flat_map(|speed| {
        times.map(|after| {
            let cues = [(0.5, Vec3::NEG_Z * speed), (0.5 + after, Vec3::Z * speed)];
            Tape::of(&format!("back after {after} s at {speed} m/s"), 3.0, &cues)
        })
    });
    assert_none_pops("flat", tapes.collect());
}

#[test]
fn turning_back_again_and_again_never_pops() {
    let tapes = [(0.1, RUN), (0.2, RUN), (0.2, WALK), (0.35, RUN), (0.5, RUN), (0.5, WALK)].map(|(every, speed)| {
        let way = |index: usize| if index.is_multiple_of(2) { Vec3::NEG_Z } else { Vec3::Z } * speed;
        let cues: Vec<_> = (0..(5.0 / every) as usize).map(|index| (0.5 + every * index as f32, way(index))).collect();
        Tape::of(&format!("back every {every} s at {speed} m/s"), 5.5, &cues)
    });
    assert_none_pops("flat", tapes.to_vec());
}

/// Ten seconds of someone who can't decide: other speeds and ways, each for up to a second.
fn restless() -> impl Strategy<Value = Tape> {
    let speed = prop::sample::select(vec![0.0, WALK, RUN, 5.0]);
    prop::collection::vec((0.05f32..1.0, 0u8..8, speed), 20..30).prop_map(|keys| {
        let mut at = 0.5;
        let cues: Vec<_> = keys
            .into_iter()
            .map(|(seconds, eighth, speed)| {
                let way = Quat::from_rotation_y(f32::from(eighth) * FRAC_PI_4) * Vec3::NEG_Z;
                at += seconds * seconds;
                (at, way * speed)
            })
            .collect();
        Tape::of("restless", 10.5, &cues)
    })
}

#[test]
fn whoever_cannot_decide_never_pops() {
    // The same tapes in every run.
    let mut runner = TestRunner::deterministic();
    for world in ["flat", "rubble", "hills"] {
        let mut tape = |number| {
            let tape = restless().new_tree(&mut runner).unwrap().current();
            Tape { name: format!("restless {number}"), ..tape }
        };
        assert_none_pops(world, (0..6).map(&mut tape).collect());
    }
}
