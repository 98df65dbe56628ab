//! A joint's matrix as three rows: as the GPU takes it, and a quarter less to keep and to multiply than four columns.
//!
//! One matrix is handled here, many of them in `many`.

mod many;

use core::ops::Mul;

use bevy::math::{Affine3A, Mat3A, Quat, Vec3, Vec3A, Vec4};
use bytemuck::{Pod, Zeroable};

pub(super) use many::{between, write_models, write_palette, write_palette_between};
pub(crate) use many::{move_toward, write_between};

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
        let [x, y, z] = self.0;
        let axis = |row: [f32; 4]| Vec3A::from_vec4(Vec4::from_array(row));
        Mat3A::from_cols(axis(x), axis(y), axis(z))
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
        if is_rotation(&self.axes_as_columns()) { self.unscaled_rotation() } else { scaled_rotation(&self.to_affine()) }
    }

    /// From the largest of the four squares (Mike Day, "Converting a Rotation Matrix to a Quaternion", Insomniac Games, 2015); how long the
    /// numbers are makes no difference to what is made one long.
    #[inline]
    fn unscaled_rotation(&self) -> Quat {
        let [[xx, xy, xz, _], [yx, yy, yz, _], [zx, zy, zz, _]] = self.0;
        let numbers = if zz <= 0.0 {
            if yy <= xx {
                [1.0 - zz + xx - yy, xy + yx, xz + zx, zy - yz]
            } else {
                [xy + yx, 1.0 - zz + yy - xx, yz + zy, xz - zx]
            }
        } else if xx + yy <= 0.0 {
            [xz + zx, yz + zy, 1.0 + zz - xx - yy, yx - xy]
        } else {
            [zy - yz, xz - zx, yx - xy, 1.0 + zz + xx + yy]
        };
        Quat::from_array(numbers).normalize()
    }

    /// A `rotation` of where it leads as it is where that comes from: `r⁻¹ * rotation * r`, where r is its own rotation.
    #[inline]
    pub(super) fn turn_back(&self, rotation: Quat) -> Quat {
        let rows = self.axes_as_columns();
        if is_rotation(&rows) {
            // The same angle about an axis that is turned back.
            return Quat::from_vec4((rows * rotation.xyz()).extend(rotation.w));
        }
        let own = scaled_rotation(&self.to_affine());
        own.inverse() * rotation * own
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

#[cfg(test)]
mod tests;
