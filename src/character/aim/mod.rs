//! Points arms along [`MoveIntent::aim`] while the legs go their way; spine and shoulders take part of what is far aside.
//!
//! Reads the intent and the whole pose; turns spine, shoulders and arms. In model space, so that arms hold still in
//! whatever way hips and chest sway: metres, +Y up, the character faces -Z; yaw left positive, pitch up positive, radians.

mod arm;

use core::f32::consts::FRAC_PI_2;

use bevy::prelude::*;

use self::arm::Arm;
use super::{
    Character,
    animator::CharacterPose,
    bind::CharacterAssets,
    detail::Pacing,
    intent::MoveIntent,
    schedule::{PoseClock, PoseSystems},
};
use crate::{
    anim::{
        leg::{LEFT, RIGHT},
        pose::Pose,
        skeleton::{JointIndex, Skeleton},
    },
    math::{
        fade::Fade,
        rotation::{from_scaled_axis, to_scaled_axis, yaw_and_pitch},
        spring::Pursuit,
    },
    rig::{
        character::CharacterAsset,
        humanoid::HumanoidRole::{Head, Neck},
        tuning::aim::AimConfig,
    },
};

/// A character's aim, carried from frame to frame.
#[derive(Component, Clone, Debug, Default)]
pub struct Aiming {
    /// Yaw and pitch of the arms.
    pub way: Pursuit<Vec2>,
    weight: Fade,
    /// Joints between hips and shoulders, lowest first.
    spine: Vec<JointIndex>,
    /// What keeps the head as it is while the spine turns below it.
    neck: Option<JointIndex>,
    /// Left and right, as far as the body has them.
    arms: [Option<Arm>; 2],
}

impl Aiming {
    /// For the arms of this body.
    #[must_use]
    pub fn new(asset: &CharacterAsset) -> Self {
        let neck = asset.humanoid.get(Neck).or_else(|| asset.humanoid.get(Head));
        let spine = asset.humanoid.spine(&asset.skeleton);
        Self { arms: Arm::both(asset), spine, neck, ..Self::default() }
    }

    /// Goes on where `other` is: for a character whose file has changed.
    pub fn take_over(&mut self, other: &Self) {
        (self.way, self.weight) = (other.way, other.weight);
    }

    /// How far the arms are raised, 0..=1.
    #[must_use]
    pub fn weight(&self) -> f32 {
        self.weight.value()
    }

    /// One frame; `wanted` is the direction in model space to aim along, if any.
    fn follow(&mut self, wanted: Option<Vec3>, config: &AimConfig, dt: f32) {
        let target = if wanted.is_some() { 1.0 } else { 0.0 };
        if (self.weight.target() - target).abs() > 0.5 {
            let pitch = wanted.map_or(self.way.value(), |wanted| wanted_way(wanted, config)).y;
            self.weight.send_to(target, fade_seconds(config, pitch));
        }
        if let Some(wanted) = wanted {
            let goal = wanted_way(wanted, config);
            if self.weight.value() <= 0.0 {
                self.way = Pursuit::at(goal);
            }
            self.way.step(goal, config.fastest, config.half_life, dt);
        }
        self.weight.advance(dt);
    }

    /// Raises the arms. Model matrices are up to date before and after.
    fn apply(&self, pose: &mut Pose, skeleton: &Skeleton, config: &AimConfig) {
        let weight = self.weight.value();
        if weight <= 0.0 {
            return;
        }
        let turn = self.way.value();
        self.turn_trunk(pose, skeleton, turn * (weight * config.trunk));
        let way = turned(turn) * Vec3::NEG_Z;
        for (side, arm) in [LEFT, RIGHT].into_iter().zip(&self.arms) {
            if let Some(arm) = arm.filter(|_| config.arms.contain(side)) {
                arm.shrug(pose, skeleton, turned(turn * (weight * config.shoulder)));
                arm.point(pose, skeleton, way, config.reach, weight);
            }
        }
    }

    /// Turns the spine, each joint by the same share; the head goes on looking where it did.
    fn turn_trunk(&self, pose: &mut Pose, skeleton: &Skeleton, turn: Vec2) {
        let Some(&lowest) = self.spine.first().filter(|_| turn != Vec2::ZERO) else { return };
        let share = from_scaled_axis(to_scaled_axis(turned(turn)) / self.spine.len() as f32);
        let looks = self.neck.map(|neck| pose.rotation(neck));
        for &joint in &self.spine {
            pose.rotate_model(skeleton, joint, share);
            pose.update_model_below(skeleton, joint);
        }
        if let (Some(neck), Some(looks)) = (self.neck, looks) {
            pose.rotate_model(skeleton, neck, looks * pose.rotation(neck).inverse());
        }
        pose.update_model_below(skeleton, lowest);
    }
}

/// Seconds in which an arm that hangs rises to this pitch: higher than level it takes longer.
fn fade_seconds(config: &AimConfig, pitch: f32) -> f32 {
    config.fade * (1.0 + pitch / FRAC_PI_2).max(1.0)
}

/// Yaw and pitch as a rotation in model space.
fn turned(turn: Vec2) -> Quat {
    Quat::from_rotation_y(turn.x) * Quat::from_rotation_x(turn.y)
}

/// Yaw and pitch, within limits, of arms that shall point along `direction`, model space.
#[must_use]
pub fn wanted_way(direction: Vec3, config: &AimConfig) -> Vec2 {
    let most = Vec2::new(config.side_limit, config.up_limit).max(Vec2::ZERO);
    yaw_and_pitch(direction).clamp(-most, most)
}

/// Points arms.
pub struct AimPlugin;

impl Plugin for AimPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(FixedPostUpdate, aim.in_set(PoseSystems::Aim));
    }
}

fn aim(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    mut characters: Query<(&Character, &Transform, &MoveIntent, Option<&Pacing>, &mut Aiming, &mut CharacterPose)>,
) {
    let dt = clock.delta_secs();
    characters.par_iter_mut().for_each(|(character, root, intent, pacing, mut aiming, mut pose)| {
        let (Some(asset), Some(dt)) = (assets.get(character), Pacing::whole(pacing, dt)) else { return };
        let config = &asset.file.aim;
        let wanted = intent.aims().filter(|_| config.enabled);
        if wanted.is_none() && aiming.weight() <= 0.0 {
            return;
        }
        aiming.follow(wanted.map(|way| root.rotation.inverse() * way), config, dt);
        aiming.apply(&mut pose.pose, &asset.skeleton, config);
    });
}
