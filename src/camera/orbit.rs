//! Where the camera wants to be: on an arm behind a pivot that follows the target.
//!
//! World space, metres, +Y up. Yaw 0 looks along -Z and grows to the left; pitch grows as the camera climbs above the pivot
//! and looks down. Reads the target's position; nothing here knows walls.

use bevy::{math::ops, prelude::*};

use super::{
    config::OrbitCameraConfig,
    follow::{approach, track},
};
use crate::math::spring::{Spring, damp, damp_vec3};

/// A camera on an arm around `target`.
#[derive(Component, Reflect, Clone, Copy, Debug, PartialEq)]
#[reflect(Component)]
#[require(OrbitCameraConfig, OrbitCameraState, CameraInput, Transform)]
pub struct OrbitCamera {
    /// Whom it follows; its translation is the ground between the feet.
    pub target: Entity,
    /// Wanted yaw in radians.
    pub yaw: f32,
    /// Wanted pitch in radians, kept within the config's limits.
    pub pitch: f32,
    /// Wanted length of the arm in metres, kept within the config's limits.
    pub distance: f32,
}

impl OrbitCamera {
    /// Behind and a little above a target that faces -Z.
    #[must_use]
    pub fn around(target: Entity) -> Self {
        Self { target, yaw: 0.0, pitch: 0.22, distance: 4.0 }
    }

    /// The same, with the camera behind someone who faces `yaw` radians.
    #[must_use]
    pub fn facing(self, yaw: f32) -> Self {
        Self { yaw, ..self }
    }
}

/// What the player wants of the camera since the last frame. Whoever reads the devices adds to it; the camera takes it and leaves
/// zero.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component)]
pub struct CameraInput {
    /// Radians to turn the view: x to the right, y up.
    pub orbit: Vec2,
    /// Steps to move nearer (above 0) or farther (below 0).
    pub zoom: f32,
}

/// What an [`OrbitCamera`] carries from frame to frame.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct OrbitCameraState {
    /// The followed point on the plan (its y is unused), world space.
    pub ground: Spring<Vec3>,
    /// The followed height, world space.
    pub height: Spring<f32>,
    /// Metres that the pivot looks ahead on the plan, world space.
    pub ahead: Vec3,
    /// Yaw, pitch in radians and arm in metres as shown, on their way to the wanted ones.
    pub shown: Shown,
    /// Metres by which walls have shortened the arm.
    pub shortened: f32,
    /// Field of view in radians as shown.
    pub field_of_view: f32,
    last: Option<Last>,
}

/// An orbit as shown in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shown {
    /// Radians.
    pub yaw: f32,
    /// Radians.
    pub pitch: f32,
    /// Metres.
    pub distance: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Last {
    target: Vec3,
    yaw: f32,
    pitch: f32,
}

/// Where the camera wants to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arm {
    /// Above the target as it is, inside its own width: a point that is never inside a wall. World space.
    pub axis: Vec3,
    /// The arm's root: above the target as followed, ahead of it and over its shoulder. World space.
    pub root: Vec3,
    /// How the camera is turned, world space; it looks along -Z.
    pub rotation: Quat,
    /// Length of the arm in metres, back along the view.
    pub length: f32,
}

impl OrbitCamera {
    /// Takes the player's wishes into yaw, pitch and distance, within the limits. Wishes that are not numbers are ignored.
    pub fn steer(&mut self, input: CameraInput, config: &OrbitCameraConfig) {
        let finite = |value: f32| if value.is_finite() { value } else { 0.0 };
        self.yaw -= finite(input.orbit.x);
        self.pitch = within(self.pitch - finite(input.orbit.y), config.lowest_pitch, config.highest_pitch);
        let zoomed = self.distance * ops::powf(config.zoom_step.clamp(0.1, 1.0), finite(input.zoom));
        self.distance = within(zoomed, config.nearest, config.farthest);
    }
}

