//! `sprint`: 6 m/s, on the forefoot, knees high and trunk forward.
//!
//! The run's curves with thigh and shank swung wider, as they are at this speed.

use super::body::{Arm, turn};
use super::curves::{Spline, wave};
use super::foot_path::{Bump, Stride, toe_curve};
use super::gait::{Gait, SwingAngles, Trunk};
use super::leg::{Sole, rest};
use super::run::{ELBOW, OBLIQUITY, PELVIS_HEIGHT, SHANK, SHOULDER, THIGH};
use glam::DVec3;

const PERIOD: f64 = 35.0 / 60.0;
const SPEED: f64 = 6.0;
const TOE_OFF: f64 = 0.24;

fn trunk(phase: f64) -> Trunk {
    // Everything that follows the steps comes earlier than in the run, as stance is shorter.
    let early = phase + 0.05;
    let hips = DVec3::new(
        wave(phase, 1.0, 0.12, 0.008),
        rest("hips").y - 0.068 + 0.72 * PELVIS_HEIGHT.at(early),
        0.01 + wave(phase, 2.0, 0.30, 0.005),
    );
    let pelvis = turn(wave(phase, 1.0, 0.72, 8.0), 12.0 + wave(phase, 2.0, 0.33, 2.5), 0.7 * OBLIQUITY.at(early));
    let thorax_turn = wave(phase, 1.0, 0.40, 13.0);
    let thorax = turn(thorax_turn, 15.0 + wave(phase, 2.0, 0.10, 1.8), wave(phase, 1.0, 0.60, 1.5));
    let head = turn(0.1 * thorax_turn, 5.0, wave(phase, 1.0, 0.60, 0.3));
    Trunk { hips, pelvis, thorax, head, arms: [arm(early), arm(early + 0.5)] }
}

fn arm(phase: f64) -> Arm {
    let swing = 2.3 * SHOULDER.at(phase);
    Arm {
        flex: swing - 8.0,
        abduct: 15.0 - 0.10 * swing,
        inward: 10.0 + 0.22 * swing,
        elbow: 88.0 + 0.9 * ELBOW.at(phase),
        pronate: 0.0,
        wrist: 2.0,
        curl: 0.45,
        shrug: 2.0,
        protract: 0.16 * swing,
    }
}

/// The left foot's stride.
fn stride() -> Stride {
    let pitch = [
        (0.06, -4.0),
        (0.10, -7.0),
        (0.15, -19.0),
        (0.20, -37.0),
        (0.24, -55.0),
        (0.30, -77.0),
        (0.36, -95.0),
        (0.42, -108.0),
        (0.48, -114.0),
        (0.54, -113.0),
        (0.60, -103.0),
        (0.66, -84.0),
        (0.72, -59.0),
        (0.78, -36.0),
        (0.84, -19.0),
        (0.90, -11.0),
        (0.95, -9.0),
        (1.0, -7.5),
        (1.06, -4.0),
    ];
    let pitch = Spline::clamped(&pitch, 0.0, 0.0);
    let tip_off = 0.19;
    let toes = [(0.22, 39.0), (TOE_OFF, 38.0), (0.32, 18.0), (0.45, 5.0), (0.7, 8.0), (0.92, 12.0)];
    let angles = SwingAngles {
        thigh: THIGH.about(17.0, 1.22),
        shank: SHANK.about(-46.0, 1.12),
        least_knee: 34.0,
        toe_off: [TOE_OFF, 0.355],
        early: 0.075,
        x: 0.036,
    };
    Stride {
        period: PERIOD,
        travel: DVec3::Z * SPEED,
        toe_off: TOE_OFF,
        tip_off,
        placement: DVec3::new(0.028, rest("leftFoot").y, 0.258),
        toe_out: 4.0,
        toes: toe_curve(&pitch, tip_off, &toes),
        pitch,
        bends: [0.13, 0.08],
        hold: [0.06, 0.08],
        rise: [0.05, 0.03],
        bumps: vec![
            Bump::new(0.78, 0.2, 0.02, 0.0),
            Bump::new(0.93, 0.08, 0.005, -0.022),
            Bump::new(0.32, 0.07, 0.01, 0.015),
        ],
        swing: Some(Box::new(angles.below(trunk))),
        sole: Sole::left(),
    }
}

/// The sprint.
pub fn gait() -> Gait {
    Gait { name: "sprint", strides: [stride(), stride()], right_phase: 0.5, rate: 120.0, knees_out: 3.0, trunk }
}
