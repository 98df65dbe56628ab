//! Records what a viewer sees: final poses against the true colliders, once a frame.

use avian3d::prelude::*;
use bevy::prelude::*;

use super::frame::{FootFrame, Frame};
use crate::{
    anim::{
        blend::lerp_into,
        ik::two_bone::bend_angle,
        leg::Leg,
        peak::{JointMotion, Peak},
        pose::Pose,
    },
    character::{
        Character,
        animator::{Actions, CharacterPose},
        bind::CharacterAssets,
        foot_ik::{FootIk, Frames, GroundFilter, GroundFrames, NoGround, PhysicsProbe, Pivot, Probe},
        intent::MoveIntent,
        locomotion::Locomotion,
        motion::MotionState,
        schedule::PoseSystems,
        sole::sole_model,
    },
    rig::character::CharacterAsset,
};

/// Records the frames of the character that it is put on.
#[derive(Component, Clone, Debug, Default)]
pub struct Recorder {
    /// What was recorded, in order of time.
    pub frames: Vec<Frame>,
    /// Seconds from one recorded frame to the next, whatever the frame rate. 0 records what is shown, frame by frame. Default 0.
    ///
    /// Two frame rates compare only where both are seen at the same moments: speeds and changes are differences of frames. Poses
    /// between two frames are blended, and so is where grounds are; what holds a foot and what plays is that of the later one.
    pub every: f32,
    /// The last frame, and the seconds from the last recorded one to it.
    shown: Option<Shown>,
    since: f32,
    clock: f32,
    motion: JointMotion,
    peaks: ClipPeaks,
    grounds: Vec<(Entity, Isometry3d)>,
    /// Of each foot on no ground of its own: how far it slid, and its ball in the last frame.
    slides: [Option<(Vec3, Vec3)>; 2],
}

/// Fills [`Recorder`]s.
pub struct MeasurePlugin;

impl Plugin for MeasurePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, record.in_set(PoseSystems::Attach));
    }
}

/// What holds a foot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hold {
    /// Nothing: it swings.
    #[default]
    Free,
    /// It stands, but its ball doesn't yet, or no longer.
    Stance,
    /// Its ball stands on this ground; `None` on whatever lies below it.
    Ball(Option<Entity>),
}

/// What a viewer sees of a character in one frame.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// Whose legs these are.
    pub asset: &'a CharacterAsset,
    /// The final pose.
    pub pose: &'a Pose,
    /// The root, world.
    pub root: &'a Transform,
    /// Whether it stands on ground.
    pub grounded: bool,
    /// Velocity wanted, world, m/s.
    pub wanted: Vec3,
    /// Velocity over the ground, m/s.
    pub velocity: Vec3,
    /// What holds each foot.
    pub holds: [Hold; 2],
    /// Metres by which each ankle missed its target, if it has one.
    pub missed: [Option<f32>; 2],
    /// What plays.
    pub playing: &'a [Playing],
}

/// A clip that plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playing {
    /// Index in [`CharacterAsset::clips`].
    pub clip: usize,
    /// Factor on its own speed.
    pub rate: f32,
}

/// A frame as it was shown: pose, root, and the grounds that feet are over.
#[derive(Clone, Debug)]
struct Shown {
    pose: Pose,
    root: Transform,
    grounds: Vec<(Entity, Isometry3d)>,
}

impl Shown {
    fn of(seen: &Seen<'_>, under: &[(Entity, Isometry3d)], now: &impl GroundFrames) -> Self {
        let grounds = under.iter().filter_map(|(entity, _)| Some((*entity, now.frame(*entity)?))).collect();
        Self { pose: seen.pose.clone(), root: *seen.root, grounds }
    }
}

/// Grounds between two frames.
struct Between<'a, G> {
    last: &'a [(Entity, Isometry3d)],
    now: &'a G,
    share: f32,
}

impl<G: GroundFrames> GroundFrames for Between<'_, G> {
    fn frame(&self, entity: Entity) -> Option<Isometry3d> {
        let now = self.now.frame(entity)?;
        let known = self.last.iter().find(|(known, _)| *known == entity);
        Some(known.map_or(now, |(_, last)| {
            let translation = last.translation.lerp(now.translation, self.share);
            Isometry3d::new(translation, last.rotation.slerp(now.rotation, self.share))
        }))
    }
}

/// Seconds by which a frame may come too early to be recorded.
const EARLY: f32 = 1e-4;

