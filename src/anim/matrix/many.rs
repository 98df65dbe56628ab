//! What is done to many matrices, by the best instructions of the machine, found out at run time.
//!
//! A matrix is three rows of four numbers, each a register: products add whole rows, so that nothing has to be turned round.

use fearless_simd::{Simd, dispatch, f32x4, prelude::*};

use super::JointMatrix;
use crate::anim::{
    level,
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// Writes `above * local` for each of `joints`, parents first, where `above` is the matrix of its parent, or `model_from_root`.
///
/// The readable form is the product with [`JointTransform::to_affine`].
#[inline]
pub(in crate::anim) fn write_models(
    skeleton: &Skeleton,
    locals: &[JointTransform],
    joints: impl Iterator<Item = usize>,
    models: &mut [JointMatrix],
) {
    let root = JointMatrix::from(skeleton.model_from_root);
    dispatch!(level::best(), simd => models_by(simd, (skeleton.parents(), &root), locals, joints, models));
}

#[inline(always)]
pub(super) fn models_by<S: Simd>(
    simd: S,
    (parents, root): (&[Option<JointIndex>], &JointMatrix),
    locals: &[JointTransform],
    joints: impl Iterator<Item = usize>,
    models: &mut [JointMatrix],
) {
    for joint in joints {
        let above = match parents[joint] {
            Some(parent) => &models[parent.index()],
            None => root,
        };
        models[joint] = product_of_rows(simd, above, &rows(simd, &locals[joint]));
    }
}

/// Writes `model_from_joint * inverse_bind` slot by slot; a joint that there isn't moves nothing.
pub(in crate::anim) fn write_palette(
    models: &[JointMatrix],
    slots: (&[JointIndex], &[JointMatrix]),
    palette: &mut [JointMatrix],
) {
    dispatch!(level::best(), simd => palette_by(simd, models, slots, palette));
}

#[inline(always)]
pub(super) fn palette_by<S: Simd>(
    simd: S,
    models: &[JointMatrix],
    (joints, inverse_bind): (&[JointIndex], &[JointMatrix]),
    palette: &mut [JointMatrix],
) {
    for ((matrix, joint), bind) in palette.iter_mut().zip(joints).zip(inverse_bind) {
        *matrix = match models.get(joint.index()) {
            Some(model) => product(simd, model, bind),
            None => JointMatrix::IDENTITY,
        };
    }
}

/// The same of the matrices that lie `share` (0..=1) of the way between two each, as [`write_between`] writes them.
pub(in crate::anim) fn write_palette_between(
    (from, to, share): (&[JointMatrix], &[JointMatrix], f32),
    slots: (&[JointIndex], &[JointMatrix]),
    palette: &mut [JointMatrix],
) {
    dispatch!(level::best(), simd => palette_between_by(simd, (from, to, share), slots, palette));
}

#[inline(always)]
pub(super) fn palette_between_by<S: Simd>(
    simd: S,
    (from, to, share): (&[JointMatrix], &[JointMatrix], f32),
    (joints, inverse_bind): (&[JointIndex], &[JointMatrix]),
    palette: &mut [JointMatrix],
) {
    let share = f32x4::splat(simd, share);
    for ((matrix, joint), bind) in palette.iter_mut().zip(joints).zip(inverse_bind) {
        *matrix = match (from.get(joint.index()), to.get(joint.index())) {
            (Some(from), Some(to)) => product(simd, &between_of(simd, from, to, share), bind),
            _ => JointMatrix::IDENTITY,
        };
    }
}

/// Writes matrices that lie between two each, `share` (0..=1) of the way: points go from place to place on straight lines, evenly.
pub(crate) fn write_between(from: &[JointMatrix], to: &[JointMatrix], share: f32, between: &mut [JointMatrix]) {
    dispatch!(level::best(), simd => between_by(simd, from, to, share, between));
}

#[inline(always)]
pub(super) fn between_by<S: Simd>(
    simd: S,
    from: &[JointMatrix],
    to: &[JointMatrix],
    share: f32,
    between: &mut [JointMatrix],
) {
    let share = f32x4::splat(simd, share);
    for ((between, from), to) in between.iter_mut().zip(from).zip(to) {
        *between = between_of(simd, from, to, share);
    }
}

#[inline(always)]
fn between_of<S: Simd>(simd: S, from: &JointMatrix, to: &JointMatrix, share: f32x4<S>) -> JointMatrix {
    JointMatrix([
        row_between(simd, from.0[0], to.0[0], share),
        row_between(simd, from.0[1], to.0[1], share),
        row_between(simd, from.0[2], to.0[2], share),
    ])
}

#[inline(always)]
fn row_between<S: Simd>(simd: S, from: [f32; 4], to: [f32; 4], share: f32x4<S>) -> [f32; 4] {
    let (from, to) = (f32x4::simd_from(simd, from), f32x4::simd_from(simd, to));
    (to - from).mul_add(share, from).into()
}

/// Moves matrices `share` (0..=1) of the way to others, as [`write_between`] does.
pub(crate) fn move_toward(from: &mut [JointMatrix], to: &[JointMatrix], share: f32) {
    for (from, to) in from.iter_mut().zip(to) {
        let before = *from;
        write_between(&[before], core::slice::from_ref(to), share, core::slice::from_mut(from));
    }
}

/// One of these.
#[must_use]
pub(in crate::anim) fn between(from: &JointMatrix, to: &JointMatrix, share: f32) -> JointMatrix {
    let mut between = JointMatrix::IDENTITY;
    write_between(core::slice::from_ref(from), core::slice::from_ref(to), share, core::slice::from_mut(&mut between));
    between
}

/// `left * right`.
#[inline(always)]
fn product<S: Simd>(simd: S, left: &JointMatrix, right: &JointMatrix) -> JointMatrix {
    let rows =
        [f32x4::simd_from(simd, right.0[0]), f32x4::simd_from(simd, right.0[1]), f32x4::simd_from(simd, right.0[2])];
    product_of_rows(simd, left, &rows)
}

#[inline(always)]
fn product_of_rows<S: Simd>(simd: S, left: &JointMatrix, rows: &[f32x4<S>; 3]) -> JointMatrix {
    JointMatrix([row(simd, &left.0[0], rows), row(simd, &left.0[1], rows), row(simd, &left.0[2], rows)])
}

/// `left * rows`. Each is multiplied whole, so that nothing has to be turned round.
#[inline(always)]
fn row<S: Simd>(simd: S, left: &[f32; 4], rows: &[f32x4<S>; 3]) -> [f32; 4] {
    let last = f32x4::simd_from(simd, [0.0, 0.0, 0.0, 1.0]);
    let moved = f32x4::splat(simd, left[0]).mul_add(rows[0], f32x4::splat(simd, left[3]) * last);
    let turned = f32x4::splat(simd, left[1]).mul_add(rows[1], f32x4::splat(simd, left[2]) * rows[2]);
    (moved + turned).into()
}

/// Scales, then turns, then moves. A rotation's matrix is the unit matrix and products of its numbers, sorted by rows: each row takes two
/// of the three orders of the quaternion, times one number each.
#[inline(always)]
fn rows<S: Simd>(simd: S, local: &JointTransform) -> [f32x4<S>; 3] {
    let (q, s, t) = (local.rotation, local.scale, local.translation);
    let of = |numbers: [f32; 4]| f32x4::simd_from(simd, numbers);
    let double = of(q.to_array()) + of(q.to_array());
    let [x2, y2, z2, _]: [f32; 4] = double.into();
    let [x2, y2, z2] = [f32x4::splat(simd, x2), f32x4::splat(simd, y2), f32x4::splat(simd, z2)];
    let a = of([q.y, q.x, q.w, q.z]) * of([-1.0, 1.0, 1.0, 0.0]);
    let b = of([q.z, q.w, q.x, q.y]) * of([-1.0, -1.0, 1.0, 0.0]);
    let c = of([q.w, q.z, q.y, q.x]) * of([1.0, -1.0, 1.0, 0.0]);
    let scale = of([s.x, s.y, s.z, 1.0]);
    let x = y2.mul_add(a, z2.mul_add(b, of([1.0, 0.0, 0.0, t.x])));
    let y = z2.mul_add(c, of([0.0, 1.0, 0.0, t.y]) - x2 * a);
    let z = of([0.0, 0.0, 1.0, t.z]) - x2.mul_add(b, y2 * c);
    [x * scale, y * scale, z * scale]
}
