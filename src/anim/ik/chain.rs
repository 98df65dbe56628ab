//! A chain of joints, each the parent of the next: what IK solvers turn.
//!
//! *Chain space* is the space that the first joint stands in (its parent's). Solvers write rotations only.

use bevy::math::{Affine3A, Mat3, Quat, Vec3, ops};

use super::limits::Limit;
use crate::{
    anim::skeleton::JointTransform,
    math::rotation::{from_scaled_axis, shortest_arc, to_scaled_axis, twist_angle},
};

/// Of two distances the shorter one has no direction when it is this small a part of the longer one.
const NO_DIRECTION: f32 = 1e-4;

/// A joint that a solver turns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChainJoint {
    /// Where it is in its parent's space. Solvers write the rotation.
    pub local: JointTransform,
    /// Its rotation at rest, from which limits count.
    pub rest: Quat,
    /// How far it turns.
    pub limit: Limit,
    /// How readily it turns compared with the others, 0..=1: a wrist at 0.2 leaves the work to shoulder and elbow.
    pub give: f32,
}

impl Default for ChainJoint {
    fn default() -> Self {
        Self { local: JointTransform::IDENTITY, rest: Quat::IDENTITY, limit: Limit::Free, give: 1.0 }
    }
}

/// What a chain's end shall come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// The place, in chain space.
    pub target: Vec3,
    /// The chain's end, in the space of its last joint.
    pub effector: Vec3,
    /// Distance between both that is near enough, in units of chain space.
    pub tolerance: f32,
    /// Most steps from one start.
    pub iterations: u32,
    /// Other starts to try when limits bar the way from the first one.
    pub retries: u32,
}

/// What became of a [`Goal`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Distance left between end and target, in units of chain space. Infinite for input that isn't finite.
    pub missed: f32,
    /// Whether that is within the tolerance.
    pub reached: bool,
    /// Steps made, over all starts.
    pub iterations: u32,
}

/// Room that solvers work in, to be kept between calls: it allocates only for a longer chain than ever before.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    pub(super) start: Vec<Quat>,
    pub(super) best: Vec<Quat>,
    pub(super) before: Vec<Quat>,
    pub(super) points: Vec<Vec3>,
    pub(super) old_points: Vec<Vec3>,
    pub(super) axes: Vec<Vec3>,
    pub(super) frames: Vec<Mat3>,
    pub(super) turns: Vec<Vec3>,
    pub(super) allowed: Vec<Mat3>,
}

impl Workspace {
    /// Room for chains of `joint_count` joints.
    #[must_use]
    pub fn for_joints(joint_count: usize) -> Self {
        let mut room = Self::default();
        room.make_room(joint_count);
        room
    }

    pub(super) fn make_room(&mut self, joint_count: usize) {
        for rotations in [&mut self.start, &mut self.best, &mut self.before] {
            rotations.resize(joint_count, Quat::IDENTITY);
        }
        for points in [&mut self.points, &mut self.old_points, &mut self.axes, &mut self.turns] {
            points.resize(joint_count + 1, Vec3::ZERO);
        }
        for matrices in [&mut self.frames, &mut self.allowed] {
            matrices.resize(joint_count, Mat3::IDENTITY);
        }
    }
}

impl ChainJoint {
    /// A point of the joint's own space, in its parent's.
    #[must_use]
    pub fn in_parent(&self, point: Vec3) -> Vec3 {
        self.local.translation + self.local.rotation * (self.local.scale * point)
    }

    /// A point of its parent's space, in the joint's own. Not finite where a scale is zero.
    #[must_use]
    pub fn in_own(&self, point: Vec3) -> Vec3 {
        self.local.rotation.inverse() * (point - self.local.translation) / self.local.scale
    }

    /// How far it is turned from rest, in its own space.
    #[must_use]
    pub fn turned(&self) -> Quat {
        self.rest.inverse() * self.local.rotation
    }