impl OrbitCameraState {
    /// Follows `target`, the world position of its feet, for `dt` seconds; jumps there at first and after a teleport.
    pub fn advance(&mut self, camera: &OrbitCamera, config: &OrbitCameraConfig, target: Vec3, dt: f32) -> Arm {
        let now = Last { target, yaw: camera.yaw, pitch: camera.pitch };
        let last = self.last.filter(|last| last.target.distance(target) <= config.teleport);
        self.last = Some(now);
        if let Some(last) = last {
            self.follow(last, now, camera, config, dt);
        } else {
            let shown = Shown { yaw: camera.yaw, pitch: camera.pitch, distance: camera.distance };
            let (ground, height) = (Spring::at(target.with_y(0.0)), Spring::at(target.y));
            let field_of_view = config.field_of_view;
            *self = Self { ground, height, shown, field_of_view, last: self.last, ..Self::default() };
        }
        self.arm(config, target)
    }

    fn follow(&mut self, last: Last, now: Last, camera: &OrbitCamera, config: &OrbitCameraConfig, dt: f32) {
        let flat = |point: Vec3| point.with_y(0.0);
        track(&mut self.ground, flat(last.target), flat(now.target), config.follow_half_life, dt);
        track(&mut self.height, last.target.y, now.target.y, config.climb_half_life, dt);
        let ahead = (self.ground.velocity * config.look_ahead).clamp_length_max(config.most_look_ahead.max(0.0));
        self.ahead = damp_vec3(self.ahead, ahead, config.look_ahead_half_life, dt);
        let turn = config.orbit_half_life;
        self.shown.yaw = approach(self.shown.yaw, last.yaw, now.yaw, turn, dt);
        self.shown.pitch = approach(self.shown.pitch, last.pitch, now.pitch, turn, dt);
        self.shown.distance = damp(self.shown.distance, camera.distance, config.zoom_half_life, dt);
        let speed = self.ground.velocity.length() / config.fast.max(0.1);
        let wide = config.field_of_view + config.widening * (2.0 * speed - 1.0).clamp(0.0, 1.0);
        self.field_of_view = damp(self.field_of_view, wide, config.look_ahead_half_life, dt);
    }

    fn arm(&self, config: &OrbitCameraConfig, target: Vec3) -> Arm {
        let Shown { yaw, pitch, distance } = self.shown;
        let turned = Quat::from_rotation_y(yaw);
        let range = (config.farthest - config.nearest).max(0.01);
        let near = 1.0 - ((distance - config.nearest) / range).clamp(0.0, 1.0);
        let followed = self.ground.value.with_y(self.height.value + config.pivot_height);
        Arm {
            axis: target + Vec3::Y * config.pivot_height,
            root: followed + self.ahead + turned * Vec3::X * (config.shoulder * near),
            rotation: turned * Quat::from_rotation_x(-pitch),
            length: distance,
        }
    }
}

