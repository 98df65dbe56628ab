//! `jump`, `leap`, `fall`, `land_light`, `land_hard`: off the ground and back.
//!
//! The game moves the root: it leaves the ground at once when a jump begins, so the clips start in the push-off. Landings
//! start at touch-down and come to stand on the feet of `idle`, which do not move from then on. How deep the body sinks
//! there is mostly the game's business too, since that depends on the speed of the fall.

use super::super::clip::Clip;
use super::body::Figure;
use super::curves::{ease, wave};
use super::keyed::{Keyed, Reach, Step, Still};
use super::record::{Moment, Timing, record};

const JUMP: f64 = 0.55;
const LEAP: f64 = 0.75;
const FALL: f64 = 1.2;

fn pushing() -> Still {
    let arm = Reach { flex: -34.0, abduct: 14.0, elbow: 28.0, inward: 8.0, curl: 0.5 };
    let [left, right] = Still::STANDING.steps;
    Still {
        drop: 0.075,
        ahead: 0.0,
        pelvis: 12.0,
        thorax: 16.0,
        head: -4.0,
        steps: [Step { pitch: -12.0, toes: 12.0, ..left }, Step { pitch: -12.0, toes: 12.0, ..right }],
        arms: [arm, arm],
        ..Still::STANDING
    }
}

fn stretched() -> Still {
    let arm = Reach { flex: 38.0, abduct: 20.0, elbow: 42.0, inward: 8.0, curl: 0.45 };
    let [left, right] = Still::STANDING.steps;
    Still {
        drop: -0.070,
        ahead: 0.02,
        pelvis: 3.0,
        thorax: 3.0,
        head: -8.0,
        shrug: 3.0,
        steps: [
            Step { z: -0.035, up: 0.005, pitch: -46.0, toes: 24.0, ..left },
            Step { z: -0.055, up: 0.015, pitch: -44.0, toes: 22.0, ..right },
        ],
        arms: [arm, arm],
    }
}

fn rising() -> Still {
    Still {
        drop: -0.035,
        ahead: 0.0,
        pelvis: 8.0,
        thorax: 8.0,
        head: 0.0,
        shrug: 3.0,
        steps: [
            Step { x: 0.095, z: -0.17, up: 0.12, pitch: -48.0, toes: 4.0, out: 8.0 },
            Step { x: 0.100, z: 0.10, up: 0.30, pitch: -20.0, toes: 4.0, out: 9.0 },
        ],
        arms: [
            Reach { flex: 58.0, abduct: 34.0, elbow: 62.0, inward: 4.0, curl: 0.4 },
            Reach { flex: 26.0, abduct: 38.0, elbow: 56.0, inward: 4.0, curl: 0.4 },
        ],
    }
}

fn falling(phase: f64) -> Still {
    let arm = |at: f64| Reach {
        flex: 14.0 + wave(phase, 1.0, at, 9.0),
        abduct: 55.0 + wave(phase, 1.0, at + 0.25, 7.0) + wave(phase, 2.0, at, 2.0),
        elbow: 44.0 + wave(phase, 1.0, at + 0.4, 8.0),
        inward: -8.0,
        curl: 0.26,
    };
    let paddle = wave(phase, 1.0, 0.1, 1.0);
    Still {
        drop: -0.01 + wave(phase, 2.0, 0.3, 0.004),
        ahead: -0.01,
        pelvis: 7.0 + wave(phase, 1.0, 0.6, 1.5),
        thorax: 9.0 + wave(phase, 1.0, 0.35, 2.0),
        head: 12.0,
        shrug: 3.0,
        steps: [
            Step {
                x: 0.125,
                z: -0.17 + 0.05 * paddle,
                up: 0.025 + 0.02 * paddle,
                pitch: -42.0 - 5.0 * paddle,
                toes: 3.0,
                out: 10.0,
            },
            Step {
                x: 0.130,
                z: 0.15 - 0.05 * paddle,
                up: 0.09 - 0.035 * paddle,
                pitch: -16.0 - 4.0 * paddle,
                toes: 3.0,
                out: 12.0,
            },
        ],
        arms: [arm(0.0), arm(0.45)],
    }
}

/// Touching down on the balls of both feet.
fn touching() -> Still {
    let [left, right] = Still::STANDING.steps;
    Still {
        drop: 0.02,
        ahead: -0.005,
        pelvis: 10.0,
        thorax: 13.0,
        head: 10.0,
        shrug: 2.0,
        steps: [Step { pitch: -20.0, toes: 20.0, ..left }, Step { pitch: -16.0, toes: 16.0, ..right }],
        arms: [
            Reach { flex: 14.0, abduct: 46.0, elbow: 40.0, inward: -4.0, curl: 0.3 },
            Reach { flex: 18.0, abduct: 44.0, elbow: 42.0, inward: -4.0, curl: 0.3 },
        ],
    }
}

fn absorbing() -> Still {
    let arm = Reach { flex: 8.0, abduct: 30.0, elbow: 48.0, inward: 10.0, curl: 0.4 };
    Still {
        drop: 0.06,
        ahead: -0.02,
        pelvis: 15.0,
        thorax: 22.0,
        head: 9.0,
        shrug: 0.0,
        arms: [arm, arm],
        ..Still::STANDING
    }
}

