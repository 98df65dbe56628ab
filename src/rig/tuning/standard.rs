//! The standard states and transitions: what a character does whose file lists none.
//!
//! Every state is named after its clip. Speeds in m/s, fades in seconds.

use super::locomotion::{
    Condition::{
        self, AirborneFor, All, Crouched, FacingFree, FacingLocked, FallingFaster, Finished, Grounded, InStateFor,
        Jumped, LandedFaster, SpeedAbove, SpeedBelow, TurnBelow, TurnLeftAbove, TurnRightAbove, Upright,
    },
    Pace, StateConfig, TransitionBlend, TransitionConfig,
};

/// On the spot.
const STILL: &[&str] = &["idle", "turn_left", "turn_right"];
/// Upright and on the way.
const GOING: &[&str] = &["walk", "run", "sprint", "strafe"];
const CROUCHED: &[&str] = &["crouch_idle", "crouch_walk", "crouch_strafe"];
const LANDING: &[&str] = &["land_light", "land_hard"];
const AIRBORNE: &[&str] = &["jump", "fall"];

/// Speeds at which a gait begins, from slower ones.
const WALK: f32 = 0.15;
const RUN: f32 = 2.4;
const SPRINT: f32 = 4.7;
/// Speeds below which it ends.
const STAND: f32 = 0.08;
const RUN_NO_MORE: f32 = 2.0;
const SPRINT_NO_MORE: f32 = 4.3;
/// Speed of a landing from which it is a hard one.
const HARD: f32 = 7.0;

/// Phase from which gaits start: the left foot under the body, the right one about to swing. It is early in those with
/// short stances.
const STROLL: f32 = 0.14;
const DASH: f32 = 0.05;

/// All states.
#[must_use]
pub fn states() -> Vec<StateConfig> {
    let state = |name: &str, pace| StateConfig { name: name.into(), clip: name.into(), blend: Vec::new(), pace };
    let gait = |name: &str, start_phase: f32| state(name, Pace::Gait { start_phase });
    let clock = |name: &str| state(name, Pace::Clock);
    let turn = |name: &str, degrees: f32| state(name, Pace::Turn { angle: degrees.to_radians() });
    let ways = |name: &str, clips: &[&str]| StateConfig {
        clip: String::new(),
        blend: clips.iter().copied().map(String::from).collect(),
        ..gait(name, STROLL)
    };
    vec![
        clock("idle"),
        gait("walk", STROLL),
        gait("run", DASH),
        gait("sprint", DASH),
        ways("strafe", &["walk", "run", "walk_back", "strafe_left", "strafe_right"]),
        clock("crouch_idle"),
        gait("crouch_walk", STROLL),
        ways("crouch_strafe", &["crouch_walk", "crouch_back", "crouch_left", "crouch_right"]),
        clock("jump"),
        clock("fall"),
        clock("land_light"),
        clock("land_hard"),
        turn("turn_left", 90.0),
        turn("turn_right", -90.0),
    ]
}

/// All transitions.
#[must_use]
pub fn transitions() -> Vec<TransitionConfig> {
    groups().into_iter().flat_map(|(_, transitions)| transitions).collect()
}

