//! Lays actions over the animated pose: a wave while walking.
//!
//! Reads what was asked of [`Actions`] and the character's clips; changes local transforms of [`CharacterPose`] where the
//! actions' masks reach. Each joint in its parent's space.

use bevy::{prelude::*, utils::Parallel};

use super::CharacterPose;
use crate::{
    anim::skeleton::JointTransform,
    character::{Character, bind::CharacterAssets, detail::Pacing, schedule::PoseClock},
    math::fade::Fade,
    rig::{
        actions::CharacterAction,
        character::{CharacterAsset, CharacterClip},
    },
};

/// What a character does beside going about: clips by name, each over the part of the body that its mask names.
///
/// Every character has one. Names are those of [`CharacterFile::actions`](crate::rig::character_file::CharacterFile::actions)
/// and of all clips; one that doesn't exist is warned of, with those that do. An action that begins later lies over those
/// that began earlier.
#[derive(Component, Clone, Debug, Default)]
pub struct Actions {
    asked: Vec<Request>,
    playing: Vec<Playing>,
}

/// What was asked for since the last frame.
#[derive(Clone, Debug, PartialEq)]
enum Request {
    Play(String),
    Fade { name: String, weight: f32, seconds: f32 },
    Stop(String),
}

/// An action under way.
#[derive(Clone, Debug)]
struct Playing {
    name: String,
    /// Seconds into the clip.
    time: f32,
    weight: Fade,
    /// Seconds until it begins to go.
    stays: f32,
    goes: bool,
}

impl Actions {
    /// Begins the action `name`, once or, if it loops, until it is stopped.
    ///
    /// One that plays already begins anew over itself, without a jump; one that still fades in or that loops goes on.
    pub fn play(&mut self, name: impl Into<String>) {
        self.asked.push(Request::Play(name.into()));
    }

    /// Has the action `name` go, in its own time.
    pub fn stop(&mut self, name: impl Into<String>) {
        self.asked.push(Request::Stop(name.into()));
    }

    /// Has the action `name`, if it plays, show by `weight` (0..=1) after so many seconds; it goes on playing.
    pub fn fade_to(&mut self, name: impl Into<String>, weight: f32, seconds: f32) {
        let weight = if weight.is_nan() { 0.0 } else { weight.clamp(0.0, 1.0) };
        let seconds = if seconds.is_finite() { seconds } else { 0.0 };
        self.asked.push(Request::Fade { name: name.into(), weight, seconds });
    }

    /// Whether the action `name` plays, or was asked for since the last frame, and isn't about to go.
    #[must_use]
    pub fn is_playing(&self, name: &str) -> bool {
        let asked = self.asked.iter().rev().find_map(|request| match request {
            Request::Play(asked) if asked == name => Some(true),
            Request::Stop(asked) if asked == name => Some(false),
            _ => None,
        });
        asked.unwrap_or_else(|| self.playing.iter().any(|playing| playing.name == name && !playing.goes))
    }

    /// How much of the action `name` shows, 0..=1.
    #[must_use]
    pub fn weight(&self, name: &str) -> f32 {
        let weights = self.playing.iter().filter(|playing| playing.name == name).map(|playing| playing.weight.value());
        weights.fold(0.0, f32::max)
    }

    /// Names of all that plays, the lowest layer first.
    pub fn playing(&self) -> impl Iterator<Item = &str> {
        self.playing.iter().map(|playing| playing.name.as_str())
    }

    /// The clips that play, the lowest layer first.
    pub fn clips<'a>(&'a self, asset: &'a CharacterAsset) -> impl Iterator<Item = &'a CharacterClip> {
        self.playing.iter().filter_map(|playing| asset.action(&playing.name).ok()?.clip(asset))
    }

