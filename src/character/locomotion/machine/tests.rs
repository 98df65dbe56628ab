use bevy::math::Vec2;

use core::f32::consts::{FRAC_PI_2, PI};

use super::*;
use crate::rig::character_file::CharacterFile;

const fn once(duration: f32) -> ClipFacts {
    ClipFacts { duration, looping: false, stride: 0.0, heading: 0.0 }
}

const fn gait(duration: f32, speed: f32, heading: f32) -> ClipFacts {
    ClipFacts { duration, looping: true, stride: speed * duration, heading }
}

/// Clips as the mannequin has them.
fn facts(clip: &str) -> ClipFacts {
    match clip {
        "walk" => gait(1.08, 1.4, 0.0),
        "run" => gait(0.72, 3.5, 0.0),
        "sprint" => gait(0.58, 6.0, 0.0),
        "crouch_walk" => gait(1.1, 1.0, 0.0),
        "walk_back" => gait(1.07, 1.1, PI),
        "strafe_left" => gait(0.58, 1.2, FRAC_PI_2),
        "strafe_right" => gait(0.58, 1.2, -FRAC_PI_2),
        "jump" => once(0.55),
        "land_light" | "wave" => once(0.5),
        "land_hard" => once(1.15),
        "turn_left" | "turn_right" => once(1.0),
        _ => gait(6.0, 0.0, 0.0),
    }
}

fn machine() -> Machine {
    Machine::new(&LocomotionConfig::default().completed(|_| true), facts)
}

/// What stays so while a test runs: on the ground, ahead.
fn ahead(speed: f32) -> Facts<'static> {
    Facts { speed, velocity: Vec2::new(0.0, speed), grounded: true, ..Facts::default() }
}

fn state(machine: &Machine) -> &str {
    machine.name(machine.current())
}

fn run_for(machine: &mut Machine, speed: f32, seconds: f32) {
    keep(machine, &ahead(speed), seconds);
}

fn keep(machine: &mut Machine, facts: &Facts<'_>, seconds: f32) {
    for _ in 0..(seconds * 60.0) as usize {
        machine.advance(facts, 1.0 / 60.0);
    }
}

#[test]
fn speed_leads_from_idle_over_walk_to_run_and_back() {
    let mut machine = machine();
    for (speed, name) in [(0.0, "idle"), (1.4, "walk"), (3.5, "run"), (1.4, "walk"), (0.0, "idle")] {
        run_for(&mut machine, speed, 0.5);
        assert_eq!(machine.name(machine.current()), name, "at {speed} m/s");
        assert!(machine.weight(machine.current()) > 0.999, "{name} weighs {}", machine.weight(machine.current()));
    }
}

#[test]
fn a_speed_between_the_bounds_keeps_the_gait() {
    let mut machine = machine();
    run_for(&mut machine, 1.4, 0.5);
    run_for(&mut machine, 2.2, 1.0);
    assert_eq!(machine.name(machine.current()), "walk");
    run_for(&mut machine, 3.0, 0.5);
    run_for(&mut machine, 2.2, 1.0);
    assert_eq!(machine.name(machine.current()), "run");
}

#[test]
fn a_change_of_gait_keeps_the_phase() {
    let mut machine = machine();
    run_for(&mut machine, 1.4, 1.0);
    let before = machine.phase();
    machine.advance(&ahead(3.5), 1.0 / 60.0);
    let moved = (machine.phase() - before).rem_euclid(1.0);
    assert!(moved < 0.04, "the phase jumped by {moved}");
    assert_eq!(machine.name(machine.current()), "run");
}

#[test]
fn one_stride_of_ground_is_one_cycle() {
    let mut machine = machine();
    run_for(&mut machine, 1.4, 1.0);
    assert!((machine.phase_rate() * 1.512 * machine.stride_scale() - 1.4).abs() < 1e-3, "feet skate");
    run_for(&mut machine, 0.5, 1.0);
    let covered = machine.phase_rate() * 1.512 * machine.stride_scale();
    assert!((covered - 0.5).abs() < 1e-3, "feet cover {covered} m/s at 0.5 m/s");
}

#[test]
fn two_half_frames_are_one_whole() {
    let (mut once, mut twice) = (machine(), machine());
    let facts = ahead(1.4);
    for _ in 0..30 {
        once.advance(&facts, 1.0 / 30.0);
        twice.advance(&facts, 1.0 / 60.0);
        twice.advance(&facts, 1.0 / 60.0);
    }
    let off = (once.phase() - twice.phase()).abs();
    assert!(off < 0.02, "phases {off} apart after a second at 30 and 60 Hz");
}

#[test]
fn a_clip_without_length_is_no_danger() {
    let config = LocomotionConfig::default().completed(|_| true);
    let mut machine = Machine::new(&config, |_| ClipFacts { looping: true, ..ClipFacts::default() });
    run_for(&mut machine, 1.4, 0.5);
    assert!(machine.clip_phase(0).is_finite() && machine.phase().is_finite());
}

#[test]
fn triggers_and_finished_clips_lead_on() {
    let text = r#"(locomotion: (
        states: [(name: "idle", clip: "idle"), (name: "greet", clip: "wave")],
        transitions: [
            (from: ["idle"], to: "greet", when: Trigger("hello")),
            (from: ["greet"], to: "idle", when: Finished),
        ],
    ))"#;
    let config = CharacterFile::parse(text).expect("the text is good").locomotion;
    let mut machine = Machine::new(&config, facts);
    let pulled = ["hello".to_owned()];
    machine.advance(&Facts { triggers: &pulled, ..ahead(0.0) }, 1.0 / 60.0);
    assert_eq!(state(&machine), "greet");
    run_for(&mut machine, 0.0, 0.7);
    assert_eq!(state(&machine), "idle");
}

