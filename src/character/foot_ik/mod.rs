//! Keeps feet where they landed.
//!
//! Reads the animated pose, the playing clips' cues, the root and the ground; turns hips, knees and ankles of the pose and
//! lowers the pelvis. Feet are placed in world space, legs solved in model space: metres, +Y up, the character faces -Z.

mod carry;
mod decide;
mod flight;
mod foot;
mod ground;
mod landing;
mod near;
mod pace;
mod pelvis;
mod probe;
mod ride;
mod stance;
mod surroundings;
mod turns;
mod way;

use bevy::prelude::*;

use flight::ease;
pub use foot::{FootState, Mode, Pivot, Plant, Release};
pub use ground::{Footprint, GroundHit, Plane, Probe, Reach, SoleShape, find_room, footprint};
pub use near::{Grounds, NearProbe};
pub use pelvis::{LegReach, PelvisFrame, PelvisState, drop_for};
pub use probe::{Frames, GroundFilter, NoGround, PhysicsProbe};
pub use ride::{Ride, ride};
pub use surroundings::{AnimatedFoot, GroundFrames, PlacedFoot, Surroundings};

use super::{
    Character,
    animator::CharacterPose,
    bind::CharacterAssets,
    legs::{LegJoints, LegResult, heel_lift, heel_turn, keep_rotation, not_folded, place_leg},
    locomotion::Locomotion,
    motion::MotionState,
    schedule::PoseSystems,
    sole::sole_model,
};
use crate::{
    anim::{ik::two_bone::Extension, leg::Leg, pose::Pose},
    math::{rotation::from_scaled_axis, spring::damp},
    rig::{character::CharacterAsset, tuning::foot_ik::FootIkConfig},
};

/// Seconds for which who has left the ground still counts as on it.
const STILL_GROUNDED: f32 = 0.1;
/// Upward speed in m/s from which a body in the air has jumped.
const RISING: f32 = 0.5;
/// Reach that the pelvis leaves to a lifted heel, as a fraction of the leg.
const HEEL_SLACK: f32 = 0.02;
/// How fast a heel lifts to reach, rad/s, and the half-life in seconds in which it comes down when it needn't.
const HEEL: (f32, f32) = (10.0, 0.06);
/// Seconds before a landing from which the pelvis prepares for it.
const FORESIGHT: f32 = 0.4;

/// Lengths of a leg about the root within which feet look for ground: a run's flight and a foot.
const STRIDE: f32 = 2.0;

/// Foot placement of one character: what it carries from frame to frame, and what it did.
#[derive(Component, Clone, Debug, Default)]
pub struct FootIk {
    /// Left and right foot.
    pub feet: [FootState; 2],
    /// Where the feet were put in this frame, world; `None` while the effect is off.
    pub placed: [Option<PlacedFoot>; 2],
    /// What became of the legs in this frame.
    pub legs: [LegResult; 2],
    /// The pelvis' offset.
    pub pelvis: PelvisState,
    /// How much of the effect is on, 0..1.
    pub weight: f32,
    soles: [SoleShape; 2],
    teleports: u32,
}

impl FootIk {
    /// For the feet of `asset`.
    #[must_use]
    pub fn new(asset: &CharacterAsset) -> Self {
        let rest = Pose::rest(&asset.skeleton);
        let soles = [0, 1].map(|side| {
            let [heel, ball, tip] = sole_model(&rest, &asset.legs[side]);
            let along = |from: Vec3, to: Vec3| (to - from).with_y(0.0).length();
            let ankle = rest.position(asset.legs[side].foot);
            SoleShape { heel: along(heel, ball), tip: along(ball, tip), ankle: along(ankle, ball) }
        });
        Self { soles, ..Self::default() }
    }

    /// Forgets the ground: feet start from the clip. For teleports.
    pub fn reset(&mut self) {
        for foot in &mut self.feet {
            foot.reset();
        }
        self.pelvis.reset();
    }
}

/// Places feet.
pub struct FootIkPlugin;

impl Plugin for FootIkPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, plant.in_set(PoseSystems::Plant));
    }
}

