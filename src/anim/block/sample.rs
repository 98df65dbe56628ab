//! Samples and blends one character's clips and lays its layers over each other: lanes = joints.
//!
//! Reads rows of clips, writes one row: rotations, translations and scales between frames. In-between values stay in
//! registers, whatever the number of clips and layers.

use fearless_simd::{Simd, prelude::*};

use super::{
    Layer, LayerMode, Play,
    lanes::{Floats, LANES, Quats, Row, inverse_length_between_units, load, load_shorts, select, splat, store},
    rows::{FloatRows, RowData, Rows, ShortRows},
    species::Tracks,
    transpose::{halves, transpose_halves},
};

/// What to sample for one character, in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Plan {
    spans: Vec<Span>,
    passes: Vec<Pass>,
}

/// A clip between two of its frames.
#[derive(Clone, Copy, Debug)]
struct Span {
    clip: usize,
    first: usize,
    second: usize,
    /// 0 at `first`, 1 at `second`.
    blend: f32,
    /// All weights of a layer sum to one.
    weight: f32,
}

/// A layer with something to do.
#[derive(Clone, Copy, Debug)]
struct Pass {
    mode: LayerMode,
    weight: f32,
    mask: Option<usize>,
    /// Its spans.
    first: usize,
    end: usize,
}

impl Pass {
    /// Whether nothing of the layers below is left.
    fn hides(&self) -> bool {
        self.mode == LayerMode::Override && self.weight >= 1.0 && self.mask.is_none()
    }
}

impl Plan {
    #[inline(always)]
    pub(super) fn make(&mut self, tracks: &Tracks, layers: &[Layer]) {
        self.spans.clear();
        self.passes.clear();
        for layer in layers {
            let heard = |play: &&Play| play.weight > 0.0 && play.clip < tracks.clips.len();
            let total: f32 = layer.clips.iter().filter(heard).map(|play| play.weight).sum();
            if total <= 0.0 || layer.weight.is_nan() || layer.weight <= 0.0 {
                continue;
            }
            let first = self.spans.len();
            for play in layer.clips.iter().filter(heard) {
                let rows = &tracks.clips[play.clip];
                if rows.count > 0 {
                    let (first, second, blend) = rows.span(play.time);
                    self.spans.push(Span { clip: play.clip, first, second, blend, weight: play.weight / total });
                }
            }
            let mask = layer.mask.filter(|mask| *mask < tracks.masks.len());
            if first < self.spans.len() {
                let weight = layer.weight.min(1.0);
                self.passes.push(Pass { mode: layer.mode, weight, mask, first, end: self.spans.len() });
            }
        }
    }
}

impl Rows {
    /// The frames around `time` seconds and the way between them; as [`Clip::span`](crate::anim::clip::Clip::span).
    #[inline(always)]
    pub(super) fn span(&self, time: f32) -> (usize, usize, f32) {
        let inside = (0.0..=self.duration).contains(&time);
        let time = match () {
            () if inside => time,
            () if !time.is_finite() || self.duration <= 0.0 => 0.0,
            () if self.looping => time.rem_euclid(self.duration).min(self.duration),
            () => time.clamp(0.0, self.duration),
        };
        let (last, position) = (self.count - 1, time * self.rate);
        let first = (position as usize).min(last);
        (first, (first + 1).min(last), (position - first as f32).clamp(0.0, 1.0))
    }
}

