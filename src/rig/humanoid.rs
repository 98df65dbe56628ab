//! Which joint plays which part in a body, told by names or spelt out.

use bevy::{platform::collections::HashMap, reflect::Reflect};
use serde::{Deserialize, Serialize};

use super::names::{JointName, Side, listed, suggestion};
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

/// Who hangs below whom, where both are there.
const CHAINS: [[Role; 2]; 14] = [
    [Role::Hips, Role::LeftUpperLeg],
    [Role::LeftUpperLeg, Role::LeftLowerLeg],
    [Role::LeftLowerLeg, Role::LeftFoot],
    [Role::LeftFoot, Role::LeftToes],
    [Role::Hips, Role::RightUpperLeg],
    [Role::RightUpperLeg, Role::RightLowerLeg],
    [Role::RightLowerLeg, Role::RightFoot],
    [Role::RightFoot, Role::RightToes],
    [Role::LeftUpperArm, Role::LeftLowerArm],
    [Role::LeftLowerArm, Role::LeftHand],
    [Role::RightUpperArm, Role::RightLowerArm],
    [Role::RightLowerArm, Role::RightHand],
    [Role::Hips, Role::Spine],
    [Role::Neck, Role::Head],
];

/// Roles with a side: left, right, and the names tools give them, best first.
///
/// `leg` and `arm` stand for the lower or the upper one, whichever has no name of its own.
const SIDED: [(Role, Role, &[&str]); 8] = [
    (
        Role::LeftLowerLeg,
        Role::RightLowerLeg,
        &["lowerleg", "lowleg", "leglower", "calf", "shin", "shank", "knee", "leg"],
    ),
    (Role::LeftUpperLeg, Role::RightUpperLeg, &["upperleg", "upleg", "legupper", "thigh", "thighbend", "hip", "leg"]),
    (Role::LeftFoot, Role::RightFoot, &["foot", "ankle"]),
    (Role::LeftToes, Role::RightToes, &["toes", "toe", "toebase", "ball", "toe1", ""]),
    (Role::LeftLowerArm, Role::RightLowerArm, &["lowerarm", "lowarm", "armlower", "forearm", "forearmbend", "elbow"]),
    (Role::LeftUpperArm, Role::RightUpperArm, &["upperarm", "uparm", "armupper", "shldrbend", "shldr", "arm"]),
    (Role::LeftShoulder, Role::RightShoulder, &["shoulder", "clavicle", "collar", "collarbone"]),
    (Role::LeftHand, Role::RightHand, &["hand", "wrist"]),
];

/// Why the parts of a body weren't found.
#[derive(thiserror::Error, Clone, Debug, PartialEq)]
pub enum HumanoidError {
    /// Roles without a joint.
    #[error(
        "no joint found for {missing}; found by name: {found}; joints of the skin: {joints}. \
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
    /// Finds the parts among `candidates` (the joints of the skins; all joints where there are none): those in
    /// `spelt_out` as they say, the others by name.
    ///
    /// # Errors
    /// When hips or legs aren't found, a spelt-out joint doesn't exist, or a limb's joints don't hang together.
    pub fn bind(
        skeleton: &Skeleton,
        candidates: &[JointIndex],
        spelt_out: &[(Role, String)],
    ) -> Result<Self, HumanoidError> {
        let all: Vec<JointIndex> = skeleton.joints().collect();
        let candidates = if candidates.is_empty() { &all } else { candidates };
        let mut humanoid = Self::default();
        for (role, name) in spelt_out {
            // A joint of the skin rather than a mesh node of the same name.
            let joint = candidates.iter().copied().find(|&joint| skeleton.name(joint) == name);
            let joint = joint.or_else(|| skeleton.find(name)).ok_or_else(|| HumanoidError::Unknown {
                role: spelling(*role),
                joint: name.clone(),
                suggestion: suggestion(name, skeleton.names().iter().map(String::as_str)),
                joints: listed(skeleton.names().iter().map(String::as_str)),
            })?;
            humanoid.joints.insert(*role, joint);
        }
        let names: Vec<(JointIndex, JointName)> =
            candidates.iter().map(|&joint| (joint, JointName::parse(skeleton.name(joint)))).collect();
        humanoid.bind_limbs(&names);
        humanoid.bind_trunk(skeleton, &names);
        humanoid.check(skeleton, candidates)?;
        Ok(humanoid)
    }

    /// The joint that plays `role`.
    #[must_use]
    pub fn get(&self, role: Role) -> Option<JointIndex> {
        self.joints.get(&role).copied()
    }

    /// All parts found, in the order of the roles.
    pub fn iter(&self) -> impl Iterator<Item = (Role, JointIndex)> {
        let mut list: Vec<_> = self.joints.iter().map(|(role, joint)| (*role, *joint)).collect();
        list.sort();
        list.into_iter()
    }

