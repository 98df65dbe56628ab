//! Leans the body into accelerations, turns and slopes.
//!
//! Reads `MotionState`, the locomotion's grade and the animated pose; turns pelvis and spine of the pose and sets the legs
//! back onto their feet. Model space: metres, +Y up, the character faces -Z.

use bevy::{math::ops, prelude::*};

use crate::{
    character::{
        Character, animator::CharacterPose, bind::CharacterAssets, detail::Pacing, locomotion::Locomotion,
        motion::MotionState, schedule::PoseClock,
    },
    math::{
        rotation::{direction_or, from_scaled_axis},
        spring::{Spring, damp},
    },
    rig::{character::CharacterAsset, humanoid::HumanoidRole, tuning::balance::BalanceConfig},
};

/// Acceleration of a body that falls over, m/s².
const GRAVITY: f32 = 9.81;
/// Half-life in seconds in which leans fade where there is no ground to push against.
const AIR_HALF_LIFE: f32 = 0.1;
/// Leans below this, in radians, are none.
const NOTHING: f32 = 1e-4;
/// Speed in m/s from which a slope is leaned against fully, and from which on accelerations across are told from those along.
const WALKS: f32 = 1.0;

/// The spine, from below.
const SPINE: [HumanoidRole; 3] = [HumanoidRole::Spine, HumanoidRole::Chest, HumanoidRole::UpperChest];

/// A character's balance, carried from frame to frame.
#[derive(Component, Clone, Debug, Default)]
pub struct Balance {
    /// The lean into accelerations, from the ankles up: what turns upright into it, as axis times radians, model space.
    pub lean: Vec3,
    /// The lean of the trunk to the slope, likewise.
    pub stoop: Vec3,
    /// Velocity over the ground as the body feels it, world; its velocity is the acceleration felt.
    felt: Spring<Vec3>,
    /// How firm the ground is to lean against, 0..1.
    grip: f32,
}

impl Balance {
    /// One frame: what a body turned by `turn` feels. `grade` is the rise over run of its way.
    pub fn feel(&mut self, motion: &MotionState, turn: Quat, grade: f32, config: &BalanceConfig, dt: f32) {
        let flat = motion.ground_velocity.with_y(0.0);
        let grounded = motion.ground.is_some();
        self.felt.step(flat, config.half_life, dt);
        self.grip = damp(self.grip, if grounded { 1.0 } else { 0.0 }, AIR_HALF_LIFE, dt);
        let into_model = turn.inverse();
        self.lean = wanted_lean(into_model * self.felt.velocity, into_model * self.felt.value, config) * self.grip;
        self.stoop = wanted_stoop(into_model * flat, grade, config) * self.grip;
    }

    /// The lean of the chest against the clip's: axis times radians, model space.
    #[must_use]
    pub fn whole(&self) -> Vec3 {
        self.lean + self.stoop
    }
}

/// The lean for an acceleration at a velocity; model space, axis times radians.
#[must_use]
pub fn wanted_lean(acceleration: Vec3, velocity: Vec3, config: &BalanceConfig) -> Vec3 {
    let way = direction_or(velocity, Vec3::ZERO);
    let along = way * acceleration.dot(way);
    let balancing = |acceleration: Vec3| {
        let size = acceleration.length();
        direction_or(acceleration, Vec3::ZERO) * ops::atan(size / GRAVITY)
    };
    let across = acceleration - along;
    // Who hardly moves has no side.
    let side = config.forward + (config.side - config.forward) * (velocity.length() / WALKS).min(1.0);
    limited(balancing(along) * config.forward + balancing(across) * side, config)
}

/// The lean of the trunk for a velocity over ground of this grade; model space, axis times radians.
#[must_use]
pub fn wanted_stoop(velocity: Vec3, grade: f32, config: &BalanceConfig) -> Vec3 {
    let share = if grade > 0.0 { config.uphill } else { config.downhill };
    let toward = direction_or(velocity, Vec3::ZERO) * (ops::atan(grade) * share);
    limited(toward * (velocity.length() / WALKS).min(1.0), config)
}

/// The lean toward a horizontal direction by its length in radians, within limits.
fn limited(toward: Vec3, config: &BalanceConfig) -> Vec3 {
    let ahead = -toward.z;
    let ahead = soft_limit(ahead, if ahead > 0.0 { config.forward_limit } else { config.backward_limit });
    let aside = soft_limit(toward.x, config.side_limit);
    Vec3::Y.cross(Vec3::new(aside, 0.0, -ahead))
}

/// `value` with its size bent so that it never exceeds `most`.
fn soft_limit(value: f32, most: f32) -> f32 {
    if most <= 0.0 { 0.0 } else { most * ops::tanh(value / most) }
}

