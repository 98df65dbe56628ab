//! Points arms along [`MoveIntent::aim`] while the legs go their way.
//!
//! Reads the intent and the whole pose; turns upper arm, forearm and hand. In model space, so that arms hold still in
//! whatever way hips and chest sway: metres, +Y up, the character faces -Z; yaw left positive, pitch up positive, radians.

use bevy::prelude::*;

use super::{
    Character,
    animator::CharacterPose,
    bind::CharacterAssets,
    detail::Pacing,
    intent::MoveIntent,
    legs::{LegJoints, place_leg},
    schedule::PoseSystems,
};
use crate::{
    anim::{
        blend::lerp,
        ik::two_bone::Extension,
        leg::{LEFT, RIGHT},
        pose::Pose,
        skeleton::Skeleton,
    },
    math::{
        fade::Fade,
        rotation::{direction_or, shortest_arc, yaw_and_pitch},
        spring::Spring,
    },
    rig::{
        character::CharacterAsset,
        humanoid::HumanoidRole::{LeftHand, LeftLowerArm, LeftUpperArm, RightHand, RightLowerArm, RightUpperArm},
        tuning::aim::AimConfig,
    },
};

/// Fastest that arms turn, rad/s: an aim that crosses behind the back leaves one limit for the other.
const FASTEST: f32 = 12.0;

/// A character's aim, carried from frame to frame.
#[derive(Component, Clone, Debug, Default)]
pub struct Aiming {
    /// Yaw and pitch of the arms.
    pub way: Spring<Vec2>,
    weight: Fade,
    /// Left and right, as far as the body has them.
    arms: [Option<Arm>; 2],
}

/// An arm that points.
#[derive(Clone, Copy, Debug)]
struct Arm {
    joints: LegJoints,
    /// Where the hand points when it goes on straight from the forearm, in its own space.
    forward: Vec3,
}

impl Aiming {
    /// For the arms of this body.
    #[must_use]
    pub fn new(asset: &CharacterAsset) -> Self {
        let rest = Pose::rest(&asset.skeleton);
        let roles = [[LeftUpperArm, LeftLowerArm, LeftHand], [RightUpperArm, RightLowerArm, RightHand]];
        let arms = roles.map(|roles| {
            let [upper, lower, hand] = roles.map(|role| asset.humanoid.get(role));
            let joints = LegJoints { upper: upper?, lower: lower?, foot: hand? };
            let along = direction_or(rest.position(joints.foot) - rest.position(joints.lower), Vec3::NEG_Y);
            Some(Arm { joints, forward: rest.rotation(joints.foot).inverse() * along })
        });
        Self { arms, ..Self::default() }
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
            self.weight.send_to(target, config.fade);
        }
        if let Some(wanted) = wanted {
            let goal = wanted_way(wanted, config);
            if self.weight.value() <= 0.0 {
                self.way = Spring::at(goal);
            }
            let before = self.way.value;
            self.way.step(goal, config.half_life, dt);
            self.way.value = before + (self.way.value - before).clamp_length_max(FASTEST * dt.max(0.0));
            self.way.velocity = self.way.velocity.clamp_length_max(FASTEST);
        }
        self.weight.advance(dt);
    }

    /// Raises the arms. Model matrices are up to date before and after.
    fn apply(&self, pose: &mut Pose, skeleton: &Skeleton, config: &AimConfig) {
        let weight = self.weight.value();
        let Vec2 { x: yaw, y: pitch } = self.way.value;
        let way = Quat::from_rotation_y(yaw) * Quat::from_rotation_x(pitch) * Vec3::NEG_Z;
        for (side, arm) in [LEFT, RIGHT].into_iter().zip(&self.arms) {
            if let Some(arm) = arm.filter(|_| weight > 0.0 && config.arms.contain(side)) {
                arm.point(pose, skeleton, way, config.reach, weight);
            }
        }
    }
}

/// Yaw and pitch, within limits, of arms that shall point along `direction`, model space.
#[must_use]
pub fn wanted_way(direction: Vec3, config: &AimConfig) -> Vec2 {
    let most = Vec2::new(config.side_limit, config.up_limit).max(Vec2::ZERO);
    yaw_and_pitch(direction).clamp(-most, most)
}

impl Arm {
    /// Brings the arm by `weight` to point along `way`, its wrist `reach` times its length from the shoulder.
    fn point(&self, pose: &mut Pose, skeleton: &Skeleton, way: Vec3, reach: f32, weight: f32) {
        let LegJoints { upper, lower, foot: hand } = self.joints;
        let joints = [upper, lower, hand];
        let before = joints.map(|joint| pose.local(joint));
        let hand_from_forearm = pose.rotation(lower).inverse() * pose.rotation(hand);
        let shoulder = pose.position(upper);
        let length = shoulder.distance(pose.position(lower)) + pose.position(lower).distance(pose.position(hand));
        let extension = Extension { soft: reach, hard: reach.max(Extension::default().hard) };
        // An arm that hangs straight bends backward, and once it is raised downward.
        place_leg(pose, skeleton, self.joints, shoulder + way * (length * reach), Quat::IDENTITY, Vec3::Z, extension);
        let carried = pose.rotation(lower) * hand_from_forearm;
        let aimed = shortest_arc(carried * self.forward, way) * carried;
        pose.rotate_model(skeleton, hand, aimed * pose.rotation(hand).inverse());
        for (joint, before) in joints.into_iter().zip(before) {
            pose.set_local(joint, lerp(before, pose.local(joint), weight));
        }
        pose.update_model_below(skeleton, upper);
    }
}

/// Points arms.
pub struct AimPlugin;

impl Plugin for AimPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, aim.in_set(PoseSystems::Aim));
    }
}

fn aim(
    time: Res<Time>,
    assets: CharacterAssets,
    mut characters: Query<(&Character, &Transform, &MoveIntent, Option<&Pacing>, &mut Aiming, &mut CharacterPose)>,
) {
    let dt = time.delta_secs();
    characters.par_iter_mut().for_each(|(character, root, intent, pacing, mut aiming, mut pose)| {
        let (Some(asset), Some(dt)) = (assets.get(character), Pacing::due(pacing, dt)) else { return };
        let config = &asset.file.aim;
        let wanted = intent.aims().filter(|_| config.enabled);
        if wanted.is_none() && aiming.weight() <= 0.0 {
            return;
        }
        aiming.follow(wanted.map(|way| root.rotation.inverse() * way), config, dt);
        aiming.apply(&mut pose.pose, &asset.skeleton, config);
    });
}
