//! Morph targets of a character by name, and expressions made of them: one weight moves every mesh that has a target of that
//! name.

use bevy::{mesh::morph::MeshMorphWeights, prelude::*};

use super::{
    model::{ModelParts, SkinPose},
    palette::SkinnedMeshes,
};
use crate::{
    character::{
        Character,
        animator::{Actions, Blink, MorphScratch, MorphSources, morph_weights},
        bind::CharacterAssets,
        locomotion::Locomotion,
    },
    rig::expressions::{Expression, ExpressionBind},
};

/// Morph weights of a character, by name. Comes onto a character when its model is built, if that has morph targets.
///
/// Clips and blinks move them; one that is [set](Self::set) stays as it is until it is [released](Self::release). Expressions
/// that a model brings, VRM ones, are added to what clips and blinks say where they are [shown](Self::express).
#[derive(Component, Clone, Debug, Default)]
pub struct Morphs {
    names: Vec<String>,
    weights: Vec<f32>,
    rest: Vec<f32>,
    /// Whether it was set and not yet released.
    held: Vec<bool>,
    /// For each mesh of the rig that has targets: its place in `Rig::meshes`, and for each target the index above.
    meshes: Vec<(usize, Vec<usize>)>,
    expressions: Vec<Shown>,
    /// For each target what expressions add to its weight.
    added: Vec<f32>,
    /// Share of blinks that expressions take away.
    no_blinks: f32,
}