    fn bind_limbs(&mut self, names: &[(JointIndex, JointName)]) {
        for (left, right, aliases) in SIDED {
            for (role, side) in [(left, Side::Left), (right, Side::Right)] {
                if self.joints.contains_key(&role) {
                    continue;
                }
                let found = aliases.iter().find_map(|alias| {
                    let named = |(_, name): &&(JointIndex, JointName)| name.side == Some(side) && name.key == **alias;
                    let free = |joint: &JointIndex| !self.joints.values().any(|taken| taken == joint);
                    names.iter().filter(named).map(|(joint, _)| *joint).find(free)
                });
                if let Some(joint) = found {
                    self.joints.insert(role, joint);
                }
            }
        }
    }

    /// Hips above the legs, the spine up to the arms, neck and head.
    fn bind_trunk(&mut self, skeleton: &Skeleton, names: &[(JointIndex, JointName)]) {
        let middle = |aliases: &[&str]| {
            let named = |alias: &&str| names.iter().find(|(_, name)| name.side.is_none() && name.key == **alias);
            aliases.iter().find_map(named).map(|(joint, _)| *joint)
        };
        if let (None, Some(left), Some(right)) =
            (self.get(Role::Hips), self.get(Role::LeftUpperLeg), self.get(Role::RightUpperLeg))
        {
            let carries = |hips: &JointIndex| skeleton.is_below(left, *hips) && skeleton.is_below(right, *hips);
            // Some rigs name a joint beside the legs `hips`; what carries both legs counts.
            let hips = middle(&["hips", "hip", "pelvis"]).filter(carries);
            if let Some(hips) = hips.or_else(|| meeting(skeleton, left, right)) {
                self.joints.insert(Role::Hips, hips);
            }
        }
        for (role, aliases) in [(Role::Head, ["head", "head1"]), (Role::Neck, ["neck", "neck1"])] {
            if let (None, Some(joint)) = (self.get(role), middle(&aliases)) {
                self.joints.insert(role, joint);
            }
        }
        let Some(hips) = self.get(Role::Hips) else { return };
        let shoulder = |side: [Role; 2]| side.into_iter().find_map(|role| self.get(role));
        let left = shoulder([Role::LeftShoulder, Role::LeftUpperArm]);
        let right = shoulder([Role::RightShoulder, Role::RightUpperArm]);
        let top = match (left, right) {
            (Some(left), Some(right)) => meeting(skeleton, left, right),
            _ => self.get(Role::Neck).or_else(|| self.get(Role::Head)).and_then(|joint| skeleton.parent(joint)),
        };
        let mut spine = Vec::new();
        let mut walk = top;
        while let Some(joint) = walk.filter(|&joint| joint != hips && skeleton.is_below(joint, hips)) {
            spine.insert(0, joint);
            walk = skeleton.parent(joint);
        }
        let roles: &[(Role, usize)] = match spine.len() {
            0 => &[],
            1 => &[(Role::Spine, 0)],
            2 => &[(Role::Spine, 0), (Role::Chest, 1)],
            3 => &[(Role::Spine, 0), (Role::Chest, 1), (Role::UpperChest, 2)],
            count => &[(Role::Spine, 0), (Role::Chest, count / 2), (Role::UpperChest, count - 1)],
        };
        for &(role, place) in roles {
            self.joints.entry(role).or_insert(spine[place]);
        }
    }

    fn check(&self, skeleton: &Skeleton, candidates: &[JointIndex]) -> Result<(), HumanoidError> {
        let missing: Vec<String> = NEEDED.into_iter().filter(|role| self.get(*role).is_none()).map(spelling).collect();
        if !missing.is_empty() {
            let found: Vec<String> =
                self.iter().map(|(role, joint)| format!("{} = `{}`", spelling(role), skeleton.name(joint))).collect();
            return Err(HumanoidError::Missing {
                missing: missing.join(", "),
                found: if found.is_empty() { "nothing".to_owned() } else { found.join(", ") },
                joints: listed(candidates.iter().map(|&joint| skeleton.name(joint))),
            });
        }
        for [above_role, role] in CHAINS {
            if let (Some(above), Some(joint)) = (self.get(above_role), self.get(role))
                && (joint == above || !skeleton.is_below(joint, above))
            {
                return Err(HumanoidError::Detached {
                    role: spelling(role),
                    joint: skeleton.name(joint).to_owned(),
                    above_role: spelling(above_role),
                    above: skeleton.name(above).to_owned(),
                });
            }
        }
        Ok(())
    }
}

/// The lowest joint above both.
fn meeting(skeleton: &Skeleton, a: JointIndex, b: JointIndex) -> Option<JointIndex> {
    let mut walk = skeleton.parent(a);
    while let Some(joint) = walk.filter(|&joint| !skeleton.is_below(b, joint)) {
        walk = skeleton.parent(joint);
    }
    walk
}

/// The role as RON spells it.
pub(super) fn spelling(role: Role) -> String {
    let name = format!("{role:?}");
    let mut letters = name.chars();
    letters.next().map(|first| first.to_ascii_lowercase()).into_iter().chain(letters).collect()
}