impl Recorder {
    /// Forgets what was recorded.
    pub fn restart(&mut self) {
        *self = Self { every: self.every, grounds: core::mem::take(&mut self.grounds), ..Self::default() };
    }

    /// Records one frame of `dt` seconds, or what lies in it of those that are recorded [`every`](Self::every) so many seconds.
    pub fn record(&mut self, seen: &Seen<'_>, probe: &impl Probe, grounds: &impl GroundFrames, dt: f32) {
        if self.every <= 0.0 {
            return self.take(seen, probe, grounds, dt);
        }
        let last = self.shown.take().unwrap_or_else(|| Shown::of(seen, &self.grounds, grounds));
        self.since += dt;
        while self.since >= self.every - EARLY {
            self.since -= self.every;
            let share = (1.0 - self.since / dt).clamp(0.0, 1.0);
            let mut pose = last.pose.clone();
            lerp_into(pose.locals_mut(), seen.pose.locals(), share);
            pose.update_model(&seen.asset.skeleton);
            let root = Transform {
                translation: last.root.translation.lerp(seen.root.translation, share),
                rotation: last.root.rotation.slerp(seen.root.rotation, share),
                scale: seen.root.scale,
            };
            let between = Between { last: &last.grounds, now: grounds, share };
            self.take(&Seen { pose: &pose, root: &root, ..*seen }, probe, &between, self.every);
        }
        self.shown = Some(Shown::of(seen, &self.grounds, grounds));
    }

    fn take(&mut self, seen: &Seen<'_>, probe: &impl Probe, grounds: &impl GroundFrames, dt: f32) {
        let world_from_model = seen.root.to_isometry();
        let mut met = Vec::with_capacity(6);
        let feet = [0, 1].map(|side| {
            let leg = &seen.asset.legs[side];
            let sole = sole_model(seen.pose, leg).map(|point| world_from_model * point);
            let hits = sole.map(|point| probe.down(point + Vec3::Y * ABOVE, ABOVE + BELOW));
            let mut carried = [Vec3::ZERO; 3];
            for (index, hit) in hits.iter().enumerate() {
                let Some((entity, now)) = hit.and_then(|hit| Some((hit.entity, grounds.frame(hit.entity)?))) else {
                    continue;
                };
                met.push((entity, now));
                if let Some((_, last)) = self.grounds.iter().find(|(known, _)| *known == entity) {
                    carried[index] = sole[index] - *last * (now.inverse() * sole[index]);
                }
            }
            let planted_ball = match seen.holds[side] {
                // Without what it moves along the world's vertical: a foot that lifts off a slope doesn't drift.
                Hold::Ball(Some(ground)) => grounds.frame(ground).map(|frame| {
                    let into = frame.inverse();
                    (into * sole[1]).reject_from_normalized(into.rotation * Vec3::Y)
                }),
                // Slides from one solid to the next: what it moved over all of them counts.
                Hold::Ball(None) => Some(match self.slides[side] {
                    Some((slid, ball)) => (slid + sole[1] - ball - carried[1]).with_y(0.0),
                    None => sole[1].with_y(0.0),
                }),
                Hold::Free | Hold::Stance => None,
            };
            self.slides[side] =
                planted_ball.filter(|_| seen.holds[side] == Hold::Ball(None)).map(|slid| (slid, sole[1]));
            let extension = extension(seen.pose, leg);
            let hardest = seen.asset.file.foot_ik.extension.1;
            FootFrame {
                sole,
                ground: hits.map(|hit| hit.map(|hit| hit.point.y)),
                carried,
                planted_ball,
                stance: seen.holds[side] != Hold::Free,
                // A leg stretches straight toward what it misses: both together are how far the target was.
                missed: seen.missed[side].filter(|missed| extension + missed / leg.length() <= hardest),
                extension,
                knee: knee(seen.pose, leg),
            }
        });
        self.grounds = met;
        self.clock += dt;
        let step = self.motion.advance(seen.pose, dt);
        self.frames.push(Frame {
            time: self.clock,
            feet,
            pelvis: (world_from_model * seen.pose.position(seen.asset.hips)).y,
            root: seen.root.translation,
            grounded: seen.grounded,
            wanted: seen.wanted.with_y(0.0),
            velocity: seen.velocity.with_y(0.0),
            pose_speed: step.speed,
            joint_speed: step.joint_speed,
            velocity_jump: step.velocity_jump,
            peak: self.peaks.advance(seen, dt),
        });
    }
}

