//! The body that feet are placed for: where the clip has its feet, where they will land, and how a leg is set.
//!
//! Feet in world space, legs in model space: metres, +Y up, the character faces -Z.

use bevy::{math::ops, prelude::*};

use super::{
    ON,
    foot::FootState,
    ground::{Probe, Reach, SoleShape},
    pelvis::LegReach,
    soften::Limits,
    surroundings::{AnimatedFoot, PlacedFoot},
};
use crate::{
    anim::{
        ik::two_bone::{Extension, Limb},
        leg::Leg,
        peak::Peak,
    },
    character::{
        animator::CharacterPose,
        legs::{
            CLIP_EXTENSION, LegJoints, LegResult, LegTurns, heel_lift, heel_turn, not_folded, place_leg, place_limb,
            turn_toes,
        },
        locomotion::Locomotion,
        motion::MotionState,
        sole::sole_model,
    },
    math::{rotation::yaw, spring::damp},
    rig::{character::CharacterAsset, tuning::foot_ik::FootIkConfig},
};

/// How fast a heel lifts to reach, rad/s, and the half-life in seconds in which it comes down when it needn't.
const HEEL: (f32, f32) = (8.0, 0.06);
/// Metres over the ground up to which a late foot is lifted, if it is asked to be there, and the half-life in seconds in which
/// it is.
const LATE_CLEARS: f32 = 0.02;
const LATE_LIFTS: f32 = 0.005;
/// Metres of such a lift that nobody sees.
const LEAST_LIFT: f32 = 1e-4;
/// Metres by which a foot that stands may go on into its ground while its leg slows.
const DEEP: f32 = 0.004;
/// Seconds before a landing from which the pelvis prepares for it.
const FORESIGHT: f32 = 0.4;

/// What stays the same while one character's feet are placed.
pub(super) struct Body<'a> {
    pub(super) root: &'a Transform,
    pub(super) motion: &'a MotionState,
    pub(super) locomotion: &'a Locomotion,
    pub(super) asset: &'a CharacterAsset,
    /// Tuning, scaled to the leg.
    pub(super) config: &'a FootIkConfig,
    pub(super) reach: Reach,
    /// Length of the leg as a factor on the mannequin's.
    pub(super) size: f32,
    /// Whether feet shall find the ground at all.
    pub(super) wanted: bool,
    pub(super) dt: f32,
    /// Horizontal direction that it goes, model space.
    pub(super) way: Vec3,
    /// How fast it turns about +Y, rad/s, as feet see it.
    pub(super) turns: f32,
    /// How lively the clips are that play, and how fast they move a leg's joints, rad/s.
    pub(super) clips: Peak,
    pub(super) leg_speed: f32,
}

/// Where a leg shall have its foot.
pub(super) struct LegAim<'a, P> {
    pub(super) placed: &'a PlacedFoot,
    /// How much of the effect is on, 0..1.
    pub(super) weight: f32,
    /// Least speed of the leg's joints that it may have, rad/s: who stops a fall is in a hurry.
    pub(super) hurry: f32,
    pub(super) probe: &'a P,
}

/// The ground that feet reach for around this root.
pub(super) fn reach(root: &Transform, config: &FootIkConfig) -> Reach {
    let (up, down) = (config.probe_up, config.probe_down);
    Reach { root: root.translation, up, down, upright: ops::cos(config.walkable) }
}

/// Horizontal direction, model space, that a body with this root goes.
pub(super) fn way(root: &Transform, motion: &MotionState) -> Vec3 {
    (root.rotation.inverse() * motion.ground_velocity).with_y(0.0).normalize_or(Vec3::NEG_Z)
}

