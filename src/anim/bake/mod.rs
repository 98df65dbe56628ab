//! Exact curves → [`Clip`]: uniform frames at the lowest rate that is true enough, constant channels taken out.

mod keyed;
mod rebuild;

use bevy::math::{Quat, Vec3, Vec3A};

pub use super::keys::{JointCurves, MorphCurves};
use super::{
    clip::{Clip, ClipReport, Frames},
    curve::Interpolation,
    pose::Pose,
    skeleton::{JointTransform, Skeleton},
};

/// Metres a joint may be off the exact curves before a higher frame rate is taken, or its keys are kept.
const TOLERANCE: f32 = 1e-4;
/// The same as a share of the skeleton's size, for those smaller than people.
const TOLERANCE_OF_SIZE: f32 = 5e-5;
/// Frame rates to try, lowest first, in Hz.
const RATES: [f32; 2] = [30.0, 60.0];
/// A file's own key rate and frames between its keys are taken up to this, Hz.
const MAX_RATE: f32 = 125.0;
/// Frames from key to key at most.
const BETWEEN_KEYS: [f32; 3] = [1.0, 2.0, 4.0];
/// Times the bound on single channels is halved twice before all of them are keyed.
const TRIES: usize = 6;
/// Frames of one clip; above it the rate goes down. An hour at 30 Hz.
const MAX_FRAMES: f32 = 108_000.0;
/// Times at which a clip is compared with its curves at most: beyond 80 s or so not all between its frames are.
const MAX_CHECKS: usize = 20_000;
/// First and last pose closer than this fraction of the skeleton's size make a loop.
const SEAM: f32 = 0.01;
/// How far out from a joint turns are measured, as a fraction of the skeleton's size.
const LEVER: f32 = 0.1;
/// Changes below this are rounding: a channel that moves less is constant.
const STILL: f32 = 1e-6;

/// A clip's curves as the file has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipCurves {
    /// Its name in the file.
    pub name: String,
    /// Whether it loops, where the file says so; else it does when its last pose is its first.
    pub looping: Option<bool>,
    /// Speed over ground in m/s at which its feet don't slide, where the file says so.
    pub ground_speed: Option<f32>,
    /// Joints with keys, each at most once.
    pub joints: Vec<JointCurves>,
    /// Morph weights with keys.
    pub morphs: Vec<MorphCurves>,
}

impl ClipCurves {
    /// Seconds from 0 to the last key.
    #[must_use]
    pub fn duration(&self) -> f32 {
        self.key_times().map(|(times, _)| times.last().copied().unwrap_or(0.0)).fold(0.0, f32::max)
    }

    /// Writes every joint at `time` seconds, exactly; joints without keys are at rest.
    pub fn sample(&self, skeleton: &Skeleton, time: f32, out: &mut [JointTransform]) {
        out.copy_from_slice(skeleton.rest());
        for curves in &self.joints {
            curves.sample(time, &mut out[curves.joint.index()]);
        }
    }

    /// Resamples to the lowest of 30 Hz, 60 Hz, the file's own rate and multiples of it that keeps every joint within
    /// 0.1 mm of the exact curves, else to the truest of them; what is still off then keeps its keys beside the frames,
    /// as steps always do. It loops when its last pose is its first.
    #[must_use]
    pub fn bake(&self, skeleton: &Skeleton) -> Clip {
        let tolerance = TOLERANCE.min(TOLERANCE_OF_SIZE * size(skeleton));
        let own = self.own_rate().into_iter().flat_map(|rate| BETWEEN_KEYS.map(|frames| rate * frames));
        let mut best: Option<Clip> = None;
        for rate in RATES.into_iter().chain(own.filter(|rate| *rate <= MAX_RATE)) {
            let clip = self.bake_at(skeleton, rate);
            let good = clip.report.max_error <= tolerance;
            if best.as_ref().is_none_or(|best| clip.report.max_error < best.report.max_error) {
                best = Some(clip);
            }
            // More frames than that there aren't, whatever the rate.
            if good || self.duration() * rate > MAX_FRAMES {
                break;
            }
        }
        let mut clip = best.unwrap_or_default();
        let mut bound = tolerance;
        for _ in 0..TRIES {
            if clip.report.max_error <= tolerance {
                break;
            }
            keyed::key(self, skeleton, &mut clip, bound);
            clip.report = self.check(skeleton, &clip);
            bound *= 0.25;
        }
        clip
    }