    /// All that plays, the lowest layer first: the action, seconds into its clip, and how much of it shows.
    pub(super) fn layers<'a>(
        &'a self,
        asset: &'a CharacterAsset,
    ) -> impl Iterator<Item = (&'a CharacterAction, f32, f32)> {
        let layer =
            |playing: &'a Playing| Some((asset.action(&playing.name).ok()?, playing.time, playing.weight.value()));
        self.playing.iter().filter_map(layer)
    }

    /// Whether nothing plays or is asked for.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.asked.is_empty() && self.playing.is_empty()
    }

    /// One frame of `dt` seconds.
    fn advance(&mut self, asset: &CharacterAsset, dt: f32) {
        let Self { asked, playing } = self;
        for request in asked.drain(..) {
            match request {
                Request::Play(name) => begin(playing, asset, name),
                Request::Stop(name) => each_of(playing, asset, &name, Playing::go),
                Request::Fade { name, weight, seconds } => {
                    each_of(playing, asset, &name, |playing, _| playing.fade_to(weight, seconds));
                }
            }
        }
        playing
            .retain_mut(|playing| asset.action(&playing.name).is_ok_and(|action| playing.advance(action, asset, dt)));
    }

    /// Lays all that plays over `pose`. Model matrices are stale afterwards.
    fn apply(&self, asset: &CharacterAsset, pose: &mut [JointTransform], sampled: &mut Vec<JointTransform>) {
        sampled.resize(asset.skeleton.len(), JointTransform::IDENTITY);
        for (action, time, weight) in self.layers(asset) {
            let Some(clip) = action.clip(asset) else { continue };
            clip.clip.sample(&asset.skeleton, time, sampled);
            match &action.reference {
                Some(reference) => action.mask.add(pose, sampled, reference, weight),
                None => action.mask.blend(pose, sampled, weight),
            }
        }
    }
}

fn begin(playing: &mut Vec<Playing>, asset: &CharacterAsset, name: String) {
    let action = match asset.action(&name) {
        Ok(action) => action,
        Err(error) => return warn!("`{}`: {error}", asset.file.model),
    };
    let config = &action.config;
    let mut fade_in = config.fade_in;
    for before in playing.iter_mut().filter(|playing| playing.name == name && !playing.goes) {
        if config.looping || before.weight.is_fading() {
            return;
        }
        // It stays below the new one until that covers it, so nothing shows through. The way from its pose to the clip's
        // first one is that of going and coming, so it takes the time of both.
        fade_in = config.fade_in + config.fade_out;
        before.stays = fade_in;
    }
    let mut weight = Fade::at(0.0);
    weight.send_to(config.weight, fade_in);
    playing.push(Playing { name, time: 0.0, weight, stays: seconds_of(action, asset), goes: false });
}

/// Does something to all that plays by this name.
fn each_of(
    playing: &mut [Playing],
    asset: &CharacterAsset,
    name: &str,
    mut change: impl FnMut(&mut Playing, &CharacterAction),
) {
    match asset.action(name) {
        Ok(action) => playing.iter_mut().filter(|playing| playing.name == name).for_each(|it| change(it, action)),
        Err(error) => warn!("`{}`: {error}", asset.file.model),
    }
}

/// Seconds that an action plays before it begins to go.
fn seconds_of(action: &CharacterAction, asset: &CharacterAsset) -> f32 {
    let Some(clip) = action.clip(asset).filter(|_| !action.config.looping) else { return f32::INFINITY };
    (clip.clip.duration / clip.clip.speed - action.config.fade_out).max(0.0)
}

impl Playing {
    fn go(&mut self, action: &CharacterAction) {
        if !self.goes {
            self.goes = true;
            self.weight.send_to(0.0, action.config.fade_out);
        }
    }

    fn fade_to(&mut self, weight: f32, seconds: f32) {
        if !self.goes {
            self.weight.send_to(weight, seconds);
        }
    }

    /// One frame; false when it is over.
    fn advance(&mut self, action: &CharacterAction, asset: &CharacterAsset, dt: f32) -> bool {
        let Some(clip) = action.clip(asset) else { return false };
        self.time += dt * clip.clip.speed;
        if action.config.looping && self.time >= clip.clip.duration && clip.clip.duration > 0.0 {
            self.time %= clip.clip.duration;
        }
        self.weight.advance(dt);
        self.stays -= dt;
        if self.stays <= 0.0 && !self.goes {
            self.go(action);
            // It began to go within the frame.
            self.weight.advance(-self.stays);
        }
        !self.goes || self.weight.is_fading()
    }
}

pub(super) fn act(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    sampled: Local<Parallel<Vec<JointTransform>>>,
    mut characters: Query<(&Character, Option<&Pacing>, &mut Actions, &mut CharacterPose)>,
) {
    let dt = clock.delta_secs();
    characters.par_iter_mut().for_each_init(
        || sampled.borrow_local_mut(),
        |sampled, (character, pacing, mut actions, mut pose)| {
            let Some(asset) = assets.get(character).filter(|_| !actions.is_idle()) else { return };
            let Some(dt) = Pacing::whole(pacing, dt) else { return };
            actions.advance(asset, dt);
            pose.set_legs(asset);
            actions.apply(asset, pose.pose.locals_mut(), sampled);
            pose.pose.update_model_of(&asset.skeleton, &asset.trunk);
        },
    );
}
