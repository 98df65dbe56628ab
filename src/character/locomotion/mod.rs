//! `MotionState` → clip weights and phase.
//!
//! Reads what the controller did and the clips' gaits; writes [`Locomotion`]: which clip weighs how much, where it is, and
//! for each foot what the clips say of its contact with the ground.

mod compass;
mod cues;
mod facts;
mod fade;
mod machine;
mod plan;

use std::sync::Arc;

use bevy::prelude::*;
use smallvec::SmallVec;

pub use cues::FootCue;
pub use facts::{ClipFacts, Facts, Taken};
pub use fade::Fades;
pub use machine::Machine;

use super::{
    bind::CharacterAssets,
    detail::{self, Detail, Pacing},
    motion::MotionState,
    schedule::{PoseClock, PoseSystems, stagger},
};
use crate::{
    anim::{
        peak::{Liveliness, Peak},
        pose::Pose,
    },
    math::{rotation::heading, spring::damp},
    rig::character::{CharacterAsset, CharacterClip},
};

/// Share of the slowest gait's liveliness and speed that a step of a foot by itself has.
const STEP: f32 = 0.5;

/// What plays: the state machine and what follows from it.
#[derive(Component, Clone, Debug)]
pub struct Locomotion {
    /// The machine, with weights and phases.
    pub machine: Machine,
    /// What the playing clips say of the left and right foot; kept up while more than clips pose it.
    pub cues: [FootCue; 2],
    /// The transition taken in this frame.
    pub taken: Option<Taken>,
    tracks: Arc<[Track]>,
    /// By state: its first track; at the end, how many tracks there are.
    firsts: Arc<[usize]>,
    /// How lively the slowest gait is, and how fast it moves a leg's joints, rad/s.
    slowest: (Liveliness, f32),
    heard: SmallVec<[Heard; 4]>,
    triggers: Vec<String>,
    grade: f32,
    last_root: Option<Vec3>,
    /// `MotionState::jumps` of the last frame.
    jumps: Option<u32>,
    /// Whether it stood on ground when it last looked, and how long ago that was, seconds.
    grounded: bool,
    waited: f32,
}

/// The slowest gait; nothing without gaits.
fn slowest_gait(asset: &CharacterAsset) -> (Liveliness, f32) {
    let gaits = asset.clips().iter().filter(|clip| clip.gait.speed > 0.0);
    let slowest = gaits.min_by(|a, b| a.gait.speed.total_cmp(&b.gait.speed));
    slowest.map_or_else(Default::default, |clip| (clip.lively, clip.gait.leg_speed))
}

/// A clip of a state.
#[derive(Clone, Debug)]
struct Track {
    state: usize,
    /// Its number among the state's clips.
    slot: usize,
    /// Its place among the character's clips.
    clip: usize,
    landing: cues::Landing,
}

/// A track that plays, and where it is.
#[derive(Clone, Copy, Debug)]
struct Heard {
    track: u32,
    weight: f32,
    time: f32,
    gait_phase: f32,
}

/// A clip that plays.
#[derive(Clone, Copy, Debug)]
pub struct Playing<'a> {
    /// The clip.
    pub clip: &'a CharacterClip,
    /// Its place among the character's clips.
    pub index: usize,
    /// The state that it belongs to.
    pub state: usize,
    /// How much of the pose it is, 0..=1; all sum to one.
    pub weight: f32,
    /// Where in the clip it is, seconds.
    pub time: f32,
    /// The same as a phase of its gait: 0 is left contact.
    pub gait_phase: f32,
    landing: cues::Landing,
}

impl Locomotion {
    /// The machine of `asset`'s file. `scratch` is a pose of its skeleton; its content is lost.
    #[must_use]
    pub fn new(asset: &CharacterAsset, scratch: &mut Pose) -> Self {
        let config = &asset.file.locomotion;
        let (mut tracks, mut firsts) = (Vec::new(), vec![0]);
        for (state, config) in config.states().iter().enumerate() {
            for (slot, name) in config.clips().enumerate() {
                let Some(clip) = asset.clip_index(name) else { continue };
                let landing = cues::landing(asset, &asset.clips()[clip], scratch);
                tracks.push(Track { state, slot, clip, landing });
            }
            firsts.push(tracks.len());
        }
        *scratch = Pose::rest(&asset.skeleton);
        let mut locomotion = Self {
            machine: Machine::new(config, |name| asset.clip(name).map(facts_of).unwrap_or_default()),
            cues: Default::default(),
            taken: None,
            heard: SmallVec::new(),
            tracks: tracks.into(),
            firsts: firsts.into(),
            slowest: slowest_gait(asset),
            triggers: Vec::new(),
            grade: 0.0,
            last_root: None,
            jumps: None,
            grounded: true,
            waited: 0.0,
        };
        locomotion.listen(asset);
        locomotion
    }

