//! Palettes of characters that clips alone pose: in blocks of one kind, straight from their clips to their matrices.
//!
//! Reads what [`CharacterPose`] notes of the clips of the last two ticks, writes skinning matrices of what lies between, once a
//! frame. Whoever draws characters gathers [`PaletteJob`]s, of all others, too, and has them [written](Crowd::write).

use bevy::{ecs::system::SystemParam, prelude::*, tasks::ComputeTaskPool, utils::Parallel};

use super::{
    Character,
    animator::CharacterPose,
    detail::{ClipsOnly, Mode, Pacing},
    schedule::{PoseClock, stagger},
};
use crate::{
    anim::{
        block::{Actor, Layer, Play, Species, Workspace, pose},
        matrix::JointMatrix,
    },
    rig::character::CharacterAsset,
};

/// Characters of a block: as many as there are lanes.
const BLOCK: usize = 8;
/// Fewest palettes that are worth a task of their own.
const LEAST: usize = 64;
/// Tasks for each thread, so that none waits long for the last.
const TASKS: usize = 4;

/// Goes on characters whose pose is read by more than their skin: it is made in any case, and
/// [`Detail::clips_only`](super::detail::Detail::clips_only) does nothing for them.
///
/// What [rides](super::attach::Attach) on a character puts it there; put it on those whose [`CharacterPose`] you read.
#[derive(Component, Reflect, Clone, Copy, Debug, Default)]
#[reflect(Component)]
pub struct PoseRead;

/// A palette to be written.
#[derive(Clone, Copy, Debug)]
pub struct PaletteJob {
    /// Where it begins among all matrices.
    pub first: usize,
    /// Its matrices.
    pub len: usize,
    /// Whose it is.
    pub character: Entity,
    /// Which of the character's: index of the skin in [`Rig::skins`](crate::rig::Rig::skins), or whatever tells it from others
    /// where the job isn't done in blocks.
    pub part: usize,
    /// The kind of a character that clips alone pose; `None`: it has a pose.
    pub kind: Option<Kind>,
}

/// Characters that blocks pose together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Kind {
    /// Their file.
    pub asset: AssetId<CharacterAsset>,
    /// [`Detail::small_joints`](super::detail::Detail::small_joints).
    pub small_joints: bool,
}

/// Memory of one thread.
#[derive(Default)]
struct Scratch {
    work: Workspace,
    plays: [Vec<Play>; BLOCK],
}

/// Poses characters by their clips alone, in blocks. Where nothing animates characters it only writes the palettes of others.
#[derive(SystemParam)]
pub struct Crowd<'w, 's> {
    time: Option<Res<'w, Time>>,
    fixed: Option<Res<'w, Time<Fixed>>>,
    clock: Option<Res<'w, PoseClock>>,
    assets: Option<Res<'w, Assets<CharacterAsset>>>,
    poses: Query<'w, 's, &'static CharacterPose>,
    scratch: Local<'s, Parallel<Scratch>>,
}

impl Crowd<'_, '_> {
    /// The kind of `character` if clips alone pose it.
    #[must_use]
    pub fn kind(character: &Character, pacing: Option<&Pacing>) -> Option<Kind> {
        let pacing = pacing.filter(|pacing| pacing.mode == Mode::ClipsOnly(ClipsOnly::Alone))?;
        Some(Kind { asset: character.0.id(), small_joints: pacing.small_joints })
    }

    /// Whether who is posed by clips alone is to be shown anew in this frame.
    #[must_use]
    pub fn is_due(&self, character: Entity, pacing: &Pacing) -> bool {
        let step = f64::from(pacing.shown_every);
        let Some(time) = self.time.as_ref().filter(|_| step > 0.0 && !pacing.returns) else { return true };
        let now = time.elapsed_secs_f64() / step + f64::from(stagger(character));
        now.floor() > (now - time.delta_secs_f64() / step).floor()
    }