/// Metres above and below a sole point between which its ground is looked for.
const ABOVE: f32 = 0.6;
const BELOW: f32 = 3.0;
/// Share of the slowest gait's liveliness that no pose is blamed for: feet may step while the body stands.
const STEP: f32 = 0.5;

/// How lively each clip is, at the frame rate of the recording.
#[derive(Clone, Debug, Default)]
struct ClipPeaks {
    dt: f32,
    clips: Vec<Peak>,
    floor: Peak,
    last: Peak,
}

impl ClipPeaks {
    /// The most that what plays now, or played in the last frame, does by itself.
    fn advance(&mut self, seen: &Seen<'_>, dt: f32) -> Peak {
        let clips = seen.asset.clips();
        if self.clips.len() != clips.len() || (self.dt - dt).abs() > 0.02 * dt {
            self.dt = dt;
            self.clips = clips.iter().map(|clip| Peak::of(&clip.clip, &seen.asset.skeleton, dt)).collect();
            let gaits = clips.iter().zip(&self.clips).filter(|(clip, _)| clip.gait.speed > 0.0);
            let slowest = gaits.min_by(|a, b| a.0.gait.speed.total_cmp(&b.0.gait.speed));
            self.floor = slowest.map_or_else(Peak::default, |(_, peak)| *peak * STEP);
        }
        let rated = |playing: &Playing| self.clips[playing.clip].at_rate(playing.rate.max(1.0));
        let now = seen.playing.iter().map(rated).fold(self.floor, Peak::max);
        now.max(core::mem::replace(&mut self.last, now))
    }
}

fn record(
    time: Res<Time>,
    assets: CharacterAssets,
    spatial: SpatialQuery,
    no_ground: Query<(), NoGround>,
    grounds: Frames,
    mut characters: Query<(
        &Character,
        &Transform,
        &MoveIntent,
        &MotionState,
        &Locomotion,
        &Actions,
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
    for (character, root, intent, motion, locomotion, actions, pose, ik, filter, mut recorder) in &mut characters {
        let Some(asset) = assets.get(character) else { continue };
        let seen = Seen {
            asset,
            pose: &pose.pose,
            root,
            grounded: motion.ground.is_some(),
            wanted: intent.velocity,
            velocity: motion.ground_velocity,
            holds: [0, 1].map(|side| {
                let leg = &asset.legs[side];
                // Nothing holds a foot in the air, whatever the clip thinks.
                if motion.ground.is_some() { hold(ik, locomotion, &pose.pose, leg, side) } else { Hold::Free }
            }),
            missed: [0, 1].map(|side| ik.placed[side].map(|_| ik.legs[side].missed)),
            playing: &playing(asset, locomotion, actions),
        };
        recorder.record(&seen, &PhysicsProbe::new(&spatial, &no_ground, filter), &grounds, dt);
    }
}

/// By the plants of foot IK; without foot IK by what the clips say.
fn hold(ik: &FootIk, locomotion: &Locomotion, pose: &Pose, leg: &Leg, side: usize) -> Hold {
    if ik.weight < 0.01 {
        return hold_of_clip(pose, leg, locomotion.cues[side].contact);
    }
    match ik.feet[side].plant() {
        None => Hold::Free,
        Some(plant) if plant.pivot == Pivot::Ball => Hold::Ball(Some(plant.ground)),
        Some(_) => Hold::Stance,
    }
}

/// What a clip alone says of a foot whose contact weighs `contact`.
#[must_use]
pub fn hold_of_clip(pose: &Pose, leg: &Leg, contact: f32) -> Hold {
    let [heel, ball, _] = sole_model(pose, leg);
    match contact >= 0.5 {
        true if ball.y <= heel.y + 0.005 => Hold::Ball(None),
        true => Hold::Stance,
        false => Hold::Free,
    }
}

fn playing(asset: &CharacterAsset, locomotion: &Locomotion, actions: &Actions) -> Vec<Playing> {
    let machine = &locomotion.machine;
    let laid_over = actions
        .clips(asset)
        .filter_map(|clip| Some(Playing { clip: asset.clip_index(&clip.name)?, rate: clip.clip.speed }));
    locomotion
        .playing(asset)
        .filter_map(|playing| {
            let gait = machine.is_gait(playing.state);
            let rate = if gait { machine.phase_rate() * playing.clip.clip.duration } else { 1.0 };
            Some(Playing { clip: asset.clip_index(&playing.clip.name)?, rate })
        })
        .chain(laid_over)
        .collect()
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
