//! Records what a viewer sees: final poses against the true colliders, once a frame.

use avian3d::prelude::*;
use bevy::prelude::*;

use super::summary::{FootFrame, Frame};
use crate::{
    anim::{ik::two_bone::bend_angle, leg::Leg, pose::Pose, skeleton::JointTransform},
    character::{
        Character,
        animator::CharacterPose,
        bind::CharacterAssets,
        foot_ik::{FootIk, Frames, GroundFilter, GroundFrames, PhysicsProbe, Pivot, Probe},
        locomotion::Locomotion,
        motion::MotionState,
        schedule::PoseSystems,
        sole::sole_model,
    },
    math::rotation::angle_between,
};

/// Records the frames of the character that it is put on.
#[derive(Component, Clone, Debug, Default)]
pub struct Recorder {
    /// What was recorded, in order of time.
    pub frames: Vec<Frame>,
    clock: f32,
    last: Vec<JointTransform>,
    positions: Vec<Vec3>,
    velocities: Vec<Vec3>,
}

/// Fills [`Recorder`]s.
pub struct MeasurePlugin;

impl Plugin for MeasurePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, record.in_set(PoseSystems::Attach));
    }
}

/// Metres above and below a sole point between which its ground is looked for.
const ABOVE: f32 = 0.6;
const BELOW: f32 = 3.0;

fn record(
    time: Res<Time>,
    assets: CharacterAssets,
    spatial: SpatialQuery,
    sensors: Query<(), With<Sensor>>,
    grounds: Frames,
    mut characters: Query<(
        &Character,
        &Transform,
        &MotionState,
        &Locomotion,
        &CharacterPose,
        &FootIk,
        &GroundFilter,
        &mut Recorder,
    )>,
) {
    let dt = time.delta_secs();
    if dt <= 0.0 {
        return;
    }
    for (character, root, motion, locomotion, pose, ik, filter, mut recorder) in &mut characters {
        let Some(asset) = assets.get(character) else { continue };
        let probe = PhysicsProbe::new(&spatial, &sensors, filter);
        let world_from_model = root.to_isometry();
        let feet = [0, 1].map(|side| {
            let leg = &asset.legs[side];
            let sole = sole_model(&pose.pose, leg).map(|point| world_from_model * point);
            let ground = sole.map(|point| probe.down(point + Vec3::Y * ABOVE, ABOVE + BELOW).map(|hit| hit.point.y));
            FootFrame {
                sole,
                ground,
                planted_ball: planted_ball(ik, locomotion, side, sole, &grounds),
                stance: stance(ik, locomotion, side),
                missed: ik.legs[side].missed,
                extension: extension(&pose.pose, leg),
                knee: knee(&pose.pose, leg),
            }
        });
        recorder.clock += dt;
        let (joint_speed, velocity_jump) = recorder.compare(pose, dt);
        let frame = Frame {
            time: recorder.clock,
            feet,
            pelvis: (world_from_model * pose.pose.position(asset.hips)).y,
            root: root.translation,
            grounded: motion.ground.is_some(),
            joint_speed,
            velocity_jump,
        };
        recorder.frames.push(frame);
    }
}

impl Recorder {
    /// Largest angular speed of a joint, and largest change of a joint's model-space velocity, since the last frame.
    fn compare(&mut self, pose: &CharacterPose, dt: f32) -> (f32, f32) {
        let (mut speed, mut jump) = (0.0f32, 0.0f32);
        let known = self.last.len() == pose.pose.len();
        for (before, after) in self.last.iter().zip(pose.pose.locals()) {
            speed = speed.max(angle_between(after.rotation, before.rotation) / dt);
        }
        let moving = self.velocities.len() == pose.pose.len();
        self.velocities.resize(pose.pose.len(), Vec3::ZERO);
        for (index, model) in pose.pose.models().iter().enumerate() {
            let position = Vec3::from(model.translation);
            if known {
                let velocity = (position - self.positions[index]) / dt;
                if moving && self.frames.len() > 2 {
                    jump = jump.max(velocity.distance(self.velocities[index]));
                }
                self.velocities[index] = velocity;
            }
        }
        self.positions = pose.pose.models().iter().map(|model| Vec3::from(model.translation)).collect();
        self.last = pose.pose.locals().to_vec();
        (speed, jump)
    }
}

/// The ball in its ground's frame while the foot is planted on it. Without foot IK, while the clip says so.
fn planted_ball(ik: &FootIk, locomotion: &Locomotion, side: usize, sole: [Vec3; 3], grounds: &Frames) -> Option<Vec3> {
    let [heel, ball, _] = sole;
    if ik.weight < 0.01 {
        return (locomotion.cues[side].contact >= 0.5 && ball.y <= heel.y + 0.005).then_some(ball);
    }
    let plant = ik.feet[side].plant().filter(|plant| plant.pivot == Pivot::Ball)?;
    Some(grounds.frame(plant.ground)?.inverse() * ball)
}

fn stance(ik: &FootIk, locomotion: &Locomotion, side: usize) -> bool {
    if ik.weight < 0.01 { locomotion.cues[side].contact >= 0.5 } else { ik.feet[side].plant().is_some() }
}

fn extension(pose: &Pose, leg: &Leg) -> f32 {
    pose.position(leg.upper).distance(pose.position(leg.foot)) / leg.length()
}

/// Bend of the knee in radians; negative where the shin stands in front of the thigh's line.
fn knee(pose: &Pose, leg: &Leg) -> f32 {
    let (hip, knee, ankle) = (pose.position(leg.upper), pose.position(leg.lower), pose.position(leg.foot));
    let angle = bend_angle(hip, knee, ankle);
    let hinge = pose.rotation(leg.upper) * leg.knee_axis;
    let turn = (knee - hip).cross(ankle - knee).dot(hinge);
    if turn < 0.0 { -angle } else { angle }
}
