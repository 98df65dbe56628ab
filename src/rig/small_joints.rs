//! Joints that are too small to be seen to move from afar, and how they are held there.

use super::humanoid::{Humanoid, HumanoidRole as Role};
use crate::anim::{
    clip::Clip,
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// Parts of a body that end in something small.
const ENDS: [Role; 5] = [Role::LeftHand, Role::RightHand, Role::LeftToes, Role::RightToes, Role::Head];

/// Joints below hands, head and toes, and one pose of them.
#[derive(Clone, Debug, Default)]
pub struct SmallJoints {
    joints: Vec<JointIndex>,
    held: Vec<JointTransform>,
}

impl SmallJoints {
    /// Those of a body, held as they are at the start of `clip`.
    #[must_use]
    pub fn new(skeleton: &Skeleton, humanoid: &Humanoid, clip: Option<&Clip>) -> Self {
        let ends: Vec<JointIndex> = ENDS.into_iter().filter_map(|role| humanoid.get(role)).collect();
        let is_small = |joint: JointIndex| ends.iter().any(|&end| joint != end && skeleton.is_below(joint, end));
        let joints: Vec<JointIndex> = skeleton.joints().filter(|joint| is_small(*joint)).collect();
        let mut pose = skeleton.rest().to_vec();
        if let Some(clip) = clip {
            clip.sample(skeleton, 0.0, &mut pose);
        }
        let held = joints.iter().map(|joint| pose[joint.index()]).collect();
        Self { joints, held }
    }

    /// The joints, parents first.
    #[must_use]
    pub fn joints(&self) -> &[JointIndex] {
        &self.joints
    }

    /// Holds them: `locals` has one transform a joint of the skeleton, each in its parent's space.
    pub fn hold(&self, locals: &mut [JointTransform]) {
        for (joint, held) in self.joints.iter().zip(&self.held) {
            locals[joint.index()] = *held;
        }
    }
}
