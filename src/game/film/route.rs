//! Follows a row of points over the course, each leg at its own speed. Pure; world space, metres, only x and z count.

use bevy::math::{Vec2, Vec3, Vec3Swizzles};

/// Metres ahead on the way that the walker aims for: small turns sharply at each point, large cuts corners.
const LOOK_AHEAD: f32 = 1.2;
/// Metres from the end of the way at which the walker stops.
const ARRIVAL: f32 = 0.3;

/// A point of the way, and how to get there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// The point, as (x, z).
    pub to: Vec2,
    /// Speed on the way to it, m/s.
    pub speed: f32,
}

/// Where a walker on the way should go now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading {
    /// Level direction, length 1.
    pub direction: Vec3,
    /// Speed, m/s.
    pub speed: f32,
}

/// Where a walker who keeps to the way will be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The place, as (x, z).
    pub position: Vec2,
    /// Level direction of the way there, as (x, z), length 1.
    pub direction: Vec2,
    /// Metres of the way behind it.
    pub travelled: f32,
}

/// A way, and how far along it the walker is.
#[derive(Clone, Debug)]
pub struct Route {
    legs: Vec<Leg>,
    /// The point where the walker set out.
    start: Vec2,
    /// The leg under way.
    leg: usize,
}

impl Route {
    /// A way from `start` through all `legs`.
    #[must_use]
    pub fn new(start: Vec3, legs: Vec<Leg>) -> Self {
        Self { legs, start: start.xz(), leg: 0 }
    }

    /// Where to go from `position`; `None` at the end.
    pub fn heading(&mut self, position: Vec3) -> Option<Heading> {
        let position = position.xz();
        loop {
            let leg = *self.legs.get(self.leg)?;
            let last = self.leg + 1 == self.legs.len();
            let left = self.left_on_leg(position);
            if left > if last { ARRIVAL } else { LOOK_AHEAD } {
                // A point on this leg, a step ahead of where the walker is nearest to it.
                let along = (leg.to - self.leg_start()).normalize_or_zero();
                let aim = leg.to - along * (left - LOOK_AHEAD).max(0.0);
                let direction = (aim - position).try_normalize().unwrap_or(along);
                return Some(Heading { direction: Vec3::new(direction.x, 0.0, direction.y), speed: leg.speed });
            }
            self.leg += 1;
        }
    }

    /// Moments `spacing` seconds apart on the whole way, the first at its start and the last at its end.
    #[must_use]
    pub fn moments(&self, spacing: f32) -> Vec<Moment> {
        let (mut moments, mut from, mut behind, mut wait) = (Vec::new(), self.start, 0.0, 0.0);
        let mut direction = Vec2::NEG_Y;
        for leg in &self.legs {
            let length = from.distance(leg.to);
            direction = (leg.to - from).try_normalize().unwrap_or(direction);
            let stride = (leg.speed * spacing).max(1e-3);
            let mut along = wait * stride;
            while along < length {
                moments.push(Moment { position: from + direction * along, direction, travelled: behind + along });
                along += stride;
            }
            wait = (along - length) / stride;
            behind += length;
            from = leg.to;
        }
        moments.push(Moment { position: from, direction, travelled: behind });
        moments
    }

    /// Metres of the way behind a walker at `position`.
    #[must_use]
    pub fn travelled(&self, position: Vec3) -> f32 {
        let (mut from, mut behind) = (self.start, 0.0);
        for (number, leg) in self.legs.iter().enumerate() {
            behind += from.distance(leg.to);
            if number == self.leg {
                return behind - self.left_on_leg(position.xz()).max(0.0);
            }
            from = leg.to;
        }
        behind
    }

    /// Metres of this leg ahead of the walker, measured along the leg.
    fn left_on_leg(&self, position: Vec2) -> f32 {
        let to = self.legs[self.leg].to;
        let along = (to - self.leg_start()).normalize_or_zero();
        (to - position).dot(along)
    }

    fn leg_start(&self) -> Vec2 {
        self.leg.checked_sub(1).map_or(self.start, |before| self.legs[before].to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Route {
        let corner = |x, z, speed| Leg { to: Vec2::new(x, z), speed };
        Route::new(Vec3::ZERO, vec![corner(6.0, 0.0, 1.4), corner(6.0, 6.0, 3.5), corner(0.0, 6.0, 1.4)])
    }

    /// Walks `route` from `position` in steps of 5 cm; returns all places.
    fn walked(mut route: Route, mut position: Vec3) -> Vec<Vec3> {
        let mut places = vec![position];
        while let Some(heading) = route.heading(position) {
            position += heading.direction * 0.05;
            places.push(position);
            assert!(places.len() < 2000, "still under way at {position}");
        }
        places
    }

    #[test]
    fn the_walker_arrives_at_the_end_and_near_every_point_between() {
        let places = walked(square(), Vec3::ZERO);
        for leg in square().legs {
            let nearest = places.iter().map(|place| place.xz().distance(leg.to)).fold(f32::MAX, f32::min);
            assert!(nearest < LOOK_AHEAD, "passed {} at {nearest:.2} m", leg.to);
        }
        let end = places[places.len() - 1].xz().distance(Vec2::new(0.0, 6.0));
        assert!(end <= ARRIVAL + 0.05, "ended {end:.2} m away");
    }

    #[test]
    fn a_walker_pushed_aside_comes_back_to_the_way() {
        let places = walked(square(), Vec3::new(0.0, 0.0, 2.0));
        let at_half = places.iter().find(|place| place.x > 4.0).unwrap();
        assert!(at_half.z.abs() < 0.3, "still {:.2} m beside the way", at_half.z);
    }

    #[test]
    fn each_leg_has_its_own_speed() {
        let mut route = square();
        let speeds = [Vec3::ZERO, Vec3::new(6.0, 0.0, 1.0)].map(|at| route.heading(at).unwrap().speed);
        assert!((speeds[0] - 1.4).abs() + (speeds[1] - 3.5).abs() < 1e-6, "speeds {speeds:?}");
    }

    #[test]
    fn moments_are_evenly_apart_in_time_and_end_with_the_way() {
        let moments = square().moments(0.5);
        // 6 m at 1.4 m/s, 6 m at 3.5 m/s, 6 m at 1.4 m/s.
        assert_eq!(moments.len(), (2.0f32 * (6.0 / 1.4 + 6.0 / 3.5 + 6.0 / 1.4)).ceil() as usize + 1);
        let way = moments[3].travelled - moments[2].travelled;
        assert!((way - 0.7).abs() < 1e-4, "{way} m in half a second at 1.4 m/s");
        assert!((moments[moments.len() - 1].travelled - 18.0).abs() < 1e-4);
    }

    #[test]
    fn a_walker_knows_how_much_of_the_way_is_behind() {
        let mut route = square();
        assert!((route.travelled(Vec3::new(2.0, 0.0, 0.4)) - 2.0).abs() < 1e-5);
        let _ = route.heading(Vec3::new(5.5, 0.0, 0.5));
        let travelled = route.travelled(Vec3::new(5.9, 0.0, 1.5));
        assert!((travelled - 7.5).abs() < 1e-5, "{travelled} m of 7.5");
    }

    #[test]
    fn a_way_without_points_ends_at_once() {
        assert_eq!(Route::new(Vec3::ZERO, Vec::new()).heading(Vec3::ZERO), None);
    }
}
