//! `walk_back` (1.1 m/s), `strafe_left` and `strafe_right` (1.2 m/s): going one way while facing another.
//!
//! Backward, the ball lands first and the heel leaves last; sideways, the feet close and open and never cross.

use super::body::{Arm, turn};
use super::curves::{Spline, wave};
use super::foot_path::{Bump, Stride, toe_curve};
use super::gait::{Gait, Trunk};
use super::leg::{Sole, rest};
use glam::DVec3;

const BACK_PERIOD: f64 = 64.0 / 60.0;
const BACK_SPEED: f64 = 1.1;
const SIDE_PERIOD: f64 = 35.0 / 60.0;
const SIDE_SPEED: f64 = 1.2;

/// Pelvis, thorax, head and arms going backward.
pub fn back_trunk(phase: f64) -> Trunk {
    let hips = DVec3::new(
        wave(phase, 1.0, 0.30, 0.020),
        rest("hips").y - 0.056 - wave(phase, 2.0, 0.03, 0.010),
        0.005 + wave(phase, 2.0, 0.70, 0.006),
    );
    let sway = wave(phase, 1.0, 0.52, 1.0);
    let pelvis = turn(4.0 * sway, 4.0 + wave(phase, 2.0, 0.4, 0.8), wave(phase, 1.0, 0.13, 2.2));
    let thorax = turn(-2.5 * sway, 6.5 + wave(phase, 2.0, 0.1, 0.8), wave(phase, 1.0, 0.64, 1.1));
    let head = turn(-0.4 * sway, 2.0, 0.0);
    let arms = [wave(phase, 1.0, 0.02, 1.0), wave(phase, 1.0, 0.52, 0.92)].map(easy_arm);
    Trunk { hips, pelvis, thorax, head, arms }
}

/// `swing` −1..1, forward +.
fn easy_arm(swing: f64) -> Arm {
    Arm {
        flex: -2.0 + 8.0 * swing,
        abduct: 11.0 - 0.6 * swing,
        inward: 14.0 + 2.0 * swing,
        elbow: 29.0 + 6.0 * swing,
        pronate: 24.0 - 2.0 * swing,
        wrist: 5.0 - 1.5 * swing,
        curl: 0.36,
        shrug: -2.0,
        protract: 1.5 * swing,
    }
}

fn back_stride() -> Stride {
    let pitch = [
        (0.46, 0.0),
        (0.54, 5.0),
        (0.61, 15.0),
        (0.67, 17.0),
        (0.74, 8.0),
        (0.82, -8.0),
        (0.90, -20.0),
        (0.96, -24.0),
        (1.0, -22.5),
        (1.06, -13.0),
        (1.15, 0.0),
    ];
    let pitch = Spline::clamped(&pitch, 0.0, 0.0);
    let toes = [(0.72, 4.0), (0.86, 13.0), (0.96, 25.5)];
    Stride {
        period: BACK_PERIOD,
        travel: DVec3::NEG_Z * BACK_SPEED,
        toe_off: 0.61,
        tip_off: 0.61,
        placement: DVec3::new(0.060, rest("leftFoot").y, -0.405),
        toe_out: 8.0,
        toes: toe_curve(&pitch, 0.61, &toes),
        pitch,
        bends: [0.2, 0.2],
        hold: [0.13, 0.13],
        rise: [0.06, 0.05],
        bumps: vec![Bump::new(0.80, 0.19, 0.075, 0.0)],
        swing: None,
        sole: Sole::left(),
    }
}

/// Walking backward.
pub fn back() -> Gait {
    let strides = [back_stride(), back_stride()];
    Gait { name: "walk_back", strides, right_phase: 0.5, rate: 60.0, knees_out: 6.0, trunk: back_trunk }
}

/// The same going to the left.
pub fn side_trunk(phase: f64) -> Trunk {
    // To the left: both feet are widest apart at phase 0, when the left one lands, and closest at 0.5.
    let hips = DVec3::new(
        wave(phase, 1.0, 0.42, 0.012),
        rest("hips").y - 0.094 - wave(phase, 1.0, 0.10, 0.014),
        wave(phase, 1.0, 0.3, 0.003),
    );
    let pelvis = turn(-5.0 + wave(phase, 1.0, 0.0, 1.5), 5.0, wave(phase, 1.0, 0.30, 1.8));
    let thorax = turn(-1.0, 7.0 + wave(phase, 1.0, 0.12, 0.8), -1.5 + wave(phase, 1.0, 0.75, 1.2));
    let head = turn(0.0, 2.0, wave(phase, 1.0, 0.75, 0.3));
    let arm = |swing: f64| Arm { abduct: 16.0 + 4.0 * swing, elbow: 42.0 - 3.0 * swing, ..easy_arm(0.5) };
    Trunk { hips, pelvis, thorax, head, arms: [arm(wave(phase, 1.0, 0.12, 1.0)), arm(wave(phase, 1.0, 0.08, 1.0))] }
}

/// One foot; `side` +1 the left one, which leads, −1 the right one in its own mirror image.
fn side_stride(side: f64) -> Stride {
    let apart = 0.5 * (0.115 + SIDE_SPEED * SIDE_PERIOD);
    let outward = if side > 0.0 { apart } else { apart - 0.5 * SIDE_SPEED * SIDE_PERIOD };
    let pitch = [
        (0.40, 0.0),
        (0.48, -7.0),
        (0.56, -20.0),
        (0.64, -24.0),
        (0.76, -13.0),
        (0.88, -5.0),
        (1.0, -3.0),
        (1.08, 0.0),
    ];
    let pitch = Spline::clamped(&pitch, 0.0, 0.0);
    let toes = [(0.62, 25.0), (0.72, 17.0), (0.85, 10.0), (0.93, 6.5)];
    Stride {
        period: SIDE_PERIOD,
        travel: DVec3::X * SIDE_SPEED * side,
        toe_off: 0.56,
        tip_off: 0.56,
        placement: DVec3::new(outward, rest("leftFoot").y, if side > 0.0 { 0.005 } else { -0.015 }),
        toe_out: 7.0,
        toes: toe_curve(&pitch, 0.56, &toes),
        pitch,
        bends: [0.2, 0.2],
        hold: [0.14, 0.13],
        rise: [0.06, 0.05],
        bumps: vec![Bump::new(0.77, 0.22, 0.05, 0.0), Bump::new(0.66, 0.12, 0.012, 0.0)],
        swing: None,
        sole: Sole::left(),
    }
}

/// Sidestepping to the left.
pub fn left() -> Gait {
    let strides = [side_stride(1.0), side_stride(-1.0)];
    Gait { name: "strafe_left", strides, right_phase: 0.5, rate: 120.0, knees_out: 8.0, trunk: side_trunk }
}
