//! How the shapes look: their faces and colours.
//!
//! Model space, metres, the foot at y = 0; corners run counter-clockwise seen from outside.

use bevy::math::{Vec3, ops};

use super::{Flight, Shape, mast_ring, rail_bars, ridge_corners, trunk_radius};
use crate::terrain::{
    boulder,
    facets::Facets,
    palette::{Tint, scaled, shaded},
};

/// Width of the softened edge of blocks, metres: small enough that the sharp collider stands out by under a centimetre.
const BEVEL: f32 = 0.008;
/// Boxes thinner than this have sharp edges, metres: nobody would see the others.
const SHARP: f32 = 0.16;
/// Width of a plank, metres.
const PLANK: f32 = 0.3;
/// Depth of the painted edge of a stair's tread, metres.
const NOSING: f32 = 0.045;
/// Corners of round things: few enough to draw, many enough to match a round collider within 5 mm at 3 m.
const ROUND: u32 = 64;
/// Faces of boulders meet smoothly below this angle, radians.
const CREASE: f32 = 0.5;

impl Shape {
    /// The mesh in the making, painted with `tint`.
    #[must_use]
    pub fn facets(&self, tint: Tint) -> Facets {
        let mut facets = Facets::default();
        let color = tint.linear();
        match *self {
            Self::Block { size } => facets.block(Vec3::Y * size.y * 0.5, size, bevel(size), color),
            Self::Deck { size } => {
                let half = size * 0.5;
                let back = Vec3::new(half.x, size.y, -half.z);
                let front = Vec3::new(half.x, size.y, half.z);
                planks(&mut facets, front, back, size.x, color);
                walls(&mut facets, &[front, back, back - Vec3::X * size.x, front - Vec3::X * size.x], color);
            }
            Self::Ramp { size } => {
                let half = size * 0.5;
                let (low, high) = (Vec3::new(half.x, 0.0, half.z), Vec3::new(half.x, size.y, -half.z));
                planks(&mut facets, low, high, size.x, color);
                walls(&mut facets, &[low, high, high - Vec3::X * size.x, low - Vec3::X * size.x], color);
            }
            Self::Ridge { size } => ridge(&mut facets, size, color),
            Self::Stairs { steps, rise, run, width, base } => {
                stairs(&mut facets, &Flight { steps, rise, run, width, base }, color);
            }
            Self::Disc { radius, height } => disc(&mut facets, radius, height, color),
            Self::Rail { length, height } => {
                for (centre, size) in rail_bars(length, height) {
                    facets.block(centre, size, bevel(size), color);
                }
            }
            Self::Mast { height, width } => mast(&mut facets, height, width, color),
            Self::Boulder { radius, seed } => {
                let (points, triangles) = boulder::hull(radius, seed);
                let low = radius * 0.35;
                facets.smooth(&points, &triangles, CREASE, |point| {
                    shaded(color, (0.55 + 0.45 * point.y / low).clamp(0.55, 1.0))
                });
            }
            Self::Pine { height } => pine(&mut facets, height, color),
        }
        facets
    }
}

fn bevel(size: Vec3) -> f32 {
    if size.min_element() < SHARP { 0.0 } else { BEVEL }
}

/// Planks across a plane whose right edge runs from `front` to `back`, `width` metres to the left.
fn planks(facets: &mut Facets, front: Vec3, back: Vec3, width: f32, color: [f32; 4]) {
    let count = (front.distance(back) / PLANK).round().max(1.0);
    let gap = 0.012 / front.distance(back).max(0.1);
    for plank in 0..count as u32 {
        let (from, to) = (plank as f32 / count, (plank + 1) as f32 / count);
        // Neighbouring planks differ by a golden-ratio walk, so none looks like its neighbour.
        let light = 0.88 + 0.2 * (plank as f32 * 0.618_034).fract();
        for (from, to, light) in [(from, to - gap, light), (to - gap, to, 0.35)] {
            let (near, far) = (front.lerp(back, from), front.lerp(back, to));
            let left = Vec3::X * width;
            facets.polygon(&[near, far, far - left, near - left], scaled(color, light));
        }
    }
}

/// Walls below a ring of top corners that runs counter-clockwise seen from above.
fn walls(facets: &mut Facets, ring: &[Vec3], color: [f32; 4]) {
    for (index, left) in ring.iter().enumerate() {
        let right = ring[(index + 1) % ring.len()];
        if left.y.max(right.y) > 1e-4 {
            facets.wall(*left, right, 0.0, scaled(color, 0.8));
        }
    }
}

fn ridge(facets: &mut Facets, size: Vec3, color: [f32; 4]) {
    let [front, back, top, left_front, left_back, left_top] = ridge_corners(size);
    facets.polygon(&[left_front, front, top, left_top], color);
    facets.polygon(&[left_top, top, back, left_back], color);
    facets.polygon(&[front, back, top], scaled(color, 0.85));
    facets.polygon(&[left_front, left_top, left_back], scaled(color, 0.85));
}

