//! What `shaders/skinning.wgsl` reads, byte by byte.

use bevy::math::Affine3A;
use bytemuck::{Pod, Zeroable};

/// The three rows of an affine matrix: 48 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct JointMatrix(pub [[f32; 4]; 3]);

impl JointMatrix {
    /// Moves nothing.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
}

impl From<Affine3A> for JointMatrix {
    fn from(matrix: Affine3A) -> Self {
        let (m, t) = (matrix.matrix3.transpose(), matrix.translation);
        Self([m.x_axis.extend(t.x).to_array(), m.y_axis.extend(t.y).to_array(), m.z_axis.extend(t.z).to_array()])
    }
}

/// What a mesh instance is drawn with: `Instance` of `shaders/skinning.wgsl`, 32 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct InstanceRecord {
    /// Where its matrices begin.
    pub first: u32,
    /// How many it has, at least 1.
    pub count: u32,
    pub(super) padding: [u32; 2],
    /// Linear RGBA that multiplies the base colour.
    pub tint: [f32; 4],
}

impl InstanceRecord {
    /// The identity matrix and no tint: what a mesh without a palette is drawn with.
    pub const PLAIN: Self = Self { first: 0, count: 1, padding: [0; 2], tint: [1.0; 4] };
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::{Quat, Vec3};

    #[test]
    fn a_row_matrix_moves_a_point_as_its_affine_does() {
        let affine = Affine3A::from_scale_rotation_translation(
            Vec3::new(1.0, 2.0, 0.5),
            Quat::from_scaled_axis(Vec3::new(0.3, -1.0, 0.7)),
            Vec3::new(4.0, 5.0, 6.0),
        );
        let point = Vec3::new(-1.0, 0.4, 2.0);
        let rows = JointMatrix::from(affine).0.map(bevy::math::Vec4::from);
        let moved = Vec3::from_array(rows.map(|row| row.dot(point.extend(1.0))));
        assert!(moved.distance(affine.transform_point3(point)) < 1e-5, "{moved}");
    }
}
