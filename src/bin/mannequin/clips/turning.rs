//! `turn_left` and `turn_right`: a quarter turn on the spot in three steps.
//!
//! The root turns by `90°·ease(0, 1, t)` with `ease` the minimum-jerk curve 10t³ − 15t⁴ + 6t⁵ over the clip's one second.
//! That turn isn't in the clip: the game (or whoever plays it) turns the root, and planted feet turn back under it.

use super::super::clip::Clip;
use super::body::{Figure, turn};
use super::curves::ease;
use super::idle;
use super::leg::{Foot, Footing, Sole};
use super::record::{Moment, Timing, record};
use glam::{DQuat, DVec3};

const SECONDS: f64 = 1.0;
const QUARTER: f64 = 90.0;

/// A foot's way round: it leaves, it lands, and by how many degrees it has then turned in all.
struct Swing {
    leave: f64,
    land: f64,
    turned: f64,
}

/// Left foot first, then the right, then the left again beside it.
const LEFT: [Swing; 2] =
    [Swing { leave: 0.10, land: 0.38, turned: 58.0 }, Swing { leave: 0.70, land: 0.96, turned: QUARTER }];
const RIGHT: [Swing; 1] = [Swing { leave: 0.38, land: 0.70, turned: QUARTER }];

/// Degrees the foot has turned in the world, and its height 0..1 in a step.
fn turned(swings: &[Swing], time: f64) -> (f64, f64) {
    let mut state = (0.0, 0.0);
    let mut from = 0.0;
    for swing in swings {
        let t = ((time - swing.leave) / (swing.land - swing.leave)).clamp(0.0, 1.0);
        state.0 += (swing.turned - from) * ease(0.0, 1.0, t);
        state.1 += (4.0 * t * (1.0 - t)).powi(3);
        from = swing.turned;
    }
    state
}

/// The foot standing at `footing` (its left image), turned by `degrees` to its own outside about the root, and lifted.
fn turned_foot(footing: Footing, degrees: f64, lift: f64) -> Foot {
    let about = DQuat::from_rotation_y(degrees.to_radians());
    let pitch = -14.0 * lift;
    let ankle = about * footing.ankle + DVec3::Y * 0.045 * lift;
    Footing { ankle, toe_out: footing.toe_out + degrees, pitch, toes: -0.8 * pitch }.foot(&Sole::left())
}

fn figure(time: f64) -> Figure {
    let root = QUARTER * ease(0.0, SECONDS, time);
    let ((left, left_lift), (right, right_lift)) = (turned(&LEFT, time), turned(&RIGHT, time));
    let [left_footing, right_footing] = idle::footings();
    let feet = [
        turned_foot(left_footing, left - root, left_lift),
        turned_foot(right_footing, root - right, right_lift).mirrored(),
    ];
    // Head first, then shoulders; the pelvis follows the feet.
    let away = |from: f64, to: f64| ease(0.0, from, time) * (1.0 - ease(to, SECONDS, time));
    let follow = 0.5 * (left + right) - root;
    let stand = idle::figure(0.0);
    let weight = right_lift - left_lift;
    Figure {
        hips: stand.hips + DVec3::new(0.022 * weight, -0.012 * away(0.3, 0.6) - 0.006 * (left_lift + right_lift), 0.0),
        pelvis: turn(-0.6 * follow, 3.5, 1.4 * weight) * stand.pelvis,
        thorax: turn(-0.25 * follow - 9.0 * away(0.3, 0.35), 2.0 * away(0.3, 0.6), -0.8 * weight) * stand.thorax,
        head: turn(-24.0 * away(0.28, 0.3), 0.0, 0.0) * stand.head,
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
