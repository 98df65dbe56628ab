//! Exact curves → [`Clip`]: uniform frames at the lowest rate that is true enough, constant channels taken out.

use bevy::math::{Quat, Vec3};

use super::{
    clip::{Clip, ClipReport, Frames},
    curve::{Curve, Interpolation},
    pose::Pose,
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// Metres a joint may be off the exact curves before a higher frame rate is taken.
const TOLERANCE: f32 = 1e-4;
/// Frame rates to try, lowest first, in Hz.
const RATES: [f32; 2] = [30.0, 60.0];
/// A file's own key rate is taken up to this, Hz.
const MAX_RATE: f32 = 120.0;
/// Frames of one clip; above it the rate goes down. An hour at 30 Hz.
const MAX_FRAMES: f32 = 108_000.0;
/// First and last pose closer than this fraction of the skeleton's size make a loop.
const SEAM: f32 = 0.01;
/// How far out from a joint turns are measured, as a fraction of the skeleton's size.
const LEVER: f32 = 0.05;
/// Changes below this are rounding: a channel that moves less is constant.
const STILL: f32 = 1e-6;

/// A clip's curves as the file has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClipCurves {
    /// Its name in the file.
    pub name: String,
    /// Joints with keys, each at most once.
    pub joints: Vec<JointCurves>,
    /// Morph weights with keys.
    pub morphs: Vec<MorphCurves>,
}

/// Keys of one joint, in its parent's space.
#[derive(Clone, Debug, PartialEq)]
pub struct JointCurves {
    /// The joint.
    pub joint: JointIndex,
    /// Keys of the rotation.
    pub rotation: Option<Curve<Quat>>,
    /// Keys of the translation.
    pub translation: Option<Curve<Vec3>>,
    /// Keys of the scale.
    pub scale: Option<Curve<Vec3>>,
}

impl JointCurves {
    /// No keys yet.
    #[must_use]
    pub fn new(joint: JointIndex) -> Self {
        Self { joint, rotation: None, translation: None, scale: None }
    }
}

/// Keys of the morph weights of one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MorphCurves {
    /// The node that carries the mesh, as a joint.
    pub node: JointIndex,
    /// One curve a morph target.
    pub weights: Vec<Curve<f32>>,
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
            let joint = &mut out[curves.joint.index()];
            if let Some(curve) = &curves.rotation {
                joint.rotation = curve.sample(time);
            }
            if let Some(curve) = &curves.translation {
                joint.translation = curve.sample(time);
            }
            if let Some(curve) = &curves.scale {
                joint.scale = curve.sample(time);
            }
        }
    }

    /// Resamples to the lowest of 30 Hz, 60 Hz and the file's own rate that keeps every joint within 0.1 mm of the
    /// exact curves, else to the truest of them. It loops when its last pose is its first.
    #[must_use]
    pub fn bake(&self, skeleton: &Skeleton) -> Clip {
        let mut best: Option<Clip> = None;
        for rate in RATES.into_iter().chain(self.own_rate()) {
            let clip = self.bake_at(skeleton, rate);
            let good = clip.report.max_error <= TOLERANCE;
            if best.as_ref().is_none_or(|best| clip.report.max_error < best.report.max_error) {
                best = Some(clip);
            }
            if good {
                break;
            }
        }
        best.unwrap_or_default()
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
                match constant(&samples, |a, b| distance(a, b)) {
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
                        tracks.push((kind, samples.iter().flat_map(|v| v.to_array()).collect(), 3));
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
        clip.report = self.check(skeleton, &clip);
        clip.looping = duration > 0.0 && clip.report.seam <= SEAM * size(skeleton);
        clip
    }

    /// Compares `clip` with the exact curves, four times as often as it has frames and a little before each jump.
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
                    let turned = [a.x_axis - b.x_axis, a.y_axis - b.y_axis, a.z_axis - b.z_axis];
                    let turned = turned.into_iter().map(|axis| axis.length()).fold(0.0, f32::max);
                    a.translation.distance(b.translation) + turned * lever
                })
                .fold(0.0, f32::max)
        };
        let checks = 4 * (clip.frame_count() - 1);
        let max_error = (0..=checks)
            .map(|check| clip.duration * check as f32 / checks.max(1) as f32)
            .map(|time| distance_at(time, None))
            .fold(0.0, f32::max);
        let seam = distance_at(0.0, Some(clip.duration));
        ClipReport { bytes: clip.frames.bytes(), max_error, seam }
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
        (rate.is_finite() && rate <= MAX_RATE && frames >= 1.0 && even()).then_some(rate)
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
    let root = rest.models().first().map(|root| root.translation).unwrap_or_default();
    rest.models().iter().map(|joint| joint.translation.distance(root)).fold(1e-3, f32::max)
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
mod tests {
    use bevy::math::{Affine3A, ops};

