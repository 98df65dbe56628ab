//! What a flying foot must clear: the ground along its way, looked at in a row of places.
//!
//! World space, metres, +Y up.

use bevy::prelude::*;

use super::{
    ground::Probe,
    surroundings::{GroundFrames, Surroundings},
};
use crate::math::{rotation::direction_or, spring::damp};

/// Places along the way: on a stride of a walk they are 9 cm apart.
const PLACES: usize = 20;
/// Metres between two places, at least.
const APART: f32 = 0.05;
/// Metres by which a landing may move before the way is looked over again.
const MOVED: f32 = 0.02;
/// Half-life in seconds over which a new look at the way takes the place of the old one.
const LOOK_HALF_LIFE: f32 = 0.03;
/// Share of the way in which a foot comes down again behind what it has passed.
const BEHIND: f32 = 0.3;
/// Height in metres from which on an obstacle gets the full clearance.
const OBSTACLE: f32 = 0.05;
/// Shares of the time in the air, after take-off and before landing, in which lifts grow and end.
const RISE: f32 = 0.3;
const FALL: f32 = 0.35;

/// What stands along the way from take-off to landing.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Way {
    /// Metres, for every place, by which the foot must fly over the line from take-off to landing: as seen last, and smoothed.
    seen: [f32; PLACES],
    lifts: [f32; PLACES],
    start: Vec3,
    along: Vec3,
    length: f32,
    apart: f32,
    heel: f32,
    size: f32,
    /// The landing that was looked for.
    landing: Option<Vec3>,
}

impl Way {
    /// Looks over the way, where it is new. The sole flies turned to `normal`.
    pub(super) fn look<P: Probe, G: GroundFrames>(
        &mut self,
        [takeoff, landing]: [Vec3; 2],
        forward: Vec3,
        normal: Vec3,
        around: &Surroundings<'_, P, G>,
    ) {
        let first = self.landing.is_none();
        if self.landing.is_none_or(|last| last.distance(landing) > MOVED * around.size) {
            let way = (landing - takeoff).with_y(0.0);
            let (heel, tip) = (around.sole.heel, around.sole.tip);
            self.landing = Some(landing);
            self.along = direction_or(way, forward);
            self.length = way.length();
            (self.heel, self.size) = (heel, around.size);
            let apart = APART * around.size;
            self.start = takeoff;
            self.apart = apart.max((self.length + heel + tip) / (PLACES - 1) as f32);
            let grade = (landing.y - takeoff.y) / self.length.max(apart);
            let slope = -normal.dot(self.along) / normal.y.max(0.2);
            for (place, seen) in self.seen.iter_mut().enumerate() {
                let at = self.apart * place as f32 - heel;
                // The lowest that the sole passes here, somewhere between its toes and its heel.
                let ball = |ball: f32| (grade - slope) * ball.max(0.0).min(self.length);
                let sole = takeoff.y + slope * at + ball(at - tip).min(ball(at + heel));
                let ground = around.reach.height(around.probe, takeoff + self.along * at);
                let over = ground.map_or(0.0, |ground| ground - sole);
                *seen = 0.0;
                if over > 0.0 {
                    *seen = over + around.config.clearance * smooth(over / (OBSTACLE * around.size));
                }
            }
        }
        for (lift, seen) in self.lifts.iter_mut().zip(self.seen) {
            *lift = if first { seen } else { damp(*lift, seen, LOOK_HALF_LIFE, around.dt) };
        }
    }

    /// Metres by which the highest thing in the way stands over the line.
    pub(super) fn highest(&self) -> f32 {
        self.lifts.iter().copied().fold(0.0, f32::max)
    }

    /// Length of the leg as a factor on the mannequin's; 1 before the first look.
    pub(super) fn size(&self) -> f32 {
        if self.landing.is_some() { self.size } else { 1.0 }
    }

    /// Metres by which the first things in the way, within a foot's length before the toes, stand over the line.
    pub(super) fn ahead(&self) -> f32 {
        let near = 2.0 * self.heel;
        (0..PLACES)
            .filter(|place| self.apart * *place as f32 - self.heel < near)
            .map(|at| self.lifts[at])
            .fold(0.0, f32::max)
    }

    /// Metres by which a foot with its ball at `ball` flies over the line, `share` (0..1) of its time in the air passed.
    ///
    /// At once as high as the highest thing ahead asks, and lower behind it.
    pub(super) fn lift(&self, ball: Vec3, share: f32) -> f32 {
        let heel = (ball - self.start).dot(self.along) - self.heel;
        let most = (0..PLACES)
            .map(|place| {
                let passed = heel - (self.apart * place as f32 - self.heel);
                self.lifts[place] * smooth(1.0 - passed / (BEHIND * self.length).max(APART * self.size))
            })
            .fold(0.0, f32::max);
        most * smooth(share / RISE) * smooth((1.0 - share) / FALL)
    }
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A thing of 0.2 m, 0.3 m ahead, on a way of 0.8 m.
    fn way() -> Way {
        let mut way = Way { along: Vec3::NEG_Z, length: 0.8, apart: 0.05, heel: 0.19, size: 1.0, ..Way::default() };
        way.lifts[10] = 0.2;
        way
    }

    #[test]
    fn a_foot_is_up_before_it_meets_what_stands_in_its_way_and_down_after() {
        let before = way().lift(Vec3::NEG_Z * 0.2, 0.4);
        assert!((before - 0.2).abs() < 1e-6, "{before} m high before a thing that needs 0.2 m");
        let after = way().lift(Vec3::NEG_Z * 0.8, 0.7);
        assert!(after.abs() < 1e-6, "still {after} m high behind it");
    }

    #[test]
    fn neither_take_off_nor_landing_is_lifted() {
        let lifts = [0.0, 1.0].map(|share| way().lift(Vec3::NEG_Z * 0.2, share));
        assert!(lifts[0].abs() + lifts[1].abs() < 1e-6, "lifted by {lifts:?} m at the ends");
    }
}
