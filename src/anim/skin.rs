//! Linear blend skinning on the CPU: the readable reference that the GPU is held against.
//!
//! Reads vertices of a mesh (the file's space, metres), writes them in model space. A palette holds
//! `model_from_joint * inverse_bind` per slot, so one product takes a vertex from the mesh to the posed model.

use bevy::math::{Affine3A, Mat3A, Vec3, Vec3A, Vec4};

use super::{
    matrix::{JointMatrix, write_palette, write_palette_between},
    pose::Pose,
    skeleton::JointIndex,
};

/// Sum of the four quantised weights of a vertex.
pub const WEIGHT_ONE: u16 = u16::MAX;

/// Which joints move a mesh, and where they were when it was skinned.
#[derive(Clone, Debug, Default)]
pub struct Skin {
    /// Palette slot → joint of the skeleton.
    pub joints: Vec<JointIndex>,
    /// Palette slot → `joint_from_mesh` of the bind pose.
    pub inverse_bind: Vec<JointMatrix>,
}

impl Skin {
    /// The palette of `pose`, slot by slot: `model_from_joint * inverse_bind`.
    ///
    /// A joint that the pose does not have stays where the mesh was skinned.
    pub fn palette<'a>(&'a self, pose: &'a Pose) -> impl Iterator<Item = Affine3A> + 'a {
        self.joints.iter().zip(&self.inverse_bind).map(|(joint, inverse_bind)| {
            if joint.index() < pose.len() { pose.model(*joint) * inverse_bind.to_affine() } else { Affine3A::IDENTITY }
        })
    }

    /// Writes the same as rows, the way the GPU takes them; as many slots as `out` has room for.
    pub fn write_palette(&self, pose: &Pose, out: &mut [JointMatrix]) {
        let slots = (&self.joints[..], &self.inverse_bind[..]);
        match pose.between() {
            Some((before, share)) => write_palette_between((before, pose.models(), share), slots, out),
            None => write_palette(pose.models(), slots, out),
        }
    }
}

/// Up to four palette slots that move a vertex, and how much each does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influences {
    /// Palette slots.
    pub slots: [u16; 4],
    /// Shares of [`WEIGHT_ONE`]; their sum is [`WEIGHT_ONE`].
    pub weights: [u16; 4],
}

impl Influences {
    /// Moved by one slot alone.
    #[must_use]
    pub fn rigid(slot: u16) -> Self {
        Self { slots: [slot, 0, 0, 0], weights: [WEIGHT_ONE, 0, 0, 0] }
    }
}

/// What skinning moves of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinVertex {
    /// Metres.
    pub position: Vec3,
    /// Unit vector, or zero where the mesh has none.
    pub normal: Vec3,
    /// Unit vector and handedness (±1), or zero where the mesh has none.
    pub tangent: Vec4,
}

/// How far a morph target at weight 1 moves a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MorphDelta {
    /// Metres.
    pub position: Vec3,
    /// Added to the normal.
    pub normal: Vec3,
    /// Added to the tangent; its handedness stays.
    pub tangent: Vec3,
}

/// Four weights as shares of [`WEIGHT_ONE`] whose sum is exactly [`WEIGHT_ONE`].
///
/// Any positive total is scaled to one. Negative, infinite and NaN weights count as zero; `None` when nothing is left.
#[must_use]
pub fn quantized_weights(weights: [f32; 4]) -> Option<[u16; 4]> {
    let weights = weights.map(|w| if w.is_finite() { f64::from(w.max(0.0)) } else { 0.0 });
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        return None;
    }
    let exact = weights.map(|w| w / total * f64::from(WEIGHT_ONE));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 ..= 65535 by the division above")]
    let mut quantized = exact.map(|w| w as u16);
    let mut rest = WEIGHT_ONE - quantized.iter().sum::<u16>();
    // Largest remainder first, so that no weight is off by more than one step.
    let mut order = [0, 1, 2, 3];
    order.sort_by(|&a, &b| exact[b].fract().total_cmp(&exact[a].fract()));
    for slot in order {
        if rest > 0 && weights[slot] > 0.0 {
            quantized[slot] += 1;
            rest -= 1;
        }
    }
    // Rounding of the sum above may leave a step when one weight alone is exact.
    quantized[order[0]] += rest;
    Some(quantized)
}