    /// All clips that play now.
    pub fn playing<'a>(&'a self, asset: &'a CharacterAsset) -> impl Iterator<Item = Playing<'a>> {
        self.heard.iter().filter_map(move |&Heard { track, weight, time, gait_phase }| {
            let Track { state, clip, landing, .. } = *self.tracks.get(track as usize)?;
            Some(Playing { clip: asset.clips().get(clip)?, index: clip, state, weight, time, gait_phase, landing })
        })
    }

    /// Finds out what plays, and where it is.
    fn listen(&mut self, asset: &CharacterAsset) {
        let Self { machine, tracks, firsts, heard, .. } = self;
        heard.clear();
        let tracks_of = |(state, weight)| (firsts[state]..firsts[state + 1]).map(move |track| (track, weight));
        for (index, weight) in machine.heard().flat_map(tracks_of) {
            let track = &tracks[index];
            let weight = weight * machine.share(track.state, track.slot);
            let Some(clip) = asset.clips().get(track.clip).filter(|_| weight > 0.0) else { continue };
            let (phase, duration) = (machine.clip_phase(track.state), clip.clip.duration);
            let (time, gait_phase) = if machine.is_gait(track.state) {
                (clip.gait.time_at(phase, duration), phase)
            } else {
                (phase * duration, clip.gait.phase_at(phase * duration, duration))
            };
            heard.push(Heard { track: u32::try_from(index).unwrap_or(u32::MAX), weight, time, gait_phase });
        }
    }

    /// Largest angular speed in rad/s that hips, knees and ankles have in the clips that play, each by its weight among those
    /// that move legs; at least that of a step.
    #[must_use]
    pub fn leg_speed(&self, asset: &CharacterAsset) -> f32 {
        let slowest = STEP * self.slowest.1;
        let moves = self.playing(asset).filter(|playing| playing.clip.gait.leg_speed > slowest);
        let (speed, weight) = moves.fold((0.0, 0.0), |(speed, weight), playing| {
            (speed + playing.clip.gait.leg_speed * self.rate(&playing) * playing.weight, weight + playing.weight)
        });
        if weight > 0.0 { (speed / weight).max(slowest) } else { slowest }
    }

    /// Largest vertical acceleration in m/s², at normal playback, that hips have in any of the gaits that play; 0 without gaits.
    #[must_use]
    pub fn heave(&self, asset: &CharacterAsset) -> f32 {
        let gaits = self.playing(asset).filter(|playing| self.machine.is_gait(playing.state));
        gaits.map(|playing| playing.clip.gait.heave).fold(0.0, f32::max)
    }

    /// The liveliest that any of the clips that play is in frames of `dt` seconds; at least as lively as a step.
    #[must_use]
    pub fn liveliest(&self, asset: &CharacterAsset, dt: f32) -> Peak {
        let peak = |playing: Playing<'_>| playing.clip.lively.at(dt).at_rate(self.rate(&playing));
        self.playing(asset).map(peak).fold(self.slowest.0.at(dt) * STEP, Peak::max)
    }

    /// How many times as fast as by itself a clip plays, at least once.
    fn rate(&self, playing: &Playing<'_>) -> f32 {
        let gait = self.machine.is_gait(playing.state);
        let rate = if gait { self.machine.phase_rate() * playing.clip.clip.duration } else { 1.0 };
        rate.max(1.0)
    }

    /// Pulls a trigger: a transition that waits for `name` may be taken in the next frame.
    pub fn trigger(&mut self, name: impl Into<String>) {
        self.triggers.push(name.into());
    }

    /// Name of the state that the machine is in.
    #[must_use]
    pub fn state(&self) -> &str {
        if self.machine.is_empty() { "" } else { self.machine.name(self.machine.current()) }
    }

    /// Weight of the state named `name`; 0 for an unknown one.
    #[must_use]
    pub fn weight_of(&self, name: &str) -> f32 {
        (0..self.machine.len()).filter(|i| self.machine.name(*i) == name).map(|i| self.machine.weight(i)).sum()
    }

    /// Weight of the clip named `name`, whatever state plays it.
    #[must_use]
    pub fn weight_of_clip(&self, asset: &CharacterAsset, name: &str) -> f32 {
        self.playing(asset).filter(|playing| playing.clip.name == name).map(|playing| playing.weight).sum()
    }

    /// Rise over run of the way it goes, smoothed.
    #[must_use]
    pub fn grade(&self) -> f32 {
        self.grade
    }