/// An expression, and how far it is shown.
#[derive(Clone, Debug)]
struct Shown {
    expression: Expression,
    weight: f32,
    /// Targets, by the index above, and their weights in full.
    targets: Vec<(usize, f32)>,
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
        self.find(name).map(|at| self.shown(at))
    }

    /// Names of the expressions that the model brings.
    pub fn expressions(&self) -> impl Iterator<Item = &str> {
        self.expressions.iter().map(|shown| shown.expression.name.as_str())
    }

    /// How far the expression `name` is shown.
    #[must_use]
    pub fn expression(&self, name: &str) -> Option<f32> {
        self.expressions.iter().find(|shown| shown.expression.name == name).map(|shown| shown.weight)
    }

    /// Shows the expression `name`, `happy`: 0 not at all, 1 in full; `false` if there is none. A weight that is not finite
    /// counts as 0.
    ///
    /// Expressions add to each other, to clips and to blinks, up to a target's full weight; those that the model says to keep
    /// blinks or mouths away do. Targets that are [set](Self::set) stay as they are.
    pub fn express(&mut self, name: &str, weight: f32) -> bool {
        let Some(shown) = self.expressions.iter_mut().find(|shown| shown.expression.name == name) else { return false };
        let weight = if weight.is_finite() { weight.clamp(0.0, 1.0) } else { 0.0 };
        if shown.weight.to_bits() != weight.to_bits() {
            shown.weight = weight;
            self.add_expressions();
        }
        true
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

    /// Gives all targets back to the clips, and ends all expressions.
    pub fn release_all(&mut self) {
        self.held.fill(false);
        self.expressions.iter_mut().for_each(|shown| shown.weight = 0.0);
        self.add_expressions();
    }

    /// Learns the rig's expressions, once all its meshes have joined.
    pub(super) fn learn(&mut self, expressions: &[Expression]) {
        let targets = |expression: &Expression| {
            let of = |bind: &ExpressionBind| {
                let slots = &self.meshes.iter().find(|mesh| mesh.0 == bind.mesh)?.1;
                Some((*slots.get(bind.target)?, bind.weight))
            };
            // Meshes that share a target by name are moved by one weight.
            let mut targets: Vec<(usize, f32)> = Vec::new();
            for (slot, weight) in expression.binds.iter().filter_map(of) {
                match targets.iter_mut().find(|target| target.0 == slot) {
                    Some(target) => target.1 = target.1.max(weight),
                    None => targets.push((slot, weight)),
                }
            }
            targets
        };
        let shown = |it: &Expression| Shown { expression: it.clone(), weight: 0.0, targets: targets(it) };
        self.expressions = expressions.iter().map(shown).collect();
        self.added = vec![0.0; self.names.len()];
    }

    /// Finds what expressions add.
    fn add_expressions(&mut self) {
        let (mut no_blinks, mut no_mouths) = (0.0f32, 0.0f32);
        for Shown { expression, weight, .. } in &self.expressions {
            let strength = expression.strength(*weight);
            if !expression.blinks() {
                no_blinks = no_blinks.max(expression.blink.taken(strength));
            }
            if !expression.speaks() {
                no_mouths = no_mouths.max(expression.mouth.taken(strength));
            }
        }
        self.no_blinks = no_blinks;
        self.added.fill(0.0);
        for Shown { expression, weight, targets } in &self.expressions {
            let taken = match (expression.blinks(), expression.speaks()) {
                (true, _) => no_blinks,
                (_, true) => no_mouths,
                _ => 0.0,
            };
            let strength = expression.strength(*weight) * (1.0 - taken);
            targets.iter().for_each(|(slot, full)| self.added[*slot] += strength * full);
        }
    }

    /// The weight of a target as it is shown.
    fn shown(&self, target: usize) -> f32 {
        let own = self.weights[target];
        match self.added.get(target) {
            // A clip may exaggerate; expressions don't.
            Some(&added) if added > 0.0 && !self.held[target] => (own + added).min(own.max(1.0)),
            _ => own,
        }
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
        let sources = MorphSources { asset, locomotion, actions, blink, blinks: 1.0 - morphs.no_blinks };
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
                    *weight = if *slot < morphs.weights.len() { morphs.shown(*slot) } else { 0.0 };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::expressions::Override;

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

    /// Two meshes with a target in common, and expressions of them.
    fn with_expressions(expressions: &[(&str, Override, &[(usize, usize, f32)])]) -> Morphs {
        let mut morphs = Morphs::default();
        morphs.join(3, vec![("lids".into(), 0.0), ("smile".into(), 0.0)]);
        morphs.join(5, vec![("lids".into(), 0.0)]);
        let of = |(name, blink, binds): &(&str, Override, &[(usize, usize, f32)])| Expression {
            name: (*name).to_owned(),
            binds: binds.iter().map(|&(mesh, target, weight)| ExpressionBind { mesh, target, weight }).collect(),
            blink: *blink,
            ..Expression::default()
        };
        morphs.learn(&expressions.iter().map(of).collect::<Vec<_>>());
        morphs
    }

    #[test]
    fn expressions_add_to_clips_up_to_the_full_weight() {
        let mut morphs = with_expressions(&[
            ("happy", Override::None, &[(3, 0, 0.5), (5, 0, 0.5), (3, 1, 1.0), (9, 0, 1.0), (3, 7, 1.0)]),
            ("blink", Override::None, &[(3, 0, 1.0), (5, 0, 1.0)]),
        ]);
        assert_eq!(morphs.expressions().collect::<Vec<_>>(), ["happy", "blink"]);
        assert!(!morphs.express("joy", 1.0) && morphs.expression("joy").is_none(), "nobody knows it");
        assert!(morphs.express("happy", 0.5));
        let percent = |weight: Option<f32>| weight.map(|weight| (weight * 100.0).round() as u32);
        let told = |morphs: &Morphs| ["lids", "smile"].map(|name| percent(morphs.weight(name)).expect("it is there"));
        assert_eq!(told(&morphs), [25, 50]);
        morphs.follow(&[0.5, 0.1]);
        assert_eq!(told(&morphs), [75, 60], "on top of what clips say");
        morphs.express("blink", 1.0);
        assert_eq!(told(&morphs), [100, 60], "no farther than shut");
        morphs.set("lids", 0.1);
        assert_eq!(told(&morphs), [10, 60], "what is set stays");
        morphs.release_all();
        assert_eq!((told(&morphs), percent(morphs.expression("happy"))), ([10, 10], Some(0)));
    }

    #[test]
    fn eyes_that_laugh_shut_no_farther() {
        let mut morphs =
            with_expressions(&[("happy", Override::Blend, &[(3, 0, 0.6)]), ("blink", Override::None, &[(3, 0, 1.0)])]);
        morphs.express("blink", 0.5);
        assert_eq!(morphs.weight("lids"), Some(0.5));
        morphs.express("happy", 1.0);
        assert_eq!((morphs.weight("lids"), morphs.no_blinks), (Some(0.6), 1.0));
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
