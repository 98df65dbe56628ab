//! Pines and rocks scattered over the hills, off the paths and the plaza.
//!
//! World space, metres.

use bevy::math::{Vec2, Vec3, ops};

use super::{
    Heightfield, Piece,
    landscape::{HOLLOW, Landscape, on_land, plaza_distance},
    palette::Tint,
    shape::Shape,
};
use crate::math::dice::Dice;

/// Metres between the middles of the squares that may each hold one thing.
const SPACING: f32 = 8.5;
/// Nothing stands farther out than this, metres.
const REACH: f32 = 119.0;
/// Heights of the pines, metres: few, so that they share meshes.
const PINES: [f32; 4] = [4.2, 5.4, 6.6, 7.8];
/// Radius and seed of the rocks.
const ROCKS: [(f32, u32); 4] = [(0.35, 31), (0.55, 32), (0.8, 33), (1.3, 34)];
/// Steepest ground for anything to stand on, as the height of its unit normal: 30°.
const FLATTEST: f32 = 0.866;

/// Everything scattered over the land.
#[must_use]
pub fn scatter(land: &Landscape, field: &Heightfield) -> Vec<Piece> {
    let mut dice = Dice::new(101);
    let mut pieces = Vec::new();
    let squares = (REACH / SPACING) as i32;
    for x in -squares..=squares {
        for z in -squares..=squares {
            let jitter = Vec2::new(dice.between(-0.42, 0.42), dice.between(-0.42, 0.42));
            let at = (Vec2::new(x as f32, z as f32) + jitter) * SPACING;
            let (kind, which, turn) = (dice.roll(), dice.pick(4), dice.turn());
            if !may_stand(land, field, at) {
                continue;
            }
            // Woods thicken in patches and toward the border.
            let wooded = 0.5 + 0.5 * ops::sin(at.x * 0.045) * ops::cos(at.y * 0.052 + 1.0);
            let far = (at.length() / REACH).min(1.0);
            let (name, shape, tint, sunk) = if kind < 0.1 + 0.55 * wooded * far {
                ("pine", Shape::Pine { height: PINES[which] }, Tint::Needles, 0.1)
            } else if kind > 0.86 {
                let (radius, seed) = ROCKS[which];
                ("rock", Shape::Boulder { radius, seed }, Tint::Stone, 0.1 * radius)
            } else {
                continue;
            };
            let position = on_land(field, at, -sunk);
            pieces.push(Piece { name, shape, tint, position, rotation: turn, motion: None });
        }
    }
    pieces
}

fn may_stand(land: &Landscape, field: &Heightfield, at: Vec2) -> bool {
    let cover = land.cover(at.x, at.y);
    // The walk over the course begins on the slope south of the plaza: keep its view clear.
    let begins = at.distance(Vec2::new(-10.0, 21.0)) < 9.0;
    plaza_distance(at) > 4.0
        && cover.path < 0.01
        && at.distance(HOLLOW.0) > HOLLOW.1 + 3.0
        && !begins
        && field.normal(at.x, at.y).dot(Vec3::Y) > FLATTEST
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_stand_on_the_ground_beside_the_paths() {
        let land = Landscape::new(7);
        let field = land.heightfield();
        let pieces = scatter(&land, &field);
        assert!((60..400).contains(&pieces.len()), "{} things", pieces.len());
        for piece in &pieces {
            let under = field.height(piece.position.x, piece.position.z) - piece.position.y;
            assert!((0.0..0.2).contains(&under), "{} is {under} m deep", piece.name);
            let path = land.cover(piece.position.x, piece.position.z).path;
            assert!(path < 0.01, "{} on a path", piece.name);
        }
    }
}
