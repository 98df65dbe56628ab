//! Clip weights and phases → local pose and model pose.
//!
//! Reads [`Locomotion`], [`Actions`] and the character's clips; writes [`CharacterPose`].

mod actions;
mod balance;
mod blink;
mod feet;
mod lead;
mod morphs;
mod past;

use bevy::{prelude::*, utils::Parallel};

pub use actions::Actions;
pub use balance::{Balance, wanted_lean, wanted_stoop};
pub use blink::Blink;
pub use morphs::{MorphScratch, MorphSources, morph_weights};

use super::{
    Character,
    bind::CharacterAssets,
    detail::{ClipsOnly, Mode, Pacing},
    legs::keep_bent,
    locomotion::{Locomotion, Playing, Taken},
    schedule::{PoseClock, PoseSystems},
};
use feet::BlendedFeet;
use past::Past;

use crate::{
    anim::{
        blend::Accumulator,
        block::{LocalWorkspace, Play},
        inertialize::{Inertializer, Offsets},
        pose::Pose,
        skeleton::{JointTransform, Skeleton},
    },
    rig::{character::CharacterAsset, tuning::locomotion::TransitionBlend},
};

/// A character's pose: written by the animator, changed by foot IK, read by skinning.
#[derive(Component, Clone, Debug, Default)]
pub struct CharacterPose {
    /// Local transforms and model matrices of every joint. Of those that [clips alone](super::detail::Detail::clips_only) pose it stands still.
    ///
    /// In a tick, model matrices of all joints are up to date from `PoseSystems::Model` to `Ease`; in a frame from `Show` on, when they
    /// are those between the last two ticks. Local transforms are those of the last tick, or shown alike with
    /// [`ShowLocals`](super::show::ShowLocals).
    pub pose: Pose,
    inertializer: Inertializer,
    past: Past,
    feet: BlendedFeet,
    /// Whether feet are where they shall be in model space, and legs aren't set onto them yet.
    feet_lead: bool,
}

impl CharacterPose {
    /// The rest pose of `skeleton`.
    #[must_use]
    pub fn new(skeleton: &Skeleton) -> Self {
        Self { pose: Pose::rest(skeleton), ..Self::default() }
    }

    /// The pose of what plays, without a past.
    pub(super) fn begin(&mut self, asset: &CharacterAsset, locomotion: &Locomotion) {
        self.animate(asset, locomotion, &mut Scratch::default(), false, 0.0);
        self.set_legs(asset);
        self.pose.update_model(&asset.skeleton);
    }

    /// Samples all clips that play into the local pose, and finds where the feet are in each; false where no foot is to be put
    /// right. `None` where nothing plays.
    fn sample(&mut self, asset: &CharacterAsset, plays: &[Play], scratch: &mut Scratch) -> Option<bool> {
        let Scratch { sampled, work, .. } = scratch;
        sampled.resize(asset.skeleton.len(), JointTransform::IDENTITY);
        let whole = asset.rows.sample(plays, work, self.pose.locals_mut());
        if let [only] = plays[..] {
            if !whole {
                asset.clips().get(only.clip)?.clip.sample(&asset.skeleton, only.time, self.pose.locals_mut());
            }
            return Some(false);
        }
        plays.first()?;
        let mut blend = Accumulator::new(self.pose.locals_mut());
        let mut feet = self.feet.start();
        for play in plays {
            if !(whole && asset.rows.sample_watched(play.clip, play.time, sampled)) {
                let clip = &asset.clips().get(play.clip)?.clip;
                clip.sample(&asset.skeleton, play.time, sampled);
                blend.add(sampled, play.weight);
            }
            feet.add(&feet::ankles(sampled, &asset.skeleton, &asset.legs), play.weight);
        }
        Some((whole || blend.finish()) && feet.finish())
    }

