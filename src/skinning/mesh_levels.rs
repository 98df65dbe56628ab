//! Meshes with fewer triangles for those who are seen small.
//!
//! Made once for each mesh, in the background, when the first [`ScreenDetail`] is drawn with it. Which of them someone is drawn with
//! follows its size on the screen and how far off each is: [`DetailLevels::mesh_error`](super::DetailLevels::mesh_error).

use std::sync::Arc;

use bevy::{
    platform::collections::{HashMap, hash_map::Entry},
    prelude::*,
    tasks::{AsyncComputeTaskPool, Task, block_on, poll_once},
};

use super::{
    bounds::SlotBox,
    detail::ScreenDetail,
    mesh::positions,
    model::{ModelPart, ModelParts, SkinnedModel},
    palette::SkinnedMeshes,
    simplify::{SHARES, Simplified, simplified},
};
use crate::rig::Rig;

/// Meshes of one, the whole one and simplified ones.
const LEVELS: usize = SHARES.len() + 1;

/// Comes onto a character with a [`ScreenDetail`] once simplified meshes of its model are there: which of them it is drawn with.
#[derive(Component, Clone, Debug)]
pub struct MeshLevels {
    /// How far each is off, as a share of the model's largest side: none for the whole mesh, then more and more.
    errors: [f32; LEVELS],
    level: usize,
    /// Entities that are drawn, and what with.
    meshes: Vec<(Entity, Arc<Made>)>,
}

impl MeshLevels {
    /// Which meshes it is drawn with: 0 is the whole ones, the last those with the fewest triangles.
    #[must_use]
    pub fn level(&self) -> usize {
        self.level
    }

    /// How far the meshes of each level are off, as a share of the model's largest side.
    #[must_use]
    pub fn errors(&self) -> &[f32] {
        &self.errors
    }

    /// The level for a character of this size on the screen, where no more than `error` shall be seen of it; both are shares of the
    /// view's height. Finer ones are taken once it is more than that by a share of `hysteresis`.
    pub(super) fn wanted(&self, size: f32, error: f32, hysteresis: f32) -> usize {
        let seen = |level: usize| self.errors[level] * size;
        let coarsest = (0..LEVELS).rev().find(|level| seen(*level) <= error).unwrap_or(0);
        if coarsest < self.level && seen(self.level) * (1.0 - hysteresis) <= error { self.level } else { coarsest }
    }

    pub(super) fn set(&mut self, level: usize) {
        self.level = level.min(LEVELS - 1);
    }
}

/// What was made of one mesh.
#[derive(Debug)]
struct Made {
    meshes: [Handle<Mesh>; LEVELS],
    /// How far each is off, in the mesh's space.
    errors: [f32; LEVELS],
    bounds: SlotBox,
}

/// Simplified meshes, by their whole one.
#[derive(Resource, Default)]
struct Simpler(HashMap<AssetId<Mesh>, Making>);

enum Making {
    Underway(Task<[Option<Simplified>; SHARES.len()]>),
    Done(Arc<Made>),
}

/// Draws those who are seen small with fewer triangles.
pub(super) fn plugin(app: &mut App) {
    app.init_resource::<Simpler>()
        .add_systems(Update, (forget_removed, prepare).chain().run_if(resource_exists::<Assets<Rig>>))
        .add_systems(PostUpdate, (restore, exchange).chain().after(super::detail::choose));
}

fn forget_removed(mut events: MessageReader<AssetEvent<Mesh>>, mut simpler: ResMut<Simpler>) {
    for event in events.read() {
        if let AssetEvent::Removed { id } | AssetEvent::Modified { id } = event {
            simpler.0.remove(id);
        }
    }
}

/// Characters whose meshes aren't known yet, or were built again.
type Fresh = (With<ScreenDetail>, Or<(Without<MeshLevels>, Changed<ModelParts>)>);

fn prepare(
    mut commands: Commands,
    mut simpler: ResMut<Simpler>,
    mut meshes: ResMut<Assets<Mesh>>,
    rigs: Res<Assets<Rig>>,
    characters: Query<(Entity, &SkinnedModel, &ModelParts, Option<&MeshLevels>), Fresh>,
    parts: Query<(&ModelPart, &SkinnedMeshes)>,
    drawn: Query<&Mesh3d>,
) {
    for (character, model, model_parts, old) in &characters {
        if let Some(old) = old {
            // Its parts have changed: whole meshes first, from which levels are made anew.
            for (entity, made) in &old.meshes {
                if let Ok(mut drawn) = commands.get_entity(*entity) {
                    drawn.try_insert(Mesh3d(made.meshes[0].clone()));
                }
            }
            commands.entity(character).remove::<MeshLevels>();
            continue;
        }
        let Some(rig) = rigs.get(&model.rig) else { continue };
        let mut made = Vec::new();
        let mut waits = false;
        for (part, part_meshes) in parts.iter_many(model_parts.iter()) {
            for entity in part_meshes.iter() {
                let Ok(Mesh3d(mesh)) = drawn.get(entity) else { continue };
                match simpler.of(mesh, || homes(*part, rig), &mut meshes) {
                    Some(done) => made.push((entity, done)),
                    None => waits = true,
                }
            }
        }
        if !waits {
            commands.entity(character).insert(MeshLevels { errors: errors(&made), level: 0, meshes: made });
        }
    }
}

