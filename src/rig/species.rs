//! A character's clips in rows: for itself, and for blocks one [`Species`] for each skin.

use std::sync::Arc;

use super::{character::CharacterAsset, trunk::chains};
use crate::anim::block::{ClipSet, Precision, RowSource, Species, SpeciesParts};

impl CharacterAsset {
    /// Skeleton, skin and clips for [blocks](crate::anim::block), by index of the skin; clips are those of
    /// [`clips`](Self::clips). `None` where a clip keeps keys, and where a mesh rides on a joint without a skin.
    #[must_use]
    pub fn species(&self, skin: usize) -> Option<&Species> {
        self.species.get(skin)?.as_deref()
    }

    /// Whether blocks can pose all that is drawn of it.
    #[must_use]
    pub fn has_species(&self) -> bool {
        !self.species.is_empty() && self.species.iter().all(Option::is_some)
    }

    /// Brings all clips into rows.
    pub(super) fn make_rows(&mut self) {
        let above_feet = chains(&self.skeleton, self.legs.iter().map(|leg| leg.foot));
        self.rows = Arc::new(ClipSet::new(&self.skeleton, self.clips().iter().map(|clip| &*clip.clip), above_feet));
        self.species = self.make_species();
    }

    fn make_species(&self) -> Vec<Option<Arc<Species>>> {
        if self.rig.meshes.iter().any(|mesh| mesh.skin.is_none()) {
            return Vec::new();
        }
        let clips: Vec<_> = self.clips().iter().map(|clip| RowSource::new(&clip.clip, Precision::Float)).collect();
        let species = |skin| {
            let parts = SpeciesParts { skeleton: &self.skeleton, skin, limbs: &[], clips: &clips, masks: &[] };
            Species::new(&parts).ok().map(Arc::new)
        };
        self.rig.skins.iter().map(species).collect()
    }
}
