//! A character ready to play: model, clips, gaits and legs resolved, every name checked.

use std::{collections::BTreeMap, sync::Arc};

use bevy::{asset::AssetPath, math::Affine3A, prelude::*};

use super::{
    Rig,
    character_file::{CharacterFile, ClipSource, Roles},
    frame,
    humanoid::{Humanoid, HumanoidError, HumanoidRole},
    legs,
    names::{listed, suggestion},
    trunk::trunk,
    tuning::{
        locomotion::Pace,
        ranges::{RangeError, Ranges},
    },
};
use crate::anim::{
    clip::Clip,
    gait::{Contact, Gait},
    leg::Leg,
    skeleton::{JointIndex, Skeleton},
};

/// A character's body, clips and tuning: what a `.character.ron` loads as.
///
/// Model space: metres, +Y up, it faces -Z, the origin on the ground between its feet. Pairs are `[left, right]`.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct CharacterAsset {
    /// The file, with defaults filled in.
    pub file: CharacterFile,
    /// The glTF file to draw: `load::<Gltf>(model)`.
    pub model: AssetPath<'static>,
    /// Skins, meshes and bounds. Its skeleton is [`CharacterAsset::skeleton`].
    pub rig: Arc<Rig>,
    /// The joints.
    pub skeleton: Arc<Skeleton>,
    /// Which joint plays which part.
    pub humanoid: Humanoid,
    /// The joint that carries the body.
    pub hips: JointIndex,
    /// Both legs.
    pub legs: [Leg; 2],
    /// Joints of legs, spine and head, parents first: all that a pose holds in model space before `PoseSystems::Model`.
    pub trunk: Vec<JointIndex>,
    /// Thigh and shin, the mean of both legs, metres.
    pub leg_length: f32,
    clips: Vec<CharacterClip>,
}

/// A clip as this character plays it.
#[derive(Clone, Debug)]
pub struct CharacterClip {
    /// The name that states use.
    pub name: String,
    /// For the character's skeleton; speed and looping are as the character's file says.
    pub clip: Arc<Clip>,
    /// What its feet do.
    pub gait: Gait,
}

/// Why files make no character.
#[derive(thiserror::Error, Clone, Debug, PartialEq)]
pub enum CharacterError {
    /// The parts of the body aren't there.
    #[error("`{model}`: {error}")]
    Humanoid {
        /// The glTF file.
        model: String,
        /// What is missing.
        error: Box<HumanoidError>,
    },
    /// No such clip in a file.
    #[error("`clips[\"{name}\"]` asks for the clip `{clip}` of `{file}`, which doesn't have it{instead}")]
    UnknownClip {
        /// The name it should get.
        name: String,
        /// What was asked for.
        clip: String,
        /// Where.
        file: String,
        /// The nearest name, and all that the file has.
        instead: String,
    },
    /// A state plays a clip that isn't there.
    #[error("`locomotion.states` has `{state}` play the clip `{clip}`, which doesn't exist{instead}")]
    UnknownStateClip {
        /// The state.
        state: String,
        /// The clip.
        clip: String,
        /// The nearest name, and all there are.
        instead: String,
    },
    /// The file lists no states, and none of the standard ones has its clip.
    #[error(
        "no state of `locomotion` has a clip: `{model}` has {clips}; list states, or give clips the names of states"
    )]
    NoState {
        /// The model.
        model: String,
        /// All clips there are.
        clips: String,
    },
    /// A transition names a state that isn't there.
    #[error(transparent)]
    Transition(#[from] RangeError),
    /// A clip moves another body.
    #[error("`clips[\"{name}\"]`: no joint that `{file}` moves has a partner in `{model}`; it moves {joints}")]
    Foreign {
        /// The clip's name here.
        name: String,
        /// Its file.
        file: String,
        /// The character's model.
        model: String,
        /// Joints the clip moves.
        joints: String,
    },
}

