//! A leg: its joints, lengths, and the points of the sole that meet the ground.
//!
//! Legs come in pairs, `[left, right]`.

use bevy::math::Vec3;

use super::{pose::Pose, skeleton::JointIndex};

/// Index of the left leg, foot or side in a pair.
pub const LEFT: usize = 0;
/// Index of the right leg, foot or side in a pair.
pub const RIGHT: usize = 1;

/// A point of the sole, fixed to a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolePoint {
    /// The foot, or the toes where there are any.
    pub joint: JointIndex,
    /// Where it is in the joint's space.
    pub offset: Vec3,
}

impl SolePoint {
    /// The point that stands at `position` (model space) in `pose`.
    #[must_use]
    pub fn at(pose: &Pose, joint: JointIndex, position: Vec3) -> Self {
        let offset = pose.model(joint).inverse().transform_point3(position);
        Self { joint, offset: if offset.is_finite() { offset } else { Vec3::ZERO } }
    }

    /// Where it is in model space.
    #[must_use]
    #[inline]
    pub fn position(&self, pose: &Pose) -> Vec3 {
        pose.place(self.joint, self.offset)
    }
}

/// One leg. Lengths in metres of model space, at rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Leg {
    /// Thigh's joint, at the hip.
    pub upper: JointIndex,
    /// Shin's joint, at the knee.
    pub lower: JointIndex,
    /// Foot's joint, at the ankle.
    pub foot: JointIndex,
    /// Toes' joint, at the ball, where the rig has one.
    pub toes: Option<JointIndex>,
    /// Hip to knee.
    pub thigh: f32,
    /// Knee to ankle.
    pub shin: f32,
    /// Unit axis in the thigh joint's space; a right-handed turn of the shin about it bends the knee.
    pub knee_axis: Vec3,
    /// Rearmost point of the sole, on the foot.
    pub heel: SolePoint,
    /// Under the toe joint: the point that stays where it is while the heel lifts. On the toes if there are any.
    pub ball: SolePoint,
    /// Foremost point of the sole, on the toes if there are any.
    pub tip: SolePoint,
}

impl Leg {
    /// Thigh and shin.
    #[must_use]
    pub fn length(&self) -> f32 {
        self.thigh + self.shin
    }

    /// Hip, knee and ankle.
    #[must_use]
    pub fn joints(&self) -> [JointIndex; 3] {
        [self.upper, self.lower, self.foot]
    }

    /// Heel, ball and tip.
    #[must_use]
    pub fn sole(&self) -> [SolePoint; 3] {
        [self.heel, self.ball, self.tip]
    }

    /// Height in metres of the ankle over the sole's lowest point in `pose`, as a rule the rest pose.
    #[must_use]
    pub fn ankle_height(&self, pose: &Pose) -> f32 {
        let sole = self.sole().map(|point| point.position(pose).y).into_iter().fold(f32::INFINITY, f32::min);
        pose.position(self.foot).y - sole
    }
}