    use super::*;

    /// Shoulder, elbow and wrist, each a metre above the other.
    fn arm() -> Skeleton {
        let step = JointTransform { translation: Vec3::Y, ..JointTransform::IDENTITY };
        let joints = [
            ("shoulder".to_owned(), None, JointTransform::IDENTITY),
            ("elbow".to_owned(), Some(JointIndex(0)), step),
            ("wrist".to_owned(), Some(JointIndex(1)), step),
        ];
        Skeleton::new(joints, Affine3A::IDENTITY).unwrap()
    }

    fn turning(times: Vec<f32>, angles: &[f32], interpolation: Interpolation) -> ClipCurves {
        let values = angles.iter().map(|angle| Quat::from_rotation_z(*angle)).collect();
        let mut joint = JointCurves::new(JointIndex(0));
        joint.rotation = Some(Curve::rotation(times, values, interpolation).unwrap());
        ClipCurves { name: "turn".to_owned(), joints: vec![joint], morphs: Vec::new() }
    }

    fn sampled(clip: &Clip, time: f32) -> Vec<JointTransform> {
        let mut out = vec![JointTransform::IDENTITY; 3];
        clip.sample(&arm(), time, &mut out);
        out
    }

    #[test]
    fn a_smooth_clip_needs_thirty_frames_a_second() {
        let clip = turning(vec![0.0, 1.0], &[0.0, 0.5], Interpolation::Linear).bake(&arm());
        assert_eq!((clip.frame_count(), clip.frame_rate()), (31, 30.0));
        assert!(clip.report.max_error < 1e-4, "error {} m", clip.report.max_error);
        assert_eq!(clip.report.bytes, 31 * 16);
    }

    #[test]
    fn keys_at_their_own_rate_are_kept_to_the_bit() {
        let times: Vec<f32> = (0..=24).map(|key| key as f32 / 24.0).collect();
        let angles: Vec<f32> = times.iter().map(|time| 1.5 * ops::sin(time * 6.0)).collect();
        let clip = turning(times, &angles, Interpolation::Linear).bake(&arm());
        assert_eq!((clip.frame_count(), clip.frame_rate()), (25, 24.0));
        assert!(clip.report.max_error < 1e-4, "error {} m", clip.report.max_error);
    }

    #[test]
    fn baked_and_exact_pose_agree_at_any_time() {
        let times: Vec<f32> = (0..=10).map(|key| 0.13 * key as f32).collect();
        let angles: Vec<f32> = times.iter().map(|time| 0.8 * ops::sin(time * 5.0)).collect();
        let curves = turning(times, &angles, Interpolation::Linear);
        let clip = curves.bake(&arm());
        let mut exact = vec![JointTransform::IDENTITY; 3];
        for step in 0..=300 {
            let time = 1.3 * step as f32 / 300.0;
            curves.sample(&arm(), time, &mut exact);
            let error = exact[0].rotation.angle_between(sampled(&clip, time)[0].rotation);
            // Two metres of arm turn this angle into distance.
            assert!(2.0 * error <= clip.report.max_error + 2e-3, "{error} rad at {time} s");
        }
    }

    #[test]
    fn channels_that_stand_still_cost_no_rows() {
        let mut curves = turning(vec![0.0, 1.0], &[0.3, 0.3], Interpolation::Linear);
        let mut elbow = JointCurves::new(JointIndex(1));
        elbow.translation = Some(Curve::new(vec![0.0, 1.0], vec![Vec3::Y; 2], Interpolation::Step).unwrap());
        elbow.scale = Some(Curve::new(vec![0.2], vec![Vec3::splat(2.0)], Interpolation::Linear).unwrap());
        curves.joints.push(elbow);
        let clip = curves.bake(&arm());
        assert_eq!(clip.frames.rows.len(), 0, "nothing moves");
        assert_eq!(clip.frames.still_translations.len(), 0, "the elbow is at rest");
        let pose = sampled(&clip, 0.4);
        assert!(pose[0].rotation.angle_between(Quat::from_rotation_z(0.3)) < 1e-3);
        assert_eq!((pose[1].translation, pose[1].scale), (Vec3::Y, Vec3::splat(2.0)));
    }

    #[test]
    fn the_first_key_holds_from_the_start() {
        let clip = turning(vec![0.5, 1.0], &[0.2, 0.6], Interpolation::Linear).bake(&arm());
        assert_eq!(clip.duration, 1.0);
        let early = sampled(&clip, 0.25)[0].rotation.angle_between(Quat::from_rotation_z(0.2));
        assert!(early < 1e-3, "off by {early} rad");
    }

