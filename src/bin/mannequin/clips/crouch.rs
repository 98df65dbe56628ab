//! `crouch_idle`, `crouch_walk` (1.0 m/s), `crouch_back` (1.1 m/s), `crouch_left` and `crouch_right` (1.2 m/s): hips low,
//! trunk forward, arms ready before the body, the crown below 1.34 m.

use super::super::clip::Clip;
use super::body::{Arm, Figure, turn};
use super::curves::{Spline, wave};
use super::foot_path::{Bump, Stride, toe_curve};
use super::gait::{Gait, Trunk};
use super::idle::breath;
use super::leg::{Footing, Sole, rest};
use super::record::{Moment, Timing, record};
use super::sidle;
use glam::{DQuat, DVec3};

const PERIOD: f64 = 66.0 / 60.0;
const SPEED: f64 = 1.0;
const SECONDS: f64 = 8.0;
/// Metres of the hips below where they are at rest.
const DROP: f64 = 0.335;

fn trunk(phase: f64) -> Trunk {
    let hips = DVec3::new(
        wave(phase, 1.0, 0.30, 0.022),
        rest("hips").y - DROP - wave(phase, 2.0, 0.05, 0.010),
        -0.10 + wave(phase, 2.0, 0.20, 0.006),
    );
    let sway = wave(phase, 1.0, 0.02, 1.0);
    let pelvis = turn(5.5 * sway, 26.0 + wave(phase, 2.0, 0.35, 1.0), wave(phase, 1.0, 0.14, 2.2));
    let thorax = turn(-3.5 * sway, 44.0 + wave(phase, 2.0, 0.12, 1.2), wave(phase, 1.0, 0.66, 1.2));
    let head = turn(-0.5 * sway, 12.0 + wave(phase, 2.0, 0.12, 0.4), 0.0);
    Trunk { hips, pelvis, thorax, head, arms: [arm(wave(phase, 1.0, 0.47, 1.0)), arm(wave(phase, 1.0, 0.97, 1.0))] }
}

/// `swing` −1..1, forward +.
fn arm(swing: f64) -> Arm {
    Arm {
        flex: 27.0 + 9.0 * swing,
        abduct: 21.0 - swing,
        inward: 22.0 + 2.0 * swing,
        elbow: 84.0 + 7.0 * swing,
        pronate: 24.0,
        wrist: 2.0 + 2.0 * swing,
        curl: 0.42,
        shrug: 1.0,
        protract: 5.0 + 2.0 * swing,
    }
}

/// The left foot's stride: softly from the heel, low over the ground.
fn stride() -> Stride {
    let pitch = [
        (0.28, 0.0),
        (0.38, -6.5),
        (0.46, -16.0),
        (0.52, -26.0),
        (0.58, -39.0),
        (0.63, -50.0),
        (0.68, -56.0),
        (0.74, -45.0),
        (0.80, -26.0),
        (0.86, -7.0),
        (0.92, 6.0),
        (0.965, 10.0),
        (1.0, 9.0),
        (1.09, 0.0),
    ];
    let pitch = Spline::clamped(&pitch, 0.0, 0.0);
    let tip_off = 0.57;
    let toes = [(0.60, 36.0), (0.63, 36.0), (0.70, 20.0), (0.80, 8.0), (0.92, 5.0), (1.0, 5.0), (1.09, 0.0)];
    Stride {
        period: PERIOD,
        travel: DVec3::Z * SPEED,
        toe_off: 0.63,
        tip_off,
        placement: DVec3::new(0.078, rest("leftFoot").y, 0.345),
        toe_out: 10.0,
        toes: toe_curve(&pitch, tip_off, &toes),
        pitch,
        bends: [0.2, 0.16],
        hold: [0.13, 0.11],
        rise: [0.06, 0.06],
        bumps: vec![Bump::new(0.80, 0.2, 0.055, 0.0)],
        swing: None,
        sole: Sole::left(),
    }
}

/// The walk in a crouch.
pub fn gait() -> Gait {
    Gait { name: "crouch_walk", strides: [stride(), stride()], right_phase: 0.5, rate: 60.0, knees_out: 9.0, trunk }
}

/// An upright trunk brought down into the crouch.
fn lowered(upright: Trunk) -> Trunk {
    let lean = |degrees: f64| DQuat::from_rotation_x(degrees.to_radians());
    Trunk {
        hips: upright.hips - DVec3::new(0.0, 0.265, 0.10),
        pelvis: lean(21.0) * upright.pelvis,
        thorax: lean(37.0) * upright.thorax,
        head: lean(10.0) * upright.head,
        arms: [arm(0.3), arm(-0.3)],
    }
}

/// Backward in a crouch.
pub fn back() -> Gait {
    Gait { name: "crouch_back", knees_out: 10.0, trunk: |phase| lowered(sidle::back_trunk(phase)), ..sidle::back() }
}

/// Sidestepping to the left in a crouch.
pub fn left() -> Gait {
    Gait { name: "crouch_left", knees_out: 14.0, trunk: |phase| lowered(sidle::side_trunk(phase)), ..sidle::left() }
}

fn figure(time: f64) -> Figure {
    let phase = time / SECONDS;
    let full = breath(time);
    let sway = wave(phase, 1.0, 0.3, 0.006) + wave(phase, 3.0, 0.8, 0.002);
    let ahead = wave(phase, 1.0, 0.05, 0.004) + wave(phase, 2.0, 0.4, 0.003);
    let hips = DVec3::new(sway, rest("hips").y - DROP - 0.02 + 0.003 * full, -0.10 + ahead);
    let arms = [0.0, 1.0].map(|side| {
        let arm = arm(0.55 - 0.9 * side + wave(phase, 1.0, 0.2 + 0.3 * side, 0.12));
        Arm { shrug: arm.shrug + 1.2 * full, curl: 0.42 + 0.04 * side, ..arm }
    });
    let sole = Sole::left();
    let left = Footing::flat(0.125, 0.125, 12.0);
    let right = Footing { pitch: -20.0, toes: 20.0, ..Footing::flat(0.120, -0.135, 18.0) };
    Figure {
        hips,
        pelvis: turn(-7.0, 26.0, 80.0 * sway),
        thorax: turn(-4.0 + wave(phase, 1.0, 0.6, 1.0), 43.0 - 1.2 * full + 60.0 * ahead, -50.0 * sway),
        head: turn(wave(phase, 1.0, 0.55, 4.0) + wave(phase, 2.0, 0.1, 1.5), 11.0, 0.0),
        arms,
        feet: [left.foot(&sole), right.foot(&sole).mirrored()],
        knees_out: [14.0, 16.0],
    }
}

/// Eight seconds of waiting in a crouch.
#[must_use]
pub fn idle() -> Clip {
    let timing = Timing { seconds: SECONDS, rate: 30.0, ground_speed: Some(0.0) };
    record("crouch_idle", timing, |time| Moment { breath: breath(time), ..Moment::from(figure(time)) })
}
