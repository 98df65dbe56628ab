//! Damped least squares: one step of all joints together, for the last millimetres, where other solvers become slow.
//!
//! Source: Wampler, "Manipulator inverse kinematic solutions based on vector formulations and damped least-squares
//! methods", IEEE Transactions on Systems, Man, and Cybernetics 16(1), 1986, pp. 93–101: Δθ = Jᵀ (J Jᵀ + μ 1)⁻¹ e.

use bevy::math::{Mat3, Vec3};

use super::{
    chain::{ChainJoint, Goal, Workspace},
    limits::Limit,
};
use crate::math::rotation::{direction_or, from_scaled_axis};

/// Most that one joint turns in one step, radians.
const MOST_TURN: f32 = 0.5;
/// Damping for each unit of distance left and of the chain's reach: large far away, none at the target.
const DAMPING: f32 = 0.02;
/// Times that turns which a limit bars are taken out of a step.
const ROUNDS: u32 = 4;

/// Turns the joints, each within its limit, so that their end comes nearer to the target.
///
/// A joint at its limit turns along it; what it can't do goes to the others. `caution` is a factor on the
/// damping: 1, or more where a step led away.
pub(super) fn step(joints: &mut [ChainJoint], goal: &Goal, room: &mut Workspace, caution: f32) {
    let mut frame = Mat3::IDENTITY;
    for (index, joint) in joints.iter().enumerate() {
        room.frames[index] = frame;
        room.allowed[index] = turns_of(joint);
        frame = frame * Mat3::from_quat(joint.local.rotation) * Mat3::from_diagonal(joint.local.scale);
    }
    let mut end = goal.effector;
    for (joint, arm) in joints.iter().zip(&mut room.points).rev() {
        end = joint.in_parent(end);
        *arm = end - joint.local.translation;
    }
    let error = goal.target - end;
    for _ in 0..ROUNDS {
        push(joints.len(), error, caution, room);
        if !bar(joints, room) {
            break;
        }
    }
    for (joint, turn) in joints.iter_mut().zip(&room.turns) {
        joint.turn(from_scaled_axis(turn.clamp_length_max(MOST_TURN)));
    }
}

/// What a joint can turn about, and how readily, as a projection of rotation vectors in its parent's space.
fn turns_of(joint: &ChainJoint) -> Mat3 {
    let turns = match joint.limit {
        Limit::Fixed => Mat3::ZERO,
        Limit::Hinge { axis, .. } => outer(joint.rest * axis),
        Limit::Free | Limit::Cone { .. } => Mat3::IDENTITY,
    };
    turns * joint.give
}

/// How each joint turns, as a rotation vector in its parent's space: its part of Jᵀ (J Jᵀ + μ 1)⁻¹ e.
fn push(joint_count: usize, error: Vec3, caution: f32, room: &mut Workspace) {
    // A turn ω moves the end by A (ω × r): J = -A [r], Jᵀ y = r × Aᵀ y.
    let mut matrix = Mat3::ZERO;
    for index in 0..joint_count {
        let lever = room.frames[index] * cross(room.points[index]);
        matrix += lever * room.allowed[index] * lever.transpose();
    }
    let reach = (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z).sqrt();
    let damped = matrix + Mat3::from_diagonal(Vec3::splat(caution * DAMPING * error.length() * reach));
    let push = damped.inverse() * error;
    let push = if push.is_finite() { push } else { Vec3::ZERO };
    for index in 0..joint_count {
        let turn = room.points[index].cross(room.frames[index].transpose() * push);
        room.turns[index] = room.allowed[index] * turn;
    }
}

/// Takes turns that lead out of a limit from what is allowed; says whether there were any.
fn bar(joints: &[ChainJoint], room: &mut Workspace) -> bool {
    let mut barred = false;
    for (index, joint) in joints.iter().enumerate() {
        for way_out in joint.limit.ways_out(joint.turned()).into_iter().flatten() {
            let way_out = joint.rest * way_out;
            if room.turns[index].dot(way_out) > 1e-7 {
                let allowed = &mut room.allowed[index];
                *allowed -= outer(direction_or(*allowed * way_out, Vec3::ZERO)) * joint.give;
                barred = true;
            }
        }
    }
    barred
}

fn outer(vector: Vec3) -> Mat3 {
    Mat3::from_cols(vector * vector.x, vector * vector.y, vector * vector.z)
}

/// The matrix of the cross product with `vector` on its left.
fn cross(vector: Vec3) -> Mat3 {
    Mat3::from_cols(vector.cross(Vec3::X), vector.cross(Vec3::Y), vector.cross(Vec3::Z))
}