/// Where the joint of each slot is when bound, in the mesh's space.
fn homes(part: ModelPart, rig: &Rig) -> Vec<Vec3> {
    let ModelPart::Skin(skin) = part else { return Vec::new() };
    let binds = rig.skins.get(skin).map_or(&[][..], |skin| &skin.inverse_bind);
    binds.iter().map(|bind| bind.inverse().translation()).collect()
}

/// How far each level is off, as a share of the largest side of all that is drawn.
fn errors(made: &[(Entity, Arc<Made>)]) -> [f32; LEVELS] {
    let mut bounds = SlotBox::EMPTY;
    made.iter().for_each(|(_, made)| bounds.unite(made.bounds));
    let side = (bounds.max - bounds.min).max_element();
    let mut largest = 0.0f32;
    core::array::from_fn(|level| {
        largest = made.iter().map(|(_, made)| made.errors[level]).fold(largest, f32::max);
        if side > 0.0 { largest / side } else { 0.0 }
    })
}

impl Simpler {
    /// What was made of `mesh`; `None` while that is under way. `homes` as for [`simplified`].
    fn of(
        &mut self,
        mesh: &Handle<Mesh>,
        homes: impl FnOnce() -> Vec<Vec3>,
        meshes: &mut Assets<Mesh>,
    ) -> Option<Arc<Made>> {
        let making = match self.0.entry(mesh.id()) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let (whole, homes) = (meshes.get(mesh)?.clone(), homes());
                let pool = AsyncComputeTaskPool::get();
                entry.insert(Making::Underway(
                    pool.spawn(async move { SHARES.map(|share| simplified(&whole, &homes, share)) }),
                ))
            }
        };
        if let Making::Underway(task) = making {
            let results = block_on(poll_once(task))?;
            *making = Making::Done(Arc::new(Made::new(mesh, results, meshes)));
        }
        match making {
            Making::Done(made) => Some(made.clone()),
            Making::Underway(_) => None,
        }
    }
}

impl Made {
    /// Where a level could not be made the one before is drawn in its place.
    fn new(whole: &Handle<Mesh>, results: [Option<Simplified>; SHARES.len()], meshes: &mut Assets<Mesh>) -> Self {
        let bounds = meshes.get(whole).map_or(SlotBox::EMPTY, bounds);
        let mut made = Self { meshes: core::array::from_fn(|_| whole.clone()), errors: [0.0; LEVELS], bounds };
        for (index, result) in results.into_iter().enumerate() {
            let level = index + 1;
            match result {
                Some(Simplified { mesh, error }) => {
                    made.meshes[level] = meshes.add(mesh);
                    made.errors[level] = error.max(made.errors[index]);
                }
                None => {
                    made.meshes[level] = made.meshes[index].clone();
                    made.errors[level] = made.errors[index];
                }
            }
        }
        made
    }
}

fn bounds(mesh: &Mesh) -> SlotBox {
    let mut bounds = SlotBox::EMPTY;
    positions(mesh).into_iter().flatten().for_each(|position| bounds.include(Vec3::from_array(*position)));
    bounds
}
/// Who has no [`ScreenDetail`] any more has all its triangles.
fn restore(
    mut removed: RemovedComponents<ScreenDetail>,
    mut characters: Query<&mut MeshLevels, Without<ScreenDetail>>,
) {
    for character in removed.read() {
        if let Ok(mut levels) = characters.get_mut(character) {
            levels.set(0);
        }
    }
}

/// Draws what levels say.
fn exchange(characters: Query<&MeshLevels, Changed<MeshLevels>>, mut drawn: Query<&mut Mesh3d>) {
    for levels in &characters {
        for (entity, made) in &levels.meshes {
            if let Ok(mut mesh) = drawn.get_mut(*entity) {
                let wanted = &made.meshes[levels.level];
                if mesh.0 != *wanted {
                    mesh.0 = wanted.clone();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coarsest_that_nobody_sees_is_taken_and_kept_a_little_longer() {
        let mut levels = MeshLevels { errors: [0.0, 0.004, 0.01], level: 0, meshes: Vec::new() };
        let sizes = [0.9, 0.26, 0.24, 0.11, 0.09, 0.01];
        assert_eq!(sizes.map(|size| levels.wanted(size, 1e-3, 0.15)), [0, 0, 1, 1, 2, 2], "levels of {sizes:?}");
        assert_eq!(
            sizes.map(|size| levels.wanted(size, 0.0, 0.15)),
            [0; 6],
            "without an error all triangles are drawn"
        );
        levels.set(1);
        let sizes = [0.24, 0.26, 0.29, 0.3];
        assert_eq!(sizes.map(|size| levels.wanted(size, 1e-3, 0.15)), [1, 1, 1, 0], "back only once it is 15 % larger");
    }
}
