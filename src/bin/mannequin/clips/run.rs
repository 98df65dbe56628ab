//! `run`: 3.5 m/s, on the midfoot, with flight after each step.
//!
//! Fourier series of the mean of 27 strides at 3.96 m/s draw it (Hamner et al. 2010, subject 2 of the `OpenSim` running
//! models), at this speed's timing. Stance is not theirs: the foot rolls on exact contact points and the leg follows.

use super::body::{Arm, turn};
use super::curves::{Fourier, Spline, wave};
use super::foot_path::{Bump, Stride, toe_curve};
use super::gait::{Gait, SwingAngles, Trunk};
use super::leg::{Sole, rest};
use glam::DVec3;

const PERIOD: f64 = 42.0 / 60.0;
const SPEED: f64 = 3.5;

pub const THIGH: Fourier = Fourier { mean: 10.6, cos: [29.0, -6.4, -2.5, 0.1, -0.3], sin: [-17.1, 7.6, 2.4, 0.3, 0.3] };
pub const SHANK: Fourier =
    Fourier { mean: -40.6, cos: [39.2, 6.9, 2.2, 0.2, 0.0], sin: [9.9, -16.2, -0.2, -0.7, -0.5] };
pub const PELVIS_HEIGHT: Fourier =
    Fourier { mean: 0.0, cos: [0.0, 0.0134, 0.0, 0.0011, 0.0], sin: [0.0, -0.033, 0.0, 0.0009, 0.0] };
pub const OBLIQUITY: Fourier = Fourier { mean: 0.0, cos: [3.1, 0.0, -1.7, 0.0, -0.1], sin: [3.5, 0.0, 0.7, 0.0, 0.7] };
pub const SHOULDER: Fourier =
    Fourier { mean: 0.0, cos: [-12.6, -4.6, -0.3, -0.2, 0.1], sin: [9.1, 4.7, 0.0, -0.4, 0.2] };
pub const ELBOW: Fourier = Fourier { mean: 0.0, cos: [-14.7, 5.8, -0.3, 0.2, 0.0], sin: [13.0, -8.8, 1.3, 0.5, -0.1] };

/// Share of the measured bounce that the clip has: on slopes the ground's own rise and fall comes on top.
const BOUNCE: f64 = 0.92;

fn trunk(phase: f64) -> Trunk {
    let hips = DVec3::new(
        wave(phase, 1.0, 0.17, 0.011),
        rest("hips").y - 0.084 + BOUNCE * PELVIS_HEIGHT.at(phase),
        wave(phase, 2.0, 0.30, 0.006),
    );
    let pelvis_turn = wave(phase, 1.0, 0.60, 3.0);
    let pelvis = turn(pelvis_turn, 7.0 + wave(phase, 2.0, 0.38, 2.5), 0.8 * OBLIQUITY.at(phase));
    let thorax_turn = wave(phase, 1.0, 0.45, 11.0);
    let thorax = turn(thorax_turn, 9.5 + wave(phase, 2.0, 0.15, 2.0), wave(phase, 1.0, 0.66, 1.6));
    let head = turn(0.12 * thorax_turn, 2.0 + wave(phase, 2.0, 0.15, 0.6), wave(phase, 1.0, 0.66, 0.3));
    Trunk { hips, pelvis, thorax, head, arms: [arm(phase), arm(phase + 0.5)] }
}

fn arm(phase: f64) -> Arm {
    let swing = 1.3 * SHOULDER.at(phase);
    Arm {
        flex: swing - 16.0,
        abduct: 14.0 - 0.12 * swing,
        inward: 12.0 + 0.25 * swing,
        elbow: 86.0 + 0.85 * ELBOW.at(phase),
        pronate: 8.0,
        wrist: 4.0 + 0.15 * swing,
        curl: 0.72,
        shrug: 1.0,
        protract: 0.18 * swing,
    }
}

/// The left foot's stride.
fn stride() -> Stride {
    let pitch = [
        (0.165, 0.0),
        (0.20, -3.5),
        (0.25, -15.0),
        (0.30, -34.0),
        (0.35, -56.0),
        (0.40, -74.0),
        (0.45, -87.0),
        (0.50, -96.0),
        (0.55, -101.0),
        (0.60, -99.0),
        (0.65, -90.0),
        (0.70, -73.0),
        (0.75, -51.0),
        (0.80, -29.0),
        (0.85, -11.0),
        (0.90, 1.0),
        (0.95, 7.0),
        (1.0, 6.0),
        (1.06, 0.0),
    ];
    let pitch = Spline::clamped(&pitch, 0.0, 0.0);
    let tip_off = 0.29;
    let toes = [(0.32, 38.0), (0.355, 36.0), (0.42, 18.0), (0.55, 6.0), (0.8, 6.0), (1.0, 5.0), (1.06, 0.0)];
    Stride {
        period: PERIOD,
        travel: DVec3::Z * SPEED,
        toe_off: 0.355,
        tip_off,
        placement: DVec3::new(0.034, rest("leftFoot").y, 0.253),
        toe_out: 5.0,
        toes: toe_curve(&pitch, tip_off, &toes),
        pitch,
        bends: [0.35, 0.085],
        hold: [0.11, 0.10],
        rise: [0.05, 0.03],
        bumps: vec![Bump::new(0.80, 0.19, 0.03, 0.0)],
        swing: Some(Box::new(
            SwingAngles { thigh: THIGH, shank: SHANK, least_knee: 32.0, toe_off: [0.355; 2], early: 0.03, x: 0.040 }
                .below(trunk),
        )),
        sole: Sole::left(),
    }
}

/// The run.
pub fn gait() -> Gait {
    Gait { name: "run", strides: [stride(), stride()], right_phase: 0.5, rate: 120.0, knees_out: 4.0, trunk }
}