/// Leans the pose; the feet stay where they are.
fn apply(balance: &Balance, pose: &mut CharacterPose, asset: &CharacterAsset, config: &BalanceConfig) {
    if balance.lean.length() < NOTHING && balance.stoop.length() < NOTHING {
        return;
    }
    let skeleton = &*asset.skeleton;
    pose.keep_feet(asset, |pose| {
        let from_ankles = from_scaled_axis(balance.lean * config.from_ankles);
        let hips = pose.position(asset.hips);
        pose.shift_local(skeleton, asset.hips, from_ankles * hips - hips);
        pose.rotate_model(skeleton, asset.hips, from_ankles);
        let bones = || SPINE.iter().filter_map(|role| asset.humanoid.get(*role));
        let spine = balance.lean * (1.0 - config.from_ankles) + balance.stoop;
        let bend = from_scaled_axis(spine / bones().count().max(1) as f32);
        // All bends are about one axis, so each may be made in the frame that its joint had.
        bones().for_each(|joint| pose.rotate_model(skeleton, joint, bend));
        pose.update_model_of(skeleton, &asset.trunk);
    });
}

pub(super) fn keep_balance(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    mut characters: Query<(
        &Character,
        &Transform,
        &MotionState,
        &Locomotion,
        Option<&Pacing>,
        &mut Balance,
        &mut CharacterPose,
    )>,
) {
    let dt = clock.delta_secs();
    characters.par_iter_mut().for_each(|(character, root, motion, locomotion, pacing, mut balance, mut pose)| {
        let (Some(asset), Some(dt)) = (assets.get(character), Pacing::whole(pacing, dt)) else { return };
        let config = &asset.file.balance;
        if Pacing::begins(pacing) {
            balance.felt = Spring::at(motion.ground_velocity.with_y(0.0));
        }
        balance.feel(motion, root.rotation, locomotion.grade(), config, dt);
        if config.enabled {
            apply(&balance, &mut pose, asset, config);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f32 = 1.0 / 60.0;

    fn standing(velocity: Vec3) -> MotionState {
        let ground =
            crate::character::motion::Ground { entity: Entity::PLACEHOLDER, normal: Vec3::Y, velocity: Vec3::ZERO };
        MotionState { ground_velocity: velocity, ground: Some(ground), ..default() }
    }

    fn feel(balance: &mut Balance, velocity: Vec3, seconds: f32) {
        for _ in 0..(seconds * 60.0) as usize {
            balance.feel(&standing(velocity), Quat::IDENTITY, 0.0, &BalanceConfig::default(), DT);
        }
    }

    /// Where the top of a body with this lean goes, model space.
    fn top(lean: Vec3) -> Vec3 {
        from_scaled_axis(lean) * Vec3::Y
    }

    #[test]
    fn it_leans_forward_into_a_start_and_back_into_a_stop() {
        let mut balance = Balance::default();
        feel(&mut balance, Vec3::ZERO, 1.0);
        feel(&mut balance, Vec3::NEG_Z * 3.5, 0.15);
        assert!(top(balance.lean).z < -0.05, "top at {} while starting", top(balance.lean));
        feel(&mut balance, Vec3::NEG_Z * 3.5, 3.0);
        assert!(balance.lean.length() < 1e-3, "leans by {} at an even pace", balance.lean.length());
        feel(&mut balance, Vec3::ZERO, 0.15);
        assert!(top(balance.lean).z > 0.03, "top at {} while stopping", top(balance.lean));
    }

    #[test]
    fn it_leans_into_a_turn_and_never_beyond_its_limits() {
        let config = BalanceConfig::default();
        let ahead = Vec3::NEG_Z * 3.5;
        let left = wanted_lean(Vec3::NEG_X * 5.0, ahead, &config);
        assert!(top(left).x < -0.1, "top at {} in a turn to the left", top(left));
        for acceleration in [Vec3::X * 1e6, Vec3::Z * 1e6, Vec3::NEG_Z * 1e6] {
            let lean = wanted_lean(acceleration, ahead, &config).length();
            let most = config.side_limit.max(config.forward_limit);
            assert!(lean <= most + 1e-4, "{acceleration} leans by {}°", lean.to_degrees());
        }
    }

    #[test]
    fn it_leans_toward_the_slope_on_the_way_up_and_away_on_the_way_down() {
        let config = BalanceConfig::default();
        let up = wanted_stoop(Vec3::NEG_Z, 0.36, &config);
        let down = wanted_stoop(Vec3::NEG_Z, -0.36, &config);
        assert!((3.0..9.0).contains(&up.length().to_degrees()) && top(up).z < 0.0, "{up} up 20°");
        assert!((2.0..6.0).contains(&down.length().to_degrees()) && top(down).z > 0.0, "{down} down 20°");
        assert_eq!(wanted_stoop(Vec3::ZERO, 0.36, &config), Vec3::ZERO, "who stands stands upright");
    }
}
