//! The ground's collider: a heightfield shape on the very triangles of [`Heightfield`].

use avian3d::{
    parry::{math::Vector, shape::SharedShape, utils::Array2},
    prelude::Collider,
};

use super::Heightfield;

/// The collider of `field`, in world space: its entity stands at the origin, unturned and unscaled.
///
/// `Collider::heightfield` of avian 0.7 mixes up rows and columns, so the shape is made by hand.
#[must_use]
pub fn collider(field: &Heightfield) -> Collider {
    let side = field.cells() + 1;
    let heights = Array2::new(side, side, field.heights().to_vec());
    SharedShape::heightfield(heights, Vector::new(field.size(), 1.0, field.size())).into()
}