    /// Radians by which it is beyond its limit.
    #[must_use]
    pub fn excess(&self) -> f32 {
        self.limit.excess(self.turned())
    }

    /// Turns it by `turn` (its parent's space), as far as its limit allows.
    pub fn turn(&mut self, turn: Quat) {
        if self.limit != Limit::Fixed && turn.is_finite() {
            self.local.rotation = (turn * self.local.rotation).normalize();
            self.keep_limit();
        }
    }

    /// Turns it so that what is at `from` comes into line with `to`, as far as its limit allows. Both in its parent's space.
    pub fn swing(&mut self, from: Vec3, to: Vec3) {
        self.swing_part(from, to, 1.0);
    }

    /// Turns it by a part, 0..=1, of what [`swing`](Self::swing) would.
    pub fn swing_part(&mut self, from: Vec3, to: Vec3, part: f32) {
        let (from, to) = (from - self.local.translation, to - self.local.translation);
        let (near, far) = (from.length(), to.length());
        if !(near + far).is_finite() || near.min(far) <= NO_DIRECTION * near.max(far) {
            return;
        }
        match self.limit {
            Limit::Fixed => {}
            Limit::Hinge { axis, .. } => {
                let across = self.rest * axis;
                let (from, to) = (from.reject_from_normalized(across), to.reject_from_normalized(across));
                let flat = NO_DIRECTION * near.max(far);
                if from.length() > flat && to.length() > flat {
                    let angle = ops::atan2(across.dot(from.cross(to)), from.dot(to)) * part;
                    let turned = twist_angle(self.turned(), axis) + angle;
                    self.local.rotation = self.rest * self.limit.clamp(from_scaled_axis(axis * turned));
                }
            }
            Limit::Free | Limit::Cone { .. } => {
                let arc = shortest_arc(from, to);
                self.turn(if part < 1.0 { from_scaled_axis(to_scaled_axis(arc) * part) } else { arc });
            }
        }
    }

    /// Brings it within its limit.
    pub fn keep_limit(&mut self) {
        if !matches!(self.limit, Limit::Free | Limit::Fixed) {
            self.local.rotation = (self.rest * self.limit.clamp(self.turned())).normalize();
        }
    }
}

/// A point of the last joint's space, in chain space.
#[must_use]
pub fn end(joints: &[ChainJoint], effector: Vec3) -> Vec3 {
    joints.iter().rev().fold(effector, |point, joint| joint.in_parent(point))
}

/// A point of chain space, in the space of the joint that `joints` lead to.
#[must_use]
pub fn descend(joints: &[ChainJoint], point: Vec3) -> Vec3 {
    joints.iter().fold(point, |point, joint| joint.in_own(point))
}

/// Where joints and end are, in chain space; one place more than there are joints.
pub fn places(joints: &[ChainJoint], effector: Vec3, places: &mut [Vec3]) {
    let mut frame = Affine3A::IDENTITY;
    for (joint, place) in joints.iter().zip(places.iter_mut()) {
        *place = frame.transform_point3(joint.local.translation);
        frame *= joint.local.to_affine();
    }
    if let Some(last) = places.get_mut(joints.len()) {
        *last = frame.transform_point3(effector);
    }
}

/// Length of the stretched chain, in units of chain space.
#[must_use]
pub fn length(places: &[Vec3]) -> f32 {
    places.windows(2).map(|bone| bone[0].distance(bone[1])).sum()
}

/// Turns each bone toward the target in turn, from the first to the last: straight, as far as limits allow.
pub fn straighten(joints: &mut [ChainJoint], goal: &Goal) {
    let mut target = goal.target;
    for index in 0..joints.len() {
        let bone = joints.get(index + 1).map_or(goal.effector, |next| next.local.translation);
        let joint = &mut joints[index];
        joint.swing(joint.in_parent(bone), target);
        target = joint.in_own(target);
    }
}

