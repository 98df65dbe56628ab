//! Blends between the poses of those that aren't posed in every frame, and over changes from one detail to another.
//!
//! Reads [`Pacing`] and the pose of all stages before; writes [`CharacterPose`], local and model space. With steps of `s` seconds the
//! pose is seen `s` late, between its last two; where that begins or ends, the difference decays.

use bevy::{prelude::*, utils::Parallel};

use super::{
    Character,
    animator::{CharacterPose, ClipsScratch},
    bind::CharacterAssets,
    detail::{ClipsOnly, Detail, Mode, Pacing},
    schedule::{PoseClock, PoseSystems},
};
use crate::{
    anim::{blend::lerp, skeleton::JointTransform},
    math::{
        rotation::{from_scaled_axis, to_scaled_axis},
        spring::Spring,
    },
};

/// Half-life in seconds of the difference between how it was and how it will be posed.
const HALF_LIFE: f32 = 0.12;
/// Seconds by which a pose may come before its time.
const EARLY: f32 = 1e-3;
/// Share of the difference below which it is over.
const OVER: f32 = 1e-3;

/// What is carried over for one character. Its buffers are made when it is first posed in steps.
#[derive(Component, Clone, Debug, Default)]
pub struct Ease {
    /// The last two poses, the older one first.
    keys: [Vec<JointTransform>; 2],
    /// Seconds between the two, and since the last one.
    span: f32,
    since: f32,
    stepped: Option<f32>,
    offsets: Vec<Offset>,
    /// How much of the offsets is left.
    share: Spring<f32>,
    /// Whether nothing is left of them: ticks change nothing, frames show what lies between the last two poses by themselves.
    direct: bool,
    /// Where between the two it was seen last, when it no longer is so.
    left: f32,
    /// Seconds of the last tick.
    tick: f32,
}

/// What takes a joint from how it is posed now to how it was posed before.
#[derive(Clone, Copy, Debug)]
struct Offset {
    rotation: Vec3,
    translation: Vec3,
}

impl Ease {
    /// One frame: `pose` as the stages left it becomes what is seen. `clips` is that of the clips alone, where they take over or
    /// give it back.
    fn advance(&mut self, pacing: &Pacing, pose: &mut [JointTransform], clips: Option<&[JointTransform]>, dt: f32) {
        self.share.step(0.0, HALF_LIFE, dt);
        self.since += dt;
        self.tick = dt;
        let (was, due) = (self.stepped, pacing.due.is_some());
        self.stepped = if let Mode::Stepped(step) = pacing.mode { Some(step) } else { None };
        let in_time = self.stepped.is_some_and(|step| !due || self.since + EARLY >= step);
        let steady = was.is_some() && in_time && self.share.value <= OVER;
        if let (true, Some(step)) = (self.direct, was) {
            self.left = self.share(step);
        }
        // Only steps of whole ticks end where a tick does.
        let whole = self.stepped.is_some_and(|step| self.is_whole(step) && (self.since - step).abs() <= EARLY);
        self.direct = steady && if due { whole } else { self.direct };
        if let (Some(step), None) = (was, self.stepped)
            && due
            && self.since + EARLY >= step
        {
            // The last step ends in time: it was on the way to this pose.
            self.keys.swap(0, 1);
            self.record(1, pose);
        }
        match (was, self.stepped) {
            _ if pacing.mode == Mode::Hidden => return self.share = Spring::at(0.0),
            (step, _) if clips.is_some() => {
                let clips = clips.unwrap_or_default();
                if pacing.joins {
                    self.begin(pose, |_, joint, posed| (clips[joint], *posed));
                } else {
                    let seen = |ease: &Self, joint: usize, posed: &JointTransform| {
                        step.map_or(*posed, |step| ease.between(joint, ease.lag(step), posed))
                    };
                    self.begin(pose, |ease, joint, posed| (seen(ease, joint, posed), clips[joint]));
                    pose.copy_from_slice(clips);
                }
            }
            (Some(step), None) => {
                self.begin(pose, |ease, joint, posed| (ease.between(joint, ease.lag(step), posed), *posed));
            }
            (Some(step), Some(_)) if !in_time => {
                // It didn't wait: what was still to be seen of the last two poses isn't.
                self.begin(pose, |ease, joint, posed| {
                    (ease.between(joint, ease.lag(step), posed), ease.between(joint, 0.0, posed))
                });
            }
            _ => {}
        }
        match pacing.mode {
            // The first pose of the first step.
            Mode::Warming(seconds) if seconds <= 0.0 => self.record(0, pose),
            Mode::Stepped(_) if due => {
                if was.is_some() {
                    self.keys.swap(0, 1);
                }
                self.record(1, pose);
            }
            _ => {}
        }
        if self.direct {
            return;
        }
        if let (None, Some(step)) = (was, self.stepped) {
            self.begin(pose, |ease, joint, posed| (*posed, ease.between(joint, ease.lag(step), posed)));
        }
        if let Some(step) = self.stepped {
            for (joint, seen) in pose.iter_mut().enumerate() {
                *seen = self.between(joint, self.lag(step), seen);
            }
        }
        if self.share.value > OVER {
            for (seen, offset) in pose.iter_mut().zip(&self.offsets) {
                *seen = offset.on(seen, self.share.value);
            }
        }
    }