impl CharacterAsset {
    /// Puts a character together. `model` is the rig of `file.model`, `others` those of the files its clips name.
    ///
    /// # Errors
    /// When hips or legs aren't found, or a name names nothing.
    pub fn resolve(
        file: CharacterFile,
        path: AssetPath<'static>,
        mut model: Rig,
        others: &BTreeMap<String, Rig>,
    ) -> Result<Self, CharacterError> {
        let spelt_out: Vec<(HumanoidRole, String)> = match &file.roles {
            Roles::Auto => Vec::new(),
            Roles::Explicit(roles) => roles.iter().map(|(role, joint)| (*role, joint.clone())).collect(),
        };
        let body_error = |error| CharacterError::Humanoid { model: file.model.clone(), error: Box::new(error) };
        let humanoid = Humanoid::bind(&model.skeleton, &model.skin_joints(), &spelt_out).map_err(body_error)?;
        let (model_from_root, _) = frame::model_from_root(&model.skeleton, &humanoid);
        model.skeleton.model_from_root = Affine3A::from_scale(Vec3::splat(file.scale)) * model_from_root;
        let mut legs = legs::legs(&model, &humanoid).map_err(body_error)?;
        if let Some(soles) = &file.soles {
            legs::place_soles(&model.skeleton, &mut legs, soles, file.scale);
        }
        let hips = humanoid.get(HumanoidRole::Hips).unwrap_or_default();

        let mut asset = Self {
            trunk: trunk(&model.skeleton, &humanoid, &legs),
            model: path,
            skeleton: Arc::new(model.skeleton.clone()),
            rig: Arc::new(model),
            hips,
            legs,
            leg_length: 0.5 * (legs[0].length() + legs[1].length()),
            clips: Vec::new(),
            humanoid,
            file,
        };
        asset.clips = asset.resolve_clips(others)?;
        asset.complete_states()?;
        Ok(asset)
    }

    /// The clip that states call `name`.
    #[must_use]
    pub fn clip(&self, name: &str) -> Option<&CharacterClip> {
        self.clips.iter().find(|clip| clip.name == name)
    }

    /// All clips, by name.
    #[must_use]
    pub fn clips(&self) -> &[CharacterClip] {
        &self.clips
    }

    /// Place of the clip `name` in [`CharacterAsset::clips`].
    #[must_use]
    pub fn clip_index(&self, name: &str) -> Option<usize> {
        self.clips.iter().position(|clip| clip.name == name)
    }

    /// Angular speed in rad/s of a leg that makes a step by itself: half the largest of the slowest gait; 0 without gaits.
    #[must_use]
    pub fn step_speed(&self) -> f32 {
        let gaits = self.clips.iter().map(|clip| &clip.gait).filter(|gait| gait.speed > 0.0);
        gaits.min_by(|a, b| a.speed.total_cmp(&b.speed)).map_or(0.0, |gait| 0.5 * gait.leg_speed)
    }

    fn resolve_clips(&self, others: &BTreeMap<String, Rig>) -> Result<Vec<CharacterClip>, CharacterError> {
        let mut sources: BTreeMap<&str, ClipSource> =
            self.rig.clips.iter().map(|clip| (clip.name.as_str(), ClipSource::default())).collect();
        sources.extend(self.file.clips.iter().map(|(name, source)| (name.as_str(), source.clone())));
        sources.into_iter().map(|(name, source)| self.resolve_clip(name, &source, others)).collect()
    }

    fn resolve_clip(
        &self,
        name: &str,
        source: &ClipSource,
        others: &BTreeMap<String, Rig>,
    ) -> Result<CharacterClip, CharacterError> {
        let wanted = source.clip.as_deref().unwrap_or(name);
        let other = source.file.as_ref().filter(|file| **file != self.file.model);
        let rig = other.and_then(|file| others.get(file)).unwrap_or(&self.rig);
        let file = other.unwrap_or(&self.file.model);
        let names = || rig.clips.iter().map(|clip| clip.name.as_str());
        let clip = rig.clip(wanted).ok_or_else(|| CharacterError::UnknownClip {
            name: name.to_owned(),
            clip: wanted.to_owned(),
            file: file.clone(),
            instead: format!("{}; clips: {}", suggestion(wanted, names()), listed(names())),
        })?;
        let mut clip = if other.is_some() { self.retarget(name, file, rig, clip)? } else { Clip::clone(clip) };
        clip.speed = source.speed;
        clip.looping = source.looping.unwrap_or(clip.looping);
        if clip.looping {
            clip = clip.without_lead();
        }
        let mut gait = Gait::analyze(&clip, &self.skeleton, &self.legs);
        if let Some((left, right)) = &source.contacts {
            gait.set_contacts([contacts(left), contacts(right)]);
        }
        if let Some(speed) = source.ground_speed.or(clip.ground_speed) {
            gait.set_speed(speed, clip.duration);
        }
        Ok(CharacterClip { name: name.to_owned(), clip: Arc::new(clip), gait })
    }