#[test]
fn a_jump_plays_at_once_falls_and_lands_by_how_fast_it_comes_down() {
    for (landing_speed, landing) in [(5.0, "land_light"), (9.0, "land_hard")] {
        let mut machine = machine();
        let air = Facts { fall_speed: -5.0, ..Facts::default() };
        machine.advance(&Facts { jumped: true, ..air }, 1.0 / 60.0);
        assert_eq!(state(&machine), "jump");
        assert!(machine.weight(machine.current()) > 0.999, "a jump waits for no fade");
        keep(&mut machine, &air, 0.3);
        assert_eq!(state(&machine), "jump", "still rising");
        keep(&mut machine, &Facts { fall_speed: 3.0, ..air }, 0.3);
        assert_eq!(state(&machine), "fall");
        let down = Facts { landing_speed, ..ahead(0.0) };
        machine.advance(&down, 1.0 / 60.0);
        assert_eq!(state(&machine), landing, "at {landing_speed} m/s");
        keep(&mut machine, &down, 1.4);
        assert_eq!(state(&machine), "idle");
    }
}

#[test]
fn a_landing_on_the_way_goes_on_in_step() {
    for (speed, name) in [(6.0, "sprint"), (3.5, "run"), (1.4, "walk")] {
        let mut machine = machine();
        keep(&mut machine, &Facts { air_time: 0.5, fall_speed: 4.0, ..Facts::default() }, 0.5);
        assert_eq!(state(&machine), "fall");
        machine.advance(&Facts { landing_speed: 4.0, ..ahead(speed) }, 1.0 / 60.0);
        assert_eq!(state(&machine), name, "lands at {speed} m/s");
    }
}

#[test]
fn a_hop_of_a_few_frames_is_no_fall() {
    let mut machine = machine();
    run_for(&mut machine, 1.4, 0.5);
    keep(&mut machine, &Facts { air_time: 0.1, speed: 1.4, ..Facts::default() }, 0.1);
    assert_eq!(state(&machine), "walk");
}

#[test]
fn crouching_has_its_own_idle_and_walk() {
    let mut machine = machine();
    for (speed, crouched, name) in [
        (0.0, true, "crouch_idle"),
        (1.0, true, "crouch_walk"),
        (1.0, false, "walk"),
        (1.0, true, "crouch_walk"),
        (0.0, true, "crouch_idle"),
        (0.0, false, "idle"),
    ] {
        keep(&mut machine, &Facts { crouched, ..ahead(speed) }, 0.5);
        assert_eq!(state(&machine), name, "at {speed} m/s, crouched: {crouched}");
    }
}

#[test]
fn who_aims_blends_by_the_way_it_goes() {
    let mut machine = machine();
    let aim = |velocity: Vec2| Facts { velocity, facing_locked: true, ..ahead(velocity.length()) };
    for (velocity, clip) in [(Vec2::Y, 0), (Vec2::Y * 3.5, 1), (-Vec2::Y, 2), (-Vec2::X, 3), (Vec2::X, 4)] {
        keep(&mut machine, &aim(velocity), 1.0);
        assert_eq!(state(&machine), "strafe", "going {velocity}");
        let share = machine.share(machine.current(), clip);
        assert!(share > 0.99, "going {velocity} clip {clip} has a share of {share}");
    }
    keep(&mut machine, &ahead(1.4), 0.5);
    assert_eq!(state(&machine), "walk", "aims no more");
}

#[test]
fn a_sidestep_from_left_to_right_moves_shares_without_a_jump() {
    let mut machine = machine();
    let aim = |velocity: Vec2| Facts { velocity, facing_locked: true, ..ahead(velocity.length()) };
    keep(&mut machine, &aim(-Vec2::X), 1.0);
    let mut last = machine.share(machine.current(), 3);
    for _ in 0..60 {
        machine.advance(&aim(Vec2::X), 1.0 / 60.0);
        let share = machine.share(machine.current(), 3);
        assert!((share - last).abs() < 0.12, "a share jumps by {}", (share - last).abs());
        last = share;
    }
    assert!(last < 0.01, "{last} of the left step is left");
}

#[test]
fn a_turn_on_the_spot_plays_as_far_as_the_body_turned() {
    let mut machine = machine();
    let step = 0.05f32;
    let turn = |ahead_of_it: f32| Facts { facing_locked: true, turn_ahead: ahead_of_it, turned: step, ..ahead(0.0) };
    for turns in 1..=20u8 {
        machine.advance(&turn(2.0), 1.0 / 60.0);
        let (phase, wanted) = (machine.clip_phase(machine.current()), step * f32::from(turns) / FRAC_PI_2);
        assert_eq!(state(&machine), "turn_left");
        assert!(
            (phase - wanted).abs() < 1e-4,
            "after {} rad the clip is at {phase}, not {wanted}",
            step * f32::from(turns)
        );
    }
    machine.advance(&turn(-2.0), 1.0 / 60.0);
    assert_eq!(state(&machine), "turn_right");
    machine.advance(&turn(0.01), 1.0 / 60.0);
    assert_eq!(state(&machine), "idle");
}

#[test]
fn a_machine_of_a_changed_file_goes_on_where_the_old_one_was() {
    let mut old = machine();
    run_for(&mut old, 3.5, 1.0);
    let mut new = machine();
    new.take_over(&old);
    assert_eq!(state(&new), "run");
    assert!((new.phase() - old.phase()).abs() < 1e-6 && new.weight(new.current()) > 0.999);
    let mut small = Machine::new(&LocomotionConfig::default().completed(|clip| clip == "idle"), facts);
    small.take_over(&old);
    assert_eq!(state(&small), "idle", "a state that is gone is left");
}
