//! The same sampling for one character at a time, to local transforms: for those whose poses are worked on joint by joint.
//!
//! Rows are those of [blocks](super), but between no frames: rotations are in their parents' spaces.

use bevy::math::{Quat, Vec3};
use fearless_simd::{Simd, dispatch};

use super::{
    Instructions, Layer, Play, Precision,
    aligned::Rows32,
    channels::{Channels, rotation_place},
    frames::Frames,
    lanes::{LANES, Row, load, store},
    rows::{RowData, RowSource, Rows},
    sample::{Plan, sample},
    species::Tracks,
    transpose::transpose_halves,
};
use crate::anim::{
    clip::Clip,
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// Clips of one skeleton, ready to be sampled and blended in one pass.
#[derive(Clone, Debug, Default)]
pub struct ClipSet {
    tracks: Tracks,
    /// Whether a clip's rows tell all of it.
    whole: Vec<bool>,
    rest: Vec<JointTransform>,
    watched: Vec<Watched>,
}

/// A joint that is asked for by itself, and where its rotation, translation and scale are among a row's numbers.
#[derive(Clone, Debug)]
struct Watched {
    joint: JointIndex,
    rotation: Option<usize>,
    translation: Option<usize>,
    scale: Option<usize>,
}

/// Memory of one thread for [`ClipSet::sample`].
#[derive(Clone, Debug, Default)]
pub struct LocalWorkspace {
    instructions: Instructions,
    plan: Plan,
    layer: Rows32,
    row: Rows32,
}

impl LocalWorkspace {
    /// For `instructions`; [`LocalWorkspace::default`] takes the best.
    #[must_use]
    pub fn with(instructions: Instructions) -> Self {
        Self { instructions, ..Self::default() }
    }
}

impl ClipSet {
    /// Makes rows of `clips`, all for `skeleton`; `watched` are the joints of [`ClipSet::sample_watched`].
    #[must_use]
    pub fn new<'a>(
        skeleton: &Skeleton,
        clips: impl IntoIterator<Item = &'a Clip>,
        watched: impl IntoIterator<Item = JointIndex>,
    ) -> Self {
        let sources: Vec<_> = clips.into_iter().map(|clip| RowSource::new(clip, Precision::Float)).collect();
        let frames = Frames::none(skeleton);
        let channels = Channels::new(skeleton, &frames, &sources);
        let start = channels.translation_start() * LANES;
        let watched = watched.into_iter().map(|joint| Watched {
            joint,
            rotation: channels.rotation_place(joint).map(|slot| rotation_place(slot, 0)),
            translation: channels.translation_place(joint).map(|place| start + place),
            scale: channels.scale_place(joint).map(|place| start + place),
        });
        let watched = watched.collect();
        let rows = sources.iter().map(|source| Rows::new(skeleton, &frames, &channels, source)).collect();
        Self {
            tracks: Tracks { channels, clips: rows, masks: Vec::new() },
            whole: sources.iter().map(|source| !source.clip.is_keyed() && source.clip.frame_count() > 0).collect(),
            rest: skeleton.rest().to_vec(),
            watched,
        }
    }

    /// Writes the watched joints of one clip alone, each where it is among all joints; the rest of `out` stays.
    ///
    /// Gives false where [`ClipSet::sample`] does.
    #[must_use]
    pub fn sample_watched(&self, clip: usize, time: f32, out: &mut [JointTransform]) -> bool {
        let rows = self.tracks.clips.get(clip).filter(|_| self.whole[clip] && out.len() == self.rest.len());
        let Some((rows, RowData::Float(data))) = rows.map(|rows| (rows, &rows.data)) else { return false };
        let (first, second, blend) = rows.span(time);
        let [from, to] = [first, second].map(|frame| data.frame(frame).as_flattened());
        let between = |place: usize| from[place] + (to[place] - from[place]) * blend;
        let vector =
            |place: usize, step: usize| Vec3::new(between(place), between(place + step), between(place + 2 * step));
        let channels = &self.tracks.channels;
        for &Watched { joint, rotation, translation, scale } in &self.watched {
            let out = &mut out[joint.index()];
            *out = self.rest[joint.index()];
            if let Some(place) = rotation {
                let [x, y, z] = [between(place), between(place + LANES), between(place + 2 * LANES)];
                out.rotation = Quat::from_xyzw(x, y, z, between(place + 3 * LANES)).normalize();
            }
            if let Some(place) = translation {
                out.translation = vector(place, channels.translations.len());
            }
            if let Some(place) = scale {
                out.scale = vector(place, channels.scales.len());
            }
        }
        true
    }

    /// Writes every joint of a blend of clips, each joint in its parent's space; `out` has one entry a joint.
    ///
    /// Gives false and leaves `out` alone where a clip isn't of the set or [keeps keys](Clip::is_keyed) beside its frames, and
    /// where nothing weighs anything.
    #[must_use]
    pub fn sample(&self, plays: &[Play], work: &mut LocalWorkspace, out: &mut [JointTransform]) -> bool {
        let known = |play: &Play| self.whole.get(play.clip).is_some_and(|whole| *whole);
        let heard = plays.iter().any(|play| play.weight > 0.0);
        if !heard || out.len() != self.rest.len() || !plays.iter().all(known) {
            return false;
        }
        let layers = [Layer { weight: 1.0, clips: plays, ..Layer::default() }];
        work.plan.make(&self.tracks, &layers);
        let width = self.tracks.channels.width();
        work.layer.grow(width);
        work.row.grow(width);
        let LocalWorkspace { instructions, plan, layer, row } = work;
        dispatch!(instructions.0, simd => self.run(simd, plan, (&mut layer[..width], &mut row[..width]), out));
        true
    }

    #[inline(always)]
    fn run<S: Simd>(&self, simd: S, plan: &Plan, (layer, row): (&mut [Row], &mut [Row]), out: &mut [JointTransform]) {
        sample::<S, true>(simd, &self.tracks, plan, layer, row);
        out.copy_from_slice(&self.rest);
        let channels = &self.tracks.channels;
        for (tile, joints) in row.as_chunks::<4>().0.iter().zip(channels.rotations.chunks(LANES)) {
            let columns = transpose_halves(simd, tile.map(|part| load(simd, &part)));
            for (lane, joint) in joints.iter().enumerate() {
                let mut pair = [0.0; LANES];
                store(columns[lane % 4], &mut pair);
                out[joint.index()].rotation = Quat::from_slice(&pair[lane / 4 * 4..]);
            }
        }
        for (kind, (start, joints)) in channels.vector_runs().into_iter().enumerate() {
            let numbers = &row.as_flattened()[start..];
            for (slot, joint) in joints.iter().enumerate() {
                let value = Vec3::from_array([0, 1, 2].map(|part| numbers[part * joints.len() + slot]));
                let out = &mut out[joint.index()];
                *(if kind == 0 { &mut out.translation } else { &mut out.scale }) = value;
            }
        }
    }
}