/// The matrix that moves a vertex: its slots' matrices, weighted.
///
/// A slot beyond the palette counts as the palette's last one, as on the GPU. An empty palette gives the identity.
#[must_use]
pub fn blended(palette: &[Affine3A], influences: Influences) -> Affine3A {
    let Some(last) = palette.len().checked_sub(1) else {
        return Affine3A::IDENTITY;
    };
    let mut sum = Affine3A { matrix3: Mat3A::ZERO, translation: Vec3A::ZERO };
    for (slot, weight) in influences.slots.iter().zip(influences.weights) {
        let matrix = palette[usize::from(*slot).min(last)];
        let weight = f32::from(weight) / f32::from(WEIGHT_ONE);
        sum.matrix3 += matrix.matrix3 * weight;
        sum.translation += matrix.translation * weight;
    }
    sum
}

/// A normal moved by `matrix`: right for uneven scale, shear and mirroring; zero stays zero.
#[must_use]
pub fn moved_normal(matrix: &Affine3A, normal: Vec3) -> Vec3 {
    // Rows of the cofactor matrix: det(M) · M⁻ᵀ without a division, and defined where M cannot be inverted.
    let m = matrix.matrix3.transpose();
    let rows = [m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis)];
    let mirrored = m.x_axis.dot(rows[0]) < 0.0;
    let normal = Vec3A::from(normal) * if mirrored { -1.0 } else { 1.0 };
    Vec3::from(Vec3A::new(rows[0].dot(normal), rows[1].dot(normal), rows[2].dot(normal)).normalize_or_zero())
}

/// A vertex of the mesh, moved to where the palette takes it (model space).
#[must_use]
pub fn skinned(palette: &[Affine3A], influences: Influences, vertex: SkinVertex) -> SkinVertex {
    let matrix = blended(palette, influences);
    let tangent = matrix.transform_vector3(vertex.tangent.truncate()).normalize_or_zero();
    SkinVertex {
        position: matrix.transform_point3(vertex.position),
        normal: moved_normal(&matrix, vertex.normal),
        tangent: tangent.extend(vertex.tangent.w),
    }
}

