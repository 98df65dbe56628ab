//! The actions of a character, with their clips, masks and references found.

use std::sync::Arc;

use super::{
    character::{CharacterAsset, CharacterClip},
    character_file::CharacterFile,
    humanoid::HumanoidRole,
    joint_ref::{JointError, JointRef},
    names::{listed, suggestion},
    tuning::actions::{ActionConfig, standard},
};
use crate::anim::{
    mask::Mask,
    skeleton::{JointIndex, JointTransform},
};

/// An action as this character plays it.
#[derive(Clone, Debug)]
pub struct CharacterAction {
    /// The name it is played by.
    pub name: String,
    /// Which joints take part.
    pub mask: Arc<Mask>,
    /// The pose that an additive action differs from; `None` for others.
    pub reference: Option<Arc<[JointTransform]>>,
    /// What its file says of it.
    pub config: ActionConfig,
    /// Place of its clip among the character's.
    clip: usize,
}

impl CharacterAction {
    /// Its clip, of the character that it belongs to.
    #[must_use]
    pub fn clip<'a>(&self, asset: &'a CharacterAsset) -> Option<&'a CharacterClip> {
        asset.clips().get(self.clip)
    }
}

/// Why a character has no such action.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
pub enum ActionError {
    /// It plays, or differs from, a clip that isn't there.
    #[error("`actions[\"{action}\"]` asks for the clip `{clip}`, which doesn't exist{instead}")]
    UnknownClip {
        /// The action.
        action: String,
        /// The clip.
        clip: String,
        /// The nearest name, and all there are.
        instead: String,
    },
    /// Its root isn't there.
    #[error("`actions[\"{action}\"].root`: {error}")]
    Root {
        /// The action.
        action: String,
        /// Why not.
        error: JointError,
    },
    /// It names no root, and the body has no spine.
    #[error("`actions[\"{action}\"]` needs a `root`, since no joint of the spine was found")]
    NoSpine {
        /// The action.
        action: String,
    },
    /// Nothing of that name can be played.
    #[error("there is no action `{action}`{instead}")]
    Unknown {
        /// The name asked for.
        action: String,
        /// The nearest name, and all there are.
        instead: String,
    },
}

/// Where an action begins whose file names no root: the first of these that the body has.
const SPINE: [HumanoidRole; 4] =
    [HumanoidRole::Spine, HumanoidRole::Chest, HumanoidRole::UpperChest, HumanoidRole::Neck];

/// Names of clips that the actions of `file`, listed or standard, play or differ from.
pub(super) fn clips_of(file: &CharacterFile) -> Vec<String> {
    let table = file.actions.clone().unwrap_or_else(standard);
    table
        .into_iter()
        .flat_map(|(name, config)| [Some(config.clip.unwrap_or(name)), config.reference])
        .flatten()
        .collect()
}

/// The actions that the file lists, or the standard ones; and each further clip, as an action of its own name.
pub(super) fn resolve(asset: &CharacterAsset) -> Result<Vec<CharacterAction>, ActionError> {
    let mut actions = Vec::new();
    match &asset.file.actions {
        Some(listed) => {
            for (name, config) in listed {
                actions.push(action(asset, name, config)?);
            }
        }
        None => actions.extend(standard().iter().filter_map(|(name, config)| standard_action(asset, name, config))),
    }
    let config = ActionConfig::default();
    let mask = spine(asset).map(|root| Arc::new(Mask::branch(&asset.skeleton, root, config.feather)));
    for (clip, CharacterClip { name, .. }) in asset.clips().iter().enumerate() {
        if let Some(mask) = &mask
            && actions.iter().all(|action| action.name != *name)
        {
            let (name, mask, config) = (name.clone(), Arc::clone(mask), config.clone());
            actions.push(CharacterAction { name, mask, reference: None, config, clip });
        }
    }
    Ok(actions)
}

/// A standard action; of bodies without shoulders the arm alone takes part.
fn standard_action(asset: &CharacterAsset, name: &str, config: &ActionConfig) -> Option<CharacterAction> {
    let arm = ActionConfig { root: Some(JointRef::Role(HumanoidRole::RightUpperArm)), ..config.clone() };
    action(asset, name, config).or_else(|_| action(asset, name, &arm)).ok()
}

fn action(asset: &CharacterAsset, name: &str, config: &ActionConfig) -> Result<CharacterAction, ActionError> {
    let action = || name.to_owned();
    let find = |clip: &str| {
        let names = || asset.clips().iter().map(|clip| clip.name.as_str());
        asset.clip_index(clip).ok_or_else(|| ActionError::UnknownClip {
            action: action(),
            clip: clip.to_owned(),
            instead: format!("{}; clips: {}", suggestion(clip, names()), listed(names())),
        })
    };
    let clip = find(config.clip.as_deref().unwrap_or(name))?;
    let reference = config.reference.as_deref().map_or(Ok(clip), find)?;
    let root = match &config.root {
        Some(root) => root.find(asset).map_err(|error| ActionError::Root { action: action(), error })?,
        None => spine(asset).ok_or_else(|| ActionError::NoSpine { action: action() })?,
    };
    Ok(CharacterAction {
        name: action(),
        mask: Arc::new(Mask::branch(&asset.skeleton, root, config.feather)),
        reference: config.additive.then(|| first_pose(asset, &asset.clips()[reference])),
        config: config.clone(),
        clip,
    })
}

fn spine(asset: &CharacterAsset) -> Option<JointIndex> {
    SPINE.into_iter().find_map(|role| asset.humanoid.get(role))
}

fn first_pose(asset: &CharacterAsset, clip: &CharacterClip) -> Arc<[JointTransform]> {
    let mut pose = asset.skeleton.rest().to_vec();
    clip.clip.sample(&asset.skeleton, 0.0, &mut pose);
    pose.into()
}

impl CharacterAsset {
    /// The action `name`: one that the file lists, or a clip.
    ///
    /// # Errors
    /// When there is none; the error names those there are.
    pub fn action(&self, name: &str) -> Result<&CharacterAction, ActionError> {
        let names = || self.actions().iter().map(|action| action.name.as_str());
        self.actions().iter().find(|action| action.name == name).ok_or_else(|| ActionError::Unknown {
            action: name.to_owned(),
            instead: format!("{}; actions: {}", suggestion(name, names()), listed(names())),
        })
    }
}
