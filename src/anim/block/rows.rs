//! Clips as rows for the kernels: one row a frame, in it one run of joints for each component, so that lanes are joints.
//!
//! ```text
//! A frame:  x8 y8 z8 w8 | x8 y8 z8 w8 | … | 8 8 8… | 8 8 8…
//!           └ rotations of 8 joints       │        └ scales: x of all joints, then y, then z
//!             and of the next 8 …         └ translations, likewise
//! ```
//! All in vectors of 8 numbers. Rotations are those between [frames](super::frames); only joints that any clip of the
//! species moves are there. In 16 bits each number has a factor and an offset of its own, and w is left out where it
//! follows from x, y and z.

use bevy::math::{Quat, Vec3};

use super::{
    aligned::Rows32,
    channels::{Channels, Moment, rotation_place},
    frames::Frames,
    lanes::{LANES, Row},
};
use crate::anim::{
    blend::difference,
    clip::Clip,
    pose::Pose,
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// Least real part at which a rotation's other parts give it exactly enough.
const LEAST_REAL: f32 = 0.25;
/// How far out from a joint the error of a row is measured, metres.
const LEVER: f32 = 0.03;

/// How a clip's rows are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// As they are: fastest.
    #[default]
    Float,
    /// 16 bits a number: less than half the memory, a third more time to sample.
    Short,
}

/// A clip to be made into rows.
#[derive(Clone, Copy, Debug)]
pub struct RowSource<'a> {
    /// The clip.
    pub clip: &'a Clip,
    /// For additive layers: the pose that its motion is the [difference] from, one transform a joint.
    pub difference_from: Option<&'a [JointTransform]>,
    /// How exact.
    pub precision: Precision,
    /// Joints that stay at rest whatever the clip does.
    pub still: &'a [JointIndex],
}

impl<'a> RowSource<'a> {
    /// A clip to be played as it is.
    #[must_use]
    pub fn new(clip: &'a Clip, precision: Precision) -> Self {
        Self { clip, difference_from: None, precision, still: &[] }
    }
}

/// What making rows of a clip came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowsReport {
    /// Bytes of its rows and constants.
    pub bytes: usize,
    /// Largest distance in model space between a point 3 cm from a joint and where its frames in floats have it, metres.
    pub max_error: f32,
}

/// A clip's rows.
#[derive(Clone, Debug)]
pub struct Rows {
    /// Seconds; 0 is a single pose.
    pub(super) duration: f32,
    pub(super) looping: bool,
    /// Frames per second.
    pub(super) rate: f32,
    pub(super) count: usize,
    pub(super) data: RowData,
    report: RowsReport,
}

#[derive(Clone, Debug)]
pub(super) enum RowData {
    Float(FloatRows),
    Short(ShortRows),
}

/// Rows as they are.
#[derive(Clone, Debug)]
pub(super) struct FloatRows {
    pub(super) values: Rows32,
    /// Vectors from frame to frame.
    pub(super) width: usize,
}

impl FloatRows {
    pub(super) fn frame(&self, frame: usize) -> &[Row] {
        &self.values[frame * self.width..][..self.width]
    }
}

/// Rows of 16 bits.
#[derive(Clone, Debug)]
pub(super) struct ShortRows {
    pub(super) values: Vec<[i16; LANES]>,
    pub(super) factors: Rows32,
    pub(super) offsets: Rows32,
    /// Vectors of eight rotations: 3, or 4 where w is stored too.
    pub(super) parts: usize,
    /// Vectors from frame to frame.
    pub(super) width: usize,
}

impl ShortRows {
    pub(super) fn frame(&self, frame: usize) -> &[[i16; LANES]] {
        &self.values[frame * self.width..][..self.width]
    }
}

impl RowSource<'_> {
    /// Every joint of a frame in its parent's space, or its difference from the reference pose.
    pub(super) fn sample(&self, skeleton: &Skeleton, frame: usize, out: &mut [JointTransform]) {
        self.clip.sample_frame(skeleton, frame, out);
        for (joint, from) in out.iter_mut().zip(self.difference_from.unwrap_or_default()) {
            *joint = difference(*from, *joint);
        }
        for joint in self.still {
            let rest = skeleton.rest()[joint.index()];
            out[joint.index()] = if self.difference_from.is_some() { JointTransform::IDENTITY } else { rest };
        }
    }
}

