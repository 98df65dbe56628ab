//! What lies under the body: ground, a step, a wall's foot, or nothing. World space, metres.
//!
//! A ball is lowered from step height. It finds the highest thing below and rounds off edges; a ray
//! down the middle finds the surface itself, exactly.

use bevy::prelude::*;

use super::{
    capsule::MotionShapes,
    slope::{as_wall, hover, walkable},
    space::{Floor, Hit, View},
};

/// Most in metres that the ball's cast and the ray's may disagree about one surface.
const AGREE: f32 = 0.005;

/// How far in metres a wall's foot may lift the ball before the wall counts.
const NUDGE: f32 = 0.003;

/// Ways into an obstacle, metres, at which its top is looked for: the edge itself, then over a blunt shoulder.
const INTO: [f32; 2] = [0.02, 0.1];

/// How far behind its touched side an obstacle has to stay below step height to be stepped over, metres.
///
/// A slope of one degree over the usual limit rises by a whole step within it.
const STRIDE_OVER: f32 = 0.35;

/// Ground that bears the body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    /// Height of the capsule's lowest point.
    pub(super) height: f32,
    /// Height at which the root stands.
    pub(super) level: f32,
    pub(super) collider: Entity,
    /// Normal of the surface under the root.
    pub(super) normal: Vec3,
    /// Where the ball touches.
    pub(super) point: Vec3,
}

/// What a look below finds.
#[derive(Clone, Copy, Debug)]
pub(super) enum Footing {
    /// Ground to stand on.
    Support(Support),
    /// Steep ground that rises: a wall for one who walks.
    Wall {
        /// Horizontal unit normal.
        normal: Vec3,
        /// Metres along the normal to where the wall's foot ends; infinite where it doesn't.
        back: f32,
    },
    /// Steep ground that falls away, or the edge of a cliff.
    Slip(Support),
    /// Nothing within reach.
    Air,
}

/// How to look for ground.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Metres above the body's lowest point from where the ball is lowered.
    pub(super) up: f32,
    /// Metres below the body's lowest point to where.
    pub(super) down: f32,
    /// Highest contact, in metres above the body's lowest point, that still counts as ground.
    pub(super) highest: f32,
    /// Cosine of the steepest slope.
    pub(super) limit_cos: f32,
}

/// Looks for ground under a body whose lowest point is `at`.
pub(super) fn footing(view: &View, shapes: &MotionShapes, at: Vec3, look: Look) -> Footing {
    let radius = shapes.foot_radius;
    let centre = at + Vec3::Y * (look.up + shapes.radius);
    let lift = shapes.radius - radius;
    let Some(lowered) = view.lower(&shapes.foot, radius, centre, look.up + lift + look.down) else {
        return Footing::Air;
    };
    let deepest = look.down + hover(radius, Vec3::Y * look.limit_cos);
    let start = Vec3::new(at.x, at.y + look.up + lift, at.z);
    let below = view.floor(start, Dir3::NEG_Y, look.up + lift + deepest);
    let floor = below.filter(|floor| walkable(floor.normal, look.limit_cos));
    let hit = if lowered.exact { lowered } else { sharpened(view, shapes, centre, lowered, floor) };
    if hit.point.y > at.y + look.highest {
        // The ball came down on something too high to step on: back to where it stands beside it.
        let flat = Vec3::new(hit.normal.x, 0.0, hit.normal.z).length();
        return Footing::Wall { normal: as_wall(hit.normal), back: radius * (1.0 - flat).max(0.0) };
    }
    let touch = Touch { at, look, radius, height: centre.y - hit.distance - radius, hit, floor };
    let stands = walkable(hit.normal, look.limit_cos);
    let support = touch.support(stands);
    if stands {
        Footing::Support(support)
    } else if touch.is_low(view) {
        // A step if there is something below as well; else the edge of a cliff.
        if below.is_some() { Footing::Support(support) } else { Footing::Slip(support) }
    } else {
        touch.steep(support)
    }
}

/// The ball's hit made exact: by the plane that the ray found if the ball lies on it, else by a closer look.
fn sharpened(view: &View, shapes: &MotionShapes, centre: Vec3, hit: Hit, floor: Option<Floor>) -> Hit {
    if let Some(floor) = floor
        && floor.collider == hit.collider
        && floor.normal.dot(hit.normal) > 0.999
    {
        let distance = centre.y - shapes.foot_radius - hover(shapes.foot_radius, floor.normal) - floor.height;
        if (distance - hit.distance).abs() < 1e-3 {
            let point = centre - Vec3::Y * distance - floor.normal * shapes.foot_radius;
            return Hit { distance, safe: distance, normal: floor.normal, point, ..hit };
        }
    }
    view.sharpen_lowering(&shapes.foot, centre, hit)
}

