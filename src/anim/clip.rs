//! Clips: motion resampled to a uniform rate, rows of one frame each, so that sampling reads two neighbouring rows.
//!
//! Joints in their parent's space, times in seconds. No cursor, no cache, no state: any number of characters read one clip.

use bevy::math::{Quat, Vec3};

use super::{
    curve::Curve,
    keys::{JointCurves, MorphCurves},
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// What baking did to a clip.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ClipReport {
    /// Bytes of all rows and constants.
    pub bytes: usize,
    /// Largest distance between a joint of the exact curves and of the baked rows, metres in model space.
    pub max_error: f32,
    /// Distance between the first and the last pose, metres in model space: a loop has next to none.
    pub seam: f32,
}

/// Two neighbouring frames and the way between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameSpan {
    /// Earlier frame.
    pub first: usize,
    /// The one after it, or the same at the clip's end.
    pub second: usize,
    /// 0 at `first`, 1 at `second`.
    pub blend: f32,
}

/// Motion of a skeleton's joints.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// Its name in the file.
    pub name: String,
    /// Seconds at normal speed; 0 is a single pose.
    pub duration: f32,
    /// Whether time wraps at the end; else the last pose holds.
    pub looping: bool,
    /// Playback speed as a factor. Sampling takes clip seconds and leaves it to whoever advances them.
    pub speed: f32,
    /// Speed over ground in m/s at which its feet don't slide, where its file says so.
    pub ground_speed: Option<f32>,
    /// Seconds before the first key, through which the first pose holds.
    pub lead: f32,
    /// Figures of the bake.
    pub report: ClipReport,
    pub(super) frames: Frames,
}

/// Rows, one a frame: rotations (4 floats each), then translations and scales (3 each), then morph weights.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Frames {
    /// Frames per second.
    pub(super) rate: f32,
    pub(super) count: usize,
    pub(super) rotations: Vec<JointIndex>,
    pub(super) translations: Vec<JointIndex>,
    pub(super) scales: Vec<JointIndex>,
    /// Joint of the mesh's node and how many weights it has, in the order of the rows.
    pub(super) morphs: Vec<(JointIndex, usize)>,
    pub(super) rows: Vec<f32>,
    pub(super) still_rotations: Vec<(JointIndex, Quat)>,
    pub(super) still_translations: Vec<(JointIndex, Vec3)>,
    pub(super) still_scales: Vec<(JointIndex, Vec3)>,
    /// Channels that the rows hold only roughly: evaluated in their place.
    pub(super) keyed: Vec<JointCurves>,
    /// Morph weights that the rows hold only roughly.
    pub(super) keyed_morphs: Vec<MorphCurves>,
    /// Seconds of the keys that lie before the first row.
    pub(super) keyed_from: f32,
}

impl Frames {
    /// Bytes of rows, constants and keys.
    pub(super) fn all_bytes(&self) -> usize {
        let morphs = self.keyed_morphs.iter().flat_map(|morph| &morph.weights);
        self.bytes()
            + self.keyed.iter().map(JointCurves::bytes).sum::<usize>()
            + morphs.map(Curve::bytes).sum::<usize>()
    }

    pub(super) fn width(&self) -> usize {
        self.morph_start() + self.morphs.iter().map(|morph| morph.1).sum::<usize>()
    }

    /// Bytes of rows and constants.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.rows.as_slice())
            + size_of_val(self.still_rotations.as_slice())
            + size_of_val(self.still_translations.as_slice())
            + size_of_val(self.still_scales.as_slice())
    }

    fn morph_start(&self) -> usize {
        4 * self.rotations.len() + 3 * (self.translations.len() + self.scales.len())
    }

    fn row(&self, frame: usize) -> &[f32] {
        let width = self.width();
        &self.rows[frame * width..(frame + 1) * width]
    }
}

impl Clip {
    /// Frames per second of the rows.
    #[must_use]
    pub fn frame_rate(&self) -> f32 {
        self.frames.rate
    }

