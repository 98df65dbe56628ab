//! Cyclic coordinate descent: one joint after the other turns the end toward the target.
//!
//! From the first joint to the last, unlike most: when a shoulder has pointed the arm, an elbow is left with the distance,
//! and bends as elbows do. From the last to the first it is the other way round, and arms lock straight.
//!
//! Source: Wang and Chen, "A combined optimization method for solving the inverse kinematics problem of mechanical
//! manipulators", IEEE Transactions on Robotics and Automation 7(4), 1991, pp. 489–499: coordinate descent, finished by a
//! gradient method where it becomes slow.

use super::{
    chain::{ChainJoint, Goal, Outcome, Workspace},
    search::{Method, search},
};

/// Turns the joints, each within its limit, so that their end comes to the target.
///
/// A target out of reach gives the chain straight toward it, as far as limits allow. The same input gives the same pose.
pub fn solve(joints: &mut [ChainJoint], goal: &Goal, room: &mut Workspace) -> Outcome {
    search(joints, goal, room, Method { sweep, settle: 4 })
}

fn sweep(joints: &mut [ChainJoint], goal: &Goal, room: &mut Workspace) {
    // The end in each joint's own space: what is below a joint has not turned yet when its turn comes.
    let mut end = goal.effector;
    for (joint, place) in joints.iter().zip(&mut room.points).rev() {
        *place = end;
        end = joint.in_parent(end);
    }
    let mut target = goal.target;
    for (joint, place) in joints.iter_mut().zip(&room.points) {
        joint.swing_part(joint.in_parent(*place), target, joint.give);
        target = joint.in_own(target);
    }
}
