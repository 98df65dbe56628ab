//! Morph targets of a character by name: one weight moves every mesh that has a target of that name.

use bevy::{mesh::morph::MeshMorphWeights, prelude::*};

use super::{
    model::{ModelParts, SkinPose},
    palette::SkinnedMeshes,
};
use crate::character::{
    Character,
    animator::{Actions, Blink, MorphScratch, MorphSources, morph_weights},
    bind::CharacterAssets,
    locomotion::Locomotion,
};

/// Morph weights of a character, by name. Comes onto a character when its model is built, if that has morph targets.
///
/// Clips and blinks move them; one that is [set](Self::set) stays as it is until it is [released](Self::release).
#[derive(Component, Clone, Debug, Default)]
pub struct Morphs {
    names: Vec<String>,
    weights: Vec<f32>,
    rest: Vec<f32>,
    /// Whether it was set and not yet released.
    held: Vec<bool>,
    /// For each mesh of the rig that has targets: its place in `Rig::meshes`, and for each target the index above.
    meshes: Vec<(usize, Vec<usize>)>,
}

/// Goes on a mesh: for each of its targets the index in the character's [`Morphs`].
#[derive(Component, Clone, Debug)]
pub struct MorphSlots(Vec<usize>);

impl Morphs {
    /// Names of all targets.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Whether there is no target.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The weight of the target `name`: 0 at rest, 1 in full.
    #[must_use]
    pub fn weight(&self, name: &str) -> Option<f32> {
        self.find(name).map(|at| self.weights[at])
    }

    /// Sets the weight of the target `name`, whatever clips say; `false` if there is none. A weight that is not finite counts
    /// as 0.
    pub fn set(&mut self, name: &str, weight: f32) -> bool {
        let found = self.find(name);
        if let Some(at) = found {
            self.weights[at] = if weight.is_finite() { weight } else { 0.0 };
            self.held[at] = true;
        }
        found.is_some()
    }

    /// Gives the target `name` back to the clips; `false` if there is none.
    pub fn release(&mut self, name: &str) -> bool {
        let found = self.find(name);
        if let Some(at) = found {
            self.held[at] = false;
        }
        found.is_some()
    }

    /// Gives all targets back to the clips.
    pub fn release_all(&mut self) {
        self.held.fill(false);
    }

    /// Adds the targets, by name and weight at rest, of a mesh that is at `binding` in the rig's list; returns what goes on
    /// the mesh.
    pub(super) fn join(&mut self, binding: usize, targets: Vec<(String, f32)>) -> (MorphSlots, MeshMorphWeights) {
        let weights = targets.iter().map(|(_, weight)| *weight).collect();
        let slots = targets.into_iter().map(|(name, weight)| {
            self.find(&name).unwrap_or_else(|| {
                self.names.push(name);
                self.weights.push(weight);
                self.rest.push(weight);
                self.held.push(false);
                self.names.len() - 1
            })
        });
        let slots: Vec<usize> = slots.collect();
        if self.meshes.iter().all(|mesh| mesh.0 != binding) {
            self.meshes.push((binding, slots.clone()));
        }
        (MorphSlots(slots), MeshMorphWeights::Value { weights })
    }

    /// Takes what clips say where nothing is held; whether that changed anything.
    fn follow(&mut self, wanted: &[f32]) -> bool {
        let mut changed = false;
        let free = self.weights.iter_mut().zip(wanted).zip(&self.held).filter(|(_, held)| !**held);
        for ((weight, wanted), _) in free {
            changed |= weight.to_bits() != wanted.to_bits();
            *weight = *wanted;
        }
        changed
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
    }
}

/// Clips and blinks → weights, for characters that are not posed by hand.
pub(super) fn follow_clips(
    assets: CharacterAssets,
    mut characters: Query<(&Character, &Locomotion, &Actions, &Blink, &mut Morphs), Without<SkinPose>>,
    mut scratch: Local<MorphScratch>,
    mut wanted: Local<Vec<f32>>,
) {
    for (character, locomotion, actions, blink, mut morphs) in &mut characters {
        let Some(asset) = assets.get(character) else { continue };
        wanted.clone_from(&morphs.rest);
        let sources = MorphSources { asset, locomotion, actions, blink };
        for (mesh, slots) in &morphs.meshes {
            if morph_weights(&sources, *mesh, &mut scratch) {
                slots.iter().zip(&scratch.weights).for_each(|(slot, weight)| wanted[*slot] = *weight);
            }
        }
        if morphs.bypass_change_detection().follow(&wanted) {
            morphs.set_changed();
        }
    }
}

pub(super) fn apply_morphs(
    characters: Query<(&Morphs, &ModelParts), Or<(Changed<Morphs>, Changed<ModelParts>)>>,
    parts: Query<&SkinnedMeshes>,
    mut meshes: Query<(&MorphSlots, &mut MeshMorphWeights)>,
) {
    for (morphs, model_parts) in &characters {
        for mesh in parts.iter_many(model_parts.iter()).flat_map(SkinnedMeshes::iter) {
            let Ok((slots, mut target)) = meshes.get_mut(mesh) else { continue };
            if let MeshMorphWeights::Value { weights } = &mut *target {
                for (weight, slot) in weights.iter_mut().zip(&slots.0) {
                    *weight = morphs.weights.get(*slot).copied().unwrap_or(0.0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_weight_moves_every_mesh_with_a_target_of_that_name() {
        let mut morphs = Morphs::default();
        let (face, _) = morphs.join(0, vec![("blink".into(), 0.0), ("smile".into(), 0.5)]);
        let (lashes, weights) = morphs.join(1, vec![("blink".into(), 0.0)]);
        assert!(morphs.set("blink", 0.7), "both meshes have it");
        assert!(!morphs.set("frown", 1.0), "nobody has it");
        let mut app = App::new();
        app.add_systems(Update, apply_morphs);
        let world = app.world_mut();
        let character = world.spawn(morphs).id();
        let part = world.spawn(super::super::model::PartOf(character)).id();
        let skinned = super::super::palette::SkinnedBy(part);
        let first = world.spawn((skinned, face, MeshMorphWeights::Value { weights: vec![0.0; 2] })).id();
        let second = world.spawn((skinned, lashes, weights)).id();
        app.update();
        let weights = |mesh| match app.world().get::<MeshMorphWeights>(mesh) {
            Some(MeshMorphWeights::Value { weights }) => weights.clone(),
            other => panic!("{other:?}"),
        };
        assert!(
            (weights(first)[0] - 0.7).abs() < 1e-6 && (weights(first)[1] - 0.5).abs() < 1e-6,
            "{:?}",
            weights(first)
        );
        assert!((weights(second)[0] - 0.7).abs() < 1e-6, "{:?}", weights(second));
    }

    #[test]
    fn clips_move_what_is_not_held() {
        let mut morphs = Morphs::default();
        morphs.join(0, vec![("blink".into(), 0.0), ("smile".into(), 0.5)]);
        assert!(morphs.set("smile", 0.9), "it can smile");
        assert!(morphs.follow(&[0.4, 0.2]) && !morphs.follow(&[0.4, 0.2]), "only a change is one");
        assert_eq!(["blink", "smile"].map(|name| morphs.weight(name)), [Some(0.4), Some(0.9)]);
        assert!(morphs.release("smile") && !morphs.release("frown"), "only what is there is released");
        assert!(morphs.follow(&[0.4, 0.2]));
        assert_eq!(morphs.weight("smile"), Some(0.2), "released it goes with the clip");
    }
}