fn stairs(facets: &mut Facets, flight: &Flight, color: [f32; 4]) {
    let half = flight.width * 0.5;
    let accent = Tint::Accent.linear();
    for step in 0..flight.steps {
        let (top, front, back) = (flight.top(step), flight.front(step), flight.front(step + 1));
        let tread = |from: f32, to: f32| {
            [
                Vec3::new(half, top, from),
                Vec3::new(half, top, to),
                Vec3::new(-half, top, to),
                Vec3::new(-half, top, from),
            ]
        };
        facets.polygon(&tread(front, front - NOSING), accent);
        facets.polygon_with(&tread(front - NOSING, back), |corner| {
            shaded(color, if corner.z > back { 1.0 } else { 0.75 })
        });
        let floor = if step == 0 { 0.0 } else { flight.top(step - 1) };
        let (right, left) = (Vec3::new(half, top, front), Vec3::new(-half, top, front));
        facets.wall(left, right, floor, scaled(color, 0.72));
        facets.wall(right, right.with_z(back), 0.0, scaled(color, 0.85));
        facets.wall(left.with_z(back), left, 0.0, scaled(color, 0.85));
    }
    let (top, back) = (flight.top(flight.steps.max(1) - 1), flight.front(flight.steps));
    facets.wall(Vec3::new(half, top, back), Vec3::new(-half, top, back), 0.0, scaled(color, 0.85));
}

fn disc(facets: &mut Facets, radius: f32, height: f32, color: [f32; 4]) {
    let at = |corner: u32, radius: f32| {
        let (sin, cos) = ops::sin_cos(corner as f32 / ROUND as f32 * core::f32::consts::TAU);
        Vec3::new(radius * cos, height, -radius * sin)
    };
    let (accent, paint) = (Tint::Accent.linear(), Tint::Paint.linear());
    for corner in 0..ROUND {
        let (here, next) = (at(corner, radius), at(corner + 1, radius));
        facets.wall(here, next, 0.0, scaled(accent, 0.8));
        let sector = corner * 8 / ROUND;
        let rings =
            [(0.0, 0.16, accent), (0.16, 0.9, if sector.is_multiple_of(2) { color } else { scaled(color, 0.8) })];
        for (inner, outer, color) in rings.into_iter().chain([(0.9, 1.0, if sector == 0 { paint } else { accent })]) {
            let (from, to) = (inner * radius, outer * radius);
            let ring = [at(corner, from), at(corner, to), at(corner + 1, to), at(corner + 1, from)];
            facets.polygon(if inner > 0.0 { &ring } else { &ring[..3] }, color);
        }
    }
}

fn mast(facets: &mut Facets, height: f32, width: f32, color: [f32; 4]) {
    let paint = Tint::Paint.linear();
    let bands = height.ceil().max(1.0) as u32;
    for band in 0..bands {
        let (low, high) = (band as f32, (band as f32 + 1.0).min(height));
        let (below, above) = (mast_ring(height, width, low), mast_ring(height, width, high));
        for side in 0..4 {
            let next = (side + 1) % 4;
            let color = if band.is_multiple_of(2) { color } else { paint };
            facets.polygon(&[below[side], below[next], above[next], above[side]], color);
        }
    }
    facets.polygon(&mast_ring(height, width, height), color);
}

fn pine(facets: &mut Facets, height: f32, color: [f32; 4]) {
    const SIDES: u32 = 7;
    let ring = |radius: f32, up: f32, turn: f32, corner: u32| {
        let (sin, cos) = ops::sin_cos((corner as f32 + turn) / SIDES as f32 * core::f32::consts::TAU);
        Vec3::new(radius * cos, up, -radius * sin)
    };
    let trunk = trunk_radius(height);
    for corner in 0..SIDES {
        let (here, next) = (ring(trunk, height * 0.3, 0.0, corner), ring(trunk, height * 0.3, 0.0, corner + 1));
        facets.wall(here, next, 0.0, Tint::DarkWood.linear());
    }
    for tier in 0..4u32 {
        let share = tier as f32 / 4.0;
        let (low, high) = (height * (0.2 + 0.62 * share), height * (0.2 + 0.62 * share + 0.36 - 0.08 * share));
        let (wide, turn) = (height * 0.23 * (1.0 - 0.68 * share), tier as f32 * 0.37);
        for corner in 0..SIDES {
            let (here, next) = (ring(wide, low, turn, corner), ring(wide, low, turn, corner + 1));
            let light = 0.82 + 0.16 * share + if corner.is_multiple_of(2) { 0.0 } else { 0.1 };
            facets.polygon_with(&[here, next, Vec3::Y * high], |at| {
                shaded(scaled(color, light), if at.y > low { 1.0 } else { 0.8 })
            });
            // The higher tiers' undersides are hidden by the tier below.
            if tier == 0 {
                facets.polygon(&[next, here, Vec3::Y * (low + 0.05 * height)], shaded(scaled(color, 0.5), 0.5));
            }
        }
    }
}
