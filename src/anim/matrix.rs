//! A joint's matrix as three rows: as the GPU takes it, and a quarter less to keep and to multiply than four columns.
//!
//! What is done to many of them uses the best instructions of the machine, found out at run time.

use core::ops::Mul;

use bevy::math::{Affine3A, Mat3A, Quat, Vec3};
use bytemuck::{Pod, Zeroable};
use fearless_simd::{Simd, dispatch, f32x4, prelude::*};

use super::{
    level,
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// The three rows of an affine matrix: 48 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct JointMatrix(pub [[f32; 4]; 3]);

impl Default for JointMatrix {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl From<Affine3A> for JointMatrix {
    #[inline]
    fn from(matrix: Affine3A) -> Self {
        let (m, t) = (matrix.matrix3.transpose(), matrix.translation);
        Self([m.x_axis.extend(t.x).to_array(), m.y_axis.extend(t.y).to_array(), m.z_axis.extend(t.z).to_array()])
    }
}

impl From<JointMatrix> for Affine3A {
    #[inline]
    fn from(matrix: JointMatrix) -> Self {
        Self { matrix3: matrix.axes_as_columns().transpose(), translation: matrix.translation().into() }
    }
}

impl Mul for JointMatrix {
    type Output = Self;

    /// What `other` takes somewhere is taken further by this one.
    #[inline]
    fn mul(self, other: Self) -> Self {
        (self.to_affine() * other.to_affine()).into()
    }
}

impl JointMatrix {
    /// Moves nothing.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);

    /// Where it takes the origin.
    #[must_use]
    #[inline]
    pub fn translation(&self) -> Vec3 {
        let [x, y, z] = &self.0;
        Vec3::new(x[3], y[3], z[3])
    }

    /// Moves where it takes everything by `offset`.
    #[inline]
    pub(crate) fn shift(&mut self, offset: Vec3) {
        let [x, y, z] = &mut self.0;
        x[3] += offset.x;
        y[3] += offset.y;
        z[3] += offset.z;
    }

    /// As columns.
    #[must_use]
    #[inline]
    pub fn to_affine(self) -> Affine3A {
        self.into()
    }

    /// What takes everything back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        self.to_affine().inverse().into()
    }

    /// Whether all of its numbers are.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.0.as_flattened().iter().all(|number| number.is_finite())
    }

    /// Where it takes `point`.
    #[must_use]
    #[inline]
    pub fn transform_point3(&self, point: Vec3) -> Vec3 {
        let row = |[x, y, z, w]: [f32; 4]| x * point.x + y * point.y + z * point.z + w;
        let [x, y, z] = self.0;
        Vec3::new(row(x), row(y), row(z))
    }

    /// The rows without the translation, as columns: the axes' matrix, transposed.
    #[inline]
    fn axes_as_columns(&self) -> Mat3A {
        let [x, y, z] = self.0.map(|[x, y, z, _]| Vec3::new(x, y, z).into());
        Mat3A::from_cols(x, y, z)
    }

    /// What it takes to `vector`, which has no place; not finite where an axis is squashed to nothing.
    #[must_use]
    #[inline]
    pub fn inverse_transform_vector3(&self, vector: Vec3) -> Vec3 {
        let rows = self.axes_as_columns();
        if is_rotation(&rows) { rows * vector } else { rows.transpose().inverse() * vector }
    }

    /// Its rotation, scale and mirroring taken out; the identity where an axis is squashed to nothing.
    #[must_use]
    #[inline]
    pub fn rotation(&self) -> Quat {
        let rows = self.axes_as_columns();
        if is_rotation(&rows) {
            // A rotation's transpose turns the other way.
            return Quat::from_mat3a(&rows).conjugate().normalize();
        }
        scaled_rotation(&self.to_affine())
    }
}

/// Difference from 1 of the square of an axis' length up to which it counts as unscaled: rounding of a long chain.
const UNSCALED: f32 = 1e-4;

/// Whether neither scale nor mirroring is in it, told by its rows.
#[inline]
fn is_rotation(rows: &Mat3A) -> bool {
    let unscaled = [rows.x_axis, rows.y_axis, rows.z_axis].map(|axis| (axis.length_squared() - 1.0).abs() < UNSCALED);
    unscaled == [true; 3] && rows.x_axis.cross(rows.y_axis).dot(rows.z_axis) > 0.0
}

#[cold]
fn scaled_rotation(matrix: &Affine3A) -> Quat {
    let rotation = matrix.to_scale_rotation_translation().1;
    if rotation.is_finite() && rotation.length_squared() > 0.5 { rotation } else { Quat::IDENTITY }
}

/// Writes `above * local` for each of `joints`, parents first, where `above` is the matrix of its parent, or `model_from_root`.
///
/// The readable form is the product with [`JointTransform::to_affine`].
#[inline]
pub(super) fn write_models(
    skeleton: &Skeleton,
    locals: &[JointTransform],
    joints: impl Iterator<Item = usize>,
    models: &mut [JointMatrix],
) {
    let root = JointMatrix::from(skeleton.model_from_root);
    dispatch!(level::best(), simd => models_by(simd, (skeleton.parents(), &root), locals, joints, models));
}

