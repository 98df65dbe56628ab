//! Shows what lies between two ticks: poses as the engine's interpolation shows roots and grounds.
//!
//! Reads [`CharacterPose`] at the end of each tick and writes its model pose in each frame. Joints go from place to place on
//! straight lines in model space, not by their turns: a foot that stands still in both ticks stands still between them.

use bevy::{prelude::*, utils::Parallel};

use super::{
    Character,
    animator::{CharacterPose, ClipsScratch},
    bind::CharacterAssets,
    detail::{ClipsOnly, Mode, Pacing},
    ease::Ease,
    motion::MotionState,
    schedule::{PoseClock, PoseSystems},
};
use crate::anim::{
    blend::lerp,
    matrix::{JointMatrix, move_toward, write_between},
    pose::Pose,
    skeleton::{JointTransform, Skeleton},
};

/// The poses of the last two ticks, or steps, the older one first, of who has a [`Detail`](super::detail::Detail) or [`ShowLocals`]: of
/// others the [pose](CharacterPose) itself keeps the one before. Its buffers are made when it is first posed.
#[derive(Component, Clone, Debug, Default)]
pub struct Ticked {
    models: [Vec<JointMatrix>; 2],
    /// Empty for who has no [`ShowLocals`].
    locals: [Vec<JointTransform>; 2],
    teleports: u32,
    /// The two are poses of steps that take more than a tick: level of detail.
    direct: bool,
    /// Clips alone posed it since they were recorded.
    stale: bool,
}

/// Has local transforms shown between ticks, too; without it [`CharacterPose`] keeps those of the last tick.
///
/// For those whose shown pose is changed further, or read joint by joint. IK chains ask for it by themselves.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct ShowLocals;

impl Ticked {
    /// One tick. Takes the model matrices of `pose`, which are stale until it is shown or posed again. `jumped`: there is no way
    /// from the pose before to this one.
    fn record(&mut self, pose: &mut Pose, locals: bool, jumped: bool) {
        let known = self.models[1].len() == pose.len() && !jumped;
        self.models.swap(0, 1);
        if self.models[1].len() != pose.len() {
            fill(&mut self.models[1], pose.models());
        }
        pose.swap_models(&mut self.models[1]);
        if !known {
            let [before, now] = &mut self.models;
            fill(before, now);
        }
        if locals {
            let known = known && self.locals[1].len() == pose.len();
            self.locals.swap(0, 1);
            fill(&mut self.locals[1], pose.locals());
            if !known {
                fill(&mut self.locals[0], pose.locals());
            }
        }
    }

    /// What is recorded next comes after `before`, local transforms.
    fn begin_after(&mut self, pose: &mut Pose, skeleton: &Skeleton, before: &[JointTransform], locals: bool) {
        if before.len() != pose.len() {
            return;
        }
        let swap = |pose: &mut Pose, with: &mut Vec<JointTransform>| {
            pose.locals_mut().swap_with_slice(with);
            pose.update_model(skeleton);
        };
        let mut other = before.to_vec();
        swap(pose, &mut other);
        fill(&mut self.models[1], pose.models());
        if locals {
            fill(&mut self.locals[1], before);
        }
        swap(pose, &mut other);
    }

    /// Whether the body was put elsewhere since this was asked last.
    fn jumped(&mut self, motion: &MotionState) -> bool {
        core::mem::replace(&mut self.teleports, motion.teleports) != motion.teleports
    }

    /// It keeps both poses from now on, of which the pose itself kept one so far.
    fn take_over(&mut self, pose: &mut Pose) {
        *self = Self { models: [Vec::new(), pose.forget_before()], teleports: self.teleports, ..Self::default() };
    }

    /// The same in a frame, for a pose that is to be changed in it.
    fn take_over_shown(&mut self, pose: &mut Pose) {
        self.models = [pose.forget_before(), pose.models().to_vec()];
        self.locals = [pose.locals().to_vec(), pose.locals().to_vec()];
    }

    /// The pose itself keeps the one before from now on.
    fn leave(&mut self, pose: &mut Pose) {
        let [_, last] = core::mem::take(&mut self.models);
        if last.len() == pose.len() && !self.stale {
            pose.take_before(last);
        }
        *self = Self { teleports: self.teleports, ..Self::default() };
    }

