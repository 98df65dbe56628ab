//! Records what a viewer sees: final poses against the true colliders, once a frame.

use avian3d::prelude::*;
use bevy::prelude::*;

use super::{
    frame::{FootFrame, Frame},
    seen::{Hold, Playing, Seen, Ticked, extension, hold, knee, missed, playing},
};
use crate::{
    anim::{
        blend::lerp_into,
        matrix::move_toward,
        peak::{JointMotion, Peak},
        pose::Pose,
    },
    character::{
        Character,
        animator::{Actions, CharacterPose},
        bind::CharacterAssets,
        foot_ik::{FootIk, Frames, GroundFilter, GroundFrames, GroundHit, NoGround, PhysicsProbe, Probe},
        intent::MoveIntent,
        locomotion::Locomotion,
        motion::MotionState,
        schedule::PoseSystems,
        show::ShowLocals,
        sole::sole_model,
    },
};

/// Records the frames of the character that it is put on.
#[derive(Component, Clone, Debug, Default)]
#[require(ShowLocals)]
pub struct Recorder {
    /// What was recorded, in order of time.
    pub frames: Vec<Frame>,
    /// Seconds from one recorded frame to the next, whatever the frame rate. 0 records what is shown, frame by frame. Default 0.
    ///
    /// Two frame rates compare only where both are seen at the same moments: speeds and changes are differences of frames. Poses
    /// between two frames are blended, and so is where grounds are; a foot is held if it is in both. What plays is that of the later one.
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
    /// What the last two ticks did, the earlier one first.
    ticks: [Ticked; 2],
}

/// Fills [`Recorder`]s.
pub struct MeasurePlugin;

impl Plugin for MeasurePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(FixedPostUpdate, note.in_set(PoseSystems::Aim))
            .add_systems(PostUpdate, record.in_set(PoseSystems::Attach));
    }
}

/// A frame as it was shown: pose, root, and the grounds that feet are over.
#[derive(Clone, Debug)]
struct Shown {
    pose: Pose,
    root: Transform,
    holds: [Hold; 2],
    grounds: Vec<(Entity, Isometry3d)>,
}

impl Shown {
    fn of(seen: &Seen<'_>, under: &[(Entity, Isometry3d)], now: &impl GroundFrames) -> Self {
        let grounds = under.iter().filter_map(|(entity, _)| Some((*entity, now.frame(*entity)?))).collect();
        Self { pose: seen.pose.clone(), root: *seen.root, holds: seen.holds, grounds }
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
        let grounds = core::mem::take(&mut self.grounds);
        *self = Self { every: self.every, ticks: self.ticks, grounds, ..Self::default() };
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
            move_toward(pose.models_mut(), seen.pose.models(), share);
            let root = Transform {
                translation: last.root.translation.lerp(seen.root.translation, share),
                rotation: last.root.rotation.slerp(seen.root.rotation, share),
                scale: seen.root.scale,
            };
            let between = Between { last: &last.grounds, now: grounds, share };
            // A moment between two frames may be that of an earlier tick.
            let holds = match share < 1.0 - EARLY {
                true => [0, 1].map(|side| last.holds[side].and(seen.holds[side])),
                false => seen.holds,
            };
            self.take(&Seen { pose: &pose, root: &root, holds, ..*seen }, probe, &between, self.every);
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
            FootFrame {
                sole,
                ground: hits.map(|hit| hit.map(|hit| hit.point.y)),
                carried,
                planted_ball,
                stance: seen.holds[side] != Hold::Free,
                missed: seen.missed[side],
                extension: extension(seen.pose, leg),
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

/// Colliders as the frame shows them: those that move are where the last tick left them.
struct ShownGround<'a, 'w, 's, P, G> {
    colliders: P,
    places: &'a Query<'w, 's, (&'static Position, &'static Rotation)>,
    shown: &'a G,
}

impl<P: Probe, G: GroundFrames> Probe for ShownGround<'_, '_, '_, P, G> {
    fn down(&self, start: Vec3, length: f32) -> Option<GroundHit> {
        let hit = self.colliders.down(start, length)?;
        let (Ok((position, rotation)), Some(shown)) = (self.places.get(hit.entity), self.shown.frame(hit.entity))
        else {
            return Some(hit);
        };
        let carried = shown * Isometry3d::new(position.0, rotation.0).inverse();
        Some(GroundHit { point: carried * hit.point, ..hit })
    }
}

/// Notes what a tick did with the feet.
fn note(
    assets: CharacterAssets,
    mut characters: Query<(&Character, &MotionState, &Locomotion, &CharacterPose, &FootIk, &mut Recorder)>,
) {
    for (character, motion, locomotion, pose, ik, mut recorder) in &mut characters {
        let Some(asset) = assets.get(character) else { continue };
        let grounded = motion.ground.is_some();
        recorder.ticks.swap(0, 1);
        recorder.ticks[1] = Ticked {
            grounded,
            // Nothing holds a foot in the air, whatever the clip thinks.
            holds: [0, 1].map(|side| match grounded {
                true => hold(ik, locomotion, &pose.pose, &asset.legs[side], side),
                false => Hold::Free,
            }),
            missed: [0, 1].map(|side| ik.placed[side].and_then(|_| missed(asset, &pose.pose, side, ik))),
        };
    }
}

fn record(
    time: Res<Time>,
    assets: CharacterAssets,
    spatial: SpatialQuery,
    no_ground: Query<(), NoGround>,
    grounds: Frames,
    places: Query<(&'static Position, &'static Rotation)>,
    mut characters: Query<(
        &Character,
        &Transform,
        &MoveIntent,
        &MotionState,
        &Locomotion,
        &Actions,
        &CharacterPose,
        &GroundFilter,
        &mut Recorder,
    )>,
) {
    let dt = time.delta_secs();
    if dt <= 0.0 {
        return;
    }
    for (character, root, intent, motion, locomotion, actions, pose, filter, mut recorder) in &mut characters {
        let Some(asset) = assets.get(character) else { continue };
        let ticked = Ticked::between(&recorder.ticks);
        let seen = Seen {
            asset,
            pose: &pose.pose,
            root,
            grounded: ticked.grounded,
            wanted: intent.velocity,
            velocity: motion.ground_velocity,
            holds: ticked.holds,
            missed: ticked.missed,
            playing: &playing(asset, locomotion, actions),
        };
        let colliders = PhysicsProbe::new(&spatial, &no_ground, filter);
        recorder.record(&seen, &ShownGround { colliders, places: &places, shown: &grounds }, &grounds, dt);
    }
}