impl Rows {
    pub(super) fn new(skeleton: &Skeleton, frames: &Frames, channels: &Channels, source: &RowSource) -> Self {
        let clip = source.clip;
        let mut pose = skeleton.rest().to_vec();
        let mut floats: Vec<Vec<Row>> = Vec::with_capacity(clip.frame_count());
        for frame in 0..clip.frame_count() {
            source.sample(skeleton, frame, &mut pose);
            let is_difference = source.difference_from.is_some();
            let moment = |joint: JointIndex| Moment::new(frames, joint, pose[joint.index()], is_difference);
            let mut row = channels.row(moment);
            keep_side(channels, floats.last(), &mut row);
            floats.push(row);
        }
        let exact = Self {
            duration: clip.duration.max(0.0),
            looping: clip.looping,
            rate: clip.frame_rate(),
            count: floats.len(),
            data: RowData::Float(FloatRows {
                values: floats.iter().flatten().copied().collect(),
                width: channels.width(),
            }),
            report: RowsReport { bytes: floats.len() * channels.width() * size_of::<Row>(), max_error: 0.0 },
        };
        if source.precision == Precision::Float || exact.count == 0 {
            return exact;
        }
        let shorts = ShortRows::new(channels, &floats);
        let mut rows = Self { data: RowData::Short(shorts), ..exact.clone() };
        rows.report = rows.check(skeleton, frames, channels, &exact);
        rows
    }

    /// What making them came to.
    #[must_use]
    pub fn report(&self) -> RowsReport {
        self.report
    }

    /// Writes every joint of a frame in its parent's space.
    pub(super) fn frame(
        &self,
        skeleton: &Skeleton,
        frames: &Frames,
        channels: &Channels,
        frame: usize,
        out: &mut [JointTransform],
    ) {
        out.copy_from_slice(skeleton.rest());
        let row = self.data.row(channels, frame);
        let row = row.as_flattened();
        for (slot, joint) in channels.rotations.iter().enumerate() {
            let rotation = Quat::from_array([0, 1, 2, 3].map(|part| row[rotation_place(slot, part)]));
            out[joint.index()].rotation = frames.local_rotation(*joint, rotation).normalize();
        }
        for (kind, (start, joints)) in channels.vector_runs().into_iter().enumerate() {
            for (slot, joint) in joints.iter().enumerate() {
                let value = Vec3::from_array([0, 1, 2].map(|part| row[start + part * joints.len() + slot]));
                let out = &mut out[joint.index()];
                if kind == 0 {
                    out.translation = frames.local_translation(*joint, value);
                } else {
                    out.scale = value;
                }
            }
        }
    }

    fn check(&self, skeleton: &Skeleton, frames: &Frames, channels: &Channels, exact: &Self) -> RowsReport {
        let (mut own, mut other) = (Pose::rest(skeleton), Pose::rest(skeleton));
        let mut max_error: f32 = 0.0;
        for frame in 0..self.count {
            for (rows, pose) in [(self, &mut own), (exact, &mut other)] {
                rows.frame(skeleton, frames, channels, frame, pose.locals_mut());
                pose.update_model(skeleton);
            }
            for (a, b) in own.models().iter().zip(other.models()) {
                let [a, b] = [a, b].map(|matrix| matrix.to_affine());
                for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                    // The joint may be in centimetres; 3 cm are meant in the model.
                    let out = |m: &bevy::math::Affine3A| {
                        m.translation + m.transform_vector3a(axis.into()).normalize_or_zero() * LEVER
                    };
                    max_error = max_error.max(out(&a).distance(out(&b)));
                }
            }
        }
        RowsReport { bytes: self.data.bytes(), max_error }
    }
}

impl RowData {
    fn bytes(&self) -> usize {
        match self {
            Self::Float(rows) => size_of_val(&*rows.values),
            Self::Short(rows) => {
                size_of_val(rows.values.as_slice()) + size_of_val(&*rows.factors) + size_of_val(&*rows.offsets)
            }
        }
    }