    /// The pose of `plays` and what `ease` makes of it; legs and spine are brought into model space, feet may lead their legs.
    /// Nothing where nothing plays.
    fn play(
        &mut self,
        asset: &CharacterAsset,
        plays: &[Play],
        scratch: &mut Scratch,
        ease: impl FnOnce(&mut Inertializer, &mut [JointTransform]) -> bool,
    ) -> Option<()> {
        let corrects = self.sample(asset, plays, scratch)?;
        // What eases moves the feet away from where the clips have them.
        let early = (corrects && self.inertializer.remembers())
            .then(|| feet::ankles(self.pose.locals(), &asset.skeleton, &asset.legs));
        let eases = ease(&mut self.inertializer, self.pose.locals_mut());
        self.feet_lead = false;
        self.pose.update_model_of(&asset.skeleton, &asset.trunk);
        if eases {
            for leg in &asset.legs {
                keep_bent(&mut self.pose, &asset.skeleton, leg);
            }
        }
        if corrects {
            let blended = early.unwrap_or_else(|| {
                let [left, right] = &asset.legs;
                [feet::ankle(&self.pose, left), feet::ankle(&self.pose, right)]
            });
            let wanted = self.feet.ankles();
            for ((leg, wanted), blended) in asset.legs.iter().zip(wanted).zip(blended) {
                let ankle = self.pose.position(leg.foot) + wanted.translation - blended.translation;
                self.lead_foot(leg, wanted.rotation * blended.rotation.inverse(), ankle);
            }
        }
        Some(())
    }

    /// Plays what was played in the last two poses again, to carry their motion over: nothing was carried over in them.
    fn recall(&mut self, asset: &CharacterAsset, scratch: &mut Scratch) {
        let Some([last, before]) = self.past.played() else { return };
        let mut memory = scratch.spare.pop().unwrap_or_default();
        if self.play(asset, &before, scratch, |_, _| false).is_some() {
            self.set_legs(asset);
            memory.set_before(self.pose.locals());
        }
        if self.play(asset, &last, scratch, |_, _| false).is_some() {
            self.set_legs(asset);
            memory.set_last(self.pose.locals());
        }
        self.past.plays = [last, before];
        self.inertializer.recall(memory);
    }

    /// What plays `share` of the way between the last two ticks, 0..=1.
    pub fn plays_between(&self, asset: &CharacterAsset, share: f32, out: &mut Vec<Play>) {
        self.past.between(asset, share, out);
    }

    /// Poses it as [blocks](super::crowd) show it, `share` of the way between the last two ticks: their readable reference, for checks.
    /// False where nothing plays.
    pub fn show_clips(&mut self, asset: &CharacterAsset, small_joints: bool, share: f32) -> bool {
        let mut plays = Vec::new();
        self.plays_between(asset, share, &mut plays);
        let work = &mut LocalWorkspace::default();
        let posed = sample_clips(asset, &plays, small_joints, work, self.pose.locals_mut());
        if posed {
            self.pose.update_model(&asset.skeleton);
        }
        posed
    }

    /// The local pose of what played in the last tick, or in the one `before`, by the clips alone; `None` where nothing did.
    pub(super) fn clips_pose<'a>(
        &self,
        asset: &CharacterAsset,
        (before, small_joints): (bool, bool),
        scratch: &'a mut ClipsScratch,
    ) -> Option<&'a [JointTransform]> {
        scratch.pose.resize(asset.skeleton.len(), JointTransform::IDENTITY);
        let plays = &self.past.plays[usize::from(before)];
        sample_clips(asset, plays, small_joints, &mut scratch.work, &mut scratch.pose).then_some(&scratch.pose)
    }

    /// One tick of who is posed by its clips alone: notes what they play, and poses it as long as it isn't alone.
    fn animate_by_clips(
        &mut self,
        asset: &CharacterAsset,
        locomotion: &Locomotion,
        scratch: &mut Scratch,
        pacing: &Pacing,
        dt: f32,
    ) {
        scratch.put_by(self.inertializer.forget());
        let mut plays = core::mem::take(&mut scratch.plays);
        list(asset, locomotion, &mut plays);
        if pacing.returns {
            self.past.forget();
            self.past.push(&plays, dt);
        } else if let Some(taken) = carried_over(locomotion) {
            self.past.leave(taken.fade);
        }
        self.past.fade(&mut plays, dt);
        if pacing.mode != Mode::ClipsOnly(ClipsOnly::Alone) {
            // Where nothing weighs anything the last pose stays.
            sample_clips(asset, &plays, pacing.small_joints, &mut scratch.work, self.pose.locals_mut());
        }
        self.past.push(&plays, dt);
        scratch.plays = plays;
    }

    fn animate(
        &mut self,
        asset: &CharacterAsset,
        locomotion: &Locomotion,
        scratch: &mut Scratch,
        joins: bool,
        dt: f32,
    ) {
        self.pose.begin();
        let taken = carried_over(locomotion);
        if taken.is_some() && !self.inertializer.remembers() {
            self.recall(asset, scratch);
        }
        let mut plays = core::mem::take(&mut scratch.plays);
        list(asset, locomotion, &mut plays);
        let past_dt = self.past.dt;
        let played = self.play(asset, &plays, scratch, |inertializer, locals| {
            if let Some(taken) = taken {
                inertializer.begin(locals, past_dt, taken.fade, taken.blend == TransitionBlend::Burst);
            }
            inertializer.apply(locals, dt)
        });
        if played.is_some() {
            if self.inertializer.remembers() {
                self.set_legs(asset);
                self.inertializer.record(self.pose.locals());
            }
            scratch.put_by(self.inertializer.rest());
            if joins {
                // What clips alone would have played on.
                self.past.fade(&mut plays, dt);
                self.past.forget();
            }
            self.past.push(&plays, dt);
        }
        scratch.plays = plays;
    }
}

