//! `idle`: standing at ease, breathing, weight drifting from leg to leg over feet that stay where they are.
//!
//! Breathing 15 a minute, sway of a few millimetres below 0.5 Hz, weight shift once each way.

use super::super::clip::Clip;
use super::body::{Arm, Figure, turn};
use super::curves::{ease, wave};
use super::leg::{Footing, Sole, rest};
use super::record::{Moment, Timing, record};
use glam::DVec3;

const SECONDS: f64 = 8.0;
/// Two breaths in a loop.
const BREATH: f64 = 4.0;

/// Where the feet stand, each as its left image.
pub fn footings() -> [Footing; 2] {
    [Footing::flat(0.100, 0.006, 9.0), Footing::flat(0.104, -0.030, 12.0)]
}

/// How full the chest is, 0..1: in, out, a short rest.
pub fn breath(time: f64) -> f64 {
    let t = time.rem_euclid(BREATH);
    ease(0.0, 1.6, t) - ease(1.7, 3.8, t)
}

fn arm(time: f64, side: usize) -> Arm {
    let (phase, full) = (time / SECONDS, breath(time - 0.25));
    let one = side as f64;
    let drift = wave(phase, 1.0, 0.35 + 0.3 * one, 1.0) + wave(phase, 3.0, 0.1 + 0.2 * one, 0.4);
    Arm {
        flex: -5.0 + 3.0 * one + 1.1 * drift,
        abduct: 10.5 + 0.9 * full - 0.4 * drift,
        inward: 14.0 - 3.0 * one + 0.8 * drift,
        elbow: 17.0 + 4.0 * one + 1.2 * drift + 0.8 * full,
        pronate: 24.0 + 4.0 * one,
        wrist: 6.0 - 0.8 * drift,
        curl: 0.34 + 0.03 * one + 0.008 * drift,
        shrug: -3.5 + 1.3 * full,
        protract: 1.0 - 0.7 * full,
    }
}

/// The body at `time`.
pub fn figure(time: f64) -> Figure {
    let phase = time / SECONDS;
    let full = breath(time);
    let ([left, right], sole) = (footings(), Sole::left());
    let shift = ease(0.06, 0.27, phase) - ease(0.55, 0.78, phase);
    let weight = 2.0 * shift - 1.0;
    let sway_side = wave(phase, 2.0, 0.20, 0.0016) + wave(phase, 3.0, 0.71, 0.0011);
    let sway_ahead = wave(phase, 1.0, 0.60, 0.0035) + wave(phase, 2.0, 0.13, 0.0022) + wave(phase, 3.0, 0.37, 0.0012);
    let hips = DVec3::new(
        0.013 * weight + sway_side,
        rest("hips").y - 0.0165 + 0.0006 * full - 0.001 * weight * weight,
        0.016 + sway_ahead,
    );
    let pelvis = turn(2.0 - weight, 2.5 + wave(phase, 1.0, 0.8, 0.3), 1.1 * weight);
    let thorax = turn(
        1.2 + 0.5 * weight + wave(phase, 2.0, 0.45, 0.4),
        0.5 - 1.3 * full + 60.0 * sway_ahead,
        -0.9 * weight + 100.0 * sway_side,
    );
    let head = turn(
        wave(phase, 1.0, 0.55, 2.2) + wave(phase, 3.0, 0.9, 0.5),
        1.0 + wave(phase, 1.0, 0.2, 0.7) - 0.25 * full,
        -0.3 * weight + wave(phase, 2.0, 0.6, 0.3),
    );
    Figure {
        hips,
        pelvis,
        thorax,
        head,
        arms: [arm(time, 0), arm(time, 1)],
        feet: [left.foot(&sole), right.foot(&sole).mirrored()],
        knees_out: [7.0, 9.0],
    }
}

/// Eight seconds of standing.
#[must_use]
pub fn clip() -> Clip {
    let timing = Timing { seconds: SECONDS, rate: 30.0, ground_speed: Some(0.0) };
    record("idle", timing, |time| Moment { joints: figure(time).joints(), breath: breath(time) })
}
