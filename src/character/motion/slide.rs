//! Moves a shape through the world and along what it meets. World space, metres.

use avian3d::prelude::Collider;
use bevy::prelude::*;

use super::{
    body::{MotionBody, Push},
    planes::Planes,
    slope::{as_wall, walkable},
    space::{Hit, View},
};
use crate::rig::tuning::motion::MotionConfig;

/// Most sweeps in one slide. A corner takes three.
const SWEEPS: usize = 4;

/// Ways shorter than this, in metres, are no movement.
const SHORTEST: f32 = 1e-5;

/// One tick's movement: the view, the tuning, and what was met so far.
pub(super) struct Slider<'a> {
    pub(super) view: &'a View<'a>,
    pub(super) config: &'a MotionConfig,
    pub(super) limit_cos: f32,
    pub(super) dt: f32,
    /// What was met, for the velocity.
    pub(super) planes: Planes,
    /// World velocity that the character wants to have, for pushing, m/s.
    pub(super) velocity: Vec3,
    /// Whether the capsule began inside something.
    pub(super) stuck: bool,
}

impl Slider<'_> {
    /// Slides horizontally: everything met is an upright wall.
    pub(super) fn walk(&mut self, body: &mut MotionBody, shape: &Collider, from: Vec3, way: Vec3) -> Vec3 {
        self.slide(body, shape, from, way, |hit, _, _| as_wall(hit.normal))
    }

    /// Slides freely; steep ground doesn't turn a horizontal way into a climb.
    pub(super) fn fly(&mut self, body: &mut MotionBody, shape: &Collider, from: Vec3, way: Vec3) -> Vec3 {
        let limit_cos = self.limit_cos;
        self.slide(body, shape, from, way, |hit, left, slid| {
            let climbs = slid.y > left.y.max(0.0) + 1e-6;
            let steep = hit.normal.y > 0.0 && !walkable(hit.normal, limit_cos);
            if climbs && steep { as_wall(hit.normal) } else { hit.normal }
        })
    }

    fn slide(
        &mut self,
        body: &mut MotionBody,
        shape: &Collider,
        from: Vec3,
        way: Vec3,
        normal_of: impl Fn(&Hit, Vec3, Vec3) -> Vec3,
    ) -> Vec3 {
        let (mut at, mut left) = (from, way);
        for _ in 0..SWEEPS {
            let length = left.length();
            if length < SHORTEST {
                break;
            }
            let Some(hit) = self.view.sweep(shape, at, left) else {
                return at + left;
            };
            self.stuck |= hit.distance < 1e-4;
            at += left * (hit.safe / length);
            left *= 1.0 - hit.safe / length;
            let slid = left - hit.normal * left.dot(hit.normal).min(0.0);
            let normal = normal_of(&hit, left, slid);
            if normal == Vec3::ZERO {
                break;
            }
            let speed = self.meet(body, &hit, normal);
            self.planes.push(normal, speed);
            left = self.planes.slide(left);
        }
        at
    }

    /// Speed with which what was hit comes along `normal`; notes a push if it is a dynamic body.
    fn meet(&self, body: &mut MotionBody, hit: &Hit, normal: Vec3) -> f32 {
        let Some(met) = self.view.body(hit.collider, self.dt) else {
            return 0.0;
        };
        let coming = met.velocity_at(hit.point, self.dt).dot(normal);
        let closing = -self.velocity.dot(normal) + coming;
        if !met.dynamic || closing <= 0.0 || body.pushes.iter().any(|push| push.body == met.entity) {
            return coming;
        }
        let impulse = (met.mass * closing).min(self.config.push_force * self.dt);
        // At the height of its centre, so that it slides rather than topples.
        let point = hit.point.with_y(met.centre.y);
        body.pushes.push(Push { body: met.entity, point, impulse: -normal * impulse });
        // It gives way by what the impulse does to it.
        coming - impulse / met.mass.max(1e-3)
    }
}
