//! Keys of single joints and of morph weights: the channels of a clip, each an exact curve.

use bevy::math::{Quat, Vec3};

use super::{
    curve::Curve,
    skeleton::{JointIndex, JointTransform},
};

/// Keys of one joint, in its parent's space.
#[derive(Clone, Debug, PartialEq)]
pub struct JointCurves {
    /// The joint.
    pub joint: JointIndex,
    /// Keys of the rotation.
    pub rotation: Option<Curve<Quat>>,
    /// Keys of the translation.
    pub translation: Option<Curve<Vec3>>,
    /// Keys of the scale.
    pub scale: Option<Curve<Vec3>>,
}

impl JointCurves {
    /// No keys yet.
    #[must_use]
    pub fn new(joint: JointIndex) -> Self {
        Self { joint, rotation: None, translation: None, scale: None }
    }

    /// Whether it has no keys.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rotation.is_none() && self.translation.is_none() && self.scale.is_none()
    }

    /// Writes what has keys, at `time` seconds; the rest of `out` stays.
    pub fn sample(&self, time: f32, out: &mut JointTransform) {
        if let Some(curve) = &self.rotation {
            out.rotation = curve.sample(time);
        }
        if let Some(curve) = &self.translation {
            out.translation = curve.sample(time);
        }
        if let Some(curve) = &self.scale {
            out.scale = curve.sample(time);
        }
    }

    /// The same motion in `factor` times the time.
    #[must_use]
    pub fn stretched(self, factor: f32) -> Self {
        Self {
            joint: self.joint,
            rotation: self.rotation.map(|curve| curve.stretched(factor)),
            translation: self.translation.map(|curve| curve.stretched(factor)),
            scale: self.scale.map(|curve| curve.stretched(factor)),
        }
    }

    /// Bytes of all keys.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let vectors = [&self.translation, &self.scale].into_iter().flatten().map(Curve::bytes).sum::<usize>();
        vectors + self.rotation.as_ref().map_or(0, Curve::bytes)
    }
}

/// Keys of the morph weights of one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MorphCurves {
    /// The node that carries the mesh, as a joint.
    pub node: JointIndex,
    /// One curve a morph target.
    pub weights: Vec<Curve<f32>>,
}

impl MorphCurves {
    /// The same weights in `factor` times the time.
    #[must_use]
    pub fn stretched(self, factor: f32) -> Self {
        let weights = self.weights.into_iter().map(|curve| curve.stretched(factor));
        Self { node: self.node, weights: weights.collect() }
    }
}