    /// How many frames there are, both ends included.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.frames.count
    }

    /// Joints whose rotation, translation or scale changes, with doubles.
    pub fn moving_joints(&self) -> impl Iterator<Item = JointIndex> + '_ {
        self.frames.rotations.iter().chain(&self.frames.translations).chain(&self.frames.scales).copied()
    }

    /// `time` brought into the clip: wrapped when it loops, else held at the ends. NaN counts as 0.
    #[must_use]
    pub fn wrap(&self, time: f32) -> f32 {
        if !time.is_finite() || self.duration <= 0.0 {
            0.0
        } else if (0.0..=self.duration).contains(&time) {
            time
        } else if self.looping {
            // Rounding may give the duration itself, which is the same pose as 0.
            time.rem_euclid(self.duration).min(self.duration)
        } else {
            time.clamp(0.0, self.duration)
        }
    }

    /// The frames around `time` seconds.
    #[must_use]
    pub fn span(&self, time: f32) -> FrameSpan {
        self.held_span(self.wrap(time))
    }

    /// Time of `sample` of `count` even steps through `duration` seconds, both ends included.
    pub(super) fn time_of(sample: usize, count: usize, duration: f32) -> f32 {
        duration * sample as f32 / count.max(1) as f32
    }

    /// The frames around `time` seconds, held at the ends whether it loops or not.
    fn held_span(&self, time: f32) -> FrameSpan {
        let last = self.frames.count.saturating_sub(1);
        let position = time.clamp(0.0, self.duration.max(0.0)) * self.frames.rate;
        let first = (position as usize).min(last);
        FrameSpan { first, second: (first + 1).min(last), blend: (position - first as f32).clamp(0.0, 1.0) }
    }

    /// Writes every joint at `time` seconds, each in its parent's space; joints without keys are at rest.
    ///
    /// `skeleton` is the one the clip was baked for and `out` has one entry a joint.
    pub fn sample(&self, skeleton: &Skeleton, time: f32, out: &mut [JointTransform]) {
        self.sample_at(skeleton, self.wrap(time), out);
    }

    /// As [`Clip::sample`], but the clip's duration is its last pose, not its first again.
    pub(super) fn sample_held(&self, skeleton: &Skeleton, time: f32, out: &mut [JointTransform]) {
        self.sample_at(skeleton, time, out);
    }

    /// Every joint at one frame of the rows, without what is [keyed](Clip::is_keyed).
    pub(super) fn sample_frame(&self, skeleton: &Skeleton, frame: usize, out: &mut [JointTransform]) {
        self.sample_rows(skeleton, FrameSpan { first: frame, second: frame, blend: 0.0 }, out);
    }

    /// Whether its rows alone don't tell a joint's motion: steps, and what no frame rate follows.
    #[must_use]
    pub fn is_keyed(&self) -> bool {
        !self.frames.keyed.is_empty()
    }

    fn sample_at(&self, skeleton: &Skeleton, time: f32, out: &mut [JointTransform]) {
        self.sample_rows(skeleton, self.held_span(time), out);
        for curves in &self.frames.keyed {
            curves.sample(time + self.frames.keyed_from, &mut out[curves.joint.index()]);
        }
    }

    fn sample_rows(&self, skeleton: &Skeleton, span: FrameSpan, out: &mut [JointTransform]) {
        debug_assert_eq!(out.len(), skeleton.len(), "one transform a joint");
        out.copy_from_slice(skeleton.rest());
        let frames = &self.frames;
        for &(joint, rotation) in &frames.still_rotations {
            out[joint.index()].rotation = rotation;
        }
        for &(joint, translation) in &frames.still_translations {
            out[joint.index()].translation = translation;
        }
        for &(joint, scale) in &frames.still_scales {
            out[joint.index()].scale = scale;
        }
        if frames.count == 0 {
            return;
        }
        let (mut a, mut b) = (frames.row(span.first), frames.row(span.second));
        for &joint in &frames.rotations {
            let (from, to) = (quat(take(&mut a, 4)), quat(take(&mut b, 4)));
            // Neighbouring frames were baked on the same side, so this is the shortest arc.
            out[joint.index()].rotation = (from * (1.0 - span.blend) + to * span.blend).normalize();
        }
        for &joint in &frames.translations {
            out[joint.index()].translation = vec3(take(&mut a, 3)).lerp(vec3(take(&mut b, 3)), span.blend);
        }
        for &joint in &frames.scales {
            out[joint.index()].scale = vec3(take(&mut a, 3)).lerp(vec3(take(&mut b, 3)), span.blend);
        }
    }

    /// The clip without its lead: a loop must not wait at its start. Only whole frames are taken off.
    #[must_use]
    pub fn without_lead(&self) -> Self {
        let frames = self.lead * self.frames.rate;
        let cut = (frames + 0.01).floor();
        if cut < 1.0 || cut as usize + 1 >= self.frames.count {
            return self.clone();
        }
        let mut clip = self.clone();
        clip.frames.rows.drain(..cut as usize * self.frames.width());
        clip.frames.count -= cut as usize;
        clip.duration = (clip.frames.count - 1) as f32 / self.frames.rate;
        clip.lead = ((frames - cut) / self.frames.rate).max(0.0);
        clip.frames.keyed_from += cut / self.frames.rate;
        clip.report.bytes = clip.frames.all_bytes();
        clip
    }

    /// Writes the morph weights at `time` seconds of the mesh that hangs on `node`.
    ///
    /// Gives false and leaves `out` alone when the clip has none for that node; a shorter `out` takes the first weights.
    pub fn morph_weights(&self, node: JointIndex, time: f32, out: &mut [f32]) -> bool {
        let time = self.wrap(time);
        match self.frames.keyed_morphs.iter().find(|morph| morph.node == node) {
            Some(morph) => {
                for (weight, curve) in out.iter_mut().zip(&morph.weights) {
                    *weight = curve.sample(time + self.frames.keyed_from);
                }
                true
            }
            None => self.held_morph_weights(node, time, out),
        }
    }

    /// As [`Clip::morph_weights`], from the rows alone and held at the ends.
    pub(super) fn held_morph_weights(&self, node: JointIndex, time: f32, out: &mut [f32]) -> bool {
        let frames = &self.frames;
        let mut start = frames.morph_start();
        for &(joint, count) in &frames.morphs {
            if joint == node && frames.count > 0 {
                let span = self.held_span(time);
                let (a, b) = (&frames.row(span.first)[start..], &frames.row(span.second)[start..]);
                for ((weight, from), to) in out.iter_mut().zip(&a[..count]).zip(&b[..count]) {
                    *weight = from + (to - from) * span.blend;
                }
                return true;
            }
            start += count;
        }
        false
    }
}

fn take<'a>(row: &mut &'a [f32], count: usize) -> &'a [f32] {
    let (head, tail) = row.split_at(count);
    *row = tail;
    head
}

fn quat(values: &[f32]) -> Quat {
    Quat::from_slice(values)
}

fn vec3(values: &[f32]) -> Vec3 {
    Vec3::from_slice(values)
}
