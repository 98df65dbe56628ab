//! A joint of a character that a user names: by its own name, or by the part it plays.

use bevy::reflect::Reflect;
use serde::{Deserialize, Serialize};

use super::{
    character::CharacterAsset,
    humanoid::HumanoidRole,
    names::{listed, suggestion},
};
use crate::anim::skeleton::JointIndex;

/// A joint, as a user names it.
#[derive(Reflect, Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointRef {
    /// By its name in the model.
    Name(String),
    /// By the part it plays, in any humanoid.
    Role(HumanoidRole),
}

/// Why a character has no such joint.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
pub enum JointError {
    /// No joint of that name.
    #[error("no joint is named `{joint}`{suggestion}; joints: {joints}")]
    Unknown {
        /// The name asked for.
        joint: String,
        /// The nearest name, if any.
        suggestion: String,
        /// All joints.
        joints: String,
    },
    /// No joint plays that part.
    #[error("no joint was found for the role {role}; found: {found}")]
    NoRole {
        /// The role asked for.
        role: String,
        /// All roles that have a joint.
        found: String,
    },
}

impl JointRef {
    /// The joint in a character's skeleton.
    ///
    /// # Errors
    /// When the character has no joint of that name or role.
    pub fn find(&self, asset: &CharacterAsset) -> Result<JointIndex, JointError> {
        match self {
            Self::Name(name) => asset.skeleton.find(name).ok_or_else(|| {
                let names = || asset.skeleton.names().iter().map(String::as_str);
                JointError::Unknown {
                    joint: name.clone(),
                    suggestion: suggestion(name, names()),
                    joints: listed(names()),
                }
            }),
            Self::Role(role) => asset.humanoid.get(*role).ok_or_else(|| {
                let found: Vec<String> = asset.humanoid.iter().map(|(role, _)| role.spelling()).collect();
                JointError::NoRole { role: role.spelling(), found: found.join(", ") }
            }),
        }
    }
}

impl From<&str> for JointRef {
    fn from(name: &str) -> Self {
        Self::Name(name.to_owned())
    }
}

impl From<HumanoidRole> for JointRef {
    fn from(role: HumanoidRole) -> Self {
        Self::Role(role)
    }
}
