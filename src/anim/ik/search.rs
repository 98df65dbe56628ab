//! What iterative solvers share: straight where the target is out of reach, early ends, a fallback where they become slow,
//! other starts where limits bar the way.

use bevy::math::{Quat, Vec3};

use super::{
    chain::{ChainJoint, Goal, Outcome, Workspace, end, length, places, straighten},
    least_squares,
    limits::Limit,
};
use crate::math::rotation::{any_perpendicular, direction_or, from_scaled_axis};

/// Sweeps in which the target is approached: little by little, so that a small change of it changes the way little.
const APPROACH: u32 = 8;
/// Factors on the caution of least squares after a step that led away, and after one that didn't.
const CAUTION: (f32, f32) = (8.0, 0.25);
/// Share of the distance that has to go in [`PATIENCE`] steps, else a start is given up.
const PROGRESS: f32 = 0.98;
const PATIENCE: u32 = 8;
/// Radians by which each joint of a chain that is stuck in one line is bent.
const BEND: f32 = 0.6;

/// A method of search.
#[derive(Clone, Copy)]
pub(super) struct Method {
    /// Turns all joints once, toward the target.
    pub(super) sweep: fn(&mut [ChainJoint], &Goal, &mut Workspace),
    /// Sweeps at the target itself, before least squares take over.
    pub(super) settle: u32,
}

/// Repeats a method's sweep until the end is at the target. Keeps the pose that came nearest; another start than the pose that came
/// in counts only if it reaches the target.
pub(super) fn search(joints: &mut [ChainJoint], goal: &Goal, room: &mut Workspace, method: Method) -> Outcome {
    room.make_room(joints.len());
    if !is_sound(joints, goal) {
        return Outcome { missed: f32::INFINITY, reached: false, iterations: 0 };
    }
    for joint in joints.iter_mut() {
        joint.keep_limit();
    }
    places(joints, goal.effector, &mut room.points);
    let reach = Reach::of(&room.points, goal.target);
    if reach == Reach::TooFar {
        straighten(joints, goal);
    }
    keep(joints, &mut room.start);
    let mut steps = 0;
    let mut missed = descend(joints, goal, room, method, &mut steps);
    if reach == Reach::Within && missed > goal.tolerance {
        keep(joints, &mut room.best);
        for retry in 0..goal.retries {
            restart(joints, goal, &room.start, retry);
            let left = descend(joints, goal, room, method, &mut steps);
            if left <= goal.tolerance {
                missed = left;
                keep(joints, &mut room.best);
                break;
            }
        }
        restore(joints, &room.best);
    }
    Outcome { missed, reached: missed <= goal.tolerance, iterations: steps }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Reach {
    TooFar,
    TooNear,
    Within,
}

impl Reach {
    fn of(places: &[Vec3], target: Vec3) -> Self {
        let wanted = places[0].distance(target);
        let (most, longest) =
            (length(places), places.windows(2).map(|bone| bone[0].distance(bone[1])).fold(0.0, f32::max));
        if wanted >= most {
            Self::TooFar
        } else if wanted < 2.0 * longest - most {
            Self::TooNear
        } else {
            Self::Within
        }
    }
}

fn is_sound(joints: &[ChainJoint], goal: &Goal) -> bool {
    let sound = |joint: &ChainJoint| {
        let local = &joint.local;
        local.translation.is_finite()
            && local.scale.is_finite()
            && [local.rotation, joint.rest].iter().all(|turn| turn.is_finite() && turn.length_squared() > 0.5)
    };
    !joints.is_empty() && goal.target.is_finite() && goal.effector.is_finite() && joints.iter().all(sound)
}

/// From one start toward the target; returns the distance left.
fn descend(joints: &mut [ChainJoint], goal: &Goal, room: &mut Workspace, method: Method, steps: &mut u32) -> f32 {
    let mut place = end(joints, goal.effector);
    let mut missed = place.distance(goal.target);
    let mut mark = f32::INFINITY;
    let mut caution = 1.0f32;
    for step in 0..goal.iterations {
        if missed <= goal.tolerance {
            break;
        }
        *steps += 1;
        if step < APPROACH + method.settle {
            let share = 1.0 / APPROACH.saturating_sub(step).max(1) as f32;
            (method.sweep)(joints, &Goal { target: place.lerp(goal.target, share), ..*goal }, room);
            place = end(joints, goal.effector);
            missed = place.distance(goal.target);
            continue;
        }
        if step % PATIENCE == 0 {
            if missed > PROGRESS * mark {
                break;
            }
            mark = missed;
        }
        keep(joints, &mut room.before);
        least_squares::step(joints, goal, room, caution);
        let left = end(joints, goal.effector).distance(goal.target);
        if left < missed {
            missed = left;
            caution = (caution * CAUTION.1).max(1.0);
        } else {
            restore(joints, &room.before);
            caution *= CAUTION.0;
        }
    }
    missed
}

/// Another pose to begin with: the given one, bent; then some all over the limits, the same ones every time.
fn restart(joints: &mut [ChainJoint], goal: &Goal, start: &[Quat], retry: u32) {
    restore(joints, start);
    let root = joints[0].local.translation;
    let way = direction_or(goal.target - root, Vec3::NEG_Y);
    for (index, joint) in joints.iter_mut().enumerate() {
        if joint.limit == Limit::Fixed {
            continue;
        }
        if retry == 0 {
            let side = if index % 2 == 0 { BEND } else { -2.0 * BEND };
            let axis = match joint.limit {
                Limit::Hinge { axis, min, max } => joint.rest * axis * (min + max).signum() * side.signum(),
                _ => any_perpendicular(way),
            };
            joint.turn(from_scaled_axis(axis * side));
        } else {
            joint.local.rotation = joint.rest * from_scaled_axis(scatter(retry, index));
            joint.keep_limit();
        }
    }
}

/// A rotation vector for a start and a joint: spread evenly, and always the same.
fn scatter(retry: u32, index: usize) -> Vec3 {
    // Fractions of multiples of powers of the plastic number's inverses fill a cube evenly (Roberts 2018, "R3").
    const STEPS: Vec3 = Vec3::new(0.819_172_5, 0.671_043_6, 0.549_700_5);
    let number = retry as f32 + 7.0 * index as f32;
    let place = STEPS * number;
    (place.fract_gl() - 0.5) * 4.0
}

fn keep(joints: &[ChainJoint], rotations: &mut [Quat]) {
    for (joint, rotation) in joints.iter().zip(rotations) {
        *rotation = joint.local.rotation;
    }
}

fn restore(joints: &mut [ChainJoint], rotations: &[Quat]) {
    for (joint, rotation) in joints.iter_mut().zip(rotations) {
        joint.local.rotation = *rotation;
    }
}
