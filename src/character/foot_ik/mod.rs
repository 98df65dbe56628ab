//! Keeps feet where they landed.
//!
//! Reads the animated pose, the playing clips' cues, the root and the ground; turns hips, knees and ankles of the pose and
//! lowers the pelvis. Feet are placed in world space, legs solved in model space: metres, +Y up, the character faces -Z.

mod air;
mod board;
mod body;
mod carry;
mod decide;
mod flight;
mod foot;
mod ground;
mod heave;
mod landing;
mod near;
mod pace;
mod pelvis;
mod probe;
mod ride;
mod soften;
mod stance;
mod surroundings;
mod turns;
mod way;

use bevy::prelude::*;

use body::{Body, LegAim};
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
    detail::{Detail, Pacing},
    legs::LegResult,
    locomotion::Locomotion,
    motion::MotionState,
    schedule::{PoseClock, PoseSystems},
    sole::sole_model,
};
use crate::{
    anim::{peak::Peak, pose::Pose},
    math::spring::damp,
    rig::{character::CharacterAsset, tuning::foot_ik::TUNED_LEG},
};

/// Half-life in seconds over which feet take up how fast the body turns.
const TURNS_HALF_LIFE: f32 = 0.04;
/// Seconds for which who has left the ground still counts as on it.
const STILL_GROUNDED: f32 = 0.1;
/// Upward speed in m/s from which a body in the air has jumped.
const RISING: f32 = 0.5;
/// Reach that the pelvis leaves to a lifted heel, as a fraction of the leg.
const HEEL_SLACK: f32 = 0.02;

/// Seconds within which what happens is seen as one moment, however many frames show it.
const SEEN: f32 = 1.0 / 60.0;

/// Seconds of a frame from which on no motion is carried over into the next: at 25 frames a second nobody sees it go on.
const LONG: f32 = 1.0 / 25.0;

/// Share of the effect from which on legs and pelvis are kept from jumping: one that fades lets go of the ground.
const ON: f32 = 0.99;

/// Share of the effect below which it is off.
const OFF: f32 = 0.01;

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
    /// How fast the body turns about +Y, rad/s, smoothed.
    turns: f32,
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
            let ankle_height = asset.legs[side].ankle_height(&rest);
            let bends = asset.legs[side].toes.is_some();
            SoleShape { heel: along(heel, ball), tip: along(ball, tip), ankle: along(ankle, ball), ankle_height, bends }
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

    /// Carries no motion over into this frame.
    fn forget_motion(&mut self) {
        self.feet.iter_mut().for_each(FootState::forget_motion);
        self.pelvis.forget_motion();
    }
}

/// Places feet.
pub struct FootIkPlugin;

impl Plugin for FootIkPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(FixedPostUpdate, plant.in_set(PoseSystems::Plant));
    }
}

fn plant(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    grounds: Grounds,
    frames: Frames,
    mut characters: Query<(
        &Character,
        &Transform,
        &MotionState,
        &Locomotion,
        &GroundFilter,
        (Option<&Detail>, Option<&Pacing>),
        &mut CharacterPose,
        &mut FootIk,
    )>,
) {
    let tick = clock.delta_secs();
    characters.par_iter_mut().for_each(
        |(character, root, motion, locomotion, filter, (detail, pacing), mut pose, mut ik)| {
            let (Some(asset), Some(dt)) = (assets.get(character), Pacing::whole(pacing, tick)) else { return };
            let wanted = detail.is_none_or(|detail| detail.feet);
            // Landings turn with the body; one that begins to turn would throw them about.
            ik.turns = damp(ik.turns, motion.yaw_rate, TURNS_HALF_LIFE, dt);
            let clips = lively(locomotion, asset, tick, dt);
            let config = &asset.file.foot_ik.for_leg(asset.leg_length);
            let size = asset.leg_length / TUNED_LEG;
            let leg_speed = locomotion.leg_speed(asset);
            let (turns, way, reach) = (ik.turns, body::way(root, motion), body::reach(root, config));
            let body =
                Body { root, motion, locomotion, asset, config, reach, size, wanted, dt, way, turns, clips, leg_speed };
            if Pacing::begins(pacing) {
                ik.reset();
            }
            if dt >= LONG {
                ik.forget_motion();
            }
            if !wanted && ik.weight < OFF {
                let animated = ik.animated(&body, &pose);
                return ik.fly_free(&body, &mut pose, &animated);
            }
            let mut probe = grounds.probe(filter);
            // Feet that stay where they stand ask for no ground.
            let stay =
                ik.feet.iter().zip(&locomotion.cues).all(|(foot, cue)| foot.stands_on_forefoot() && cue.contact > 0.9);
            if !stay {
                grounds.gather(filter, body.reach, STRIDE * asset.leg_length, &mut probe);
            }
            ik.place(&body, &mut pose, &probe, &frames);
        },
    );
}