    /// Goes on where `other` is, as far as it has the same states: for a character whose file has changed.
    pub fn take_over(&mut self, other: &Self, asset: &CharacterAsset) {
        self.machine.take_over(&other.machine);
        (self.grade, self.last_root, self.jumps) = (other.grade, other.last_root, other.jumps);
        self.listen(asset);
    }
}

/// What the machine must know of a clip.
fn facts_of(clip: &CharacterClip) -> ClipFacts {
    let CharacterClip { clip, gait, .. } = clip;
    ClipFacts {
        duration: clip.duration,
        looping: clip.looping,
        stride: gait.stride * f32::from(gait.strides),
        heading: if gait.speed > 0.0 { heading(gait.velocity) } else { 0.0 },
    }
}

impl Locomotion {
    /// Whether something happened that can't wait.
    fn must_hear(&self, motion: &MotionState) -> bool {
        self.jumps != Some(motion.jumps) || self.grounded != motion.ground.is_some() || !self.triggers.is_empty()
    }

    /// Rise over run of the root's way, or of the way ahead where that is steeper; smoothed.
    fn follow_grade(&mut self, root: Vec3, motion: &MotionState, dt: f32) {
        let last = self.last_root.replace(root).unwrap_or(root);
        let ahead = motion.grade_ahead;
        let carried = motion.ground.map_or(Vec3::ZERO, |ground| ground.velocity * dt);
        let way = root - last - carried;
        let run = Vec2::new(way.x, way.z).length();
        let moves = motion.ground.is_some() && run > 0.1 * dt;
        let grade = if moves { (way.y / run).clamp(-1.0, 1.0) } else { 0.0 };
        let steeper = if ahead.abs() > grade.abs() { ahead } else { grade };
        // Who stands looks before the first step.
        self.grade = damp(self.grade, steeper, if moves { GRADE_HALF_LIFE } else { 0.0 }, dt);
    }
}

/// Half-life in seconds over which the grade of the way is found.
const GRADE_HALF_LIFE: f32 = 0.15;

/// Runs the locomotion state machines.
pub struct LocomotionPlugin;

impl Plugin for LocomotionPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            FixedPostUpdate,
            (locomote.in_set(PoseSystems::Locomote), hear_feet.in_set(PoseSystems::Pace).after(detail::pace)),
        );
    }
}

fn locomote(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    mut characters: Query<(Entity, &super::Character, &Transform, &MotionState, &mut Locomotion, Option<&Detail>)>,
) {
    let tick = clock.delta_secs();
    characters.par_iter_mut().for_each(|(entity, character, root, motion, mut locomotion, detail)| {
        let locomotion = &mut *locomotion;
        locomotion.waited += tick;
        let rests = detail.is_some_and(|detail| !detail.posed && locomotion.waited < rest(entity, detail.glide));
        if rests && !locomotion.must_hear(motion) {
            locomotion.taken = None;
            return;
        }
        let dt = core::mem::take(&mut locomotion.waited);
        let Some(asset) = assets.get(character) else { return };
        locomotion.follow_grade(root.translation, motion, dt);
        let velocity = (root.rotation.inverse() * motion.ground_velocity).with_y(0.0);
        let grounded = motion.ground.is_some();
        let facts = Facts {
            grade: locomotion.grade,
            speed: Vec2::new(motion.ground_velocity.x, motion.ground_velocity.z).length(),
            velocity: Vec2::new(velocity.x, -velocity.z),
            grounded,
            air_time: motion.air_time,
            fall_speed: -motion.velocity.y,
            landing_speed: motion.landing_speed,
            jumped: locomotion.jumps.replace(motion.jumps).is_some_and(|jumps| jumps != motion.jumps),
            crouched: motion.crouched,
            facing_locked: motion.facing_locked,
            turn_ahead: motion.turn_ahead,
            turned: motion.ground_yaw_rate * dt,
            triggers: &locomotion.triggers,
        };
        locomotion.grounded = grounded;
        locomotion.taken = locomotion.machine.advance(&facts, dt);
        locomotion.triggers.clear();
        locomotion.listen(asset);
    });
}

/// Seconds between two looks at who isn't seen, `most` or up to a third less: not all of them look in the same tick.
fn rest(character: Entity, most: f32) -> f32 {
    most * (1.0 - stagger(character) / 3.0)
}

/// What clips say of the feet of those that are posed by more than them.
fn hear_feet(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    mut characters: Query<(&super::Character, &mut Locomotion, Option<&Pacing>)>,
) {
    let dt = clock.delta_secs();
    characters.par_iter_mut().for_each(|(character, mut locomotion, pacing)| {
        if Pacing::whole(pacing, dt).is_none() {
            return;
        }
        let Some(asset) = assets.get(character) else { return };
        let cues = [0, 1].map(|foot| cues::cue(&locomotion, asset, foot));
        locomotion.cues = cues;
    });
}