#[inline(always)]
fn models_by<S: Simd>(
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
pub(super) fn write_palette(
    models: &[JointMatrix],
    slots: (&[JointIndex], &[JointMatrix]),
    palette: &mut [JointMatrix],
) {
    dispatch!(level::best(), simd => palette_by(simd, models, slots, palette));
}

#[inline(always)]
fn palette_by<S: Simd>(
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
pub(super) fn write_palette_between(
    (from, to, share): (&[JointMatrix], &[JointMatrix], f32),
    slots: (&[JointIndex], &[JointMatrix]),
    palette: &mut [JointMatrix],
) {
    dispatch!(level::best(), simd => palette_between_by(simd, (from, to, share), slots, palette));
}

#[inline(always)]
fn palette_between_by<S: Simd>(
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
fn between_by<S: Simd>(simd: S, from: &[JointMatrix], to: &[JointMatrix], share: f32, between: &mut [JointMatrix]) {
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
pub(super) fn between(from: &JointMatrix, to: &JointMatrix, share: f32) -> JointMatrix {
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

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::Level;
    use proptest::prelude::*;

    fn joint() -> impl Strategy<Value = JointTransform> {
        let vector = || prop::array::uniform3(-2.0f32..2.0).prop_map(Vec3::from);
        (vector(), vector(), vector()).prop_map(|(translation, turn, scale)| JointTransform {
            translation,
            rotation: Quat::from_scaled_axis(turn),
            scale,
        })
    }

    fn off(a: &JointMatrix, b: &Affine3A) -> f32 {
        let b = JointMatrix::from(*b);
        a.0.as_flattened().iter().zip(b.0.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    proptest! {
        #[test]
        fn every_instruction_set_multiplies_as_matrices_do(a in joint(), b in joint(), share in 0.0f32..1.0) {
            let (left, right) = (a.to_affine(), b.to_affine());
            let (from, to) = (JointMatrix::from(left), JointMatrix::from(right));
            let parents = [None, Some(JointIndex(0))];
            let half = left.matrix3 + (right.matrix3 - left.matrix3) * share;
            let between = Affine3A {
                matrix3: half,
                translation: left.translation + (right.translation - left.translation) * share,
            };
            for level in [Level::new(), Level::baseline()] {
                let mut models = [JointMatrix::IDENTITY; 2];
                let root = JointMatrix::from(right);
                dispatch!(level, simd => models_by(simd, (&parents, &root), &[a, b], 0..2, &mut models));
                let worst = off(&models[1], &(right * left * right));
                prop_assert!(worst < 1e-4, "a child's matrix is {worst} off with {level:?}");
                let mut palette = [JointMatrix::default(); 2];
                let joints = [JointIndex(0), JointIndex(9)];
                dispatch!(level, simd => palette_by(simd, &[from], (&joints, &[to, to]), &mut palette));
                prop_assert!(off(&palette[0], &(left * right)) < 2e-5, "{level:?}");
                prop_assert_eq!(palette[1], JointMatrix::IDENTITY);
                let slots = (&joints[..], &[to, to][..]);
                dispatch!(level, simd => palette_between_by(simd, (&[from], &[to], share), slots, &mut palette));
                prop_assert!(off(&palette[0], &(between * right)) < 2e-5, "{level:?}");
                prop_assert_eq!(palette[1], JointMatrix::IDENTITY);
                let mut seen = [JointMatrix::default()];
                dispatch!(level, simd => between_by(simd, &[from], &[to], share, &mut seen));
                prop_assert!(off(&seen[0], &between) < 1e-5, "{level:?}");
            }
        }

        #[test]
        fn rows_tell_what_columns_tell(joint in joint()) {
            let affine = joint.to_affine();
            let rows = JointMatrix::from(affine);
            prop_assert_eq!(Affine3A::from(rows), affine);
            prop_assert_eq!(rows.translation(), joint.translation);
            let unscaled = JointTransform { scale: Vec3::ONE, ..joint };
            let angle = JointMatrix::from(unscaled.to_affine()).rotation().angle_between(joint.rotation);
            prop_assert!(angle < 2e-3, "turned {angle} rad off");
            let grown = JointTransform { scale: joint.scale.abs() + 0.1, ..joint };
            let angle = JointMatrix::from(grown.to_affine()).rotation().angle_between(joint.rotation);
            prop_assert!(angle < 2e-3, "turned {angle} rad off where it is scaled");
            for matrix in [rows, JointMatrix::from(unscaled.to_affine()), JointMatrix::from(grown.to_affine())] {
                let back = matrix.inverse_transform_vector3(Vec3::new(0.3, -1.0, 2.0));
                let off = matrix.to_affine().transform_vector3(back).distance(Vec3::new(0.3, -1.0, 2.0));
                prop_assert!(off < 1e-3 || joint.scale.abs().min_element() < 1e-2, "a vector comes back {off} off");
            }
            let point = rows.transform_point3(Vec3::new(0.3, -1.0, 2.0));
            let moved = affine.transform_point3(Vec3::new(0.3, -1.0, 2.0));
            prop_assert!(point.distance(moved) < 1e-4, "a point comes {} off", point.distance(moved));
        }
    }

    #[test]
    fn what_is_squashed_to_nothing_is_not_turned() {
        let flat = JointMatrix::from(Affine3A::from_scale(Vec3::ZERO));
        assert_eq!(flat.rotation(), Quat::IDENTITY);
        let mut moved = flat;
        moved.shift(Vec3::new(1.0, 2.0, 3.0));
        assert_eq!(moved.translation(), Vec3::new(1.0, 2.0, 3.0));
    }
}