/// How lively the clips are that play, for a pose every `step` seconds of ticks of `tick` seconds.
///
/// A pose of a long step changes velocities in a single frame: legs may do so hardly more than in frames of that length, or as
/// much as the clips themselves do in such steps.
fn lively(locomotion: &Locomotion, asset: &CharacterAsset, tick: f32, step: f32) -> Peak {
    let in_frames = locomotion.liveliest(asset, tick.max(SEEN));
    if step <= tick.max(SEEN) {
        return in_frames;
    }
    let in_steps = locomotion.liveliest(asset, step);
    Peak { velocity_jump: in_frames.velocity_jump.max(in_steps.velocity_jump / soften::LIVELIER.0), ..in_frames }
}

impl FootIk {
    fn place(&mut self, body: &Body<'_>, pose: &mut CharacterPose, probe: &impl Probe, frames: &impl GroundFrames) {
        if !body.root.translation.is_finite() || !body.root.rotation.is_finite() {
            // The controller mends it in its next tick.
            return;
        }
        let config = body.config;
        // A step down a ledge is no flight yet, a jump is.
        let rises = body.motion.velocity.y > RISING;
        let grounded = body.motion.ground.is_some() || (body.motion.air_time < STILL_GROUNDED && !rises);
        let goal = if config.enabled && body.wanted && grounded { 1.0 } else { 0.0 };
        self.weight = damp(self.weight, goal, config.air_half_life, body.dt);
        let animated = self.animated(body, pose);
        if body.motion.teleports != self.teleports {
            self.teleports = body.motion.teleports;
            self.reset();
        } else if goal > 0.0 && self.placed == [None; 2] {
            self.weight = 1.0;
            // Out of the air feet go down from where they are, and the pelvis goes on falling as it did.
            if self.feet.iter().all(FootState::flies_free) && !self.pelvis.falls() {
                self.pelvis.land();
            }
        }
        if let Some(ground) = body.motion.lands_on.filter(|_| config.enabled && body.wanted && goal == 0.0) {
            return self.come_down(body, pose, &animated, ground);
        }
        if self.weight < OFF {
            return self.fly_free(body, pose, &animated);
        }
        let (halts, may_restep) = (body.halts(), body.stands());
        let mut advance = |side: usize| {
            let around = Surroundings {
                probe,
                frames,
                reach: body.reach,
                sole: self.soles[side],
                config,
                size: body.size,
                dt: body.dt,
                other: self.feet[1 - side].plant().map(|plant| plant.pivot),
                level: self.feet[1 - side].level(body, 1 - side, animated[side].time_to_contact),
                halts,
                may_restep,
            };
            self.feet[side].advance(&animated[side], &around)
        };
        let mut placed = [advance(0), advance(1)];
        self.placed = placed.map(Some);
        let ankle = |side: usize| animated[side].clip_ankle.lerp(placed[side].ankle, self.weight);
        let ankles = [ankle(0), ankle(1)];
        self.sink_pelvis(body, pose, &animated, &placed, ankles);
        let hurry = self.pelvis.bending(body.asset.leg_length);
        for side in 0..2 {
            placed[side].ankle = ankles[side];
            let aim = LegAim { placed: &placed[side], weight: self.weight, hurry, probe };
            self.legs[side] = body.solve_leg(pose, side, &mut self.feet[side], &aim);
        }
        pose.legs_follow();
    }

    /// Feet as the clips have them.
    fn animated(&self, body: &Body<'_>, pose: &CharacterPose) -> [AnimatedFoot; 2] {
        let foot = |side: usize| body.animated_foot(pose, side, self.soles[side], &self.feet[side]);
        [foot(0), foot(1)]
    }

    fn sink_pelvis(
        &mut self,
        body: &Body<'_>,
        pose: &mut CharacterPose,
        animated: &[AnimatedFoot; 2],
        placed: &[PlacedFoot; 2],
        ankles: [Vec3; 2],
    ) {
        let world_from_model = body.root.to_isometry();
        let (motion, root) = (body.motion, body.root.translation);
        let carried = motion.ground.map_or(0.0, |ground| ground.velocity.y);
        let ride = ride(placed, root, motion.ground_velocity, carried);
        let leg = |side: usize| {
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
                body.landed(now, (landing, seconds), then, &animated[side], self.soles[side])
            })
        };
        let legs = [leg(0), leg(1)];
        let frame = PelvisFrame {
            floor: root.y,
            hips: body.hips(pose),
            weight: self.weight,
            heave: body.locomotion.heave(body.asset),
            config: body.config,
            dt: body.dt,
        };
        let offset = self.pelvis.advance(&legs, ride, &frame);
        if offset.abs() > 1e-6 {
            if !body.asset.skeleton.is_whole_branch(body.asset.hips) {
                pose.set_legs(body.asset);
            }
            pose.pose.shift_model_of(&body.asset.skeleton, body.asset.hips, Vec3::Y * offset, &body.asset.trunk);
        }
    }
}