fn plant(
    time: Res<Time>,
    assets: CharacterAssets,
    grounds: Grounds,
    frames: Frames,
    mut characters: Query<(
        &Character,
        &Transform,
        &MotionState,
        &Locomotion,
        &GroundFilter,
        &mut CharacterPose,
        &mut FootIk,
    )>,
) {
    let dt = time.delta_secs();
    if dt <= 0.0 {
        return;
    }
    characters.par_iter_mut().for_each(|(character, root, motion, locomotion, filter, mut pose, mut ik)| {
        let Some(asset) = assets.get(character) else { return };
        let body = Body { root, motion, locomotion, asset, dt };
        let config = asset.file.foot_ik.for_leg(asset.leg_length);
        let probe = grounds.near(filter, body.reach(&config), STRIDE * asset.leg_length);
        ik.place(&body, &mut pose, &probe, &frames);
    });
}

/// What stays the same while one character's feet are placed.
struct Body<'a> {
    root: &'a Transform,
    motion: &'a MotionState,
    locomotion: &'a Locomotion,
    asset: &'a CharacterAsset,
    dt: f32,
}

impl FootIk {
    fn place(&mut self, body: &Body<'_>, pose: &mut CharacterPose, probe: &impl Probe, frames: &impl GroundFrames) {
        if !body.root.translation.is_finite() || !body.root.rotation.is_finite() {
            // The controller mends it in its next tick.
            return;
        }
        let config = &body.asset.file.foot_ik;
        // A step down a ledge is no flight yet, a jump is.
        let rises = body.motion.velocity.y > RISING;
        let grounded = body.motion.ground.is_some() || (body.motion.air_time < STILL_GROUNDED && !rises);
        let goal = if config.enabled && grounded { 1.0 } else { 0.0 };
        self.weight = damp(self.weight, goal, config.air_half_life, body.dt);
        let animated = [0, 1].map(|side| body.animated_foot(pose, side, self.soles[side]));
        if body.motion.teleports != self.teleports {
            self.teleports = body.motion.teleports;
            self.reset();
        } else if goal > 0.0 && self.placed == [None; 2] {
            self.weight = 1.0;
            // Out of the air feet go down from where they are, and the pelvis goes on falling as it did.
            if self.feet.iter().all(FootState::flies_free) {
                self.pelvis.land();
            }
        }
        if self.weight < 0.01 {
            self.placed = [None; 2];
            self.legs = [LegResult::default(); 2];
            self.pelvis.fly_free(body.hips(pose), body.dt);
            for ((foot, animated), leg) in self.feet.iter_mut().zip(&animated).zip(&body.asset.legs) {
                foot.fly_free(animated, body.dt);
                foot.pace.note(&pose.pose, leg, body.dt);
            }
            return;
        }
        let config = &config.for_leg(body.asset.leg_length);
        let placed = [0, 1].map(|side| {
            let around = Surroundings {
                probe,
                frames,
                reach: body.reach(config),
                sole: self.soles[side],
                config,
                dt: body.dt,
                other_holds: self.feet[1 - side].plant().is_some(),
                halts: body.halts(),
                may_restep: body.stands(),
            };
            self.feet[side].advance(&animated[side], &around)
        });
        self.placed = placed.map(Some);
        let ankles = [0, 1].map(|side| animated[side].clip_ankle.lerp(placed[side].ankle, self.weight));
        self.sink_pelvis(body, pose, &animated, &placed, ankles, config);
        let hurry = self.pelvis.bending(body.asset.leg_length);
        for side in 0..2 {
            let placed = PlacedFoot { ankle: ankles[side], ..placed[side] };
            self.legs[side] = body.solve_leg(pose, side, &placed, &mut self.feet[side], (self.weight, hurry), config);
        }
    }

    fn sink_pelvis(
        &mut self,
        body: &Body<'_>,
        pose: &mut CharacterPose,
        animated: &[AnimatedFoot; 2],
        placed: &[PlacedFoot; 2],
        ankles: [Vec3; 2],
        config: &FootIkConfig,
    ) {
        let world_from_model = body.root.to_isometry();
        let (motion, root) = (body.motion, body.root.translation);
        let carried = motion.ground.map_or(0.0, |ground| ground.velocity.y);
        let ride = ride(placed, root, motion.ground_velocity, carried);
        let legs = [0, 1].map(|side| {
            let leg = &body.asset.legs[side];
            let hip = world_from_model * pose.pose.position(leg.upper);
            let now = LegReach {
                hip,
                ankle: ankles[side],
                length: leg.length(),
                animated: hip.distance(animated[side].clip_ankle),
                slack: if self.feet[side].stands_on_forefoot() { HEEL_SLACK * leg.length() } else { 0.0 },
                weight: animated[side].contact,
            };
            placed[side].landing.map_or(now, |(landing, seconds)| {
                // By then the body rides over other ground.
                let then = ride.height + ride.speed * seconds;
                let now = LegReach { hip: now.hip + Vec3::Y * (then - ride.height), ..now };
                body.landed(now, landing, seconds, then, &animated[side])
            })
        });
        let frame = PelvisFrame { floor: root.y, hips: body.hips(pose), weight: self.weight, config, dt: body.dt };
        let offset = self.pelvis.advance(&legs, ride, &frame);
        if offset.abs() > 1e-6 {
            pose.pose.shift_model(&body.asset.skeleton, body.asset.hips, Vec3::Y * offset);
        }
    }
}

