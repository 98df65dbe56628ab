//! Clip weights and phases → local pose and model pose.
//!
//! Reads [`Locomotion`], [`Actions`] and the character's clips; writes [`CharacterPose`].

mod actions;
mod balance;
mod blink;
mod feet;
mod morphs;

use bevy::{prelude::*, utils::Parallel};

pub use actions::Actions;
pub use balance::{Balance, wanted_lean, wanted_stoop};
pub use blink::Blink;
pub use morphs::{MorphScratch, MorphSources, morph_weights};

use super::{
    Character,
    bind::CharacterAssets,
    detail::Pacing,
    legs::keep_bent,
    locomotion::{Locomotion, Playing},
    schedule::{PoseClock, PoseSystems},
};
use feet::BlendedFeet;

use crate::{
    anim::{
        blend::Accumulator,
        block::{LocalWorkspace, Play},
        inertialize::Inertializer,
        pose::Pose,
        skeleton::{JointTransform, Skeleton},
    },
    rig::{character::CharacterAsset, tuning::locomotion::TransitionBlend},
};

/// A character's pose: written by the animator, changed by foot IK, read by skinning.
#[derive(Component, Clone, Debug, Default)]
pub struct CharacterPose {
    /// Local transforms and model matrices of every joint.
    ///
    /// In a tick, model matrices of all joints are up to date from `PoseSystems::Model` to `Ease`; in a frame from `Show` on, when they
    /// are those between the last two ticks. Local transforms are those of the last tick, or shown alike with
    /// [`ShowLocals`](super::show::ShowLocals).
    pub pose: Pose,
    inertializer: Inertializer,
    feet: BlendedFeet,
}

impl CharacterPose {
    /// The rest pose of `skeleton`, with buffers for everything to come.
    #[must_use]
    pub fn new(skeleton: &Skeleton) -> Self {
        Self {
            pose: Pose::rest(skeleton),
            inertializer: Inertializer::new(skeleton.len()),
            feet: BlendedFeet::default(),
        }
    }

    /// The pose of what plays, without a past.
    pub(super) fn begin(&mut self, asset: &CharacterAsset, locomotion: &Locomotion) {
        self.animate(asset, locomotion, &mut Scratch::default(), 0.0);
        self.pose.update_model(&asset.skeleton);
    }

    /// Samples all clips that play into the local pose, and finds where the feet are in each; false where no foot is to be put
    /// right. `None` where nothing plays.
    fn sample(&mut self, asset: &CharacterAsset, locomotion: &Locomotion, scratch: &mut Scratch) -> Option<bool> {
        let Scratch { sampled, plays, work } = scratch;
        plays.clear();
        plays.extend(locomotion.playing(asset).map(|Playing { index: clip, time, weight, .. }| Play {
            clip,
            time,
            weight,
        }));
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
        for playing in locomotion.playing(asset) {
            if !(whole && asset.rows.sample_watched(playing.index, playing.time, sampled)) {
                playing.clip.clip.sample(&asset.skeleton, playing.time, sampled);
                blend.add(sampled, playing.weight);
            }
            feet.add(&feet::ankles(sampled, &asset.skeleton, &asset.legs), playing.weight);
        }
        Some((whole || blend.finish()) && feet.finish())
    }

    fn animate(&mut self, asset: &CharacterAsset, locomotion: &Locomotion, scratch: &mut Scratch, dt: f32) {
        let Some(corrects) = self.sample(asset, locomotion, scratch) else { return };
        let blended = corrects.then(|| feet::ankles(self.pose.locals(), &asset.skeleton, &asset.legs));
        if let Some(taken) = locomotion.taken.filter(|taken| taken.blend != TransitionBlend::CrossFade) {
            self.inertializer.begin(self.pose.locals(), taken.fade, taken.blend == TransitionBlend::Burst);
        }
        let eases = self.inertializer.apply(self.pose.locals_mut(), dt);
        self.pose.update_model_of(&asset.skeleton, &asset.trunk);
        if eases {
            for leg in &asset.legs {
                keep_bent(&mut self.pose, &asset.skeleton, leg);
            }
        }
        if let Some(blended) = blended {
            self.feet.correct(&mut self.pose, &asset.skeleton, &asset.legs, &blended);
        }
        self.inertializer.record(self.pose.locals(), dt);
    }
}

/// Memory of one thread for sampling.
#[derive(Default)]
struct Scratch {
    sampled: Vec<JointTransform>,
    plays: Vec<Play>,
    work: LocalWorkspace,
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
            if let (Some(asset), Some(dt)) = (assets.get(character), Pacing::due(pacing, dt)) {
                pose.animate(asset, locomotion, scratch, dt);
            }
        },
    );
}