    /// Writes the palettes of all `jobs` into `matrices`, on all threads; `others` writes those of characters with a pose. Jobs
    /// change places. Those that lie over others, or beyond the end, are left out.
    pub fn write(
        &self,
        jobs: &mut [PaletteJob],
        matrices: &mut [JointMatrix],
        others: impl Fn(&PaletteJob, &mut [JointMatrix]) + Sync,
    ) {
        jobs.sort_unstable_by_key(|job| job.first);
        let threads = ComputeTaskPool::try_get().map_or(1, |pool| pool.thread_num());
        let Some(pool) = ComputeTaskPool::try_get().filter(|_| threads > 1 && jobs.len() >= 2 * LEAST) else {
            return self.write_run(jobs, 0, matrices, &others);
        };
        let run = jobs.len().div_ceil(threads * TASKS).max(LEAST);
        pool.scope(|scope| {
            let (mut jobs, mut matrices, mut base) = (jobs, matrices, 0);
            while !jobs.is_empty() {
                let (run, later) = jobs.split_at_mut(run.min(jobs.len()));
                let end =
                    later.first().map_or(matrices.len(), |job| job.first.clamp(base, base + matrices.len()) - base);
                let (own, rest) = matrices.split_at_mut(end);
                let others = &others;
                let first = base;
                scope.spawn(async move { self.write_run(run, first, own, others) });
                base += end;
                (jobs, matrices) = (later, rest);
            }
        });
    }

    /// Writes palettes into `matrices`, which begin at `base` among all.
    fn write_run(
        &self,
        jobs: &mut [PaletteJob],
        base: usize,
        matrices: &mut [JointMatrix],
        others: &impl Fn(&PaletteJob, &mut [JointMatrix]),
    ) {
        jobs.sort_unstable_by_key(|job| (job.kind, if job.kind.is_some() { job.part } else { 0 }, job.first));
        let mut scratch = self.scratch.borrow_local_mut();
        for run in jobs.chunk_by(|a, b| a.kind == b.kind && (a.kind.is_none() || a.part == b.part)) {
            let species = |kind: Kind| {
                let asset = self.assets.as_ref()?.get(kind.asset)?;
                Some((asset, asset.species(run[0].part, kind.small_joints)?))
            };
            match run[0].kind.and_then(species) {
                Some(kind) => {
                    for block in run.chunks(BLOCK) {
                        self.write_block(block, kind, base, matrices, &mut scratch);
                    }
                }
                None => {
                    for job in run {
                        let place = job.first.wrapping_sub(base);
                        if let Some(out) = place.checked_add(job.len).and_then(|end| matrices.get_mut(place..end)) {
                            others(job, out);
                        }
                    }
                }
            }
        }
    }

    fn write_block(
        &self,
        block: &[PaletteJob],
        (asset, species): (&CharacterAsset, &Species),
        base: usize,
        matrices: &mut [JointMatrix],
        scratch: &mut Scratch,
    ) {
        let share = match (&self.clock, &self.fixed) {
            (Some(clock), Some(fixed)) => clock.share(fixed.overstep_fraction()),
            _ => 1.0,
        };
        for (job, plays) in block.iter().zip(&mut scratch.plays) {
            plays.clear();
            if let Ok(pose) = self.poses.get(job.character) {
                pose.plays_between(asset, share, plays);
            }
        }
        let mut layers = [Layer::default(); BLOCK];
        for (layer, plays) in layers.iter_mut().zip(&scratch.plays) {
            *layer = Layer { weight: 1.0, clips: plays, ..Layer::default() };
        }
        let mut actors = [Actor::default(); BLOCK];
        for ((actor, layer), job) in actors.iter_mut().zip(layers.chunks(1)).zip(block) {
            *actor = Actor { layers: layer, palette: job.first.wrapping_sub(base), ..Actor::default() };
        }
        pose(species, &actors[..block.len()], &mut scratch.work, matrices);
    }
}