/// Writes the row of one character. `layer` is scratch memory. `UNIT`: rotations are made one long.
#[inline(always)]
pub(super) fn sample<S: Simd, const UNIT: bool>(
    simd: S,
    tracks: &Tracks,
    plan: &Plan,
    layer: &mut [Row],
    out: &mut [Row],
) {
    if !plan.passes.first().is_some_and(Pass::hides) {
        out.copy_from_slice(&tracks.channels.rest);
    }
    for (index, pass) in plan.passes.iter().enumerate() {
        // What comes on top wants them so, too.
        let unit = UNIT || index + 1 < plan.passes.len();
        if pass.hides() && cross_fade(simd, tracks, &plan.spans[pass.first..pass.end], unit, out) {
            continue;
        }
        for (index, span) in plan.spans[pass.first..pass.end].iter().enumerate() {
            let tiles = tracks.channels.tiles();
            match &tracks.clips[span.clip].data {
                RowData::Float(rows) => {
                    let frame = |frame| FloatFrame::of(rows, frame, tiles);
                    add_or_begin(simd, index == 0, [frame(span.first), frame(span.second)], span, tiles, layer);
                }
                RowData::Short(rows) if rows.parts == 3 => {
                    let frame = |frame| ShortFrame::<3>::of(rows, frame, tiles);
                    add_or_begin(simd, index == 0, [frame(span.first), frame(span.second)], span, tiles, layer);
                }
                RowData::Short(rows) => {
                    let frame = |frame| ShortFrame::<4>::of(rows, frame, tiles);
                    add_or_begin(simd, index == 0, [frame(span.first), frame(span.second)], span, tiles, layer);
                }
            }
        }
        lay(simd, tracks, pass, unit, layer, out);
    }
}

/// The common case in one go: two clips in floats and nothing below. Whether it was one.
#[inline(always)]
fn cross_fade<S: Simd>(simd: S, tracks: &Tracks, spans: &[Span], unit: bool, out: &mut [Row]) -> bool {
    let [a, b] = spans else { return false };
    let (RowData::Float(rows_a), RowData::Float(rows_b)) = (&tracks.clips[a.clip].data, &tracks.clips[b.clip].data)
    else {
        return false;
    };
    let tiles = tracks.channels.tiles();
    let (from_a, to_a) = (FloatFrame::of(rows_a, a.first, tiles), FloatFrame::of(rows_a, a.second, tiles));
    let (from_b, to_b) = (FloatFrame::of(rows_b, b.first, tiles), FloatFrame::of(rows_b, b.second, tiles));
    let (blend_a, blend_b) = (splat(simd, a.blend), splat(simd, b.blend));
    let (weight_a, weight_b) = (splat(simd, a.weight), splat(simd, b.weight));
    let (turns, numbers) = out.split_at_mut(4 * tiles);
    for (tile, out) in turns.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let a = from_a.rotations(simd, tile).toward(to_a.rotations(simd, tile), blend_a);
        let b = from_b.rotations(simd, tile).toward(to_b.rotations(simd, tile), blend_b);
        let share_a = inverse_length_between_units(simd, a.dot(a)) * weight_a;
        let share_b = (inverse_length_between_units(simd, b.dot(b)) * weight_b).copysign(a.dot(b));
        let sum = a.times(share_a).plus_times(b, share_b);
        (if unit { sum.normalized_or_identity(simd) } else { sum }).store(out);
    }
    for (vector, out) in numbers.iter_mut().enumerate() {
        let (a, b) = (from_a.numbers(simd, vector), from_b.numbers(simd, vector));
        let a = (to_a.numbers(simd, vector) - a).mul_add(blend_a, a);
        let b = (to_b.numbers(simd, vector) - b).mul_add(blend_b, b);
        store(b.mul_add(weight_b, a * weight_a), out);
    }
    true
}

/// A frame of a clip, however it is stored.
trait Frame: Copy {
    /// Eight rotations.
    fn rotations<S: Simd>(self, simd: S, tile: usize) -> Quats<S>;

    /// Eight numbers of translations and scales.
    fn numbers<S: Simd>(self, simd: S, vector: usize) -> Floats<S>;
}

#[derive(Clone, Copy)]
struct FloatFrame<'a> {
    tiles: &'a [[Row; 4]],
    numbers: &'a [Row],
}

impl<'a> FloatFrame<'a> {
    fn of(rows: &'a FloatRows, frame: usize, tiles: usize) -> Self {
        let (turns, numbers) = rows.frame(frame).split_at(4 * tiles);
        Self { tiles: turns.as_chunks().0, numbers }
    }
}

impl Frame for FloatFrame<'_> {
    #[inline(always)]
    fn rotations<S: Simd>(self, simd: S, tile: usize) -> Quats<S> {
        Quats::load(simd, &self.tiles[tile])
    }

    #[inline(always)]
    fn numbers<S: Simd>(self, simd: S, vector: usize) -> Floats<S> {
        load(simd, &self.numbers[vector])
    }
}

