//! What plays, and blinks → weights of morph targets.

use super::{Actions, Blink};
use crate::{
    character::locomotion::Locomotion,
    rig::{actions::CharacterAction, character::CharacterAsset, humanoid::HumanoidRole},
};

/// What moves a character's morph targets.
#[derive(Clone, Copy, Debug)]
pub struct MorphSources<'a> {
    /// Its clips and meshes.
    pub asset: &'a CharacterAsset,
    /// What plays.
    pub locomotion: &'a Locomotion,
    /// What lies over it.
    pub actions: &'a Actions,
    /// When its eyes shut.
    pub blink: &'a Blink,
    /// Share of its blinks that is shown, 0..=1: an expression may have something against them.
    pub blinks: f32,
}

/// Buffers of [`morph_weights`].
#[derive(Debug, Default)]
pub struct MorphScratch {
    sampled: Vec<f32>,
    /// The weights found, one a target of the mesh.
    pub weights: Vec<f32>,
}

/// Finds the weights of the targets of the mesh that is at `mesh` in the rig's list; `false` when nothing says anything of
/// them.
///
/// Clips blend by their weights, those that say nothing as the mesh is at rest. Actions lie over them as far as they reach the
/// head: faces go with it. Additive ones add their weights. A blink shuts the eyes at least as far as it goes.
pub fn morph_weights(sources: &MorphSources, mesh: usize, scratch: &mut MorphScratch) -> bool {
    let MorphSources { asset, locomotion, actions, blink, blinks } = *sources;
    let MorphScratch { sampled, weights } = scratch;
    weights.clear();
    let Some(binding) = asset.rig.meshes.get(mesh) else { return false };
    let mut told = false;
    weights.resize(binding.morph_weights.len(), 0.0);
    for playing in locomotion.playing(asset) {
        sampled.clone_from(&binding.morph_weights);
        told |= playing.clip.clip.morph_weights(binding.joint, playing.time, sampled);
        weights.iter_mut().zip(&*sampled).for_each(|(sum, weight)| *sum += playing.weight * weight);
    }
    for (action, time, weight) in actions.layers(asset) {
        let share = weight * reach(action, asset);
        sampled.clone_from(&binding.morph_weights);
        let clip = action.clip(asset).filter(|_| share > 0.0);
        if !clip.is_some_and(|clip| clip.clip.morph_weights(binding.joint, time, sampled)) {
            continue;
        }
        told = true;
        for (below, above) in weights.iter_mut().zip(&*sampled) {
            *below += share * if action.config.additive { *above } else { above - *below };
        }
    }
    let shut = blinks * blink.shut(&asset.file.blink);
    for bind in asset.blink_targets.iter().filter(|bind| bind.mesh == mesh && shut > 0.0) {
        if let Some(weight) = weights.get_mut(bind.target) {
            told = true;
            *weight = weight.max(shut * bind.weight);
        }
    }
    told
}

/// How far an action takes part in the face.
fn reach(action: &CharacterAction, asset: &CharacterAsset) -> f32 {
    asset.humanoid.get(HumanoidRole::Head).map_or(1.0, |head| action.mask.share(head))
}
