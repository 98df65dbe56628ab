//! One tick in the air: the whole capsule flies, slides along what it meets and looks for ground to land on.
//! World space, metres.

use bevy::prelude::*;

use super::{
    body::MotionBody,
    capsule::{MotionShapes, Posture},
    descent::TOUCHING,
    footing::{Footing, Look, Support, footing},
    jump::cut_gravity,
    slide::Slider,
    space::SKIN,
    speed::{SpeedRates, approach_velocity},
};
use crate::{character::intent::MoveIntent, math::rotation::direction_or, rig::tuning::motion::MotionConfig};

/// Seconds without a way down after which a body counts as standing.
const WEDGED: f32 = 0.1;

/// Where a flight of one tick ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flown {
    pub(super) position: Vec3,
    /// Velocity relative to the frame, m/s.
    pub(super) velocity: Vec3,
    /// Ground landed on.
    pub(super) support: Option<Support>,
}

/// Velocity after `dt` seconds in the air: gravity, and a little steering; relative to the frame, m/s.
pub(super) fn air_velocity(velocity: Vec3, intent: &MoveIntent, jumping: bool, config: &MotionConfig, dt: f32) -> Vec3 {
    let rate = config.air_acceleration;
    let flat = Vec3::new(velocity.x, 0.0, velocity.z);
    let rates = SpeedRates { accelerate: rate, brake: rate, reverse: rate };
    // Who wants nothing goes on flying as they jumped.
    let steered =
        if intent.velocity == Vec3::ZERO { flat } else { approach_velocity(flat, intent.velocity, rates, dt) };
    let cut = jumping && velocity.y > 0.0 && !intent.jump;
    let gravity = if cut { cut_gravity(config) } else { config.gravity };
    // A cut jump stops rising at its apex; what is left of the tick falls by the common rule from the next on.
    let least = if cut { 0.0 } else { -config.fall_speed };
    steered.with_y((velocity.y - gravity * dt).max(least))
}

/// Flies for one tick from the body's position.
pub(super) fn fly(
    slider: &mut Slider,
    body: &mut MotionBody,
    shapes: &MotionShapes,
    posture: &Posture,
    velocity: Vec3,
) -> Flown {
    let (dt, from) = (slider.dt, body.position);
    // The mean of both ends' velocities: exact under steady gravity, whatever the tick.
    let way = ((body.velocity + velocity) * 0.5 + body.frame_velocity) * dt;
    let to = slider.fly(body, &posture.flying, from, way);
    let mut velocity = velocity;
    if velocity.y <= 0.0 {
        let down = if body.descent.onto.is_some() { TOUCHING } else { SKIN * 3.0 };
        let look = Look { up: 0.0, down, highest: f32::INFINITY, limit_cos: slider.limit_cos };
        let found = footing(slider.view, shapes, to, look);
        body.wedged = if (to - from).length() < 1e-3 && velocity.y < 0.0 { body.wedged + dt } else { 0.0 };
        match found {
            // A ball is lowered a little further than asked.
            Footing::Support(support) if to.y - support.height <= look.down + 1e-3 => {
                body.wedged = 0.0;
                return Flown { position: to.with_y(support.height), velocity, support: Some(support) };
            }
            Footing::Slip(support) if body.wedged > WEDGED => {
                return Flown { position: to, velocity, support: Some(support) };
            }
            _ => {}
        }
    }
    if !slider.planes.is_empty() {
        let slid = slider.planes.slide(velocity + body.frame_velocity) - body.frame_velocity;
        // What a corner turns aside still rises as it did.
        let kept = if passes_corner(slider, posture, from, velocity, slid) { velocity.y } else { slid.y };
        velocity = slid.with_y(kept);
    }
    Flown { position: to, velocity, support: None }
}

/// Whether what changes a rising body's velocity to `slid` is but the edge of a ceiling: a little aside the way up is free.
fn passes_corner(slider: &Slider, posture: &Posture, from: Vec3, velocity: Vec3, slid: Vec3) -> bool {
    let corner = slider.config.jump_corner;
    let aside = direction_or((slid - velocity).with_y(0.0), Vec3::ZERO) * corner;
    let slowed = velocity.y > 0.0 && slid.y < velocity.y;
    // Far enough up that the round of the head is past the edge.
    let up = Vec3::Y * (2.0 * slider.config.radius);
    let free = |from: Vec3, way: Vec3| slider.view.sweep(&posture.flying, from, way).is_none();
    slowed && aside != Vec3::ZERO && free(from, aside) && free(from + aside, up)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fall_has_a_top_speed() {
        let (config, intent) = (MotionConfig::default(), MoveIntent::default());
        let mut velocity = Vec3::ZERO;
        for _ in 0..1000 {
            velocity = air_velocity(velocity, &intent, false, &config, 1.0 / 64.0);
        }
        assert!((velocity.y + config.fall_speed).abs() < 1e-4, "falls at {} m/s", velocity.y);
    }

    #[test]
    fn a_jump_let_go_falls_sooner() {
        let config = MotionConfig::default();
        let rise = |jump: bool| {
            let intent = MoveIntent { jump, ..default() };
            let (mut velocity, mut height, dt) = (Vec3::Y * 5.0, 0.0, 1.0 / 64.0);
            while velocity.y > 0.0 {
                let next = air_velocity(velocity, &intent, true, &config, dt);
                height += (velocity.y + next.y) * 0.5 * dt;
                velocity = next;
            }
            height
        };
        let (held, tapped) = (rise(true), rise(false));
        let ratio = tapped / held;
        let wanted = config.jump_tap_height / config.jump_height;
        assert!((ratio - wanted).abs() < 0.03, "tapped {tapped} m, held {held} m");
    }
}
