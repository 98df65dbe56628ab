//! Which joint plays which part in a body. How they are found: [`binding`](super::binding).

use bevy::{platform::collections::HashMap, reflect::Reflect};
use serde::{Deserialize, Serialize};

use crate::anim::skeleton::{JointIndex, Skeleton};

/// A part of a body. Names are those of VRM 1.0.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
#[expect(missing_docs, reason = "each name says it all")]
pub enum HumanoidRole {
    Hips,
    Spine,
    Chest,
    UpperChest,
    Neck,
    Head,
    LeftShoulder,
    LeftUpperArm,
    LeftLowerArm,
    LeftHand,
    LeftUpperLeg,
    LeftLowerLeg,
    LeftFoot,
    LeftToes,
    RightShoulder,
    RightUpperArm,
    RightLowerArm,
    RightHand,
    RightUpperLeg,
    RightLowerLeg,
    RightFoot,
    RightToes,
}

use HumanoidRole as Role;

/// What a walking body can't do without.
const NEEDED: [Role; 7] = [
    Role::Hips,
    Role::LeftUpperLeg,
    Role::LeftLowerLeg,
    Role::LeftFoot,
    Role::RightUpperLeg,
    Role::RightLowerLeg,
    Role::RightFoot,
];

/// Why the parts of a body weren't found.
#[derive(thiserror::Error, Clone, Debug, PartialEq)]
pub enum HumanoidError {
    /// Roles without a joint.
    #[error(
        "no joint found for {missing}; found: {found}; joints: {joints}. \
         Name the missing ones in `roles: Explicit({{leftFoot: \"…\"}})`"
    )]
    Missing {
        /// The roles.
        missing: String,
        /// What was found, as role = joint.
        found: String,
        /// All joints.
        joints: String,
    },
    /// A body on four legs.
    #[error(
        "this is a body on four legs: `{hind}` and `{front}` both carry limbs that reach the ground, and the trunk between \
         them lies. Only bodies on two legs are placed; if it stands on two, name its parts in \
         `roles: Explicit({{hips: \"…\", leftUpperLeg: \"…\", leftLowerLeg: \"…\", leftFoot: \"…\", …}})`"
    )]
    FourLegs {
        /// The joint that carries one pair of legs.
        hind: String,
        /// The joint that carries the other.
        front: String,
    },
    /// A role spelt out names no joint.
    #[error("`roles` gives {role} the joint `{joint}`, which the model doesn't have{suggestion}; joints: {joints}")]
    Unknown {
        /// The role.
        role: String,
        /// The name it was given.
        joint: String,
        /// The nearest name, if any.
        suggestion: String,
        /// All joints.
        joints: String,
    },
    /// A joint that should move with another doesn't.
    #[error("{role} `{joint}` does not hang below {above_role} `{above}`, so the limb can't carry it")]
    Detached {
        /// The role.
        role: String,
        /// Its joint.
        joint: String,
        /// The role that should carry it.
        above_role: String,
        /// That role's joint.
        above: String,
    },
    /// Legs that are no pair.
    #[error(
        "the left leg ({left}) is {left_length:.2} m long and the right one ({right}) {right_length:.2} m: one of their joints \
         is another part's"
    )]
    Uneven {
        /// Joints of the left leg.
        left: String,
        /// Its length, metres.
        left_length: f32,
        /// Joints of the right leg.
        right: String,
        /// Its length, metres.
        right_length: f32,
    },
    /// Two joints of a leg in one place.
    #[error("{role} `{joint}` is where {above_role} `{above}` is: that bone has no length")]
    NoLength {
        /// The role.
        role: String,
        /// Its joint.
        joint: String,
        /// The role above.
        above_role: String,
        /// That role's joint.
        above: String,
    },
}

/// Which joint plays which part. Hips and legs are always there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Humanoid {
    joints: HashMap<Role, JointIndex>,
}

impl Humanoid {
    pub(super) fn new(joints: impl IntoIterator<Item = (Role, JointIndex)>) -> Self {
        Self { joints: joints.into_iter().collect() }
    }

    /// The joint that plays `role`.
    #[must_use]
    pub fn get(&self, role: Role) -> Option<JointIndex> {
        self.joints.get(&role).copied()
    }

    /// Joints of the spine above the hips, lowest first.
    #[must_use]
    pub fn spine(&self, skeleton: &Skeleton) -> Vec<JointIndex> {
        let top = [Role::UpperChest, Role::Chest, Role::Spine].into_iter().find_map(|role| self.get(role));
        let (Some(hips), Some(top)) = (self.get(Role::Hips), top) else { return Vec::new() };
        let mut joints = Vec::new();
        let mut walk = Some(top);
        while let Some(joint) = walk.filter(|&joint| joint != hips) {
            joints.push(joint);
            walk = skeleton.parent(joint);
        }
        joints.reverse();
        joints
    }

    /// All parts found, in the order of the roles.
    pub fn iter(&self) -> impl Iterator<Item = (Role, JointIndex)> {
        let mut list: Vec<_> = self.joints.iter().map(|(role, joint)| (*role, *joint)).collect();
        list.sort();
        list.into_iter()
    }
}

impl HumanoidRole {
    /// All of them, in order.
    pub const ALL: [Self; 22] = [
        Role::Hips,
        Role::Spine,
        Role::Chest,
        Role::UpperChest,
        Role::Neck,
        Role::Head,
        Role::LeftShoulder,
        Role::LeftUpperArm,
        Role::LeftLowerArm,
        Role::LeftHand,
        Role::LeftUpperLeg,
        Role::LeftLowerLeg,
        Role::LeftFoot,
        Role::LeftToes,
        Role::RightShoulder,
        Role::RightUpperArm,
        Role::RightLowerArm,
        Role::RightHand,
        Role::RightUpperLeg,
        Role::RightLowerLeg,
        Role::RightFoot,
        Role::RightToes,
    ];

    /// Whether no body walks without it: hips, thighs, shins and feet.
    #[must_use]
    pub fn is_needed(self) -> bool {
        NEEDED.contains(&self)
    }

    /// The same on the other side; what has no side stays.
    #[must_use]
    pub fn mirrored(self) -> Self {
        // The roles of the left side, then those of the right in the same order.
        let (left, right, place) = (Role::LeftShoulder as usize, Role::RightShoulder as usize, self as usize);
        let other = match place {
            middle if middle < left => middle,
            of_left if of_left < right => of_left + (right - left),
            of_right => of_right - (right - left),
        };
        Self::ALL[other]
    }

    /// As RON spells it: `leftUpperLeg`.
    #[must_use]
    pub fn spelling(self) -> String {
        let name = format!("{self:?}");
        let mut letters = name.chars();
        letters.next().map(|first| first.to_ascii_lowercase()).into_iter().chain(letters).collect()
    }
}