fn squatting() -> Still {
    let [left, right] = Still::STANDING.steps;
    Still {
        drop: 0.29,
        ahead: -0.09,
        pelvis: 38.0,
        thorax: 52.0,
        head: 20.0,
        shrug: 1.0,
        steps: [Step { pitch: -13.0, toes: 13.0, ..left }, Step { pitch: -17.0, toes: 17.0, ..right }],
        arms: [
            Reach { flex: 38.0, abduct: 42.0, elbow: 38.0, inward: 12.0, curl: 0.3 },
            Reach { flex: 62.0, abduct: 20.0, elbow: 22.0, inward: 12.0, curl: 0.16 },
        ],
    }
}

fn once(name: &'static str, seconds: f64, at: impl Fn(f64) -> Figure) -> Clip {
    record(name, Timing { seconds, rate: 60.0, ground_speed: None }, |time| Moment::from(at(time)))
}

/// Pushing off and rising, to the pose in which `fall` begins.
#[must_use]
pub fn jump() -> Clip {
    let keys = Keyed::new(&[(0.0, pushing()), (0.12, stretched()), (0.29, rising()), (JUMP, falling(0.0))]);
    once("jump", JUMP, |time| keys.at(time).figure())
}

/// One foot of a leap, on the left or right.
const fn flying(z: f64, up: f64, pitch: f64, toes: f64) -> Step {
    Step { x: 0.075, z, up, pitch, toes, out: 5.0 }
}

/// A leap's arms: one forward as the other goes back, −1..1 for the left.
fn leaping_arms(left: f64) -> [Reach; 2] {
    [left, -left].map(|forward| Reach {
        flex: 8.0 + 46.0 * forward,
        abduct: 24.0,
        elbow: 72.0 + 10.0 * forward,
        inward: 8.0,
        curl: 0.5,
    })
}

/// Off the right foot, left knee first, to land on the left and run on.
#[must_use]
pub fn leap() -> Clip {
    let body = Still { ahead: 0.0, shrug: 2.0, ..Still::STANDING };
    let off = Still {
        drop: -0.015,
        pelvis: 9.0,
        thorax: 11.0,
        head: 2.0,
        steps: [flying(0.17, 0.24, -24.0, 5.0), flying(-0.28, 0.03, -52.0, 12.0)],
        arms: leaping_arms(-0.8),
        ..body
    };
    let rising = Still {
        drop: -0.03,
        pelvis: 9.0,
        thorax: 12.0,
        head: 0.0,
        steps: [flying(0.30, 0.30, -12.0, 4.0), flying(-0.40, 0.20, -72.0, 4.0)],
        arms: leaping_arms(-1.0),
        ..body
    };
    let highest = Still {
        drop: -0.005,
        pelvis: 11.0,
        thorax: 15.0,
        head: 4.0,
        steps: [flying(0.36, 0.22, 2.0, 6.0), flying(-0.36, 0.27, -74.0, 4.0)],
        arms: leaping_arms(-0.7),
        ..body
    };
    let reaching = Still {
        drop: 0.03,
        pelvis: 9.0,
        thorax: 13.0,
        head: 8.0,
        steps: [flying(0.25, 0.02, 3.0, 6.0), flying(-0.24, 0.22, -60.0, 4.0)],
        arms: leaping_arms(-0.15),
        ..body
    };
    let keys = Keyed::new(&[(0.0, off), (0.18, rising), (0.42, highest), (LEAP, reaching)]);
    once("leap", LEAP, |time| keys.at(time).figure())
}

/// In the air.
#[must_use]
pub fn fall() -> Clip {
    let timing = Timing { seconds: FALL, rate: 30.0, ground_speed: Some(0.0) };
    record("fall", timing, |time| Moment::from(falling(time / FALL).figure()))
}

/// Down from a step or a jump.
#[must_use]
pub fn land_light() -> Clip {
    let keys = Keyed::new(&[(0.0, touching()), (0.13, absorbing()), (0.50, Still::STANDING)]);
    once("land_light", 0.5, |time| flattened(keys.at(time), time).figure())
}

/// Down from high.
#[must_use]
pub fn land_hard() -> Clip {
    let held = Still { drop: 0.31, thorax: 49.0, ..squatting() };
    let halfway = Still { steps: Still::STANDING.steps, ..absorbing() };
    let keys =
        Keyed::new(&[(0.0, touching()), (0.19, squatting()), (0.36, held), (0.72, halfway), (1.15, Still::STANDING)]);
    once("land_hard", 1.15, |time| keys.at(time).figure())
}

/// A light landing sets its heels down within a tenth of a second.
fn flattened(still: Still, time: f64) -> Still {
    let left = 1.0 - ease(0.0, 0.1, time);
    let steps = [0, 1].map(|side| {
        let pitch = touching().steps[side].pitch * left;
        Step { pitch, toes: -pitch, ..still.steps[side] }
    });
    Still { steps, ..still }
}