    /// A frame's row as floats.
    fn row(&self, channels: &Channels, frame: usize) -> Vec<Row> {
        let rows = match self {
            Self::Float(rows) => return rows.frame(frame).to_vec(),
            Self::Short(rows) => rows,
        };
        let mut row = vec![[0.0; LANES]; channels.width()];
        for (index, vector) in channels.stored(rows.parts).enumerate() {
            for (lane, value) in rows.frame(frame)[index].iter().enumerate() {
                row[vector][lane] = f32::from(*value).mul_add(rows.factors[index][lane], rows.offsets[index][lane]);
            }
        }
        for tile in row.chunks_exact_mut(4).take(if rows.parts == 3 { channels.tiles() } else { 0 }) {
            for lane in 0..LANES {
                let squared = tile[..3].iter().map(|part| part[lane] * part[lane]).sum::<f32>();
                tile[3][lane] = (1.0 - squared).max(0.0).sqrt();
            }
        }
        row
    }
}

impl ShortRows {
    fn new(channels: &Channels, rows: &[Vec<Row>]) -> Self {
        let mut rows = rows.to_vec();
        let parts = if make_real_positive(channels, &mut rows) { 3 } else { 4 };
        let stored: Vec<_> = channels.stored(parts).collect();
        let (mut factors, mut offsets) = (Vec::new(), Vec::new());
        for vector in &stored {
            let least = |lane: usize| rows.iter().map(|row| row[*vector][lane]).fold(f32::INFINITY, f32::min);
            let most = |lane: usize| rows.iter().map(|row| row[*vector][lane]).fold(f32::NEG_INFINITY, f32::max);
            let lanes: [usize; LANES] = core::array::from_fn(|lane| lane);
            offsets.push(lanes.map(|lane| (least(lane) + most(lane)) * 0.5));
            factors.push(lanes.map(|lane| (most(lane) - least(lane)).max(1e-30) * 0.5 / f32::from(i16::MAX)));
        }
        let mut values = Vec::with_capacity(rows.len() * stored.len());
        for row in &rows {
            for ((vector, factor), offset) in stored.iter().zip(&factors).zip(&offsets) {
                values.push(core::array::from_fn(|lane| steps((row[*vector][lane] - offset[lane]) / factor[lane])));
            }
        }
        let (factors, offsets) = (factors.into_iter().collect(), offsets.into_iter().collect());
        Self { values, factors, offsets, parts, width: stored.len() }
    }
}

#[expect(clippy::cast_possible_truncation, reason = "clamped")]
fn steps(value: f32) -> i16 {
    value.round().clamp(f32::from(-i16::MAX), f32::from(i16::MAX)) as i16
}

/// Flips rotations of `row` so that they lie on the side of the row before.
fn keep_side(channels: &Channels, before: Option<&Vec<Row>>, row: &mut [Row]) {
    let Some(before) = before else { return };
    let (before, row) = (before.as_flattened(), row.as_flattened_mut());
    for slot in 0..channels.rotations.len() {
        let places = [0, 1, 2, 3].map(|part| rotation_place(slot, part));
        if places.iter().map(|place| before[*place] * row[*place]).sum::<f32>() < 0.0 {
            places.iter().for_each(|place| row[*place] = -row[*place]);
        }
    }
}

/// Flips whole tracks of rotations so that all real parts are positive; whether that is possible, and exact enough.
fn make_real_positive(channels: &Channels, rows: &mut [Vec<Row>]) -> bool {
    for slot in 0..channels.rotations.len() {
        let real = rotation_place(slot, 3);
        let side = if rows[0].as_flattened()[real] < 0.0 { -1.0 } else { 1.0 };
        if rows.iter().any(|row| row.as_flattened()[real] * side < LEAST_REAL) {
            return false;
        }
        for row in rows.iter_mut() {
            (0..4).for_each(|part| row.as_flattened_mut()[rotation_place(slot, part)] *= side);
        }
    }
    true
}