    /// The clip of another file for this body: joints of the same name, else of the same role.
    fn retarget(&self, name: &str, file: &str, rig: &Rig, clip: &Clip) -> Result<Clip, CharacterError> {
        let own = self.rig.skin_joints();
        let by_name = |joint: &JointIndex| {
            let name = rig.skeleton.name(*joint);
            let skinned = own.iter().copied().find(|&own| self.skeleton.name(own) == name);
            skinned.or_else(|| self.skeleton.find(name)).map(|own| (*joint, own))
        };
        let mut pairs: Vec<(JointIndex, JointIndex)> =
            rig.skeleton.joints().filter_map(|joint| by_name(&joint)).collect();
        let mut length = 1.0;
        let mut from = rig.skeleton.clone();
        if let Ok(humanoid) = Humanoid::bind(&rig.skeleton, &rig.skin_joints(), &[]) {
            for (role, joint) in humanoid.iter() {
                if let Some(own) = self.humanoid.get(role) {
                    pairs.retain(|pair| pair.0 != joint && pair.1 != own);
                    pairs.push((joint, own));
                }
            }
            from.model_from_root = frame::model_from_root(&rig.skeleton, &humanoid).0;
            let rig = Rig { skeleton: from.clone(), ..rig.clone() };
            if let Ok(legs) = legs::legs(&rig, &humanoid) {
                length = 2.0 * self.leg_length / (legs[0].length() + legs[1].length());
            }
        }
        let mut moving = clip.moving_joints().peekable();
        if moving.peek().is_some() && !moving.any(|joint| pairs.iter().any(|pair| pair.0 == joint)) {
            return Err(CharacterError::Foreign {
                name: name.to_owned(),
                file: file.to_owned(),
                model: self.file.model.clone(),
                joints: listed(clip.moving_joints().map(|joint| rig.skeleton.name(joint))),
            });
        }
        let movers: Vec<JointIndex> =
            self.skeleton.joints().filter(|&joint| self.skeleton.is_below(self.hips, joint)).collect();
        Ok(clip.retargeted(&from, &self.skeleton, &pairs, &movers, length))
    }

    /// Takes the standard states where the file lists none, and checks the names of those it lists.
    fn complete_states(&mut self) -> Result<(), CharacterError> {
        let names = || self.clips.iter().map(|clip| clip.name.as_str());
        for state in self.file.locomotion.states() {
            if let Some(clip) = state.clips().find(|clip| self.clip(clip).is_none()) {
                return Err(CharacterError::UnknownStateClip {
                    state: state.name.clone(),
                    clip: clip.to_owned(),
                    instead: format!("{}; clips: {}", suggestion(clip, names()), listed(names())),
                });
            }
        }
        let locomotion = self.file.locomotion.completed(|clip| self.clip(clip).is_some());
        if locomotion.states().is_empty() {
            return Err(CharacterError::NoState { model: self.file.model.clone(), clips: listed(names()) });
        }
        locomotion.check_names(&Ranges::new("locomotion."))?;
        self.file.locomotion = locomotion;
        self.analyze_turns();
        Ok(())
    }

    /// Looks once more at the feet of clips in which the root turns: they stand while they turn back under it.
    fn analyze_turns(&mut self) {
        for state in self.file.locomotion.states() {
            let Pace::Turn { angle } = state.pace else { continue };
            for name in state.clips() {
                let written = self.file.clips.get(name).is_some_and(|source| source.contacts.is_some());
                let Some(turning) = self.clips.iter_mut().find(|clip| clip.name == name && !written) else { continue };
                turning.gait = Gait::analyze_turning(&turning.clip, &self.skeleton, &self.legs, angle);
                let written = self.file.clips.get(name).and_then(|source| source.ground_speed);
                if let Some(speed) = written.or(turning.clip.ground_speed) {
                    turning.gait.set_speed(speed, turning.clip.duration);
                }
            }
        }
    }
}

/// Stances as written: a lift-off before its landing is over the loop's end.
fn contacts(written: &[(f32, f32)]) -> Vec<Contact> {
    let contact = |&(start, end): &(f32, f32)| Contact { start, end: if end > start { end } else { end + 1.0 } };
    written.iter().map(contact).collect()
}
