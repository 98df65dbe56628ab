//! `*.character.ron`: which model a character has, which clips it plays, and all of its tuning.

use std::collections::BTreeMap;

use bevy::reflect::Reflect;
use ron::{Options, error::SpannedError, extensions::Extensions};
use serde::{Deserialize, Serialize};

use super::{
    humanoid::HumanoidRole,
    names::suggestion,
    tuning::{
        actions::ActionConfig,
        aim::AimConfig,
        balance::BalanceConfig,
        blink::BlinkConfig,
        foot_ik::{FootIkConfig, TUNED_LEG},
        locomotion::LocomotionConfig,
        look::LookConfig,
        motion::{BodySize, MotionConfig, TUNED_STATURE},
        ranges::{RangeError, Ranges},
        retarget::RetargetConfig,
    },
};
use crate::anim::gait::Contact;

/// A character, as its file says it. Every field may be left out.
#[derive(Reflect, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CharacterFile {
    /// The glTF file of body and clips, beside this file. Default "mannequin.glb".
    pub model: String,
    /// Size as a factor. Default 1. Lengths of foot placement follow it, and so does `motion` with `fit_motion`.
    pub scale: f32,
    /// Which joint plays which part. Default `Auto`.
    pub roles: Roles,
    /// Where the left sole meets the ground; the right one is its mirror image. Default: found from the vertices of the
    /// feet, else guessed from ankle and toes.
    pub soles: Option<Soles>,
    /// Clips by the names that states use. Every clip of the model is there under its own name; entries here add to
    /// them or change them. Default none.
    pub clips: BTreeMap<String, ClipSource>,
    /// Whether clips of the model that are called as the standard states are in other words, `Walking_A` or `Armature|Run`,
    /// play in those states. Default true.
    pub own_clips: bool,
    /// Whether clips that its states lack come from this crate's mannequin, made to fit. Default true.
    pub standard_clips: bool,
    /// How clips of another body, the mannequin's among them, become this one's.
    pub retarget: RetargetConfig,
    /// How the controller moves the character.
    pub motion: MotionConfig,
    /// Whether `motion` is meant for a person of 1.8 m and is brought to this body's size: lengths go with its stature,
    /// speeds with the root of its legs' length. Default true; `false` takes every figure as it stands.
    pub fit_motion: bool,
    /// Which clips play when.
    pub locomotion: LocomotionConfig,
    /// What is laid over it, by name. Each further clip can be played by its own name, too, with everything at its default.
    /// Default: the [standard actions](super::tuning::actions::standard) whose clips and joints there are.
    pub actions: Option<BTreeMap<String, ActionConfig>>,
    /// How the body leans into what it does.
    pub balance: BalanceConfig,
    /// How feet find the ground.
    pub foot_ik: FootIkConfig,
    /// Where the head turns to.
    pub look: LookConfig,
    /// How arms point where it aims.
    pub aim: AimConfig,
    /// When the eyes blink.
    pub blink: BlinkConfig,
}

impl Default for CharacterFile {
    fn default() -> Self {
        Self {
            model: "mannequin.glb".to_owned(),
            scale: 1.0,
            roles: Roles::Auto,
            soles: None,
            clips: BTreeMap::new(),
            own_clips: true,
            standard_clips: true,
            retarget: RetargetConfig::default(),
            motion: MotionConfig::default(),
            fit_motion: true,
            locomotion: LocomotionConfig::default(),
            actions: None,
            balance: BalanceConfig::default(),
            foot_ik: FootIkConfig::default(),
            look: LookConfig::default(),
            aim: AimConfig::default(),
            blink: BlinkConfig::default(),
        }
    }
}

/// Points of the left sole at rest: (left, up, forward) of the origin between the feet, metres of the model.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Soles {
    /// Rearmost point that touches the ground.
    pub heel: (f32, f32, f32),
    /// Point under the toe joint.
    pub ball: (f32, f32, f32),
    /// Foremost point that touches the ground.
    pub tip: (f32, f32, f32),
}

/// Which joint plays which part.
#[derive(Reflect, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum Roles {
    /// By the model's VRM map, by the names that VRM, Mixamo, Unity, Unreal, Blender, Rigify and others give, and where
    /// these fail by what hangs where and by the shape at rest. The default.
    #[default]
    Auto,
    /// As listed, role to joint; roles not listed are found.
    Explicit(BTreeMap<HumanoidRole, String>),
}

/// Where a clip comes from and how it plays.
#[derive(Reflect, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ClipSource {
    /// A glTF file beside this one. Default: the model.
    ///
    /// Joints of another file take part by name, else by role; lengths follow the legs.
    pub file: Option<String>,
    /// The clip's name in that file. Default: the name it gets here.
    pub clip: Option<String>,
    /// Playback speed as a factor. Default 1.
    pub speed: f32,
    /// Whether it starts again at its end. Default: when its last pose is its first.
    pub looping: Option<bool>,
    /// Speed over ground in m/s at which its feet don't slide, at playback speed 1. Default: found from the feet.
    pub ground_speed: Option<f32>,
    /// Stances of the left and of the right foot: landing and lift-off as shares 0..1 of the clip's duration; a lift-off
    /// before its landing is over the loop's end. Default: found from the feet.
    pub contacts: Option<(Vec<(f32, f32)>, Vec<(f32, f32)>)>,
}

