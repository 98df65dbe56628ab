//! `turn_left` and `turn_right`: a quarter turn on the spot in two steps.
//!
//! The root turns by 90° evenly over the clip. That turn isn't in the clip: the game turns the root, however fast, plays the
//! clip in step with it, and planted feet turn back under it. The end is the start again, for longer turns.

use super::super::clip::Clip;
use super::body::{Figure, turn};
use super::curves::ease;
use super::idle;
use super::leg::{Foot, Footing, Sole};
use super::record::{Moment, Timing, record};
use glam::{DQuat, DVec3};

const SECONDS: f64 = 1.0;
const QUARTER: f64 = 90.0;

/// When a foot leaves and lands.
struct Swing {
    leave: f64,
    land: f64,
}

/// The foot of the side turned to steps first. Both stand while a turn begins and ends.
const LEFT: Swing = Swing { leave: 0.04, land: 0.46 };
const RIGHT: Swing = Swing { leave: 0.48, land: 0.90 };

/// Degrees the foot has turned in the world, and its height 0..1 in a step.
fn turned(swing: &Swing, time: f64) -> (f64, f64) {
    let t = ((time - swing.leave) / (swing.land - swing.leave)).clamp(0.0, 1.0);
    (QUARTER * ease(0.0, 1.0, t), (4.0 * t * (1.0 - t)).powi(2))
}

/// The foot standing at `footing` (its left image), turned by `degrees` to its own outside about the root, and lifted.
fn turned_foot(footing: Footing, degrees: f64, lift: f64) -> Foot {
    let about = DQuat::from_rotation_y(degrees.to_radians());
    let pitch = -14.0 * lift;
    let ankle = about * footing.ankle + DVec3::Y * 0.045 * lift;
    Footing { ankle, toe_out: footing.toe_out + degrees, pitch, toes: -0.8 * pitch }.foot(&Sole::left())
}

fn figure(time: f64) -> Figure {
    let root = QUARTER * time;
    let ((left, left_lift), (right, right_lift)) = (turned(&LEFT, time), turned(&RIGHT, time));
    let [left_footing, right_footing] = idle::footings();
    let feet = [
        turned_foot(left_footing, left - root, left_lift),
        turned_foot(right_footing, root - right, right_lift).mirrored(),
    ];
    // The pelvis goes between the feet, over the one that stands.
    let follow = 0.5 * (left + right) - root;
    let weight = left_lift - right_lift;
    let lifted = left_lift + right_lift;
    let stand = idle::figure(0.0);
    Figure {
        hips: stand.hips + DVec3::new(-0.028 * weight, -0.008 - 0.006 * lifted, -0.02),
        pelvis: turn(-0.5 * follow, 1.5, -1.4 * weight) * stand.pelvis,
        thorax: turn(-0.3 * follow, 1.0, 0.8 * weight) * stand.thorax,
        feet,
        knees_out: [7.0 + 0.5 * (left - root), 9.0 + 0.5 * (root - right)],
        ..stand
    }
}

fn clip(name: &'static str, figure: impl Fn(f64) -> Figure) -> Clip {
    record(name, Timing { seconds: SECONDS, rate: 60.0, ground_speed: None }, |time| Moment::from(figure(time)))
}

/// A quarter turn to the left.
#[must_use]
pub fn left() -> Clip {
    clip("turn_left", figure)
}

/// A quarter turn to the right.
#[must_use]
pub fn right() -> Clip {
    clip("turn_right", |time| figure(time).mirrored())
}
