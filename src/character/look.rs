//! Turns the head: along the aim, ahead of a turn, along the slope, or at a point, and keeps it level while the body leans.
//!
//! Reads `MoveIntent`, `MotionState`, [`Balance`] and the pose with its feet placed; turns chest, neck and head. Model space: metres,
//! +Y up, the character faces -Z; yaw left positive, pitch up positive, radians.

use bevy::{math::ops, prelude::*};

use super::{
    Character,
    animator::{Balance, CharacterPose},
    bind::CharacterAssets,
    detail::{Detail, Pacing},
    intent::MoveIntent,
    locomotion::Locomotion,
    motion::MotionState,
    schedule::{PoseClock, PoseSystems},
};
use crate::{
    anim::pose::Pose,
    math::{
        rotation::{from_scaled_axis, heading, to_scaled_axis, yaw_and_pitch},
        spring::{Pursuit, damp},
    },
    rig::{character::CharacterAsset, humanoid::HumanoidRole, tuning::look::LookConfig},
};

/// A point in the world that a character looks at as far as its neck goes: put it on the character.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct LookAt(pub Vec3);

/// A character's gaze, carried from frame to frame.
#[derive(Component, Clone, Debug, Default)]
pub struct Look {
    /// Yaw and pitch against the clip's.
    pub gaze: Pursuit<Vec2>,
    /// How much of the look is off, 0..=1: for those that are seen small.
    pub off: f32,
}

/// Turns below this, in radians, are none.
const NOTHING: f32 = 1e-4;

/// Share of the look that may be missing.
const NEARLY: f32 = 0.999;

/// Turns heads.
pub struct LookPlugin;

impl Plugin for LookPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(FixedPostUpdate, look.in_set(PoseSystems::Look));
    }
}

/// Yaw and pitch that the gaze shall have for a body that moves so, over ground of this grade.
#[must_use]
pub fn wanted_gaze(motion: &MotionState, grade: f32, config: &LookConfig) -> Vec2 {
    let speed = motion.ground_velocity.with_y(0.0).length();
    let yaw = motion.turn_ahead + motion.ground_yaw_rate * config.ahead;
    let pitch = ops::atan(grade) * config.slope * speed.min(1.0);
    limited(Vec2::new(yaw, pitch), config)
}

/// Yaw and pitch from the head at `from` to `point`, model space.
#[must_use]
pub fn gaze_at(from: Vec3, point: Vec3, config: &LookConfig) -> Vec2 {
    let way = point - from;
    let across = way.with_y(0.0).length();
    if across < 1e-3 {
        return Vec2::ZERO;
    }
    limited(Vec2::new(heading(way), ops::atan(way.y / across)), config)
}

fn limited(gaze: Vec2, config: &LookConfig) -> Vec2 {
    let most = Vec2::new(config.side_limit, config.up_limit).max(Vec2::ZERO);
    gaze.clamp(-most, most)
}

/// Turns chest, neck and head by `turn`, axis times radians in model space. Model matrices are stale afterwards.
fn apply(turn: Vec3, pose: &mut Pose, asset: &CharacterAsset, config: &LookConfig) {
    let Some(head) = asset.humanoid.get(HumanoidRole::Head) else { return };
    let chest = asset.humanoid.get(HumanoidRole::UpperChest).or_else(|| asset.humanoid.get(HumanoidRole::Chest));
    let mut left = 1.0;
    // All turns are about one axis, so each may be made in the frame that its joint had.
    for (joint, share) in [(asset.humanoid.get(HumanoidRole::Neck), config.neck), (chest, config.chest)] {
        if let Some(joint) = joint {
            pose.rotate_model(&asset.skeleton, joint, from_scaled_axis(turn * share));
            left -= share;
        }
    }
    pose.rotate_model(&asset.skeleton, head, from_scaled_axis(turn * left));
}

fn look(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    mut characters: Query<(
        &Character,
        &Transform,
        &MoveIntent,
        &MotionState,
        &Locomotion,
        &Balance,
        Option<&LookAt>,
        (Option<&Detail>, Option<&Pacing>),
        &mut Look,
        &mut CharacterPose,
    )>,
) {
    let dt = clock.delta_secs();
    characters.par_iter_mut().for_each(|character| {
        let (character, root, intent, motion, locomotion, balance, target, (detail, pacing), mut look, mut pose) =
            character;
        let (Some(asset), Some(dt)) = (assets.get(character), Pacing::whole(pacing, dt)) else { return };
        let config = &asset.file.look;
        if !config.enabled {
            return;
        }
        let off = if detail.is_none_or(|detail| detail.look) { 0.0 } else { 1.0 };
        look.off = damp(look.off, off, config.half_life, dt);
        if look.off > NEARLY {
            return;
        }
        let goal = match (intent.aims(), target, asset.humanoid.get(HumanoidRole::Head)) {
            (Some(aim), ..) => limited(yaw_and_pitch(root.rotation.inverse() * aim), config),
            (None, Some(target), Some(head)) if target.0.is_finite() => {
                let point = root.to_isometry().inverse() * target.0;
                gaze_at(pose.pose.position(head), point, config)
            }
            _ => wanted_gaze(motion, locomotion.grade(), config),
        };
        look.gaze.step(goal, config.fastest, config.half_life, dt);
        let Vec2 { x: yaw, y: pitch } = look.gaze.value();
        let gaze = Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch);
        let lean = if asset.file.balance.enabled { balance.whole() } else { Vec3::ZERO };
        let turn = (to_scaled_axis(gaze) - lean * config.level) * (1.0 - look.off);
        if turn.length() > NOTHING {
            apply(turn, &mut pose.pose, asset, config);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gaze_goes_into_a_turn_before_the_body_and_within_limits() {
        let config = LookConfig::default();
        let turning = MotionState { turn_ahead: 0.4, ground_yaw_rate: 1.0, ..default() };
        let gaze = wanted_gaze(&turning, 0.0, &config);
        assert!((gaze.x - 0.65).abs() < 1e-4 && gaze.y.abs() < 1e-6, "{gaze}");
        let about = MotionState { turn_ahead: 3.0, ground_yaw_rate: 12.0, ..default() };
        assert!((wanted_gaze(&about, 0.0, &config).x - config.side_limit).abs() < 1e-4);
        assert_eq!(wanted_gaze(&MotionState::default(), 0.5, &config), Vec2::ZERO, "who stands looks ahead");
    }

    #[test]
    fn a_point_is_looked_at_as_far_as_the_neck_goes() {
        let config = LookConfig::default();
        let head = Vec3::Y * 1.6;
        let gaze = gaze_at(head, Vec3::new(-1.0, 1.6, -1.0), &config);
        assert!((gaze.x.to_degrees() - 45.0).abs() < 0.01 && gaze.y.abs() < 1e-4, "{gaze} to the left");
        let gaze = gaze_at(head, Vec3::new(0.0, 50.0, -1.0), &config);
        assert!((gaze.y - config.up_limit).abs() < 1e-4, "{gaze} up");
        assert_eq!(gaze_at(head, head, &config), Vec2::ZERO, "a point within the head has no direction");
    }
}