    /// Resamples to about `rate` Hz: the nearest rate that puts a frame on both ends.
    #[must_use]
    pub fn bake_at(&self, skeleton: &Skeleton, rate: f32) -> Clip {
        let duration = self.duration();
        // Rounding of key times must not add a frame.
        let steps = (duration * rate - 1e-3).ceil().clamp(0.0, MAX_FRAMES);
        let count = steps as usize + 1;
        let rate = if duration > 0.0 { steps / duration } else { 0.0 };
        let times: Vec<f32> = (0..count).map(|frame| if rate > 0.0 { frame as f32 / rate } else { 0.0 }).collect();

        let mut frames = Frames { rate, count, ..Frames::default() };
        let mut tracks = Vec::new();
        for curves in &self.joints {
            let rest = skeleton.rest()[curves.joint.index()];
            if let Some(curve) = &curves.rotation {
                let samples = same_side(times.iter().map(|&time| curve.sample(time)));
                match constant(&samples, distance) {
                    Some(value) if distance(value, rest.rotation) <= STILL => {}
                    Some(value) => frames.still_rotations.push((curves.joint, value)),
                    None => {
                        frames.rotations.push(curves.joint);
                        tracks.push((0, samples.iter().flat_map(|q| q.to_array()).collect::<Vec<f32>>(), 4));
                    }
                }
            }
            for (kind, curve, rest) in [(1, &curves.translation, rest.translation), (2, &curves.scale, rest.scale)] {
                let Some(curve) = curve else { continue };
                let samples: Vec<Vec3> = times.iter().map(|&time| curve.sample(time)).collect();
                let (still, moving) = if kind == 1 {
                    (&mut frames.still_translations, &mut frames.translations)
                } else {
                    (&mut frames.still_scales, &mut frames.scales)
                };
                match constant(&samples, |a, b| (a - b).abs().max_element()) {
                    Some(value) if (value - rest).abs().max_element() <= STILL => {}
                    Some(value) => still.push((curves.joint, value)),
                    None => {
                        moving.push(curves.joint);
                        tracks.push((kind, samples.iter().flat_map(Vec3::to_array).collect(), 3));
                    }
                }
            }
        }
        for morph in &self.morphs {
            frames.morphs.push((morph.node, morph.weights.len()));
            for weights in &morph.weights {
                tracks.push((3, times.iter().map(|&time| weights.sample(time)).collect(), 1));
            }
        }
        tracks.sort_by_key(|track| track.0);
        frames.rows.reserve(count * frames.width());
        for frame in 0..count {
            for (_, samples, size) in &tracks {
                frames.rows.extend_from_slice(&samples[frame * size..(frame + 1) * size]);
            }
        }

        let mut clip = Clip { name: self.name.clone(), duration, speed: 1.0, frames, ..Clip::default() };
        keyed::key_steps(self, &mut clip);
        keyed::key_morphs(self, &mut clip);
        clip.report = self.check(skeleton, &clip);
        let closes = duration > 0.0 && clip.report.seam <= SEAM * size(skeleton);
        clip.looping = self.looping.unwrap_or(closes);
        clip.ground_speed = self.ground_speed;
        clip.lead = self.key_times().filter_map(|(times, _)| times.first().copied()).fold(duration, f32::min).max(0.0);
        clip
    }

