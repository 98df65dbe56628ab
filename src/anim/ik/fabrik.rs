//! Forward and backward reaching: joints are put on the lines between their neighbours, from the end to the root and back.
//!
//! Source: Aristidou and Lasenby, "FABRIK: A fast, iterative solver for the Inverse Kinematics problem", Graphical Models
//! 73(5), 2011, pp. 243–260: Algorithm 1 for the two passes, section 4.3 for limits, here with round cones.

use bevy::math::{Affine3A, Quat, Vec3, ops};

use super::{
    chain::{ChainJoint, Goal, Outcome, Workspace, descend, places},
    search::{Method, search},
};
use crate::math::rotation::{direction_or, from_scaled_axis, shortest_arc};

/// Turns the joints, each within its limit, so that their end comes to the target.
///
/// A target out of reach gives the chain straight toward it, as far as limits allow. The same input gives the same pose.
pub fn solve(joints: &mut [ChainJoint], goal: &Goal, room: &mut Workspace) -> Outcome {
    search(joints, goal, room, Method { sweep, settle: 0 })
}

fn sweep(joints: &mut [ChainJoint], goal: &Goal, room: &mut Workspace) {
    places(joints, goal.effector, &mut room.old_points);
    room.points.copy_from_slice(&room.old_points);
    rest_directions(joints, goal.effector, &mut room.axes);
    backward(joints, goal, room);
    forward(joints, goal.effector, &room.points);
}

/// Where each bone would point were its joint at rest, in chain space.
fn rest_directions(joints: &[ChainJoint], effector: Vec3, axes: &mut [Vec3]) {
    let mut frame = Affine3A::IDENTITY;
    for (index, joint) in joints.iter().enumerate() {
        let bone = joints.get(index + 1).map_or(effector, |next| next.local.translation);
        axes[index] = frame.transform_vector3(joint.rest * (joint.local.scale * bone));
        frame *= joint.local.to_affine();
    }
}

/// From the end to the root: each point on the line from the one after it to where it was, one bone away (Algorithm 1, first stage).
fn backward(joints: &[ChainJoint], goal: &Goal, room: &mut Workspace) {
    let (points, old) = (&mut room.points, &room.old_points);
    points[joints.len()] = goal.target;
    for index in (1..joints.len()).rev() {
        let length = old[index].distance(old[index + 1]);
        points[index] = points[index + 1] + direction_or(points[index] - points[index + 1], Vec3::ZERO) * length;
        let above = points[index] - points[index - 1];
        let was_above = old[index] - old[index - 1];
        let rest = shortest_arc(was_above, above) * room.axes[index];
        let back = into_cone(rest, points[index + 1] - points[index], joints[index].limit.widest());
        points[index - 1] = points[index] - back * above;
    }
}

/// The least turn of `axis` after which `bone` is no more than `widest` radians away from it.
fn into_cone(axis: Vec3, bone: Vec3, widest: f32) -> Quat {
    let across = axis.cross(bone);
    let beyond = ops::atan2(across.length(), axis.dot(bone)) - widest;
    if beyond > 0.0 { from_scaled_axis(direction_or(across, Vec3::ZERO) * beyond) } else { Quat::IDENTITY }
}

/// From the root to the end: each bone toward its place, its joint within its limit (Algorithm 1, second stage).
fn forward(joints: &mut [ChainJoint], effector: Vec3, points: &[Vec3]) {
    for index in 0..joints.len() {
        let (above, rest) = joints.split_at_mut(index);
        let place = descend(above, points[index + 1]);
        let bone = rest.get(1).map_or(effector, |next| next.local.translation);
        rest[0].swing(rest[0].in_parent(bone), place);
    }
}
