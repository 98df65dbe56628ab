//! What plays → weights of morph targets.

use super::Actions;
use crate::{
    character::locomotion::Locomotion,
    rig::{MeshBinding, actions::CharacterAction, character::CharacterAsset, humanoid::HumanoidRole},
};

/// Buffers of [`morph_weights`].
#[derive(Debug, Default)]
pub struct MorphScratch {
    sampled: Vec<f32>,
    /// The weights found, one a target of the mesh.
    pub weights: Vec<f32>,
}

/// Finds the weights of `mesh`'s targets in what plays; `false` when nothing that plays says anything of them.
///
/// Clips blend by their weights, those that say nothing as the mesh is at rest. Actions lie over them as far as they reach the
/// head: faces go with it. Additive ones add their weights.
pub fn morph_weights(
    asset: &CharacterAsset,
    locomotion: &Locomotion,
    actions: &Actions,
    mesh: &MeshBinding,
    scratch: &mut MorphScratch,
) -> bool {
    let MorphScratch { sampled, weights } = scratch;
    let mut told = false;
    weights.clear();
    weights.resize(mesh.morph_weights.len(), 0.0);
    for playing in locomotion.playing(asset) {
        sampled.clone_from(&mesh.morph_weights);
        told |= playing.clip.clip.morph_weights(mesh.joint, playing.time, sampled);
        weights.iter_mut().zip(&*sampled).for_each(|(sum, weight)| *sum += playing.weight * weight);
    }
    for (action, time, weight) in actions.layers(asset) {
        let share = weight * reach(action, asset);
        sampled.clone_from(&mesh.morph_weights);
        if share <= 0.0 || !action.clip(asset).is_some_and(|clip| clip.clip.morph_weights(mesh.joint, time, sampled)) {
            continue;
        }
        told = true;
        for (below, above) in weights.iter_mut().zip(&*sampled) {
            *below += share * if action.config.additive { *above } else { above - *below };
        }
    }
    told
}

/// How far an action takes part in the face.
fn reach(action: &CharacterAction, asset: &CharacterAsset) -> f32 {
    asset.humanoid.get(HumanoidRole::Head).map_or(1.0, |head| action.mask.share(head))
}
