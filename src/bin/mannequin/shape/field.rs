//! Signed fields and how they blend: metres to a surface, negative inside.

use glam::Vec3;

/// Joins two fields with a fillet about `width` metres wide.
#[must_use]
pub fn blend(a: f32, b: f32, width: f32) -> f32 {
    let h = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - h * h * h * width / 6.0
}

/// A cone with round ends: radius `ra` at `a`, `rb` at `b`.
#[must_use]
pub fn bone(p: Vec3, a: Vec3, b: Vec3, ra: f32, rb: f32) -> f32 {
    let along = b - a;
    let t = ((p - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
    p.distance(a + along * t) - (ra + (rb - ra) * t)
}

/// An ellipsoid with half axes `half`; near its surface the value is a distance.
#[must_use]
pub fn ellipsoid(p: Vec3, center: Vec3, half: Vec3) -> f32 {
    let scaled = (p - center) / half;
    let steep = scaled / half;
    let (near, slope) = (scaled.length(), steep.length());
    if slope < 1e-6 { -half.min_element() } else { near * (near - 1.0) / slope }
}

/// A box with half sizes `half` whose edges are rounded by `round` metres.
#[must_use]
pub fn slab(p: Vec3, center: Vec3, half: Vec3, round: f32) -> f32 {
    let out = (p - center).abs() - half + Vec3::splat(round);
    out.max(Vec3::ZERO).length() + out.max_element().min(0.0) - round
}

/// Unit normal of a field at `p`, by differences over `step` metres.
#[must_use]
pub fn normal(field: &dyn Fn(Vec3) -> f32, p: Vec3, step: f32) -> Vec3 {
    let slope = |axis: Vec3| field(p + axis * step) - field(p - axis * step);
    Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or(Vec3::Y)
}