impl Default for ClipSource {
    fn default() -> Self {
        Self { file: None, clip: None, speed: 1.0, looping: None, ground_speed: None, contacts: None }
    }
}

impl ClipSource {
    /// Stances of both feet as the file says them.
    #[must_use]
    pub fn stances(&self) -> Option<[Vec<Contact>; 2]> {
        let contact = |&(start, end): &(f32, f32)| Contact { start, end: if end > start { end } else { end + 1.0 } };
        let (left, right) = self.contacts.as_ref()?;
        Some([left, right].map(|feet| feet.iter().map(contact).collect()))
    }
}

/// Why the text is no character.
#[derive(thiserror::Error, Clone, Debug, PartialEq)]
pub enum CharacterFileError {
    /// It is not the RON that is wanted.
    #[error("line {line}, column {column}: {problem}{suggestion}")]
    Ron {
        /// Line of the file, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
        /// The nearest name, if any.
        suggestion: String,
    },
    /// A value is out of range.
    #[error(transparent)]
    Range(#[from] RangeError),
}

impl CharacterFile {
    /// Reads the text of a `.character.ron` and checks every range.
    ///
    /// # Errors
    /// When it is no RON, has unknown fields or values out of range.
    pub fn parse(text: &str) -> Result<Self, CharacterFileError> {
        let options = Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        let file: Self = options.from_str(text).map_err(|error| ron_error(&error))?;
        file.validate()?;
        Ok(file)
    }

    /// Brings the controller's figures to the size of a body, metres; once is enough.
    pub(super) fn fit_motion(&mut self, stature: f32, leg_length: f32) {
        if core::mem::take(&mut self.fit_motion) {
            let size = BodySize { stature: stature / TUNED_STATURE, legs: leg_length / TUNED_LEG };
            self.motion = self.motion.fitted(size);
        }
    }

    /// Checks every range.
    ///
    /// # Errors
    /// With the first value that is out of its range: its field, itself and what would be right.
    pub fn validate(&self) -> Result<(), RangeError> {
        let ranges = Ranges::new("");
        ranges.within("scale", self.scale, 0.01..=100.0, "")?;
        if let Some(Soles { heel, ball, tip }) = self.soles {
            for (field, point) in [("soles.heel", heel), ("soles.ball", ball), ("soles.tip", tip)] {
                for value in <[f32; 3]>::from(point) {
                    ranges.within(field, value, -100.0..=100.0, " m")?;
                }
            }
            let order = heel.2 < ball.2 && ball.2 <= tip.2;
            if !order {
                let value = format!("heel {}, ball {}, tip {} m forward", heel.2, ball.2, tip.2);
                return Err(ranges.fail("soles", value, "heel behind ball, tip not behind ball".to_owned()));
            }
        }
        for (name, clip) in &self.clips {
            let ranges = Ranges::new(&format!("clips[\"{name}\"]."));
            ranges.within("speed", clip.speed, 0.01..=100.0, "")?;
            if let Some(speed) = clip.ground_speed {
                ranges.within("ground_speed", speed, 0.0..=100.0, " m/s")?;
            }
            for (start, end) in clip.contacts.iter().flat_map(|contacts| contacts.0.iter().chain(&contacts.1)) {
                ranges.within("contacts", *start, 0.0..=1.0, "")?;
                ranges.within("contacts", *end, 0.0..=1.0, "")?;
            }
        }
        self.retarget.check(&Ranges::new("retarget."))?;
        self.motion.check(&Ranges::new("motion."))?;
        self.locomotion.check(&Ranges::new("locomotion."))?;
        for (name, action) in self.actions.iter().flatten() {
            action.check(&Ranges::new(&format!("actions[\"{name}\"].")))?;
        }
        self.balance.check(&Ranges::new("balance."))?;
        self.foot_ik.check(&Ranges::new("foot_ik."))?;
        self.look.check(&Ranges::new("look."))?;
        self.aim.check(&Ranges::new("aim."))?;
        self.blink.check(&Ranges::new("blink."))
    }
}

fn ron_error(error: &SpannedError) -> CharacterFileError {
    let suggestion = match &error.code {
        ron::Error::NoSuchStructField { expected, found, .. }
        | ron::Error::NoSuchEnumVariant { expected, found, .. } => suggestion(found, expected.iter().copied()),
        _ => String::new(),
    };
    let start = error.span.start;
    CharacterFileError::Ron { line: start.line, column: start.col, problem: error.code.to_string(), suggestion }
}