    fn record(&mut self, key: usize, pose: &[JointTransform]) {
        self.keys[key].clear();
        self.keys[key].extend_from_slice(pose);
        (self.span, self.since) = (self.since, 0.0);
    }

    /// Whether it changes poses at all.
    fn is_idle(&self, pacing: &Pacing) -> bool {
        let plain = matches!(pacing.mode, Mode::Every | Mode::ClipsOnly(ClipsOnly::Settles | ClipsOnly::Alone));
        plain && !pacing.joins && self.stepped.is_none() && self.is_over()
    }

    /// Whether nothing is left of any difference.
    pub(super) fn is_over(&self) -> bool {
        self.share.value <= OVER
    }

    /// Whether frames show what lies between the last two poses, of which the older one is given.
    pub(super) fn direct(&self) -> Option<&[JointTransform]> {
        self.direct.then_some(&self.keys[0])
    }

    /// Where between the last two poses a frame lies that is seen `after` seconds after the last tick, 0..=1.
    pub(super) fn seen(&self, after: f32) -> f32 {
        self.share(self.stepped.unwrap_or(0.0) - after)
    }

    /// The same for the last tick in which frames showed that.
    pub(super) fn left(&self) -> f32 {
        self.left
    }

    /// Seconds by which a tick sees poses of such steps late. Frames show ticks one later: for steps of whole ticks that is taken
    /// off, so that nothing changes where frames go on by themselves.
    fn lag(&self, step: f32) -> f32 {
        if self.is_whole(step) { step - self.tick } else { step }
    }

    fn is_whole(&self, step: f32) -> bool {
        let ticks = (step / self.tick).round();
        (ticks * self.tick - step).abs() <= EARLY
    }

    /// Where between the keys lies what was `ago` seconds before now, 0..=1.
    fn share(&self, ago: f32) -> f32 {
        let share = if self.span > 0.0 { (self.span + self.since - ago) / self.span } else { 1.0 };
        share.clamp(0.0, 1.0)
    }

    /// The joint as it was `ago` seconds ago; as `posed` now where that isn't known, as in a model that has changed.
    fn between(&self, joint: usize, ago: f32, posed: &JointTransform) -> JointTransform {
        let [Some(from), Some(to)] = [0, 1].map(|key| self.keys[key].get(joint).copied()) else {
            return *posed;
        };
        lerp(from, to, self.share(ago))
    }

    /// From now on something else is seen: `pair` gives how a joint would be seen so far, and how it will be.
    fn begin(
        &mut self,
        pose: &[JointTransform],
        pair: impl Fn(&Self, usize, &JointTransform) -> (JointTransform, JointTransform),
    ) {
        let left = if self.share.value > OVER { self.share.value } else { 0.0 };
        let mut offsets = core::mem::take(&mut self.offsets);
        offsets.resize(pose.len(), Offset { rotation: Vec3::ZERO, translation: Vec3::ZERO });
        for (joint, (offset, posed)) in offsets.iter_mut().zip(pose).enumerate() {
            let (before, after) = pair(self, joint, posed);
            let seen = offset.on(&before, left);
            *offset = Offset {
                rotation: to_scaled_axis(seen.rotation * after.rotation.inverse()),
                translation: seen.translation - after.translation,
            };
        }
        (self.offsets, self.share) = (offsets, Spring::at(1.0));
    }
}

impl Offset {
    fn on(&self, joint: &JointTransform, share: f32) -> JointTransform {
        JointTransform {
            rotation: (from_scaled_axis(self.rotation * share) * joint.rotation).normalize(),
            translation: joint.translation + self.translation * share,
            ..*joint
        }
    }
}

/// Blends between poses.
pub struct EasePlugin;

impl Plugin for EasePlugin {
    fn build(&self, app: &mut App) {
        app.register_required_components::<Detail, Ease>().add_systems(FixedPostUpdate, ease.in_set(PoseSystems::Ease));
    }
}

pub(super) fn ease(
    clock: Res<PoseClock>,
    assets: CharacterAssets,
    scratch: Local<Parallel<ClipsScratch>>,
    mut characters: Query<(&Character, &Pacing, &mut Ease, &mut CharacterPose)>,
) {
    let dt = clock.delta_secs();
    characters.par_iter_mut().for_each(|(character, pacing, mut ease, mut pose)| {
        let Some(asset) = assets.get(character).filter(|_| !ease.is_idle(pacing)) else { return };
        let hidden = pacing.mode == Mode::Hidden;
        if hidden {
            ease.advance(pacing, &mut [], None, dt);
        } else {
            // What isn't due isn't touched, so that nobody takes it for changed.
            let direct = ease.direct && pacing.due.is_none();
            let mut scratch = scratch.borrow_local_mut();
            let passes = pacing.joins || pacing.mode == Mode::ClipsOnly(ClipsOnly::Leaves);
            let clips = if passes { pose.clips_pose(asset, (false, pacing.small_joints), &mut scratch) } else { None };
            ease.advance(pacing, if direct { &mut [] } else { pose.pose.locals_mut() }, clips, dt);
            if !ease.direct {
                pose.pose.update_model(&asset.skeleton);
            }
        }
    });
}
