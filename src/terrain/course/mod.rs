//! The obstacle course around the plaza: a list of pieces, and the scripted walk over it.
//!
//! World space, metres. The walk comes down the grass slope in the south-west, climbs the stairs and comes down again, turns
//! east over the ramps, through the rubble and between the boulders.

use bevy::{
    math::{Quat, Vec2, Vec3},
    prelude::Component,
};

use super::{Heightfield, landscape::on_land, palette::Tint, platform::MovingPlatform, shape::Shape};

mod pieces;

/// Height and depth of a stair's step, metres.
pub const STEP: Vec2 = Vec2::new(0.17, 0.29);

/// One obstacle: what it is and where it stands.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct Piece {
    /// What it is called in the world.
    pub name: &'static str,
    /// Its solid.
    pub shape: Shape,
    /// Its colour.
    pub tint: Tint,
    /// Where the middle of its foot stands, world space.
    pub position: Vec3,
    /// How it is turned.
    pub rotation: Quat,
    /// How it moves, if it does.
    pub motion: Option<MovingPlatform>,
}

impl Piece {
    fn new(name: &'static str, shape: Shape, tint: Tint, position: Vec3) -> Self {
        Self { name, shape, tint, position, rotation: Quat::IDENTITY, motion: None }
    }

    /// Turned about +Y so that what faced -Z faces `degrees` to the left.
    fn turned(mut self, degrees: f32) -> Self {
        self.rotation = Quat::from_rotation_y(degrees.to_radians());
        self
    }
}

/// A point of the scripted walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// The point on the land, world space; obstacles may stand on it.
    pub position: Vec3,
    /// Speed in m/s at which to go on from here.
    pub speed: f32,
}

/// The scripted walk of about 20 s as places on the plan and the speed from there on.
const ROUTE: [(Vec2, f32); 14] = [
    (Vec2::new(-10.0, 18.2), 1.4),
    (Vec2::new(-10.0, 13.0), 1.5),
    (Vec2::new(-10.0, 4.2), 2.6),
    (Vec2::new(-9.5, 1.9), 3.2),
    (Vec2::new(-8.2, 0.4), 3.4),
    (Vec2::new(-6.5, 0.0), 3.2),
    (Vec2::new(3.0, 0.0), 1.5),
    (Vec2::new(7.9, 0.0), 2.6),
    (Vec2::new(9.3, 0.6), 3.2),
    (Vec2::new(10.6, 0.6), 3.4),
    (Vec2::new(12.4, -0.6), 3.4),
    (Vec2::new(14.0, 0.1), 3.4),
    (Vec2::new(15.2, 0.8), 1.4),
    (Vec2::new(16.2, 1.5), 1.4),
];

/// The scripted walk: slope, stairs, ramps, rubble, boulders.
#[must_use]
pub fn route(field: &Heightfield) -> Vec<Waypoint> {
    ROUTE.iter().map(|&(at, speed)| Waypoint { position: on_land(field, at, 0.0), speed }).collect()
}

/// The points of [`route`].
#[must_use]
pub fn waypoints(field: &Heightfield) -> Vec<Vec3> {
    route(field).iter().map(|waypoint| waypoint.position).collect()
}

/// Every piece of the course.
#[must_use]
pub fn pieces(field: &Heightfield) -> Vec<Piece> {
    let mut pieces = Vec::new();
    pieces::stairs(&mut pieces);
    pieces::ramps(&mut pieces);
    pieces::rubble(&mut pieces);
    pieces::boulders(&mut pieces);
    pieces::ledges_and_walls(&mut pieces);
    pieces::platforms(&mut pieces);
    pieces::stepping_stones(field, &mut pieces);
    pieces::landmarks(field, &mut pieces);
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::landscape::Landscape;

    #[test]
    fn the_walk_takes_about_twenty_seconds() {
        let route = route(&Landscape::new(7).heightfield());
        let seconds: f32 =
            route.windows(2).map(|ends| ends[0].position.distance(ends[1].position) / ends[0].speed).sum();
        assert!((18.0..22.0).contains(&seconds), "{seconds:.1} s");
    }

    #[test]
    fn rubble_is_no_higher_than_a_foot_can_take() {
        let pieces = pieces(&Heightfield::from_fn(1, 1.0, |_, _| 0.0));
        for piece in pieces.iter().filter(|piece| piece.name == "rubble") {
            let highest = piece
                .shape
                .facets(piece.tint)
                .triangles()
                .flatten()
                .fold(0.0f32, |highest, corner| highest.max((piece.position + piece.rotation * corner).y));
            assert!((0.03..0.152).contains(&highest), "a box {highest} m high at {}", piece.position);
        }
    }
}
