//! Morph targets of a character by name: one weight moves every mesh that has a target of that name.

use bevy::{mesh::morph::MeshMorphWeights, prelude::*};

use super::{model::ModelParts, palette::SkinnedMeshes};

/// Morph weights of a character, by name. Comes onto a character when its model is built, if that has morph targets.
#[derive(Component, Clone, Debug, Default)]
pub struct Morphs {
    names: Vec<String>,
    weights: Vec<f32>,
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

    /// Sets the weight of the target `name`; `false` if there is none. A weight that is not finite counts as 0.
    pub fn set(&mut self, name: &str, weight: f32) -> bool {
        let found = self.find(name);
        if let Some(at) = found {
            self.weights[at] = if weight.is_finite() { weight } else { 0.0 };
        }
        found.is_some()
    }

    /// Adds a mesh's targets, by name and weight at rest; returns what goes on the mesh.
    pub(super) fn join(&mut self, targets: Vec<(String, f32)>) -> (MorphSlots, MeshMorphWeights) {
        let weights = targets.iter().map(|(_, weight)| *weight).collect();
        let slots = targets.into_iter().map(|(name, weight)| {
            self.find(&name).unwrap_or_else(|| {
                self.names.push(name);
                self.weights.push(weight);
                self.names.len() - 1
            })
        });
        (MorphSlots(slots.collect()), MeshMorphWeights::Value { weights })
    }

    fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|n| n == name)
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
        let (face, _) = morphs.join(vec![("blink".into(), 0.0), ("smile".into(), 0.5)]);
        let (lashes, weights) = morphs.join(vec![("blink".into(), 0.0)]);
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
}
