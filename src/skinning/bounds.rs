//! Culling boxes that follow the pose.
//!
//! Each palette slot has the box of the vertices it moves (the mesh's space, metres). Moved by the palette and united
//! they hold every blended vertex, because a blend lies between the points it blends. Writes `Aabb` in model space.

use std::sync::Arc;

use bevy::{camera::primitives::Aabb, math::Vec4, prelude::*};

use super::{
    arena::SkinArena,
    layout::JointMatrix,
    palette::{Palette, SkinnedMeshes},
};

/// Every change of an `Aabb` makes the engine look at its mesh anew; this share of the largest side is spare room
/// on each side, so that a walk changes it about never.
const SPARE: f32 = 0.15;

/// A box that may be empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotBox {
    /// Lowest corner.
    pub min: Vec3,
    /// Highest corner.
    pub max: Vec3,
}

impl SlotBox {
    /// Holds nothing.
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// Whether it holds nothing.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// Grows to hold `point`.
    pub fn include(&mut self, point: Vec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// Grows to hold `other`.
    pub fn unite(&mut self, other: Self) {
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
    }

    /// Whether all of `other` is inside.
    #[must_use]
    pub fn holds(&self, other: &Self) -> bool {
        self.min.cmple(other.min).all() && self.max.cmpge(other.max).all()
    }

    fn grown(self, by: f32) -> Self {
        Self { min: self.min - by, max: self.max + by }
    }

    fn moved(&self, matrix: &JointMatrix) -> Self {
        let (center, half) = ((self.min + self.max) * 0.5, (self.max - self.min) * 0.5);
        let rows = matrix.0.map(Vec4::from);
        let center = Vec3::from_array(rows.map(|row| row.dot(center.extend(1.0))));
        let half = Vec3::from_array(rows.map(|row| row.truncate().abs().dot(half)));
        Self { min: center - half, max: center + half }
    }
}

/// The box of everything that a palette moves.
#[must_use]
pub fn posed_box(palette: &[JointMatrix], slots: &[SlotBox]) -> SlotBox {
    let mut posed = SlotBox::EMPTY;
    for (matrix, slot) in palette.iter().zip(slots).filter(|(_, slot)| !slot.is_empty()) {
        posed.unite(slot.moved(matrix));
    }
    posed
}

/// Goes beside a [`Palette`]: the meshes it moves get an `Aabb` that follows the pose. Without it they are never culled.
#[derive(Component, Clone, Debug)]
pub struct PoseBounds {
    slots: Arc<[SlotBox]>,
    fitted: SlotBox,
}

impl PoseBounds {
    /// From the box of each slot, as [`slot_boxes`](super::mesh::slot_boxes) gives them.
    #[must_use]
    pub fn new(slots: Arc<[SlotBox]>) -> Self {
        Self { slots, fitted: SlotBox::EMPTY }
    }

    /// The box in use, in model space, with its spare room.
    #[must_use]
    pub fn fitted(&self) -> SlotBox {
        self.fitted
    }

    /// Whether the pose has left the box in use, or fills too little of it; the box is then made anew.
    fn refit(&mut self, palette: &[JointMatrix]) -> bool {
        let posed = posed_box(palette, &self.slots);
        if posed.is_empty() || !(posed.min.is_finite() && posed.max.is_finite()) {
            return false;
        }
        let spare = SPARE * (posed.max - posed.min).max_element();
        if self.fitted.holds(&posed) && posed.grown(3.0 * spare).holds(&self.fitted) {
            return false;
        }
        self.fitted = posed.grown(spare);
        true
    }
}

pub(super) fn fit(arena: Res<SkinArena>, mut bounds: Query<(&Palette, &mut PoseBounds)>) {
    bounds.par_iter_mut().for_each(|(palette, mut bounds)| {
        if bounds.bypass_change_detection().refit(arena.matrices(palette.range())) {
            bounds.set_changed();
        }
    });
}

pub(super) fn apply(
    mut commands: Commands,
    owners: Query<(&PoseBounds, &SkinnedMeshes), Or<(Changed<PoseBounds>, Changed<SkinnedMeshes>)>>,
    mut boxes: Query<&mut Aabb>,
) {
    for (bounds, meshes) in owners.iter().filter(|(bounds, _)| !bounds.fitted.is_empty()) {
        let fitted = Aabb::from_min_max(bounds.fitted.min, bounds.fitted.max);
        for mesh in meshes.iter() {
            if let Ok(mut mesh_box) = boxes.get_mut(mesh) {
                mesh_box.set_if_neq(fitted);
            } else {
                commands.entity(mesh).try_insert(fitted);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::{Affine3A, Quat};
    use proptest::prelude::*;

    fn unit_box() -> SlotBox {
        SlotBox { min: Vec3::ZERO, max: Vec3::ONE }
    }

    proptest! {
        #[test]
        fn a_blended_vertex_is_inside(
            turns in prop::array::uniform2(prop::array::uniform3(-3.0f32..3.0)),
            moves in prop::array::uniform2(prop::array::uniform3(-3.0f32..3.0)),
            vertex in prop::array::uniform3(0.0f32..1.0), weight in 0.0f32..1.0,
        ) {
            let affines = [0, 1].map(|i| {
                Affine3A::from_rotation_translation(Quat::from_scaled_axis(turns[i].into()), moves[i].into())
            });
            let posed = posed_box(&affines.map(JointMatrix::from), &[unit_box(), unit_box()]);
            let [a, b] = affines.map(|affine| affine.transform_point3(vertex.into()));
            let blended = a.lerp(b, weight);
            let spare = posed.grown(1e-4);
            prop_assert!(spare.holds(&SlotBox { min: blended, max: blended }), "{blended} is outside {posed:?}");
        }
    }

    #[test]
    fn a_small_sway_keeps_the_box_and_a_leap_changes_it() {
        let mut bounds = PoseBounds::new([unit_box()].into());
        let at = |x: f32| [JointMatrix::from(Affine3A::from_translation(Vec3::X * x))];
        assert!(bounds.refit(&at(0.0)), "the first pose gives the first box");
        assert!(!bounds.refit(&at(0.1)), "10 cm stay within {:?}", bounds.fitted);
        assert!(bounds.refit(&at(0.5)), "50 cm leave {:?}", bounds.fitted);
        assert!(!bounds.refit(&[JointMatrix([[f32::NAN; 4]; 3])]), "NaN changes nothing");
    }

    #[test]
    fn a_slot_that_moves_nothing_has_no_part() {
        let far = JointMatrix::from(Affine3A::from_translation(Vec3::splat(100.0)));
        let posed = posed_box(&[JointMatrix::IDENTITY, far], &[unit_box(), SlotBox::EMPTY]);
        assert_eq!(posed, unit_box());
    }
}
