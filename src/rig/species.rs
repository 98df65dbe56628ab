//! A character's clips in rows: for itself, and for blocks one [`Species`] for each skin, with and without its small joints.

use std::sync::Arc;

use super::{character::CharacterAsset, small_joints::SmallJoints, trunk::chains};
use crate::anim::{
    block::{ClipSet, Precision, RowSource, Species, SpeciesParts},
    skeleton::{JointIndex, Skeleton},
};

/// Kinds of a character by skin.
#[derive(Clone, Debug, Default)]
pub(super) struct AllSpecies {
    whole: Vec<Option<Arc<Species>>>,
    /// With their small joints held.
    held: Vec<Option<Arc<Species>>>,
}

impl CharacterAsset {
    /// Skeleton, skin and clips for [blocks](crate::anim::block), by index of the skin; clips are those of
    /// [`clips`](Self::clips). Without `small_joints` those are [held](CharacterAsset::small_joints) in all of them. `None` where a
    /// clip keeps keys, and where a mesh rides on a joint without a skin.
    #[must_use]
    pub fn species(&self, skin: usize, small_joints: bool) -> Option<&Species> {
        let AllSpecies { whole, held } = &self.species;
        (if small_joints { whole } else { held }).get(skin)?.as_deref()
    }

    /// Whether blocks can pose all that is drawn of it.
    #[must_use]
    pub fn has_species(&self) -> bool {
        !self.species.whole.is_empty() && self.species.whole.iter().all(Option::is_some)
    }

    /// Brings all clips into rows.
    pub(super) fn make_rows(&mut self) {
        let above_feet = chains(&self.skeleton, self.legs.iter().map(|leg| leg.foot));
        self.rows = Arc::new(ClipSet::new(&self.skeleton, self.clips().iter().map(|clip| &*clip.clip), above_feet));
        let first_state = self.file.locomotion.states().first().and_then(|state| state.clips().next());
        let stands = first_state.and_then(|name| self.clip(name)).map(|clip| &*clip.clip);
        self.small_joints = Arc::new(SmallJoints::new(&self.skeleton, &self.humanoid, stands));
        self.species = self.make_species();
    }

    fn make_species(&self) -> AllSpecies {
        if self.rig.meshes.iter().any(|mesh| mesh.skin.is_none()) {
            return AllSpecies::default();
        }
        let whole = self.species_of(&self.skeleton, &[]);
        let small = self.small_joints.joints();
        if small.is_empty() {
            return AllSpecies { held: whole.clone(), whole };
        }
        let held = self.skeleton.with_rest(|rest| self.small_joints.hold(rest));
        AllSpecies { whole, held: self.species_of(&held, small) }
    }

    fn species_of(&self, skeleton: &Skeleton, still: &[JointIndex]) -> Vec<Option<Arc<Species>>> {
        let source = |clip| RowSource { still, ..RowSource::new(clip, Precision::Float) };
        let clips: Vec<_> = self.clips().iter().map(|clip| source(&clip.clip)).collect();
        let species = |skin| {
            let parts = SpeciesParts { skeleton, skin, limbs: &[], clips: &clips, masks: &[] };
            Species::new(&parts).ok().map(Arc::new)
        };
        self.rig.skins.iter().map(species).collect()
    }
}
