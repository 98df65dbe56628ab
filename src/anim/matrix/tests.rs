//! Matrices against those of glam, with every instruction set.

use bevy::math::{Affine3A, Quat, Vec3};
use fearless_simd::{Level, dispatch};
use proptest::prelude::*;

use super::{
    JointMatrix,
    many::{between_by, models_by, palette_between_by, palette_by},
};
use crate::anim::skeleton::{JointIndex, JointTransform};

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
        for matrix in [JointMatrix::from(unscaled.to_affine()), rows] {
            let turn = Quat::from_rotation_x(1.0);
            let back = matrix.rotation().inverse() * turn * matrix.rotation();
            let angle = matrix.turn_back(turn).angle_between(back);
            prop_assert!(angle < 4e-3, "a turn comes back {angle} rad off");
        }
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