/// Samples what clips alone show; false where nothing plays.
fn sample_clips(
    asset: &CharacterAsset,
    plays: &[Play],
    small_joints: bool,
    work: &mut LocalWorkspace,
    locals: &mut [JointTransform],
) -> bool {
    let sampled = asset.rows.sample(plays, work, locals);
    if sampled && !small_joints {
        asset.small_joints.hold(locals);
    }
    sampled
}

/// The change of state that is to be carried over into the new one.
fn carried_over(locomotion: &Locomotion) -> Option<Taken> {
    locomotion.taken.filter(|taken| taken.blend != TransitionBlend::CrossFade)
}

/// Lists all that plays.
fn list(asset: &CharacterAsset, locomotion: &Locomotion, plays: &mut Vec<Play>) {
    plays.clear();
    plays.extend(locomotion.playing(asset).map(|Playing { index: clip, time, weight, .. }| Play {
        clip,
        time,
        weight,
    }));
}

/// Memory of one thread for [`CharacterPose::clips_pose`].
#[derive(Default)]
pub(super) struct ClipsScratch {
    work: LocalWorkspace,
    pose: Vec<JointTransform>,
}

/// Memory of one thread for sampling.
#[derive(Default)]
struct Scratch {
    sampled: Vec<JointTransform>,
    plays: Vec<Play>,
    work: LocalWorkspace,
    /// Given back by those who ease no longer.
    spare: Vec<Offsets>,
}

/// Most of what is given back that a thread keeps: a crowd that starts at once shall not hold its memory for good.
const SPARE: usize = 32;

impl Scratch {
    fn put_by(&mut self, memory: Option<Offsets>) {
        self.spare.extend(memory.filter(|_| self.spare.len() < SPARE));
    }
}

/// Samples and blends clips, lays actions over them, leans the body and shuts the eyes now and then.
pub struct AnimatorPlugin;

impl Plugin for AnimatorPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(
            FixedPostUpdate,
            (
                (animate, actions::act, balance::keep_balance).chain().in_set(PoseSystems::Sample),
                complete.in_set(PoseSystems::Model),
            ),
        )
        .add_systems(PostUpdate, blink::blink.in_set(PoseSystems::Show));
    }
}

/// Brings all joints into model space.
fn complete(assets: CharacterAssets, mut characters: Query<(&Character, Option<&Pacing>, &mut CharacterPose)>) {
    characters.par_iter_mut().for_each(|(character, pacing, mut pose)| {
        if let Some(asset) = assets.get(character).filter(|_| Pacing::due(pacing, 0.0).is_some()) {
            pose.set_legs(asset);
            pose.pose.update_model(&asset.skeleton);
        }
    });
}

fn animate(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    scratch: Local<Parallel<Scratch>>,
    mut characters: Query<(&Character, &Locomotion, Option<&Pacing>, &mut CharacterPose)>,
) {
    let dt = clock.delta_secs();
    characters.par_iter_mut().for_each_init(
        || scratch.borrow_local_mut(),
        |scratch, (character, locomotion, pacing, mut pose)| {
            let Some(asset) = assets.get(character) else { return };
            match pacing {
                Some(pacing @ &Pacing { mode: Mode::ClipsOnly(stage), .. }) if stage != ClipsOnly::Leaves => {
                    // Nobody shall take the pose of who is alone for changed.
                    let alone = stage == ClipsOnly::Alone;
                    let pose = if alone { pose.bypass_change_detection() } else { &mut *pose };
                    pose.animate_by_clips(asset, locomotion, scratch, pacing, dt);
                }
                _ => {
                    if let Some(dt) = Pacing::due(pacing, dt) {
                        let joins = pacing.is_some_and(|pacing| pacing.joins);
                        pose.animate(asset, locomotion, scratch, joins, dt);
                    }
                }
            }
        },
    );
}
