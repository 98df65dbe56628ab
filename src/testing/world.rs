//! Solids to walk on, as data. World space, metres, +Y up.

use avian3d::prelude::*;
use bevy::prelude::*;

use crate::measure::bars::Bars;

/// A solid's form.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Full lengths along its axes.
    Box(Vec3),
    /// Heights over a square grid, `[x][z]`, centred, and its side length.
    Heightfield(Vec<Vec<f32>>, f32),
}

/// One solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Its form.
    pub shape: Shape,
    /// Where its centre is.
    pub transform: Transform,
    /// Velocity in m/s and turn rate about +Y in rad/s, for what moves.
    pub motion: Option<(Vec3, f32)>,
}

/// Ground to walk on.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// For tables and failures.
    pub name: String,
    /// What it is made of.
    pub pieces: Vec<Piece>,
}

impl Piece {
    /// A box that stands still.
    #[must_use]
    pub fn block(size: Vec3, transform: Transform) -> Self {
        Self { shape: Shape::Box(size), transform, motion: None }
    }

    /// The collider of its shape.
    #[must_use]
    pub fn collider(&self) -> Collider {
        match &self.shape {
            Shape::Box(size) => Collider::cuboid(size.x, size.y, size.z),
            Shape::Heightfield(heights, side) => Collider::heightfield(heights.clone(), Vec3::new(*side, 1.0, *side)),
        }
    }
}

impl World {
    /// Ground of these solids.
    #[must_use]
    pub fn new(name: &str, pieces: Vec<Piece>) -> Self {
        Self { name: name.to_owned(), pieces }
    }

    /// Whether it is one level plain that stands still.
    #[must_use]
    pub fn is_level(&self) -> bool {
        let flat = |piece: &Piece| matches!(piece.shape, Shape::Box(_)) && (piece.transform.up().y - 1.0).abs() < 1e-6;
        matches!(self.pieces.as_slice(), [piece] if flat(piece) && piece.motion.is_none())
    }

    /// What walking on it is held to.
    #[must_use]
    pub fn bars(&self) -> Bars {
        if self.is_level() { Bars::flat() } else { Bars::default() }
    }

    /// The same places, each on the ground; those over an abyss are left out.
    #[must_use]
    pub fn on_ground(&self, places: &[Transform]) -> Vec<Transform> {
        let solids: Vec<_> = self.pieces.iter().map(|piece| (piece.collider(), piece.transform)).collect();
        let height = |place: &Transform| {
            let start = place.translation.with_y(SKY);
            let hit = |(collider, at): &(Collider, Transform)| {
                let hit = collider.cast_ray(at.translation, at.rotation, start, Vec3::NEG_Y, 2.0 * SKY, true);
                hit.map(|(distance, _)| SKY - distance)
            };
            solids.iter().filter_map(hit).reduce(f32::max)
        };
        places
            .iter()
            .filter_map(|place| Some(place.with_translation(place.translation.with_y(height(place)?))))
            .collect()
    }
}

/// Metres above all ground.
const SKY: f32 = 100.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_come_to_lie_on_the_highest_solid() {
        let places = [Transform::from_xyz(0.0, 9.0, 0.0), Transform::from_xyz(0.0, 0.0, -3.1)];
        let heights: Vec<f32> =
            World::stairs_up(4, 0.17, 0.29).on_ground(&places).iter().map(|place| place.translation.y).collect();
        assert!(heights[0].abs() < 1e-4 && (heights[1] - 0.17).abs() < 1e-4, "on {heights:?}");
        assert!(World::cliff().on_ground(&[Transform::from_xyz(500.0, 0.0, 0.0)]).is_empty(), "over an abyss");
    }

    #[test]
    fn only_the_plain_is_level() {
        assert!(World::flat().is_level());
        for world in [World::slope(10.0), World::hills(), World::curb(), World::moving_platform()] {
            assert!(!world.is_level(), "{} is not level", world.name);
        }
    }
}