/// `value` between two limits given in either order.
fn within(value: f32, one: f32, other: f32) -> f32 {
    value.clamp(one.min(other), one.max(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> OrbitCamera {
        OrbitCamera::around(Entity::PLACEHOLDER)
    }

    /// The end of the arm after a walk with a corner, a climb, a turn of the view and a zoom, at `rate` frames a second.
    fn end_of_arm(rate: u32) -> Vec3 {
        let (config, mut camera, mut state) = (OrbitCameraConfig::default(), camera(), OrbitCameraState::default());
        let dt = 1.0 / rate as f32;
        let mut arm = state.advance(&camera, &config, Vec3::ZERO, 0.0);
        for frame in 1..=rate * 2 {
            let time = frame as f32 * dt;
            let target = Vec3::new(3.0 * (time - 1.0).max(0.0), 0.5 * time, -2.0 * time.min(1.0));
            camera.steer(CameraInput { orbit: Vec2::new(0.8, 0.1) * dt, zoom: 0.0 }, &config);
            if frame == rate {
                camera.steer(CameraInput { orbit: Vec2::ZERO, zoom: -3.0 }, &config);
            }
            arm = state.advance(&camera, &config, target, dt);
        }
        arm.root + arm.rotation * Vec3::Z * arm.length
    }

    #[test]
    fn every_frame_rate_shows_the_same_picture() {
        let reference = end_of_arm(240);
        for rate in [30, 60, 144] {
            let off = end_of_arm(rate).distance(reference);
            assert!(off < 0.02, "{off:.4} m off at {rate} Hz");
        }
    }

    #[test]
    fn zoom_reaches_both_limits_and_no_farther() {
        let config = OrbitCameraConfig::default();
        for (zoom, limit) in [(100.0, 1.5), (-100.0, 12.0)] {
            let (mut camera, mut state) = (camera(), OrbitCameraState::default());
            state.advance(&camera, &config, Vec3::ZERO, 0.0);
            camera.steer(CameraInput { orbit: Vec2::ZERO, zoom }, &config);
            for _ in 0..120 {
                state.advance(&camera, &config, Vec3::ZERO, 1.0 / 60.0);
            }
            let length = state.shown.distance;
            assert!((length - limit).abs() < 1e-3, "{length} m, not {limit}");
        }
    }

    #[test]
    fn pitch_stays_within_its_limits_and_nonsense_is_ignored() {
        let config = OrbitCameraConfig::default();
        let mut camera = camera();
        camera.steer(CameraInput { orbit: Vec2::new(0.0, -9.0), zoom: f32::NAN }, &config);
        assert!((camera.pitch - config.highest_pitch).abs() < 1e-6, "pitch {}", camera.pitch);
        let before = camera;
        camera.steer(CameraInput { orbit: Vec2::NAN, zoom: f32::INFINITY }, &config);
        assert_eq!(camera, before);
    }

    #[test]
    fn stairs_do_not_shake_the_picture() {
        let (config, camera, mut state) = (OrbitCameraConfig::default(), camera(), OrbitCameraState::default());
        let mut arm = state.advance(&camera, &config, Vec3::ZERO, 0.0);
        let (mut fastest, mut speed_before) = (0.0f32, 0.0);
        for frame in 1..240 {
            // 1.4 m/s over 29 cm treads, 17 cm up at once.
            let steps = (frame as f32 / 60.0 * 1.4 / 0.29).floor();
            let height = arm.root.y;
            arm = state.advance(&camera, &config, Vec3::Y * steps * 0.17, 1.0 / 60.0);
            let speed = (arm.root.y - height) * 60.0;
            if frame > 60 {
                fastest = fastest.max((speed - speed_before).abs() * 60.0);
            }
            speed_before = speed;
        }
        assert!(fastest < 25.0, "the picture jolts at {fastest:.1} m/s²");
    }

    #[test]
    fn a_teleport_takes_the_camera_along_at_once() {
        let (config, camera, mut state) = (OrbitCameraConfig::default(), camera(), OrbitCameraState::default());
        state.advance(&camera, &config, Vec3::ZERO, 0.0);
        let far = Vec3::new(40.0, 3.0, 0.0);
        let arm = state.advance(&camera, &config, far, 1.0 / 60.0);
        let off = arm.root.distance(far + Vec3::Y * config.pivot_height);
        assert!(off <= config.shoulder, "{off} m behind");
    }

    #[test]
    fn turning_right_moves_the_view_right() {
        let (config, mut camera, mut state) = (OrbitCameraConfig::default(), camera(), OrbitCameraState::default());
        camera.steer(CameraInput { orbit: Vec2::new(0.3, 0.0), zoom: 0.0 }, &config);
        let arm = state.advance(&camera, &config, Vec3::ZERO, 0.0);
        let view = arm.rotation * Vec3::NEG_Z;
        assert!(view.x > 0.2, "looks along {view}");
    }
}