impl Body<'_> {
    /// Standing still: feet may correct their places.
    fn stands(&self) -> bool {
        let speed = Vec2::new(self.motion.ground_velocity.x, self.motion.ground_velocity.z).length();
        speed < 0.15 && self.locomotion.cues.iter().all(|cue| cue.contact > 0.9)
    }

    /// World height of the hips joint.
    fn hips(&self, pose: &CharacterPose) -> f32 {
        (self.root.to_isometry() * pose.pose.position(self.asset.hips)).y
    }

    /// What plays from now on doesn't step; nobody halts in the air.
    fn halts(&self) -> bool {
        let machine = &self.locomotion.machine;
        self.motion.ground.is_some() && (machine.is_empty() || !machine.steps(machine.current()))
    }

    fn reach(&self, config: &FootIkConfig) -> Reach {
        Reach { root: self.root.translation, up: config.probe_up, down: config.probe_down }
    }

    /// The foot as the clip has it, in world space, its stride warped to the ground speed.
    fn animated_foot(&self, pose: &CharacterPose, side: usize, shape: SoleShape) -> AnimatedFoot {
        let leg = &self.asset.legs[side];
        let cue = self.locomotion.cues[side];
        let world_from_model = self.root.to_isometry();
        let warp = self.warp(pose, leg);
        let ankle_model = pose.pose.position(leg.foot);
        let shift = warp(ankle_model);
        let sole = sole_model(&pose.pose, leg).map(|point| world_from_model * (point + shift));
        // A foot that is about to land is already where the body's turn will have it, so that it comes to rest in the world.
        let share = if cue.contact < 0.5 { ease(cue.swing) } else { 0.0 };
        let from_root = sole[1] - self.root.translation;
        let ahead = self.turn_ahead(cue.time_to_contact, share) * from_root - from_root;
        let sole = sole.map(|point| point + ahead);
        let [heel, ball, tip] = sole;
        let forward = (ball - heel).with_y(0.0).normalize_or(*self.root.forward());
        let (landing, landing_forward) = match cue.landing_model {
            Some(ball_model) if cue.contact < 0.5 => {
                let ankle_model = ball_model - self.root.rotation.inverse() * forward * shape.ankle;
                self.predict(ball_model + warp(ankle_model), forward, cue.time_to_contact)
            }
            _ => (ball, forward),
        };
        AnimatedFoot {
            ankle: world_from_model * (ankle_model + shift) + ahead,
            clip_ankle: world_from_model * ankle_model,
            heel,
            ball,
            tip,
            floor: self.root.translation.y,
            forward,
            contact: cue.contact,
            time_to_contact: cue.time_to_contact,
            swing: cue.swing,
            landing,
            landing_forward,
        }
    }

    /// Where the ball lands if the body keeps its velocity and turn for `seconds`.
    fn predict(&self, ball_model: Vec3, forward: Vec3, seconds: f32) -> (Vec3, Vec3) {
        let seconds = seconds.clamp(0.0, 0.6);
        let turn = self.turn_ahead(seconds, 1.0);
        let root = self.root.translation + self.motion.velocity.with_y(0.0) * seconds;
        (root + turn * self.root.rotation * ball_model, turn * forward)
    }

    /// A share of the turn that the body makes in `seconds`.
    fn turn_ahead(&self, seconds: f32, share: f32) -> Quat {
        from_scaled_axis(Vec3::Y * ((self.motion.yaw_rate * seconds).clamp(-1.2, 1.2) * share))
    }

    /// Horizontal shift, in model space, that scales the stride about the hip along the way the body goes.
    fn warp(&self, pose: &CharacterPose, leg: &Leg) -> impl Fn(Vec3) -> Vec3 + use<> {
        let hip = pose.pose.position(leg.upper);
        let way = (self.root.rotation.inverse() * self.motion.ground_velocity).with_y(0.0).normalize_or(Vec3::NEG_Z);
        let excess = self.locomotion.machine.stride_scale() - 1.0;
        move |point: Vec3| way * ((point - hip).dot(way) * excess)
    }

    /// A swinging leg as it will be when it lands; it counts the more the sooner that is.
    ///
    /// As far as it would stretch on `ground`, the height that the body rides over, it is the clip's own stretch.
    fn landed(&self, now: LegReach, landing: Vec3, seconds: f32, ground: f32, foot: &AnimatedFoot) -> LegReach {
        let ankle = landing + (foot.ankle - foot.ball).with_y(0.0) + Vec3::Y * self.ankle_height();
        let hip = now.hip + self.motion.velocity.with_y(0.0) * seconds;
        let level = ankle.with_y(ground + self.ankle_height());
        let near = (1.0 - seconds / FORESIGHT).clamp(0.0, 1.0);
        let weight = near * near * (3.0 - 2.0 * near);
        LegReach { hip, ankle, animated: hip.distance(level), slack: 0.0, weight, ..now }
    }

    /// Height of the ankle over a sole that stands flat, metres: a twelfth of the leg (0.07 of 0.875 m).
    fn ankle_height(&self) -> f32 {
        0.08 * self.asset.leg_length
    }

    fn solve_leg(
        &self,
        pose: &mut CharacterPose,
        side: usize,
        placed: &PlacedFoot,
        foot: &mut FootState,
        (weight, hurry): (f32, f32),
        config: &FootIkConfig,
    ) -> LegResult {
        let (ankle_world, turn_world) = (placed.ankle, placed.turn);
        let leg = &self.asset.legs[side];
        let model_from_world = self.root.to_isometry().inverse();
        let turn = Quat::IDENTITY.slerp(turn_world, weight);
        let turn_model = model_from_world.rotation * turn * model_from_world.rotation.inverse();
        let joints = LegJoints { upper: leg.upper, lower: leg.lower, foot: leg.foot };
        let animated = pose.pose.position(leg.upper).distance(pose.pose.position(leg.foot));
        // A clip's own stretch is not resisted: level ground shows the clip as it is.
        let soft = config.extension.0.max((animated / leg.length()).min(config.extension.1 - 0.005));
        let ankle = model_from_world * ankle_world;
        // The heel lifts about the toes' joint: that is where a foot bends.
        let rest = leg.toes.unwrap_or(leg.foot);
        let ball = ankle + turn_model * (pose.pose.position(rest) - pose.pose.position(leg.foot));
        // Of the whole sole: at the end of a push-off the ankle stands over the toes, and beyond.
        let forward = model_from_world.rotation * (placed.sole[1] - placed.sole[0]);
        let needed = match leg.toes {
            Some(_) => {
                let share = foot.heel_may_lift() * weight;
                heel_lift(pose.pose.position(leg.upper), ankle, ball, forward, soft * leg.length()) * share
            }
            None => 0.0,
        };
        foot.heel = if needed > foot.heel {
            needed.min(foot.heel + HEEL.0 * self.dt)
        } else {
            damp(foot.heel, needed, HEEL.1, self.dt)
        };
        let lifted = foot.heel.max(foot.toes_down * weight);
        let lift = heel_turn(forward, lifted);
        let toes = leg.toes.map(|toes| (toes, turn_model * pose.pose.rotation(toes)));
        let rotation = lift * turn_model * pose.pose.rotation(leg.foot);
        let target = not_folded(pose.pose.position(leg.upper), ball + lift * (ankle - ball), leg.length());
        let result = place_leg(
            &mut pose.pose,
            &self.asset.skeleton,
            joints,
            target,
            rotation,
            Vec3::NEG_Z,
            Extension { soft, hard: config.extension.1 },
        );
        if let Some((toes, rotation)) = toes.filter(|_| lifted > 0.0) {
            keep_rotation(&mut pose.pose, &self.asset.skeleton, toes, rotation);
        }
        let fastest = self.locomotion.leg_speed(self.asset).max(hurry);
        foot.pace.keep(&mut pose.pose, &self.asset.skeleton, leg, foot.plant().is_none(), (fastest, self.dt));
        foot.note_droop(&pose.pose, leg, placed);
        foot.missed = result.missed;
        result
    }
}
