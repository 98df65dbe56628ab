//! Where up and forward are in a file, and how long its unit is.

use bevy::math::{Affine3A, Mat3, Quat, Vec3};

use super::humanoid::{Humanoid, HumanoidRole as Role};
use crate::{
    anim::{pose::Pose, skeleton::Skeleton},
    math::rotation::direction_or,
};

/// Axes nearer than this (cosine) to one of the file's are taken to be that axis: bodies are never quite symmetric.
const NEAR_AXIS: f32 = 0.94;
/// Legs outside these lengths, in the file's metres, are in another unit: centimetres, or metres scaled down twice.
const LEG_LENGTHS: (f32, f32) = (0.02, 12.0);

/// From the file's space to model space for a file that says nothing: glTF faces +Z, model space -Z.
#[must_use]
pub fn gltf_default() -> Affine3A {
    Affine3A::from_quat(Quat::from_rotation_y(core::f32::consts::PI))
}

/// From the file's space to model space: +Y up, facing -Z, metres, after where the joints of `humanoid` are at rest.
///
/// The second value tells what is odd about the file, if anything.
#[must_use]
pub fn model_from_root(skeleton: &Skeleton, humanoid: &Humanoid) -> (Affine3A, Option<String>) {
    let mut in_file = skeleton.clone();
    in_file.model_from_root = Affine3A::IDENTITY;
    let rest = Pose::rest(&in_file);
    let at = |role: Role| humanoid.get(role).map(|joint| rest.position(joint));
    let pair = |left: Role, right: Role| at(left).zip(at(right));

    let Some((left_hip, right_hip)) = pair(Role::LeftUpperLeg, Role::RightUpperLeg) else {
        return (gltf_default(), None);
    };
    let Some((left_foot, right_foot)) = pair(Role::LeftFoot, Role::RightFoot) else { return (gltf_default(), None) };
    let hips = 0.5 * (left_hip + right_hip);
    let feet = 0.5 * (left_foot + right_foot);
    let up = on_axis(direction_or(at(Role::Head).unwrap_or(hips) - feet, Vec3::Y));
    let right = right_hip - left_hip;
    let right = on_axis(direction_or(right - up * right.dot(up), Vec3::NEG_X));
    let right = direction_or(right - up * right.dot(up), Vec3::NEG_X);
    let mut forward = up.cross(right);

    let mut note = None;
    if let Some((left_toes, right_toes)) = pair(Role::LeftToes, Role::RightToes) {
        let toes = left_toes - left_foot + right_toes - right_foot;
        let length = toes.length();
        if toes.dot(forward) < -0.3 * length {
            forward = -forward;
            note = Some("left and right are swapped in the joint names: the toes point the other way".to_owned());
        }
    }
    let right = forward.cross(up);
    let model_from_file = Mat3::from_cols(right, up, -forward).transpose();

    let knee = at(Role::LeftLowerLeg).unwrap_or(hips);
    let leg = left_hip.distance(knee) + knee.distance(left_foot);
    let unit = if leg > LEG_LENGTHS.1 {
        Some(0.01)
    } else if leg > 0.0 && leg < LEG_LENGTHS.0 {
        Some(100.0)
    } else {
        None
    };
    if let Some(unit) = unit {
        note.get_or_insert_with(|| format!("legs of {leg} m: lengths are taken times {unit}"));
    }
    (Affine3A::from_mat3(model_from_file * unit.unwrap_or(1.0)), note)
}

/// The axis of the file nearest to `direction` if it is near.
fn on_axis(direction: Vec3) -> Vec3 {
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    axes.into_iter().find(|axis| axis.dot(direction) > NEAR_AXIS).unwrap_or(direction)
}
