//! The head: skull, jaw and crown of the helmet.

use glam::Vec3;

use super::field::{blend, ellipsoid};
use crate::skeleton::STATURE;

/// Height of the plates that lie on it.
const PLATES: f32 = 0.007;

/// Metres from `p` to the helmet's base surface, negative inside; plates lie on it.
#[must_use]
pub fn helmet(p: Vec3) -> f32 {
    let p = Vec3::new(p.x.abs(), p.y, p.z);
    let crown = ellipsoid(p, Vec3::new(0.0, STATURE - PLATES - 0.097, -0.004), Vec3::new(0.083, 0.097, 0.108));
    let jaw = ellipsoid(p, Vec3::new(0.0, 1.625, 0.026), Vec3::new(0.066, 0.066, 0.080));
    let cheek = ellipsoid(p, Vec3::new(0.040, 1.630, 0.030), Vec3::new(0.036, 0.058, 0.060));
    blend(blend(crown, jaw, 0.060), cheek, 0.040)
}
