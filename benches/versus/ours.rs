//! Surefoot's stages on a crowd: blocks of characters, palettes into one slice.

use std::thread;

use bevy::math::{Quat, Vec3};
use surefoot::anim::{
    block::{
        Actor, Goal, Layer, LimbJoints, Play, Precision, RowSource, RowsReport, Species, SpeciesParts, Until,
        Workspace, pose_until,
    },
    clip::Clip,
    ik::two_bone::Extension,
    matrix::JointMatrix,
};

use crate::body::Body;

/// Species and clips, ready for crowds of any size.
pub(crate) struct Ours {
    species: Species,
    durations: [f32; 2],
}

/// A crowd and where its palettes go.
pub(crate) struct Crowd {
    plays: Vec<[Play; 2]>,
    goals: [Option<Goal>; 2],
    matrices: Vec<JointMatrix>,
    clips: usize,
}

impl Ours {
    pub(crate) fn new(body: &Body, precision: Precision) -> Self {
        let clips: Vec<Clip> =
            [&body.walk, &body.run].map(|keys| keys.curves(&body.skeleton).bake_at(&body.skeleton, 30.0)).into();
        let sources: Vec<_> = clips.iter().map(|clip| RowSource::new(clip, precision)).collect();
        let limbs =
            body.legs.map(|[upper, lower, end]| LimbJoints { upper, lower, end, extension: Extension::default() });
        let parts =
            SpeciesParts { skeleton: &body.skeleton, skin: &body.skin, limbs: &limbs, clips: &sources, masks: &[] };
        let species = Species::new(&parts).expect("the parts fit");
        Self { species, durations: [body.walk.duration(), body.run.duration()] }
    }

    /// Bytes and error of the walk's rows.
    pub(crate) fn walk_report(&self) -> RowsReport {
        self.species.clips()[0].report()
    }

    /// `count` characters, spread over the cycle, that play `clips` clips each.
    pub(crate) fn crowd(&self, count: usize, clips: usize) -> Crowd {
        let plays = (0..count).map(|index| {
            let phase = (index as f32 * 0.618_034).fract();
            let play = |clip: usize, weight| Play { clip, time: phase * self.durations[clip], weight };
            [play(0, 0.6), play(1, 0.4)]
        });
        let goal = |x: f32, z: f32| Goal {
            target: Vec3::new(x, 0.12, z),
            pole: Vec3::NEG_Z,
            end_turn: Quat::from_rotation_x(0.1),
        };
        Crowd {
            plays: plays.collect(),
            goals: [Some(goal(-0.1, -0.15)), Some(goal(0.1, 0.1))],
            matrices: vec![JointMatrix::IDENTITY; count * self.species.slot_count()],
            clips,
        }
    }

    /// One frame: time goes on, and stages run until one.
    pub(crate) fn frame(&self, crowd: &mut Crowd, work: &mut Workspace, until: Until) {
        let slots = self.species.slot_count();
        for (plays, matrices) in crowd.plays.chunks_mut(CHUNK).zip(crowd.matrices.chunks_mut(CHUNK * slots)) {
            self.chunk(plays, matrices, (&crowd.goals, crowd.clips), work, until);
        }
    }

    /// The same with two threads, each with half of the crowd.
    pub(crate) fn frame_on_two(&self, crowd: &mut Crowd, works: &mut [Workspace; 2]) {
        let slots = self.species.slot_count();
        let half = crowd.plays.len() / 2;
        let (plays, matrices) = (crowd.plays.split_at_mut(half), crowd.matrices.split_at_mut(half * slots));
        let goals = (&crowd.goals, crowd.clips);
        let [first, second] = works;
        let run = |plays: &mut [[Play; 2]], matrices: &mut [JointMatrix], work: &mut Workspace| {
            for (plays, matrices) in plays.chunks_mut(CHUNK).zip(matrices.chunks_mut(CHUNK * slots)) {
                self.chunk(plays, matrices, goals, work, Until::Written);
            }
        };
        thread::scope(|scope| {
            scope.spawn(|| run(plays.0, matrices.0, first));
            run(plays.1, matrices.1, second);
        });
    }

    fn chunk(
        &self,
        plays: &mut [[Play; 2]],
        matrices: &mut [JointMatrix],
        (goals, clips): (&[Option<Goal>; 2], usize),
        work: &mut Workspace,
        until: Until,
    ) {
        for play in plays.as_flattened_mut() {
            let (time, duration) = (play.time + 1.0 / 60.0, self.durations[play.clip]);
            play.time = if time < duration { time } else { time - duration };
        }
        let mut layers = [[Layer::default()]; CHUNK];
        for (layer, plays) in layers.iter_mut().zip(plays.iter()) {
            layer[0] = Layer { weight: 1.0, clips: &plays[..clips], ..Layer::default() };
        }
        let mut actors = [Actor::default(); CHUNK];
        for (index, (actor, layers)) in actors.iter_mut().zip(&layers).enumerate() {
            *actor = Actor { layers, goals, palette: index * self.species.slot_count() };
        }
        pose_until(&self.species, &actors[..plays.len()], work, matrices, until);
    }
}

/// Characters that a task takes at once.
const CHUNK: usize = 64;