/// The same in groups, each with what it is about.
#[must_use]
pub fn groups() -> [(&'static str, Vec<TransitionConfig>); 6] {
    [
        ("In the air. What is inertialized plays at once, and what was before it fades as an offset.", in_the_air()),
        (
            "Landings: who is on the way goes on, unless it was a hard one; who stands catches the fall first.",
            landings(),
        ),
        ("Crouching.", crouching()),
        ("Facing one way, going another.", aiming()),
        ("Going.", going()),
        ("On the spot.", standing()),
    ]
}

fn change(from: &[&[&str]], to: &str, when: Condition, fade: f32) -> TransitionConfig {
    let from = from.concat().into_iter().map(String::from).collect();
    TransitionConfig { from, to: to.into(), when, fade, blend: TransitionBlend::CrossFade }
}

fn sudden(from: &[&[&str]], to: &str, when: Condition, fade: f32) -> TransitionConfig {
    TransitionConfig { blend: TransitionBlend::Inertialize, ..change(from, to, when, fade) }
}

fn all<const N: usize>(conditions: [Condition; N]) -> Condition {
    All(conditions.into())
}

fn in_the_air() -> Vec<TransitionConfig> {
    vec![
        TransitionConfig { blend: TransitionBlend::Burst, ..change(&[], "jump", Jumped, 0.25) },
        change(&[STILL, GOING, CROUCHED, LANDING], "fall", AirborneFor(0.12), 0.25),
        change(&[&["jump"]], "fall", FallingFaster(1.0), 0.25),
        change(&[&["jump"]], "fall", Finished, 0.25),
    ]
}

fn landings() -> Vec<TransitionConfig> {
    let on_the_way = |speed| all([Grounded, Upright, SpeedAbove(speed)]);
    vec![
        sudden(&[AIRBORNE], "land_hard", all([Upright, LandedFaster(HARD), SpeedBelow(RUN_NO_MORE)]), 0.08),
        sudden(&[AIRBORNE], "strafe", all([Grounded, Upright, FacingLocked, SpeedAbove(0.5)]), 0.3),
        sudden(&[AIRBORNE], "sprint", on_the_way(SPRINT), 0.3),
        sudden(&[AIRBORNE], "run", on_the_way(RUN_NO_MORE), 0.3),
        sudden(&[AIRBORNE], "walk", on_the_way(0.5), 0.3),
        sudden(&[AIRBORNE], "crouch_strafe", all([Grounded, Crouched, FacingLocked, SpeedAbove(0.5)]), 0.3),
        sudden(&[AIRBORNE], "crouch_walk", all([Grounded, Crouched, SpeedAbove(0.5)]), 0.3),
        sudden(&[AIRBORNE], "crouch_idle", all([Grounded, Crouched]), 0.3),
        sudden(&[AIRBORNE], "land_light", Grounded, 0.2),
        sudden(&[AIRBORNE], "idle", Grounded, 0.3),
    ]
}

fn crouching() -> Vec<TransitionConfig> {
    let upright = |speed| all([Upright, SpeedAbove(speed)]);
    let aiming = || all([Crouched, FacingLocked, SpeedAbove(WALK)]);
    vec![
        change(&[STILL, GOING, LANDING], "crouch_strafe", aiming(), 0.3),
        change(&[STILL, GOING, LANDING], "crouch_walk", all([Crouched, SpeedAbove(WALK)]), 0.3),
        change(&[STILL, GOING, LANDING], "crouch_idle", Crouched, 0.3),
        change(&[&["crouch_idle", "crouch_walk"]], "crouch_strafe", aiming(), 0.25),
        change(&[&["crouch_strafe"]], "crouch_walk", all([Crouched, FacingFree, SpeedAbove(STAND)]), 0.25),
        change(&[&["crouch_idle"]], "crouch_walk", all([Crouched, SpeedAbove(WALK)]), 0.25),
        change(&[&["crouch_walk", "crouch_strafe"]], "crouch_idle", all([Crouched, SpeedBelow(STAND)]), 0.25),
        change(&[CROUCHED], "strafe", all([Upright, FacingLocked, SpeedAbove(WALK)]), 0.3),
        change(&[CROUCHED], "run", upright(RUN), 0.3),
        change(&[CROUCHED], "walk", upright(WALK), 0.3),
        change(&[CROUCHED], "idle", Upright, 0.3),
    ]
}

fn aiming() -> Vec<TransitionConfig> {
    let freed = |speed| all([FacingFree, SpeedAbove(speed)]);
    vec![
        change(&[STILL, LANDING, &["walk", "run", "sprint"]], "strafe", all([FacingLocked, SpeedAbove(WALK)]), 0.25),
        change(&[&["strafe"]], "sprint", freed(SPRINT), 0.25),
        change(&[&["strafe"]], "run", freed(RUN), 0.25),
        change(&[&["strafe"]], "walk", freed(STAND), 0.25),
        change(&[&["strafe"]], "idle", SpeedBelow(STAND), 0.25),
    ]
}

fn going() -> Vec<TransitionConfig> {
    // Who means to stop after a landing needs a moment for it.
    let landed = |speed| all([SpeedAbove(speed), InStateFor(0.12)]);
    vec![
        change(&[STILL], "sprint", SpeedAbove(SPRINT), 0.2),
        change(&[STILL], "run", SpeedAbove(RUN), 0.2),
        change(&[STILL], "walk", SpeedAbove(WALK), 0.2),
        change(&[LANDING], "run", landed(RUN), 0.25),
        change(&[LANDING], "walk", landed(WALK), 0.25),
        change(&[&["walk"]], "run", SpeedAbove(RUN), 0.25),
        change(&[&["run"]], "sprint", SpeedAbove(SPRINT), 0.25),
        change(&[&["sprint"]], "run", SpeedBelow(SPRINT_NO_MORE), 0.25),
        change(&[&["run"]], "walk", SpeedBelow(RUN_NO_MORE), 0.25),
        change(&[&["walk"]], "idle", SpeedBelow(STAND), 0.25),
    ]
}

fn standing() -> Vec<TransitionConfig> {
    let turn = |way| all([FacingLocked, SpeedBelow(0.1), way]);
    vec![
        change(&[LANDING], "idle", Finished, 0.25),
        change(&[&["idle", "turn_right"]], "turn_left", turn(TurnLeftAbove(35f32.to_radians())), 0.15),
        change(&[&["idle", "turn_left"]], "turn_right", turn(TurnRightAbove(35f32.to_radians())), 0.15),
        change(&[&["turn_left", "turn_right"]], "idle", TurnBelow(4f32.to_radians()), 0.25),
    ]
}