/// A point of model space in the chain space of what `model_from_chain` places; `None` where that squashes space flat.
#[must_use]
pub fn into_chain(model_from_chain: &Affine3A, point_model: Vec3) -> Option<Vec3> {
    let point = model_from_chain.inverse().transform_point3(point_model);
    point.is_finite().then_some(point)
}

#[cfg(test)]
pub(crate) mod samples {
    //! Chains, limits and spaces at random.

    use super::*;
    use proptest::prelude::*;

    pub(crate) fn direction() -> impl Strategy<Value = Vec3> {
        (-1.0f32..1.0, 0.0f32..core::f32::consts::TAU).prop_map(|(height, turn)| {
            let (sin, cos) = ops::sin_cos(turn);
            (Vec3::new(cos, 0.0, sin) * (1.0 - height * height).sqrt()).with_y(height).normalize()
        })
    }

    pub(crate) fn rotation() -> impl Strategy<Value = Quat> {
        (direction(), 0.0f32..3.0).prop_map(|(axis, angle)| from_scaled_axis(axis * angle))
    }

    pub(crate) fn limit() -> impl Strategy<Value = Limit> {
        prop_oneof![
            1 => Just(Limit::Free),
            1 => Just(Limit::Fixed),
            2 => hinge(),
            4 => cone(),
        ]
    }

    fn hinge() -> impl Strategy<Value = Limit> {
        (direction(), -1.5f32..0.0, 0.3f32..2.5).prop_map(|(axis, min, max)| Limit::Hinge { axis, min, max })
    }

    fn cone() -> impl Strategy<Value = Limit> {
        (direction(), 0.3f32..2.0, 0.1f32..1.5).prop_map(|(axis, swing, twist)| Limit::Cone {
            axis,
            swing,
            twist: [-twist, twist],
        })
    }

    /// A joint turned at random within its limit, `length` from the joint above it.
    pub(crate) fn joint(limit: impl Strategy<Value = Limit>) -> impl Strategy<Value = ChainJoint> {
        (direction(), 0.1f32..0.5, rotation(), rotation(), limit).prop_map(|(way, length, rest, turn, limit)| {
            let local = JointTransform { translation: way * length, rotation: rest * turn, scale: Vec3::ONE };
            let mut joint = ChainJoint { local, rest, limit, ..ChainJoint::default() };
            joint.keep_limit();
            joint
        })
    }

    pub(crate) fn chain(limit: impl Strategy<Value = Limit>) -> impl Strategy<Value = Vec<ChainJoint>> {
        proptest::collection::vec(joint(limit), 2..7)
    }

    /// A chain as bodies have them: balls within cones, a hinge, perhaps a joint that holds still.
    pub(crate) fn limb() -> impl Strategy<Value = Vec<ChainJoint>> {
        let ball = || prop_oneof![1 => Just(Limit::Free), 1 => Just(Limit::Fixed), 6 => cone()];
        (chain(ball()), 0usize..7, hinge()).prop_map(|(mut joints, at, hinge)| {
            let at = at % joints.len();
            joints[at].limit = hinge;
            joints[at].keep_limit();
            joints
        })
    }

    /// What may carry a chain: moved, turned, scaled differently along its axes, mirrored.
    pub(crate) fn space() -> impl Strategy<Value = Affine3A> {
        let factor = || prop_oneof![0.3f32..2.0, -2.0f32..-0.3];
        (direction(), rotation(), factor(), factor(), factor()).prop_map(|(place, rotation, x, y, z)| {
            Affine3A::from_scale_rotation_translation(Vec3::new(x, y, z), rotation, place * 3.0)
        })
    }

    /// Another pose of the same chain within its limits.
    pub(crate) fn posed(joints: &[ChainJoint], turns: &[Quat]) -> Vec<ChainJoint> {
        let mut posed = joints.to_vec();
        for (joint, turn) in posed.iter_mut().zip(turns.iter().cycle()) {
            if joint.limit != Limit::Fixed {
                joint.local.rotation = joint.rest * *turn;
                joint.keep_limit();
            }
        }
        posed
    }
}