    #[test]
    fn a_loop_is_told_by_its_seam_and_wraps() {
        let loops = turning(vec![0.0, 0.5, 1.0], &[0.1, 0.9, 0.1], Interpolation::Linear).bake(&arm());
        assert!(loops.looping && loops.report.seam < 1e-4, "seam {} m", loops.report.seam);
        assert_eq!([-0.25, 3.25, f32::NAN].map(|time| loops.wrap(time)), [0.75, 0.25, 0.0]);
        let ends = turning(vec![0.0, 1.0], &[0.1, 0.9], Interpolation::Linear).bake(&arm());
        assert!(!ends.looping, "seam {} m", ends.report.seam);
        assert_eq!([-0.25, 3.25].map(|time| ends.wrap(time)), [0.0, 1.0]);
    }

    #[test]
    fn a_clip_of_no_length_is_one_pose() {
        let clip = turning(vec![0.0], &[0.4], Interpolation::Linear).bake(&arm());
        assert_eq!((clip.duration, clip.frame_count()), (0.0, 1));
        for time in [0.0, 1.0, -1.0, f32::INFINITY] {
            let error = sampled(&clip, time)[0].rotation.angle_between(Quat::from_rotation_z(0.4));
            assert!(error < 1e-3, "off by {error} rad at {time} s");
        }
        let none = ClipCurves::default().bake(&arm());
        assert_eq!(sampled(&none, 0.3), arm().rest());
    }

    #[test]
    fn morph_weights_are_kept_by_node() {
        let curve = |values: Vec<f32>| Curve::new(vec![0.0, 1.0], values, Interpolation::Linear).unwrap();
        let mut curves = turning(vec![0.0, 1.0], &[0.0, 0.5], Interpolation::Linear);
        for (node, weights) in [(1, vec![0.0, 1.0]), (2, vec![1.0, 0.5])] {
            curves
                .morphs
                .push(MorphCurves { node: JointIndex(node), weights: vec![curve(weights), curve(vec![0.0; 2])] });
        }
        let clip = curves.bake(&arm());
        let mut weights = [9.0; 2];
        assert!(clip.morph_weights(JointIndex(2), 0.5, &mut weights));
        assert!((weights[0] - 0.75).abs() < 1e-5 && weights[1].abs() < 1e-6, "{weights:?}");
        assert!(!clip.morph_weights(JointIndex(0), 0.5, &mut weights), "no weights on that node");
    }

    #[test]
    fn clips_of_a_twin_with_other_axes_look_the_same() {
        // The same arm, in centimetres, every joint's axes turned.
        let turn = Quat::from_euler(bevy::math::EulerRot::XYZ, 0.4, -1.1, 0.7);
        let step = |rotation: Quat, translation: Vec3| JointTransform { translation, rotation, scale: Vec3::ONE };
        let up = turn.inverse() * Vec3::Y * 200.0;
        let joints = [
            ("a".to_owned(), None, step(turn, Vec3::ZERO)),
            ("b".to_owned(), Some(JointIndex(0)), step(Quat::IDENTITY, up)),
            ("c".to_owned(), Some(JointIndex(1)), step(Quat::IDENTITY, up)),
        ];
        let twin = Skeleton::new(joints, Affine3A::from_scale(Vec3::splat(0.01))).unwrap();
        let mut curves = turning(vec![0.0, 1.0], &[0.0, 1.0], Interpolation::Linear);
        let moves = vec![Vec3::ZERO, Vec3::X];
        curves.joints[0].translation = Some(Curve::new(vec![0.0, 1.0], moves, Interpolation::Linear).unwrap());
        let clip = curves.bake(&arm());
        let pairs = [0, 1, 2].map(|joint| (JointIndex(joint), JointIndex(joint)));
        let foreign = clip.retargeted(&arm(), &twin, &pairs, &[JointIndex(0)], 2.0);
        let (mut own, mut other) = (Pose::rest(&arm()), Pose::rest(&twin));
        for time in [0.0, 0.3, 0.8, 1.0] {
            clip.sample(&arm(), time, own.locals_mut());
            foreign.sample(&twin, time, other.locals_mut());
            own.update_model(&arm());
            other.update_model(&twin);
            let (want, got) = (2.0 * own.position(JointIndex(2)), other.position(JointIndex(2)));
            assert!(got.distance(want) < 1e-3, "wrist at {got}, not {want}, at {time} s");
        }
    }
}