    /// From now on ticks are recorded again: the last one was seen `share` of the way between the steps.
    fn end_steps(&mut self, share: f32) {
        let [from, to] = &mut self.models;
        move_toward(from, to, share);
        self.models.swap(0, 1);
        let [from, to] = &mut self.locals;
        for (from, to) in from.iter().zip(to) {
            *to = lerp(*from, *to, share);
        }
    }

    /// The pose that lies `share` of the way from the older pose to the newer one.
    fn show(&self, pose: &mut Pose, share: f32) {
        let [from, to] = &self.models;
        if to.len() != pose.len() || from.len() != pose.len() {
            return;
        }
        write_between(from, to, share, pose.models_mut());
        let [from, to] = &self.locals;
        for ((seen, from), to) in pose.locals_mut().iter_mut().zip(from).zip(to) {
            *seen = lerp(*from, *to, share);
        }
    }
}

fn fill<T: Copy>(buffer: &mut Vec<T>, from: &[T]) {
    buffer.clear();
    buffer.extend_from_slice(from);
}

/// Shows poses between ticks.
pub struct ShowPlugin;

impl Plugin for ShowPlugin {
    fn build(&self, app: &mut App) {
        app.register_required_components::<CharacterPose, Ticked>()
            .add_systems(FixedPostUpdate, record.in_set(PoseSystems::Ease).after(super::ease::ease))
            .add_systems(PostUpdate, show.in_set(PoseSystems::Show));
    }
}

fn record(
    assets: CharacterAssets,
    scratch: Local<Parallel<ClipsScratch>>,
    mut characters: Query<(
        &Character,
        &mut CharacterPose,
        &MotionState,
        Option<(&Pacing, &Ease)>,
        Has<ShowLocals>,
        &mut Ticked,
    )>,
) {
    characters.par_iter_mut().for_each(|(character, mut pose, motion, detail, locals, mut ticked)| {
        let mut returns = false;
        if detail.is_none() && !locals {
            if !ticked.models[1].is_empty() {
                ticked.leave(&mut pose.pose);
            }
            let jumped = ticked.jumped(motion);
            return pose.pose.keep_before(jumped);
        }
        // Who isn't posed isn't touched, so that nobody takes it for changed.
        if pose.pose.keeps_before() {
            ticked.take_over(&mut pose.pose);
        }
        if let Some((pacing, ease)) = detail {
            if pacing.mode == Mode::ClipsOnly(ClipsOnly::Alone) {
                (ticked.stale, ticked.direct) = (true, false);
                return;
            }
            let asset = assets.get(character);
            if let (true, true, Some(asset)) = (ticked.stale, pacing.joins, asset)
                && let Some(before) =
                    pose.clips_pose(asset, (true, pacing.small_joints), &mut scratch.borrow_local_mut())
            {
                ticked.begin_after(&mut pose.pose, &asset.skeleton, before, locals);
            }
            let steps = ease.direct();
            if pacing.mode == Mode::Hidden || (ticked.direct && steps.is_some() && pacing.due.is_none()) {
                return;
            }
            returns = pacing.returns;
            match (ticked.direct, steps, asset) {
                (false, Some(before), Some(asset)) => {
                    ticked.begin_after(&mut pose.pose, &asset.skeleton, before, locals);
                }
                (true, None, _) => ticked.end_steps(ease.left()),
                _ => {}
            }
            ticked.direct = steps.is_some();
        }
        ticked.stale = false;
        let jumped = ticked.jumped(motion);
        ticked.record(&mut pose.pose, locals, jumped || returns);
    });
}

fn show(
    fixed: Res<Time<Fixed>>,
    clock: Res<PoseClock>,
    mut characters: Query<(&mut Ticked, Option<(&Pacing, &Ease)>, Has<ShowLocals>, &mut CharacterPose)>,
) {
    let overstep = fixed.overstep_fraction();
    let (share, after) = (clock.share(overstep), clock.shown_secs(overstep));
    characters.par_iter_mut().for_each(|(mut ticked, detail, locals, mut pose)| {
        if pose.pose.keeps_before() {
            if !locals {
                return pose.pose.show(share);
            }
            ticked.take_over_shown(&mut pose.pose);
        }
        match detail {
            Some((pacing, _)) if matches!(pacing.mode, Mode::Hidden | Mode::ClipsOnly(ClipsOnly::Alone)) => {}
            Some((_, ease)) if ticked.direct => ticked.show(&mut pose.pose, ease.seen(after)),
            _ => ticked.show(&mut pose.pose, share),
        }
    });
}
