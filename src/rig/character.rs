//! A character ready to play: model, clips, gaits and legs resolved, every name checked.

use std::{collections::BTreeMap, sync::Arc};

use bevy::{asset::AssetPath, math::Affine3A, prelude::*};

use super::{
    Rig,
    actions::{self, ActionError, CharacterAction},
    binding::{self, Binding},
    blink,
    character_file::{CharacterFile, ClipSource},
    expressions::ExpressionBind,
    humanoid::{Humanoid, HumanoidError, HumanoidRole},
    legs::{self, Body},
    names::{listed, suggestion},
    own_clips::{self, OwnClip},
    retarget::{Source, Target},
    small_joints::SmallJoints,
    species::AllSpecies,
    standard_clips,
    trunk::trunk,
    tuning::{
        foot_ik::TUNED_LEG,
        locomotion::{Pace, StateConfig},
        ranges::{RangeError, Ranges},
    },
};
use crate::anim::{
    block::ClipSet,
    clip::Clip,
    gait::Gait,
    leg::Leg,
    peak::Liveliness,
    pose::Pose,
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
    /// Height at rest, metres.
    pub stature: f32,
    /// Clips of its own that are called as states are in other words.
    pub own_clips: Vec<OwnClip>,
    /// What is odd about how `roles` bind, one sentence each.
    pub notes: Vec<String>,
    /// Morph targets that shut the eyes.
    pub blink_targets: Vec<ExpressionBind>,
    clips: Vec<CharacterClip>,
    /// The same clips as rows, to be blended in one pass; it watches the joints that feet hang on.
    pub rows: Arc<ClipSet>,
    actions: Vec<CharacterAction>,
    /// Joints that are held where [`Detail`](crate::character::detail::Detail) says so.
    pub small_joints: Arc<SmallJoints>,
    pub(super) species: AllSpecies,
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
    /// How lively it is.
    pub lively: Liveliness,
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
    #[error("no state of `locomotion` has a clip: `{model}` has {clips}; list states, or give clips their names")]
    NoState {
        /// The model.
        model: String,
        /// All clips there are.
        clips: String,
    },
    /// A field names a state or a morph target that isn't there.
    #[error(transparent)]
    UnknownName(#[from] RangeError),
    /// An action can't be played.
    #[error(transparent)]
    Action(#[from] ActionError),
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

/// Shares of the leg by which the ground of a file's clips may be off the rest pose's: below it is none, above it is meant.
const OFF_GROUND: (f32, f32) = (0.005, 0.06);

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
        let body_error = |error| CharacterError::Humanoid { model: file.model.clone(), error: Box::new(error) };
        let mut binding = model.bind(&file.roles).map_err(body_error)?;
        if let Some(straight) = model.straightened(&binding.humanoid) {
            model = straight;
            binding = model.bind(&file.roles).map_err(body_error)?;
        }
        let Binding { humanoid, frame, .. } = binding;
        model.skeleton.model_from_root = Affine3A::from_scale(Vec3::splat(file.scale)) * frame.model_from_root;
        let body = Body { skeleton: &model.skeleton, dominated: &model.dominated };
        let mut legs = legs::legs(body, &humanoid).map_err(body_error)?;
        if let Some(soles) = &file.soles {
            legs::place_soles(&model.skeleton, &mut legs, soles, file.scale);
        }

        let mut asset = Self {
            notes: frame.notes.into_iter().filter(|note| !model.notes.contains(note)).collect(),
            trunk: trunk(&model.skeleton, &humanoid, &legs),
            model: path,
            leg_length: 0.5 * (legs[0].length() + legs[1].length()),
            stature: binding::stature(&model, &model.skeleton),
            skeleton: Arc::new(model.skeleton.clone()),
            rig: Arc::new(model),
            hips: humanoid.get(HumanoidRole::Hips).unwrap_or_default(),
            legs,
            own_clips: Vec::new(),
            blink_targets: Vec::new(),
            clips: Vec::new(),
            rows: Arc::default(),
            actions: Vec::new(),
            small_joints: Arc::default(),
            species: AllSpecies::default(),
            humanoid,
            file,
        };
        asset.blink_targets = blink::targets(&asset.file.blink, &asset.rig)?;
        asset.file.fit_motion(asset.stature, asset.leg_length);
        asset.clips = asset.resolve_clips(others)?;
        asset.add_standard_clips();
        asset.complete_states()?;
        asset.actions = actions::resolve(&asset)?;
        asset.make_rows();
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

    /// All actions: those of the file, then the other clips.
    #[must_use]
    pub fn actions(&self) -> &[CharacterAction] {
        &self.actions
    }

    /// Place of the clip `name` in [`CharacterAsset::clips`].
    #[must_use]
    pub fn clip_index(&self, name: &str) -> Option<usize> {
        self.clips.iter().position(|clip| clip.name == name)
    }

    fn target(&self) -> Target<'_> {
        let Self { rig, skeleton, humanoid, legs, file, .. } = self;
        Target { rig, skeleton, humanoid, legs, config: &file.retarget }
    }

    /// Clips that states and actions lack and the mannequin has.
    fn add_standard_clips(&mut self) {
        let locomotion = self.file.locomotion.completed(|_| true);
        let mut missing = actions::clips_of(&self.file);
        missing.extend(locomotion.states().iter().flat_map(StateConfig::clips).map(str::to_owned));
        missing.retain(|name| self.clip(name).is_none());
        if missing.is_empty() || !self.file.standard_clips {
            return;
        }
        let mannequin = standard_clips::mannequin();
        let source = Source::new(mannequin, self.target());
        // Bodies alike but for size move alike in times that go with the root of their lengths (Alexander 1989).
        let pace = source.length().sqrt();
        let fitted = |clip: &Arc<Clip>| {
            let feet = source.gait(clip, self.turn_of(&clip.name));
            let clip = source.clip(clip, self.target())?.stretched(pace);
            let slower = |gait: Gait| Gait { velocity: gait.velocity / pace, ..gait };
            Some(self.finish(&clip.name.clone(), clip, feet.map(slower), &ClipSource::default()))
        };
        let found = mannequin.clips.iter().filter(|clip| missing.contains(&clip.name));
        let clips: Vec<CharacterClip> = found.filter_map(fitted).collect();
        self.clips.extend(clips);
        self.clips.sort_by(|a, b| a.name.cmp(&b.name));
    }

    fn resolve_clips(&mut self, others: &BTreeMap<String, Rig>) -> Result<Vec<CharacterClip>, CharacterError> {
        let mut sources: BTreeMap<&str, ClipSource> =
            self.rig.clips.iter().map(|clip| (clip.name.as_str(), ClipSource::default())).collect();
        sources.extend(self.file.clips.iter().map(|(name, source)| (name.as_str(), source.clone())));
        let mut by_file: BTreeMap<Option<&str>, Vec<CharacterClip>> = BTreeMap::new();
        for (name, source) in &sources {
            let clip = self.resolve_clip(name, source, others)?;
            by_file.entry(source.file.as_deref()).or_default().push(clip);
        }
        by_file.values_mut().for_each(|clips| self.settle(clips));
        let mut clips: Vec<CharacterClip> = by_file.into_values().flatten().collect();
        drop(sources);
        if self.file.own_clips {
            self.own_clips = own_clips::adopt(&mut clips, self.leg_length);
        }
        clips.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(clips)
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
        if other.is_none() {
            return Ok(self.finish(name, Clip::clone(clip), None, source));
        }
        let body = Source::new(rig, self.target());
        let moved = body.clip(clip, self.target()).ok_or_else(|| CharacterError::Foreign {
            name: name.to_owned(),
            file: file.clone(),
            model: self.file.model.clone(),
            joints: listed(clip.moving_joints().map(|joint| rig.skeleton.name(joint))),
        })?;
        Ok(self.finish(name, moved, body.gait(clip, self.turn_of(name)), source))
    }

    /// Radians that the root turns during the clip `name`, where a state turns by it.
    fn turn_of(&self, name: &str) -> f32 {
        let states = self.file.locomotion.completed(|_| true);
        let turning = states.states().iter().filter(|state| state.clips().any(|clip| clip == name));
        turning.filter_map(|state| if let Pace::Turn { angle } = state.pace { Some(angle) } else { None }).sum()
    }

    /// A clip as this character plays it, with what its file says of it; `feet` is what they do in the clip that it was made
    /// from, speeds in metres here.
    fn finish(&self, name: &str, mut clip: Clip, feet: Option<Gait>, told: &ClipSource) -> CharacterClip {
        clip.speed = told.speed;
        clip.looping = told.looping.unwrap_or(clip.looping);
        if clip.looping {
            clip = clip.without_lead();
        }
        let mut gait = Gait::analyze_turning(&clip, &self.skeleton, &self.legs, self.turn_of(name));
        if let Some(feet) = feet {
            gait.set_contacts(feet.contacts_in_clip());
            gait.velocity = feet.velocity;
            gait.set_speed(feet.velocity.length(), clip.duration);
        }
        if let Some(stances) = told.stances() {
            gait.set_contacts(stances);
        }
        if let Some(speed) = told.ground_speed.or(clip.ground_speed) {
            gait.set_speed(speed, clip.duration);
        }
        let lively = Liveliness::of(&clip, &self.skeleton);
        CharacterClip { name: name.to_owned(), clip: Arc::new(clip), gait, lively }
    }

    /// Puts the clips of one file on the ground, where none of them stands on the rest pose's.
    fn settle(&self, clips: &mut [CharacterClip]) {
        let off = |gait: &Gait| {
            let height = gait.sole_height[0].min(gait.sole_height[1]);
            let stands = gait.contact.iter().all(|contacts| !contacts.is_empty());
            stands.then_some((height, height.abs() / self.leg_length))
        };
        if clips.iter().filter_map(|clip| off(&clip.gait)).any(|(_, share)| share < OFF_GROUND.0) {
            return;
        }
        for CharacterClip { clip, gait, .. } in clips {
            let Some((height, _)) = off(gait).filter(|&(_, share)| share < OFF_GROUND.1) else { continue };
            let down = self.hips_parent().transform_vector3(Vec3::NEG_Y * height);
            *clip = Arc::new(Clip::clone(clip).moved(&self.skeleton, self.hips, down));
            gait.sole_height = gait.sole_height.map(|sole| sole - height);
        }
    }

    /// From model space to the space that the hips move in, at rest.
    fn hips_parent(&self) -> Affine3A {
        let rest = Pose::rest(&self.skeleton);
        let above = self.skeleton.parent(self.hips).map_or(self.skeleton.model_from_root, |parent| rest.model(parent));
        above.inverse()
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
        let mut locomotion = self.file.locomotion.completed(|clip| self.clip(clip).is_some());
        if self.file.locomotion.transitions.is_none() {
            locomotion = locomotion.paced((self.leg_length / TUNED_LEG).sqrt());
        }
        if locomotion.states().is_empty() {
            return Err(CharacterError::NoState { model: self.file.model.clone(), clips: listed(names()) });
        }
        locomotion.check_names(&Ranges::new("locomotion."))?;
        self.file.locomotion = locomotion;
        Ok(())
    }
}
