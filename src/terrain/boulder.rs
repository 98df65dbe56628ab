//! Boulders: spheres roughened by noise, chiselled by planes, and made convex, so that the collider is the very mesh.

use avian3d::parry::{math::Vector, transformation::try_convex_hull};
use bevy::math::Vec3;
use fastnoise_lite::{FastNoiseLite, NoiseType};

use crate::math::dice::{Dice, on_sphere};

/// Points before the hull is taken, for a rock of 1 m radius; small rocks have fewer, but never fewer than the second.
const POINTS: (f32, usize) = (130.0, 40);
/// Flat cuts.
const CUTS: usize = 8;

/// A convex rock as points and outward triangles, about `radius` metres big, its foot a little below y = 0; nothing for a radius that is not above 0.
#[must_use]
pub fn hull(radius: f32, seed: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    if !(radius.is_finite() && radius > 0.0) {
        return (vec![], vec![]);
    }
    let mut dice = Dice::new(seed.wrapping_mul(0x9E37_79B9) ^ 0xB0);
    let cuts: Vec<(Vec3, f32)> = (0..CUTS).map(|_| (dice.direction(), dice.between(0.62, 0.92))).collect();
    let stretch = Vec3::new(dice.between(0.85, 1.15), dice.between(0.68, 0.9), dice.between(0.85, 1.15));
    let mut noise = FastNoiseLite::with_seed(seed.cast_signed());
    noise.set_noise_type(Some(NoiseType::OpenSimplex2));
    noise.set_frequency(Some(1.1));
    let count = ((POINTS.0 * radius.min(1.2)) as usize).max(POINTS.1);
    let points: Vec<Vector> = (0..count)
        .map(|index| {
            let direction = spiral(index, count);
            let rough = 1.0 + 0.1 * noise.get_noise_3d(direction.x, direction.y, direction.z);
            let cut = cuts.iter().map(|(normal, depth)| reach(direction.dot(*normal), *depth)).fold(rough, f32::min);
            let point = direction * cut * stretch * radius + Vec3::Y * (0.38 * radius);
            Vector::new(point.x, point.y, point.z)
        })
        .collect();
    match try_convex_hull(&points) {
        Ok((points, triangles)) => (points.iter().map(|p| Vec3::new(p.x, p.y, p.z)).collect(), triangles),
        // Only points that all lie in one plane have no hull.
        Err(_) => (vec![], vec![]),
    }
}

/// How far a ray runs before a plane `depth` away stops it, `along` being the cosine between ray and normal.
fn reach(along: f32, depth: f32) -> f32 {
    if along > 0.05 { depth / along } else { f32::INFINITY }
}

/// One of `count` directions spread evenly over the sphere along a golden spiral.
fn spiral(index: usize, count: usize) -> Vec3 {
    on_sphere(1.0 - 2.0 * (index as f32 + 0.5) / count as f32, index as f32 * 2.399_963_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_boulder_is_convex_and_as_big_as_asked() {
        for seed in 0..12 {
            let (points, triangles) = hull(1.5, seed);
            for triangle in &triangles {
                let [a, b, c] = triangle.map(|index| points[index as usize]);
                let normal = (b - a).cross(c - a).normalize_or_zero();
                let out = points.iter().map(|point| (point - a).dot(normal)).fold(f32::MIN, f32::max);
                assert!(out < 2e-3, "boulder {seed} stands {out} m out of its own face");
            }
            let width = points.iter().map(|point| point.with_y(0.0).length()).fold(0.0, f32::max);
            assert!((0.9..2.0).contains(&width), "boulder {seed} reaches {width} m from its middle");
        }
    }

    #[test]
    fn a_boulder_without_size_is_empty() {
        for radius in [0.0, -1.0, f32::NAN] {
            assert!(hull(radius, 1).1.is_empty(), "a boulder of {radius} m");
        }
    }
}