/// Values, their factors and their offsets.
#[derive(Clone, Copy)]
struct ShortFrame<'a, const PARTS: usize> {
    tiles: (&'a [[[i16; LANES]; PARTS]], &'a [[Row; PARTS]], &'a [[Row; PARTS]]),
    numbers: (&'a [[i16; LANES]], &'a [Row], &'a [Row]),
}

impl<'a, const PARTS: usize> ShortFrame<'a, PARTS> {
    fn of(rows: &'a ShortRows, frame: usize, tiles: usize) -> Self {
        let (turns, numbers) = rows.frame(frame).split_at(PARTS * tiles);
        let (turn_factors, number_factors) = rows.factors.split_at(PARTS * tiles);
        let (turn_offsets, number_offsets) = rows.offsets.split_at(PARTS * tiles);
        Self {
            tiles: (turns.as_chunks().0, turn_factors.as_chunks().0, turn_offsets.as_chunks().0),
            numbers: (numbers, number_factors, number_offsets),
        }
    }
}

impl<const PARTS: usize> Frame for ShortFrame<'_, PARTS> {
    #[inline(always)]
    fn rotations<S: Simd>(self, simd: S, tile: usize) -> Quats<S> {
        let (values, factors, offsets) = (&self.tiles.0[tile], &self.tiles.1[tile], &self.tiles.2[tile]);
        let x = float(simd, &values[0], &factors[0], &offsets[0]);
        let y = float(simd, &values[1], &factors[1], &offsets[1]);
        let z = float(simd, &values[2], &factors[2], &offsets[2]);
        if PARTS == 4 {
            return Quats::new(x, y, z, float(simd, &values[PARTS - 1], &factors[PARTS - 1], &offsets[PARTS - 1]));
        }
        let squared = x.mul_add(x, y.mul_add(y, z * z));
        Quats::new(x, y, z, (splat(simd, 1.0) - squared).max(0.0).sqrt())
    }

    #[inline(always)]
    fn numbers<S: Simd>(self, simd: S, vector: usize) -> Floats<S> {
        float(simd, &self.numbers.0[vector], &self.numbers.1[vector], &self.numbers.2[vector])
    }
}

#[inline(always)]
fn float<S: Simd>(simd: S, value: &[i16; LANES], factor: &Row, offset: &Row) -> Floats<S> {
    load_shorts(simd, value).mul_add(load(simd, factor), load(simd, offset))
}

#[inline(always)]
fn add_or_begin<S: Simd, F: Frame>(simd: S, begin: bool, frames: [F; 2], span: &Span, tiles: usize, layer: &mut [Row]) {
    if begin {
        add::<S, F, true>(simd, frames, span, tiles, layer);
    } else {
        add::<S, F, false>(simd, frames, span, tiles, layer);
    }
}

/// Adds a clip to the sum of its layer, or begins the sum with it. Rotations are summed on the side of the first.
#[inline(always)]
fn add<S: Simd, F: Frame, const FIRST: bool>(simd: S, frames: [F; 2], span: &Span, tiles: usize, layer: &mut [Row]) {
    let ([from, to], blend, weight) = (frames, splat(simd, span.blend), splat(simd, span.weight));
    let (rotations, numbers) = layer.split_at_mut(4 * tiles);
    for (tile, sum) in rotations.as_chunks_mut::<4>().0.iter_mut().enumerate() {
        let rotation = from.rotations(simd, tile).toward(to.rotations(simd, tile), blend);
        let share = inverse_length_between_units(simd, rotation.dot(rotation)) * weight;
        if FIRST {
            rotation.times(share).store(sum);
        } else {
            let others = Quats::load(simd, sum);
            others.plus_times(rotation, share.copysign(others.dot(rotation))).store(sum);
        }
    }
    for (vector, sum) in numbers.iter_mut().enumerate() {
        let start = from.numbers(simd, vector);
        let number = (to.numbers(simd, vector) - start).mul_add(blend, start) * weight;
        store(if FIRST { number } else { load(simd, sum) + number }, sum);
    }
}