impl Body<'_> {
    /// Standing still: feet may correct their places.
    pub(super) fn stands(&self) -> bool {
        let speed = Vec2::new(self.motion.ground_velocity.x, self.motion.ground_velocity.z).length();
        speed < 0.15 && self.locomotion.cues.iter().all(|cue| cue.contact > 0.9)
    }

    /// World height of the hips joint.
    pub(super) fn hips(&self, pose: &CharacterPose) -> f32 {
        (self.root.to_isometry() * pose.pose.position(self.asset.hips)).y
    }

    /// What plays from now on doesn't step; nobody halts in the air.
    pub(super) fn halts(&self) -> bool {
        let machine = &self.locomotion.machine;
        self.motion.ground.is_some() && (machine.is_empty() || !machine.steps(machine.current()))
    }

    /// The foot as the clip has it, in world space, its stride warped to the ground speed.
    pub(super) fn animated_foot(
        &self,
        pose: &CharacterPose,
        side: usize,
        shape: SoleShape,
        state: &FootState,
    ) -> AnimatedFoot {
        let leg = &self.asset.legs[side];
        let cue = &self.locomotion.cues[side];
        let world_from_model = self.root.to_isometry();
        let warp = self.warp(pose, leg);
        let ankle_model = pose.pose.position(leg.foot);
        let shift = warp(ankle_model);
        let [heel, ball, tip] = sole_model(&pose.pose, leg);
        let place = |point: Vec3| world_from_model * (point + shift);
        let mut sole = [place(heel), place(ball), place(tip), place(ankle_model)];
        // A foot that is about to land is already where the body's turn will have it, so that it comes to rest in the world.
        let share = if cue.contact < 0.5 { state.share_of_flight() } else { 0.0 };
        if share > 0.0 {
            let from_root = sole[1] - self.root.translation;
            let ahead = self.turn_ahead(cue.time_to_contact, share) * from_root - from_root;
            sole.iter_mut().for_each(|point| *point += ahead);
        }
        let [heel, ball, tip, ankle] = sole;
        let forward = (ball - heel).with_y(0.0).normalize_or(*self.root.forward());
        let (landing, landing_forward) = match cue.landing_model {
            Some(ball_model) if cue.contact < 0.5 => {
                let ankle_model = ball_model - self.root.rotation.inverse() * forward * shape.ankle;
                self.predict(ball_model + warp(ankle_model), forward, cue.time_to_contact)
            }
            _ => (ball, forward),
        };
        AnimatedFoot {
            ankle,
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
        yaw((self.turns * seconds).clamp(-1.2, 1.2) * share)
    }

    /// Horizontal shift, in model space, that scales the stride about the hip along the way the body goes.
    fn warp(&self, pose: &CharacterPose, leg: &Leg) -> impl Fn(Vec3) -> Vec3 + use<> {
        let (hip, way) = (pose.pose.position(leg.upper), self.way);
        let excess = self.locomotion.machine.stride_scale() - 1.0;
        move |point: Vec3| way * ((point - hip).dot(way) * excess)
    }

    /// A swinging leg as it will be when it lands; it counts the more the sooner that is.
    ///
    /// As far as it would stretch on `ground`, the height that the body rides over, it is the clip's own stretch.
    pub(super) fn landed(
        &self,
        now: LegReach,
        (landing, seconds): (Vec3, f32),
        ground: f32,
        foot: &AnimatedFoot,
        shape: SoleShape,
    ) -> LegReach {
        let ankle = landing + (foot.ankle - foot.ball).with_y(0.0) + Vec3::Y * shape.ankle_height;
        let hip = now.hip + self.motion.velocity.with_y(0.0) * seconds;
        let level = ankle.with_y(ground + shape.ankle_height);
        let near = (1.0 - seconds / FORESIGHT).clamp(0.0, 1.0);
        let weight = near * near * (3.0 - 2.0 * near);
        LegReach { hip, ankle, animated: hip.distance(level), slack: 0.0, weight, ..now }
    }

    /// Sets a leg of `pose` onto its foot, no livelier than clips are.
    pub(super) fn solve_leg<P: Probe>(
        &self,
        pose: &mut CharacterPose,
        side: usize,
        foot: &mut FootState,
        aim: &LegAim<'_, P>,
    ) -> LegResult {
        let leg = &self.asset.legs[side];
        let result = self.reach_for(pose, leg, foot, aim);
        let fastest = self.leg_speed.max(aim.hurry);
        let asked = pose.pose.position(leg.foot);
        foot.pace.keep(&mut pose.pose, &self.asset.skeleton, leg, foot.plant().is_none(), (fastest, self.dt));
        self.lift_late(pose, leg, foot, aim);
        let limits = if aim.hurry > 0.0 || aim.weight < ON {
            Limits { share: aim.weight, ..Limits::NONE }
        } else {
            Limits::of(self.clips, self.dt)
        };
        foot.soften.keep(&mut pose.pose, &self.asset.skeleton, leg, limits, self.dt);
        if foot.plant().is_some() && foot.soften.eases() && self.keep_out(pose, leg, aim.placed) {
            foot.soften.correct(&pose.pose, leg, self.dt);
        }
        foot.note_droop(&pose.pose, leg, aim.placed);
        foot.missed = result.missed;
        foot.behind = pose.pose.position(leg.foot).distance(asked);
        result
    }

    /// Turns hip, knee and ankle so that the foot is where it was placed; its heel lifts where the leg is too short.
    fn reach_for<P: Probe>(
        &self,
        pose: &mut CharacterPose,
        leg: &Leg,
        foot: &mut FootState,
        aim: &LegAim<'_, P>,
    ) -> LegResult {
        let (placed, weight, config) = (aim.placed, aim.weight, self.config);
        let model_from_world = self.root.to_isometry().inverse();
        let turn = if weight < 1.0 { Quat::IDENTITY.slerp(placed.turn, weight) } else { placed.turn };
        let turn_model = model_from_world.rotation * turn * model_from_world.rotation.inverse();
        let joints = LegJoints { upper: leg.upper, lower: leg.lower, foot: leg.foot };
        let [hip, knee, clip_ankle] = pose.pose.positions_of(leg.joints());
        let turns = LegTurns::of(&pose.pose, &self.asset.skeleton, joints);
        let animated = hip.distance(clip_ankle);
        // A clip's own stretch is not resisted: level ground shows the clip as it is. Who jumps off stretches all he can.
        let stretched = if self.motion.ground.is_some() { animated / leg.length() } else { 1.0 };
        let soft = config.extension.0.max(stretched.min(config.extension.1 - 0.005));
        let ankle = model_from_world * placed.ankle;
        // The heel lifts about the toes' joint: that is where a foot bends.
        let rest = leg.toes.unwrap_or(leg.foot);
        let ball = ankle + turn_model * (pose.pose.position(rest) - clip_ankle);
        // Of the whole sole: at the end of a push-off the ankle stands over the toes, and beyond.
        let forward = model_from_world.rotation * (placed.sole[1] - placed.sole[0]);
        let needed = match leg.toes {
            Some(_) => {
                let share = foot.heel_may_lift() * weight;
                heel_lift(hip, ankle, ball, forward, soft * leg.length()) * share
            }
            None => 0.0,
        };
        foot.heel = if needed > foot.heel {
            needed.min(foot.heel + HEEL.0 * self.dt)
        } else {
            damp(foot.heel, needed, HEEL.1, self.dt)
        };
        let lifted = foot.heel.max(foot.toes_down * weight);
        let lift = if lifted > 0.0 { heel_turn(forward, lifted) } else { Quat::IDENTITY };
        // A foot that leads its leg isn't turned as the leg carries it.
        let foot_turn = if pose.feet_lead() { pose.pose.rotation(leg.foot) } else { turns.foot };
        let rotation = lift * turn_model * foot_turn;
        if let Some(toes) = leg.toes.filter(|_| lifted > 0.0) {
            turn_toes(&mut pose.pose, &self.asset.skeleton, (leg.foot, toes), (foot_turn, rotation), turn_model);
        }
        let end = pose.carried_ankle(&self.asset.skeleton, leg);
        let target = not_folded(hip, ball + lift * (ankle - ball), leg.length());
        place_limb(
            &mut pose.pose,
            &self.asset.skeleton,
            joints,
            &turns,
            &Limb { root: hip, middle: knee, end, pole: Vec3::NEG_Z },
            (target, rotation),
            Extension { soft, hard: config.extension.1 },
        )
    }

    /// Lifts a foot that stands out of its ground, where its leg went on into it; gives whether it did.
    fn keep_out(&self, pose: &mut CharacterPose, leg: &Leg, placed: &PlacedFoot) -> bool {
        let world_from_model = self.root.to_isometry();
        let made = sole_model(&pose.pose, leg).map(|point| world_from_model * point);
        let deep =
            [0, 1, 2].map(|point| placed.plane.height(made[point]) - made[point].y).into_iter().fold(0.0, f32::max);
        let lift = deep - DEEP * self.size;
        if lift > 0.0 {
            self.lift(pose, leg, lift);
        }
        lift > 0.0
    }

    /// Sets a foot `lift` metres higher, as it is turned.
    fn lift(&self, pose: &mut CharacterPose, leg: &Leg, lift: f32) {
        let joints = LegJoints { upper: leg.upper, lower: leg.lower, foot: leg.foot };
        let ankle = pose.pose.position(leg.foot) + Vec3::Y * lift;
        let ankle = not_folded(pose.pose.position(leg.upper), ankle, leg.length());
        let rotation = pose.pose.rotation(leg.foot);
        place_leg(&mut pose.pose, &self.asset.skeleton, joints, ankle, rotation, Vec3::NEG_Z, CLIP_EXTENSION);
    }

    /// Lifts the foot of a leg that is late over the ground under it: the knee bends further instead.
    fn lift_late<P: Probe>(
        &self,
        pose: &mut CharacterPose,
        leg: &Leg,
        foot: &mut FootState,
        LegAim { placed, probe, .. }: &LegAim<'_, P>,
    ) {
        let late = foot.plant().is_none() && foot.pace.is_late();
        if foot.plant().is_some() || !late && foot.lifted <= 0.0 {
            foot.lifted = 0.0;
            return;
        }
        let ground = |point: Vec3| self.reach.height(*probe, point);
        let over = |point: Vec3| point.y - ground(point).unwrap_or_else(|| placed.plane.height(point));
        let lowest = |points: [Vec3; 3]| points.map(over).into_iter().fold(f32::MAX, f32::min);
        let world_from_model = self.root.to_isometry();
        let made = sole_model(&pose.pose, leg).map(|point| world_from_model * point);
        let wanted = if late { lowest(placed.sole).min(LATE_CLEARS * self.size) - lowest(made) } else { 0.0 };
        // An edge comes between the foot and its place from one frame to the next.
        let lift = damp(foot.lifted, wanted.max(0.0), LATE_LIFTS, self.dt);
        foot.lifted = if lift < LEAST_LIFT { 0.0 } else { lift };
        if foot.lifted > 0.0 {
            self.lift(pose, leg, lift);
        }
    }
}