    /// Compares `clip` with the exact curves, four times as often as it has frames if it isn't very long.
    fn check(&self, skeleton: &Skeleton, clip: &Clip) -> ClipReport {
        let (mut exact, mut baked) = (Pose::rest(skeleton), Pose::rest(skeleton));
        // A leaf joint's turn shows only in what hangs on it: take that to be this far out, in the file's unit.
        let lever = LEVER * size(skeleton) / skeleton.model_from_root.x_axis.length().max(f32::MIN_POSITIVE);
        let mut distance_at = |time: f32, other: Option<f32>| {
            self.sample(skeleton, time, exact.locals_mut());
            exact.update_model(skeleton);
            match other {
                Some(other) => self.sample(skeleton, other, baked.locals_mut()),
                None => clip.sample_held(skeleton, time, baked.locals_mut()),
            }
            baked.update_model(skeleton);
            let pairs = exact.models().iter().zip(baked.models());
            pairs
                .map(|(a, b)| {
                    let [a, b] = [a, b].map(|matrix| matrix.to_affine());
                    let turned = [a.x_axis - b.x_axis, a.y_axis - b.y_axis, a.z_axis - b.z_axis];
                    let turned = turned.into_iter().map(Vec3A::length).fold(0.0, f32::max);
                    a.translation.distance(b.translation) + turned * lever
                })
                .fold(0.0, f32::max)
        };
        let checks = (4 * (clip.frame_count() - 1)).min(MAX_CHECKS);
        let max_error = (0..=checks)
            .map(|check| clip.duration * check as f32 / checks.max(1) as f32)
            .map(|time| distance_at(time, None))
            .fold(0.0, f32::max);
        let seam = distance_at(0.0, Some(clip.duration));
        ClipReport { bytes: clip.frames.all_bytes(), max_error, seam }
    }

    /// The rate in Hz at which all keys stand, when there is one.
    fn own_rate(&self) -> Option<f32> {
        let duration = self.duration();
        let step = self
            .key_times()
            .filter(|(_, interpolation)| *interpolation != Interpolation::Step)
            .flat_map(|(times, _)| times.windows(2).map(|pair| pair[1] - pair[0]))
            .fold(f32::INFINITY, f32::min);
        let frames = (duration / step).round();
        let rate = frames / duration;
        let even = || {
            self.key_times()
                .all(|(times, _)| times.iter().all(|time| (time * rate - (time * rate).round()).abs() < 0.01))
        };
        (rate.is_finite() && frames >= 1.0 && even()).then_some(rate)
    }

    fn key_times(&self) -> impl Iterator<Item = (&[f32], Interpolation)> {
        let joints = self.joints.iter().flat_map(|curves| {
            let rotation = curves.rotation.as_ref().map(|c| (c.times(), c.interpolation()));
            let vectors = [&curves.translation, &curves.scale];
            rotation.into_iter().chain(vectors.into_iter().flatten().map(|c| (c.times(), c.interpolation())))
        });
        let morphs = self.morphs.iter().flat_map(|morph| &morph.weights);
        joints.chain(morphs.map(|curve| (curve.times(), curve.interpolation())))
    }
}

/// Half the largest distance between two joints at rest, about; metres in model space, at least a millimetre.
fn size(skeleton: &Skeleton) -> f32 {
    let rest = Pose::rest(skeleton);
    let root = rest.positions().next().unwrap_or_default();
    rest.positions().map(|joint| joint.distance(root)).fold(1e-3, f32::max)
}

/// Flips signs so that neighbours lie on one side and interpolate the short way.
fn same_side(samples: impl Iterator<Item = Quat>) -> Vec<Quat> {
    let mut previous: Option<Quat> = None;
    samples
        .map(|sample| {
            let sample = if previous.is_some_and(|before| before.dot(sample) < 0.0) { -sample } else { sample };
            previous = Some(sample);
            sample
        })
        .collect()
}

fn constant<T: Copy>(samples: &[T], difference: impl Fn(T, T) -> f32) -> Option<T> {
    let first = *samples.first()?;
    samples.iter().all(|&sample| difference(sample, first) <= STILL).then_some(first)
}

/// Largest difference of the components of two rotations, whatever their sign.
fn distance(a: Quat, b: Quat) -> f32 {
    let b = if a.dot(b) < 0.0 { -b } else { b };
    let difference = a - b;
    difference.to_array().into_iter().map(f32::abs).fold(0.0, f32::max)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact by construction")]
mod tests;
