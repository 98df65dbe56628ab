//! Limits of joints as users give them: in model space, as the character stands in its rest pose.

use bevy::{math::Affine3A, prelude::*};

use crate::{anim::ik::limits::Limit, math::rotation::direction_or, rig::joint_ref::JointRef};

/// How a joint of a chain turns.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub struct ChainJointSetup {
    /// Which one.
    pub joint: JointRef,
    /// How far it turns from its rest pose.
    pub limit: RestLimit,
    /// How readily it turns compared with the others, 0..=1. Default 1. Small: it leaves the work to them. For
    /// [`Solver::Aim`](super::Solver::Aim) it is its share of the turn.
    pub give: f32,
}

impl ChainJointSetup {
    /// A joint within a limit.
    #[must_use]
    pub fn new(joint: impl Into<JointRef>, limit: RestLimit) -> Self {
        Self { joint: joint.into(), limit, give: 1.0 }
    }

    /// The same joint, turning this readily.
    #[must_use]
    pub fn giving(self, give: f32) -> Self {
        Self { give, ..self }
    }
}

/// How far a joint turns from its rest pose; radians.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum RestLimit {
    /// Anywhere.
    Free,
    /// Not at all: it stays as it is animated.
    Fixed,
    /// About one axis.
    Hinge {
        /// The axis in model space at rest: the character's right is +X, up +Y, back +Z.
        axis: Vec3,
        /// Least angle, right-handed about the axis; -π or more.
        min: f32,
        /// Greatest angle; π or less.
        max: f32,
    },
    /// Its bone within a cone about where it is at rest.
    Cone {
        /// Angle between the axis of the cone and its side.
        swing: f32,
        /// Least and greatest turn about the bone itself.
        twist: [f32; 2],
    },
}

impl RestLimit {
    /// The limit in the joint's own space. `model_from_joint` places that at rest, scale of the joint itself left out;
    /// `bone` is the direction of its bone there.
    pub(super) fn in_joint(self, model_from_joint: &Affine3A, bone: Vec3) -> Limit {
        match self {
            Self::Free => Limit::Free,
            Self::Fixed => Limit::Fixed,
            Self::Hinge { axis, min, max } => {
                let joint_from_model = model_from_joint.inverse();
                // A mirrored space turns the other way round.
                let sense = joint_from_model.matrix3.determinant().signum();
                let axis = direction_or(joint_from_model.transform_vector3(axis) * sense, Vec3::X);
                Limit::Hinge { axis, min, max: max.max(min) }
            }
            Self::Cone { swing, twist: [least, most] } => {
                Limit::Cone { axis: direction_or(bone, Vec3::Y), swing, twist: [least, most.max(least)] }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::rotation::from_scaled_axis;

    #[test]
    fn a_hinge_turns_the_same_way_in_turned_scaled_and_mirrored_rigs() {
        let axis = Vec3::new(0.3, 0.9, -0.2).normalize();
        let turned = Quat::from_rotation_x(0.7) * Quat::from_rotation_z(-1.9);
        for scale in [Vec3::ONE, Vec3::splat(0.01), Vec3::new(-1.0, 1.0, 1.0), Vec3::new(2.0, -2.0, 2.0)] {
            let model_from_joint = Affine3A::from_scale_rotation_translation(scale, turned, Vec3::Y);
            let limit = RestLimit::Hinge { axis, min: 0.0, max: 2.0 }.in_joint(&model_from_joint, Vec3::X);
            let Limit::Hinge { axis: own, .. } = limit else { panic!("{limit:?} is no hinge") };
            let bone = Vec3::new(0.2, 0.5, 0.4);
            let by_joint = model_from_joint.transform_vector3(from_scaled_axis(own * 0.8) * bone);
            let by_model = from_scaled_axis(axis * 0.8) * model_from_joint.transform_vector3(bone);
            let off = by_joint.distance(by_model) / by_model.length();
            assert!(off < 1e-4, "scaled by {scale}, the bone comes to {by_joint} instead of {by_model}");
        }
    }
}