/// The height of the root between what the ball and the ray found.
///
/// On a plane, and where slopes meet, that is the surface under the middle. Over an edge it is what the ball, rolling
/// over it, would have under it; with nothing below, the edge itself.
fn level(ball: f32, contact: f32, hover: f32, floor: Option<Floor>) -> f32 {
    let (lowest, highest) = (ball - hover - AGREE, contact.max(ball) + AGREE);
    floor.map_or(contact.max(ball), |floor| floor.height.clamp(lowest, highest))
}

/// What the lowered ball touched, and the ground under its middle.
struct Touch {
    /// The body's lowest point when the look began.
    at: Vec3,
    look: Look,
    /// The ball's radius.
    radius: f32,
    /// Height of the ball's lowest point.
    height: f32,
    hit: Hit,
    /// Ground to walk on straight below.
    floor: Option<Floor>,
}

impl Touch {
    fn support(&self, stands: bool) -> Support {
        let steepest = if stands { self.hit.normal } else { Vec3::Y * self.look.limit_cos };
        let level = level(self.height, self.hit.point.y, hover(self.radius, steepest), self.floor);
        let near = self.floor.filter(|floor| (floor.height - level).abs() < 0.02);
        Support {
            height: self.height,
            level,
            collider: near.map_or(self.hit.collider, |floor| floor.collider),
            normal: self.floor.map_or(Vec3::Y, |floor| floor.normal),
            point: self.hit.point,
        }
    }

    /// Whether the obstacle touched can be stepped on or over: as far as a stride reaches no higher than where the look began.
    fn is_low(&self, view: &View) -> bool {
        let above = self.at.y + self.look.up + 0.01;
        let Ok(into) = Dir3::new(-as_wall(self.hit.normal)) else { return true };
        if self.hit.point.y > above {
            return false;
        }
        let away = (self.hit.point - self.at).dot(*into).max(0.0);
        let over = view.floor(self.at.with_y(above), into, away + STRIDE_OVER);
        over.is_none() || self.has_top(view, above, *into)
    }

    /// Whether there is a top to stand on just behind the contact, whatever towers behind that.
    fn has_top(&self, view: &View, above: f32, into: Vec3) -> bool {
        INTO.iter().any(|depth| {
            let from = self.hit.point.with_y(above) + into * *depth;
            let reach = above - self.hit.point.y + 0.02;
            view.floor(from, Dir3::NEG_Y, reach)
                .is_some_and(|top| walkable(top.normal, self.look.limit_cos) && top.height < above - 1e-4)
        })
    }

    /// Sorts out a contact with something steep that is too high to step on.
    fn steep(&self, support: Support) -> Footing {
        let normal = as_wall(self.hit.normal);
        let Some(floor) = self.floor else {
            let climbs = self.height > self.at.y + 1e-3;
            return if climbs { Footing::Wall { normal, back: f32::INFINITY } } else { Footing::Slip(support) };
        };
        let height = floor.height + hover(self.radius, floor.normal);
        let lifted = self.height - height;
        if lifted <= NUDGE {
            let level = floor.height;
            return Footing::Support(Support { height, level, collider: floor.collider, ..support });
        }
        let flat = Vec3::new(self.hit.normal.x, 0.0, self.hit.normal.z).length();
        let back = if flat > 1e-3 { lifted * self.hit.normal.y.max(0.0) / flat } else { f32::INFINITY };
        Footing::Wall { normal, back }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn floor(height: f32) -> Option<Floor> {
        Some(Floor { height, normal: Vec3::Y, collider: Entity::PLACEHOLDER })
    }

    #[test]
    fn the_root_stands_on_the_surface_not_on_the_ball() {
        let on_slope = level(0.04, 0.05, 0.04, floor(0.0));
        assert!(on_slope.abs() < 1e-6, "stands {on_slope} m above a slope");
    }

    #[test]
    fn the_root_does_not_drop_from_an_edge() {
        let over_cliff = level(-0.05, 0.0, 0.03, None);
        assert!(over_cliff.abs() < 1e-6, "dropped to {over_cliff} m");
        let over_stair = level(-0.01, 0.0, 0.01, floor(-0.17));
        assert!((-0.03..0.0).contains(&over_stair), "dropped to {over_stair} m");
    }
}