/// A vertex with morph targets added, each a weight and what it does at weight 1. Runs before [`skinned`].
#[must_use]
pub fn morphed(vertex: SkinVertex, targets: impl IntoIterator<Item = (f32, MorphDelta)>) -> SkinVertex {
    targets.into_iter().fold(vertex, |sum, (weight, delta)| SkinVertex {
        position: sum.position + delta.position * weight,
        normal: sum.normal + delta.normal * weight,
        tangent: sum.tangent + (delta.tangent * weight).extend(0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anim::skeleton::{JointTransform, Skeleton};
    use bevy::math::Quat;
    use proptest::prelude::*;

    const VERTEX: SkinVertex =
        SkinVertex { position: Vec3::new(0.0, 2.0, 0.0), normal: Vec3::Y, tangent: Vec4::new(1.0, 0.0, 0.0, -1.0) };

    proptest! {
        #[test]
        fn a_palette_written_in_rows_is_that_of_matrices(
            turns in prop::array::uniform4(prop::array::uniform3(-3.0f32..3.0)), scale in prop::array::uniform3(-2.0f32..2.0),
        ) {
            let turned = |turn: usize, at: Vec3| JointTransform {
                translation: at,
                rotation: Quat::from_scaled_axis(turns[turn].into()),
                scale: Vec3::from(scale),
            };
            let joints = [
                ("hips".to_owned(), None, turned(0, Vec3::new(0.3, 1.0, -0.2))),
                ("head".to_owned(), Some(JointIndex(0)), turned(1, Vec3::Y)),
            ];
            let pose = Pose::rest(&Skeleton::new(joints, Affine3A::IDENTITY).unwrap());
            let inverse_bind = [2, 3, 2].map(|turn| turned(turn, Vec3::X).to_affine().into()).to_vec();
            let skin = Skin { joints: [1, 0, 7].map(JointIndex).to_vec(), inverse_bind };
            let mut rows = [JointMatrix::IDENTITY; 3];
            skin.write_palette(&pose, &mut rows);
            let matrices = skin.palette(&pose).map(JointMatrix::from).collect::<Vec<_>>();
            for (row, matrix) in rows.iter().zip(&matrices) {
                let pairs = row.0.as_flattened().iter().zip(matrix.0.as_flattened());
                let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                prop_assert!(off < 1e-4, "{off} off");
            }
        }

        #[test]
        fn quantized_weights_sum_to_one_and_are_off_by_a_step_at_most(weights in prop::array::uniform4(0.0f32..10.0)) {
            prop_assume!(weights.iter().sum::<f32>() > 1e-3);
            let quantized = quantized_weights(weights).unwrap();
            let sum: u32 = quantized.iter().map(|w| u32::from(*w)).sum();
            prop_assert_eq!(sum, 65_535);
            let total: f32 = weights.iter().sum();
            for (w, q) in weights.iter().zip(quantized) {
                let error = (w / total - f32::from(q) / 65_535.0).abs() * 65_535.0;
                prop_assert!(error < 1.1, "{w} of {total} became {q}, {error} steps off");
            }
        }

        #[test]
        fn normals_stay_at_right_angles_to_the_surface(
            turn in prop::array::uniform3(-3.0f32..3.0), scale in prop::array::uniform3(0.2f32..3.0), mirror in any::<bool>(),
        ) {
            let scale = Vec3::from(scale) * Vec3::new(if mirror { -1.0 } else { 1.0 }, 1.0, 1.0);
            let matrix = Affine3A::from_scale_rotation_translation(scale, Quat::from_scaled_axis(turn.into()), Vec3::ONE);
            let (along, across) = (Vec3::new(1.0, 2.0, 0.5), Vec3::new(-0.3, 0.4, 1.0));
            let normal = moved_normal(&matrix, along.cross(across).normalize());
            for edge in [along, across] {
                let edge = matrix.transform_vector3(edge).normalize();
                prop_assert!(normal.dot(edge).abs() < 1e-4, "normal leans by {}", normal.dot(edge));
            }
            let outward = matrix.transform_vector3(along.cross(across)).dot(normal);
            prop_assert!(outward > 0.0, "normal points inward: {outward}");
        }
    }

    #[test]
    fn a_row_matrix_moves_a_point_as_its_affine_does() {
        let affine = Affine3A::from_scale_rotation_translation(
            Vec3::new(1.0, 2.0, 0.5),
            Quat::from_scaled_axis(Vec3::new(0.3, -1.0, 0.7)),
            Vec3::new(4.0, 5.0, 6.0),
        );
        let point = Vec3::new(-1.0, 0.4, 2.0);
        let rows = JointMatrix::from(affine).0.map(Vec4::from);
        let moved = Vec3::from_array(rows.map(|row| row.dot(point.extend(1.0))));
        assert!(moved.distance(affine.transform_point3(point)) < 1e-5, "{moved}");
    }

    #[test]
    fn weights_of_nothing_are_none() {
        assert_eq!(quantized_weights([0.0, -1.0, f32::NAN, f32::INFINITY]), None);
        assert_eq!(quantized_weights([0.0, 3.0, 0.0, 0.0]), Some([0, 65_535, 0, 0]));
    }

    #[test]
    fn half_the_weight_goes_half_the_way() {
        let palette = [Affine3A::IDENTITY, Affine3A::from_translation(Vec3::X)];
        let influences = Influences { slots: [0, 1, 0, 0], weights: [32_768, 32_767, 0, 0] };
        let at = skinned(&palette, influences, VERTEX).position;
        assert!(at.distance(Vec3::new(0.5, 2.0, 0.0)) < 1e-4, "vertex at {at}");
    }

    #[test]
    fn a_slot_beyond_the_palette_moves_with_its_last() {
        let palette = [Affine3A::IDENTITY, Affine3A::from_translation(Vec3::X)];
        let at = skinned(&palette, Influences::rigid(900), VERTEX).position;
        assert!(at.distance(Vec3::new(1.0, 2.0, 0.0)) < 1e-6, "vertex at {at}");
        assert_eq!(skinned(&[], Influences::rigid(3), VERTEX), VERTEX);
    }

    #[test]
    fn a_palette_squashed_to_nothing_gives_no_nan() {
        let flat = Affine3A::from_scale(Vec3::ZERO);
        let vertex = skinned(&[flat], Influences::rigid(0), VERTEX);
        assert!(vertex.normal.is_finite() && vertex.tangent.is_finite(), "{vertex:?}");
    }

    #[test]
    fn morphs_add_up_before_the_skin_moves_them() {
        let delta = MorphDelta { position: Vec3::Z, ..MorphDelta::default() };
        let vertex = morphed(VERTEX, [(0.5, delta), (0.25, delta)]);
        assert!(vertex.position.distance(Vec3::new(0.0, 2.0, 0.75)) < 1e-6, "vertex at {}", vertex.position);
        assert!((vertex.tangent.w + 1.0).abs() < 1e-6, "handedness {}", vertex.tangent.w);
    }
}