/// Lays a layer's sum on the pose below.
#[inline(always)]
fn lay<S: Simd>(simd: S, tracks: &Tracks, pass: &Pass, unit: bool, layer: &[Row], out: &mut [Row]) {
    let (tiles, scales) = (tracks.channels.tiles(), tracks.channels.scale_start());
    let (layer_turns, layer_numbers) = layer.split_at(4 * tiles);
    let (turns, numbers) = out.split_at_mut(4 * tiles);
    let mask = pass.mask.map(|mask| tracks.masks[mask].split_at(tiles));
    let (one, weight) = (splat(simd, 1.0), splat(simd, pass.weight));
    for (tile, (pose, layer)) in turns.as_chunks_mut::<4>().0.iter_mut().zip(layer_turns.as_chunks::<4>().0).enumerate()
    {
        let sum = Quats::load(simd, layer);
        let layer = if unit || !pass.hides() { sum.normalized_or_identity(simd) } else { sum };
        let share = match mask {
            Some((mask, _)) => load(simd, &mask[tile]) * weight,
            None => weight,
        };
        let turned = match pass.mode {
            LayerMode::Override if pass.hides() => layer,
            LayerMode::Override => near(simd, Quats::load(simd, pose), layer, share),
            LayerMode::Add => {
                let turn = near(simd, Quats::identity(simd), layer, share);
                Quats::load(simd, pose).after(turn).normalized_or_identity(simd)
            }
        };
        turned.store(pose);
    }
    for (vector, (pose, layer)) in numbers.iter_mut().zip(layer_numbers).enumerate() {
        let layer = load(simd, layer);
        if pass.hides() {
            store(layer, pose);
            continue;
        }
        let share = match mask {
            Some((_, mask)) => load(simd, &mask[vector]) * weight,
            None => weight,
        };
        let below = load(simd, pose);
        let moved = match pass.mode {
            LayerMode::Override => (layer - below).mul_add(share, below),
            LayerMode::Add if vector + 4 * tiles >= scales => below * (layer - 1.0).mul_add(share, one),
            LayerMode::Add => layer.mul_add(share, below),
        };
        store(moved, pose);
    }
}

/// `from` turned toward `to` by `share`, the short way.
#[inline(always)]
fn near<S: Simd>(simd: S, from: Quats<S>, to: Quats<S>, share: Floats<S>) -> Quats<S> {
    let opposite = from.dot(to).simd_lt(splat(simd, 0.0));
    let side = select::<S>(opposite, -share, share);
    from.times(splat(simd, 1.0) - share).plus_times(to, side).normalized_or_identity(simd)
}

/// Eight rotations of eight characters, whose rows are each `width` long, become lanes: lanes = characters.
#[inline(always)]
pub(super) fn transpose_turns<S: Simd>(
    simd: S,
    poses: &[Row],
    width: usize,
    tile: usize,
    turns: &mut [[Row; 4]; LANES],
) {
    for (part, vector) in (4 * tile..4 * tile + 4).enumerate() {
        for half in 0..2 {
            let columns = columns(simd, poses, width, vector, half);
            for (slot, column) in columns.into_iter().enumerate() {
                store(column, &mut turns[4 * half + slot][part]);
            }
        }
    }
}

/// The same for all translations and scales.
#[inline(always)]
pub(super) fn transpose_numbers<S: Simd>(simd: S, tracks: &Tracks, poses: &[Row], numbers: &mut [Row]) {
    let (first, width) = (tracks.channels.translation_start(), tracks.channels.width());
    for (vector, numbers) in (first..width).zip(numbers.as_chunks_mut::<LANES>().0) {
        for half in 0..2 {
            let columns = columns(simd, poses, width, vector, half);
            for (place, column) in columns.into_iter().enumerate() {
                store(column, &mut numbers[4 * half + place]);
            }
        }
    }
}

/// Half of a vector of eight characters, one column a number.
#[inline(always)]
fn columns<S: Simd>(simd: S, poses: &[Row], width: usize, vector: usize, half: usize) -> [Floats<S>; 4] {
    let row = |row: usize| halves(simd, &poses[row * width + vector], &poses[(row + 4) * width + vector], half);
    transpose_halves(simd, [row(0), row(1), row(2), row(3)])
}
