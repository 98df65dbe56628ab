//! What a clip's feet do: when each stands, how fast the ground passes, how long a stride is.
//!
//! Model space, metres, +Y up, the character faces -Z. Phases 0..1 of the clip; 0 is where the left foot lands.

use bevy::math::Vec3;

use super::{clip::Clip, leg::Leg, pose::Pose, skeleton::Skeleton};
use crate::math::rotation::direction_or;

/// Samples per second of clip, and how many at least and at most.
const SAMPLES: (f32, usize, usize) = (120.0, 48, 1024);
/// A leg of this length takes the thresholds below as they are; others scale them.
const LEG: f32 = 0.875;
/// Metres over the ground below which a point of the sole may land, and above which it has left.
const HEIGHT: (f32, f32) = (0.012, 0.025);
/// Speeds against the ground below which a point may land, and above which it has left: m/s, and share of ground speed.
const SPEED: [(f32, f32); 2] = [(0.15, 0.3), (0.3, 0.5)];
/// Ground speed below this, m/s, is standing.
const STANDING: f32 = 0.08;
/// Seconds below which a gap in a stance is noise, and below which a stance is.
const GAP: f32 = 0.03;
/// Phase over which a contact's weight grows and fades, centred on its edge.
const EDGE: f32 = 0.03;

/// A stance: from landing to lift-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Phase of landing, 0..1.
    pub start: f32,
    /// Phase of lift-off, above `start` by at most 1: beyond 1 it wraps.
    pub end: f32,
}

/// What a clip's feet do. Pairs are `[left, right]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gait {
    /// Speed over ground, in m/s at normal playback, at which the feet don't slide; 0 when standing.
    pub speed: f32,
    /// The same with its direction in model space: -Z forward.
    pub velocity: Vec3,
    /// Metres over ground from one landing of the left foot to its next; 0 when standing.
    pub stride: f32,
    /// Strides in one run of the clip: usually 1.
    pub strides: u16,
    /// Stances of each foot, by start.
    pub contact: [Vec<Contact>; 2],
    /// Share of the clip's duration, 0..1, at which the phase is 0.
    pub phase_offset: f32,
    /// Whether the clip loops; only then does phase 0 move to a landing.
    pub looping: bool,
    /// Height of each sole while it stands, metres over the model's ground plane.
    pub sole_height: [f32; 2],
}

impl Gait {
    /// Looks at the feet of `clip`.
    #[must_use]
    pub fn analyze(clip: &Clip, skeleton: &Skeleton, legs: &[Leg; 2]) -> Self {
        Track::new(clip, skeleton, legs).gait()
    }

    /// Takes `contact` for the stances, as shares of the clip's duration, and moves phase 0 to the left foot's landing.
    pub fn set_contacts(&mut self, contact: [Vec<Contact>; 2]) {
        let landing = contact[0].iter().find(|contact| contact.end - contact.start < 1.0);
        self.phase_offset = landing.filter(|_| self.looping).map_or(0.0, |contact| contact.start);
        self.contact = contact.map(|mut contacts| {
            for contact in &mut contacts {
                let length = contact.end - contact.start;
                contact.start = if length < 1.0 { wrapped(contact.start - self.phase_offset) } else { 0.0 };
                contact.end = contact.start + length;
            }
            contacts.sort_by(|a, b| a.start.total_cmp(&b.start));
            contacts
        });
        let strides = self.contact[0].len().max(self.contact[1].len()).max(1);
        self.strides = u16::try_from(strides).unwrap_or(u16::MAX);
    }

    /// Takes `speed` (m/s) for the speed over ground of a clip of `duration` seconds; forward if it had none.
    pub fn set_speed(&mut self, speed: f32, duration: f32) {
        self.velocity = direction_or(self.velocity, Vec3::NEG_Z) * speed;
        self.speed = speed;
        self.stride = speed * duration / f32::from(self.strides.max(1));
    }

    /// Phase 0..1 at `time` seconds of a clip of `duration` seconds.
    #[must_use]
    pub fn phase_at(&self, time: f32, duration: f32) -> f32 {
        if duration > 0.0 { wrapped(time / duration - self.phase_offset) } else { 0.0 }
    }

    /// Seconds into a clip of `duration` seconds at `phase`.
    #[must_use]
    pub fn time_at(&self, phase: f32, duration: f32) -> f32 {
        wrapped(phase + self.phase_offset) * duration
    }

    /// How firmly foot 0 (left) or 1 stands at `phase`: 0 in swing, 1 in stance, half on the edge.
    #[must_use]
    pub fn contact_weight(&self, foot: usize, phase: f32) -> f32 {
        let weight = |contact: &Contact| {
            let length = contact.end - contact.start;
            if length >= 1.0 {
                return 1.0;
            }
            let edge = EDGE.min(0.5 * length).min(0.5 * (1.0 - length));
            // Phase after landing, as the nearest of its repeats to the stance's middle.
            let since = wrapped(phase - contact.start - 0.5 * length + 0.5) + 0.5 * length - 0.5;
            let inside = since.min(length - since);
            smooth(0.5 + inside / edge.max(f32::MIN_POSITIVE))
        };
        self.contact[foot].iter().map(weight).fold(0.0, f32::max)
    }

    /// Phase from `phase` until the foot lands: 0 while it stands, `None` when it never does.
    #[must_use]
    pub fn phase_to_landing(&self, foot: usize, phase: f32) -> Option<f32> {
        let until = |contact: &Contact| {
            let since = wrapped(phase - contact.start);
            if since < contact.end - contact.start { 0.0 } else { 1.0 - since }
        };
        self.contact[foot].iter().map(until).reduce(f32::min)
    }

    /// Phase from `phase` until the foot lifts: 0 in swing, `None` when it never does.
    #[must_use]
    pub fn phase_to_lift(&self, foot: usize, phase: f32) -> Option<f32> {
        let stands = |contact: &&Contact| wrapped(phase - contact.start) < contact.end - contact.start;
        match self.contact[foot].iter().find(stands) {
            Some(contact) if contact.end - contact.start >= 1.0 => None,
            Some(contact) => Some(contact.end - contact.start - wrapped(phase - contact.start)),
            None => Some(0.0),
        }
    }
}

/// Sole points over the clip.
struct Track {
    duration: f32,
    looping: bool,
    /// Size of the character against [`LEG`].
    size: f32,
    /// By sample, foot, point: position in model space.
    points: Vec<[[Vec3; 3]; 2]>,
    /// Horizontal way of the hips over the clip, m/s: root motion left in the clip.
    drift: Vec3,
}

impl Track {
    fn new(clip: &Clip, skeleton: &Skeleton, legs: &[Leg; 2]) -> Self {
        let (rate, least, most) = SAMPLES;
        let count = ((clip.duration * rate) as usize).clamp(least, most);
        let mut pose = Pose::rest(skeleton);
        let mut hips = [Vec3::ZERO; 2];
        let mut points = Vec::with_capacity(count);
        for sample in 0..=count {
            // The last sample is the end itself, not the start again.
            let held = Clip::time_of(sample, count, clip.duration);
            clip.sample_held(skeleton, held, pose.locals_mut());
            pose.update_model(skeleton);
            points.push([0, 1].map(|foot| legs[foot].sole().map(|point| point.position(&pose))));
            let middle = 0.5 * (pose.position(legs[0].upper) + pose.position(legs[1].upper));
            if sample == 0 {
                hips[0] = middle;
            }
            hips[1] = middle;
        }
        let drift = if clip.duration > 0.0 { (hips[1] - hips[0]) / clip.duration } else { Vec3::ZERO };
        Self {
            duration: clip.duration,
            looping: clip.looping,
            size: (0.5 * (legs[0].length() + legs[1].length()) / LEG).max(1e-3),
            points,
            drift: Vec3::new(drift.x, 0.0, drift.z),
        }
    }

    fn count(&self) -> usize {
        self.points.len() - 1
    }

    /// Velocity of a point at a sample, m/s.
    fn velocity(&self, sample: usize, foot: usize, point: usize) -> Vec3 {
        if self.duration <= 0.0 {
            return Vec3::ZERO;
        }
        let count = self.count();
        let at = |sample: usize| self.points[sample][foot][point];
        let step = self.duration / count as f32;
        if self.looping && (sample == 0 || sample == count) {
            // Over the seam: the last sample is the first one again, a cycle of root motion further on.
            return (at(1) - at(0) + at(count) - at(count - 1)) / (2.0 * step);
        }
        let (before, after) = (sample.saturating_sub(1), (sample + 1).min(count));
        (at(after) - at(before)) / (step * (after - before) as f32)
    }

    fn height(&self, sample: usize, foot: usize, point: usize) -> f32 {
        self.points[sample][foot][point].y
    }

    /// The lowest point of a foot at a sample.
    fn lowest(&self, sample: usize, foot: usize) -> usize {
        let mut lowest = 0;
        for point in 1..3 {
            if self.height(sample, foot, point) < self.height(sample, foot, lowest) {
                lowest = point;
            }
        }
        lowest
    }

    fn gait(&self) -> Gait {
        let ground = self.ground();
        let mut passing = self.ground_velocity(|sample, foot, point| {
            self.height(sample, foot, point) < ground[foot] + HEIGHT.1 * self.size
        });
        let mut stands = [self.stance(0, ground[0], passing), self.stance(1, ground[1], passing)];
        // Once more with what stands: swing's low passes no longer count.
        if stands.iter().flatten().any(|stands| *stands) {
            passing = self.ground_velocity(|sample, foot, _| stands[foot][sample % self.count()]);
            stands = [self.stance(0, ground[0], passing), self.stance(1, ground[1], passing)];
        }

        let mut velocity = self.drift - passing;
        if velocity.length() < STANDING * self.size.sqrt() {
            velocity = Vec3::ZERO;
        }
        let contact = [self.intervals(&stands[0]), self.intervals(&stands[1])];
        let sole_height = [0, 1].map(|foot| {
            let heights = (0..self.count())
                .filter(|&sample| stands[foot][sample])
                .map(|sample| self.height(sample, foot, self.lowest(sample, foot)));
            median(heights.collect()).unwrap_or(ground[foot])
        });
        let mut gait =
            Gait { velocity, speed: velocity.length(), sole_height, looping: self.looping, ..Gait::default() };
        gait.set_contacts(contact);
        gait.set_speed(gait.speed, self.duration);
        gait
    }

    /// Height of the ground under each foot: the lowest its sole gets, but no higher than a step over the other's.
    fn ground(&self) -> [f32; 2] {
        let lowest = [0, 1].map(|foot| {
            let heights = (0..self.points.len()).map(|sample| self.height(sample, foot, self.lowest(sample, foot)));
            heights.fold(f32::INFINITY, f32::min)
        });
        let both = lowest[0].min(lowest[1]) + HEIGHT.1 * self.size;
        lowest.map(|height| height.min(both))
    }

    /// Horizontal velocity of the ground past the character: the median of what the lowest points do where `counts`.
    fn ground_velocity(&self, counts: impl Fn(usize, usize, usize) -> bool) -> Vec3 {
        let (mut x, mut z) = (Vec::new(), Vec::new());
        for sample in 0..self.count() {
            for foot in 0..2 {
                let point = self.lowest(sample, foot);
                if counts(sample, foot, point) {
                    let velocity = self.velocity(sample, foot, point);
                    x.push(velocity.x);
                    z.push(velocity.z);
                }
            }
        }
        Vec3::new(median(x).unwrap_or(0.0), 0.0, median(z).unwrap_or(0.0))
    }

    /// By sample: whether the foot stands on ground at height `ground` that moves with `passing`.
    fn stance(&self, foot: usize, ground: f32, passing: Vec3) -> Vec<bool> {
        let count = self.count();
        let near = |sample: usize, loose: bool| {
            let height = if loose { HEIGHT.1 } else { HEIGHT.0 } * self.size;
            let (slow, share) = SPEED[usize::from(loose)];
            let speed = slow * self.size.sqrt() + share * passing.length();
            (0..3).any(|point| {
                let slip = self.velocity(sample, foot, point) - passing;
                self.height(sample, foot, point) < ground + height && Vec3::new(slip.x, 0.0, slip.z).length() < speed
            })
        };
        let mut stands = vec![false; count];
        let mut standing = near(0, false);
        // Twice round, so that a loop starts as it ends.
        for step in 0..if self.looping { 2 * count } else { count } {
            let sample = step % count;
            standing = near(sample, standing);
            stands[sample] = standing;
        }
        let shortest = ((GAP * self.size.sqrt() * count as f32 / self.duration.max(GAP)) as usize).min(count / 4);
        clean(&mut stands, false, shortest, self.looping);
        clean(&mut stands, true, shortest, self.looping);
        stands
    }

    fn intervals(&self, stands: &[bool]) -> Vec<Contact> {
        let count = stands.len();
        let phase = |sample: usize| sample as f32 / count as f32;
        if stands.iter().all(|stands| *stands) {
            return vec![Contact { start: 0.0, end: 1.0 }];
        }
        runs(stands, true, self.looping)
            .map(|(start, length)| Contact { start: phase(start), end: phase(start + length) })
            .collect()
    }
}

/// Flips runs of `value` shorter than `shortest` samples.
fn clean(samples: &mut [bool], value: bool, shortest: usize, looping: bool) {
    let count = samples.len();
    let short: Vec<_> = runs(samples, value, looping).filter(|&(_, length)| length < shortest).collect();
    for (start, length) in short {
        for step in start..start + length {
            samples[step % count] = !value;
        }
    }
}

/// Runs of `value` as start and length; in a loop a run may go over the end.
fn runs(samples: &[bool], value: bool, looping: bool) -> impl Iterator<Item = (usize, usize)> {
    let count = samples.len();
    let starts = (0..count).filter(move |&start| {
        let before = if start > 0 { Some(samples[start - 1]) } else { looping.then(|| samples[count - 1]) };
        samples[start] == value && before != Some(value)
    });
    starts.map(move |start| {
        let end = if looping { start + count } else { count };
        (start, (start..end).take_while(|&at| samples[at % count] == value).count())
    })
}

fn median(mut values: Vec<f32>) -> Option<f32> {
    values.sort_by(f32::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        odd if odd % 2 == 1 => Some(values[middle]),
        _ => Some(0.5 * (values[middle - 1] + values[middle])),
    }
}

/// Phase brought into 0..1; NaN gives 0.
fn wrapped(phase: f32) -> f32 {
    let wrapped = phase.rem_euclid(1.0);
    if (0.0..1.0).contains(&wrapped) { wrapped } else { 0.0 }
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use bevy::math::{Affine3A, ops};
    use proptest::prelude::*;

    use super::*;
    use crate::anim::{
        bake::{ClipCurves, JointCurves},
        curve::{Curve, Interpolation},
        leg::SolePoint,
        skeleton::{JointIndex, JointTransform},
    };

    /// A body of two loose feet: enough to walk on paper.
    struct Walker {
        size: f32,
        speed: f32,
        /// Share of the cycle that a foot stands.
        duty: f32,
        /// Share of the clip at which the left foot lands.
        lands: f32,
        duration: f32,
        /// Whether the clip moves the body instead of the ground.
        root_motion: bool,
    }

    const WALK: Walker = Walker { size: 1.0, speed: 1.4, duty: 0.6, lands: 0.3, duration: 1.0, root_motion: false };

    impl Walker {
        fn skeleton(&self) -> Skeleton {
            let at = |x: f32, y: f32| JointTransform {
                translation: Vec3::new(x, y, 0.0) * self.size,
                ..JointTransform::IDENTITY
            };
            let joint = |name: &str, parent, transform| (name.to_owned(), parent, transform);
            let root = Some(JointIndex(0));
            let joints = [
                joint("hips", None, at(0.0, 0.0)),
                joint("leftKnee", root, at(-0.1, 0.5)),
                joint("leftFoot", root, at(-0.1, 0.08)),
                joint("rightKnee", root, at(0.1, 0.5)),
                joint("rightFoot", root, at(0.1, 0.08)),
            ];
            Skeleton::new(joints, Affine3A::IDENTITY).unwrap()
        }

        fn legs(&self) -> [Leg; 2] {
            [(1, 2), (3, 4)].map(|(knee, foot)| {
                let point =
                    |z: f32| SolePoint { joint: JointIndex(foot), offset: Vec3::new(0.0, -0.08, z) * self.size };
                Leg {
                    upper: JointIndex(0),
                    lower: JointIndex(knee),
                    foot: JointIndex(foot),
                    thigh: 0.4375 * self.size,
                    shin: 0.4375 * self.size,
                    heel: point(0.06),
                    ball: point(-0.13),
                    tip: point(-0.2),
                    ..Leg::default()
                }
            })
        }

        /// Where a foot is, relative to the hips, at `phase` after its landing.
        fn foot(&self, phase: f32) -> (f32, f32) {
            let travel = self.speed * self.duration * self.duty;
            if phase < self.duty {
                return (0.0, travel * (phase / self.duty - 0.5));
            }
            let swing = (phase - self.duty) / (1.0 - self.duty);
            let eased = swing * swing * (3.0 - 2.0 * swing);
            (0.1 * self.size * ops::sin(swing * core::f32::consts::PI), travel * (0.5 - eased))
        }

        fn clip(&self) -> (Clip, Skeleton) {
            let skeleton = self.skeleton();
            let steps = 120;
            let times: Vec<f32> = (0..=steps).map(|i| self.duration * i as f32 / steps as f32).collect();
            let mut curves = ClipCurves { name: "walk".to_owned(), ..ClipCurves::default() };
            for (foot, offset) in [(2, 0.0), (4, 0.5)] {
                let rest = skeleton.rest()[foot].translation;
                let values = times.iter().map(|time| {
                    let phase = wrapped(time / self.duration - self.lands - offset);
                    let (up, back) = self.foot(phase);
                    rest + Vec3::new(0.0, up, back)
                });
                let mut joint = JointCurves::new(JointIndex(foot as u16));
                joint.translation = Some(Curve::new(times.clone(), values.collect(), Interpolation::Linear).unwrap());
                curves.joints.push(joint);
            }
            if self.root_motion {
                let values = times.iter().map(|time| Vec3::NEG_Z * self.speed * *time).collect();
                let mut joint = JointCurves::new(JointIndex(0));
                joint.translation = Some(Curve::new(times, values, Interpolation::Linear).unwrap());
                curves.joints.insert(0, joint);
            }
            let mut clip = curves.bake(&skeleton);
            clip.looping = true;
            (clip, skeleton)
        }

        fn gait(&self) -> Gait {
            let (clip, skeleton) = self.clip();
            Gait::analyze(&clip, &skeleton, &self.legs())
        }
    }

    fn assert_near(what: &str, got: f32, want: f32, tolerance: f32) {
        assert!((got - want).abs() <= tolerance, "{what}: {got}, not {want} within {tolerance}");
    }

    #[test]
    fn a_walk_gives_its_speed_stride_and_stances() {
        let gait = WALK.gait();
        assert_near("speed", gait.speed, 1.4, 0.01);
        assert_near("stride", gait.stride, 1.4, 0.01);
        assert!(gait.velocity.normalize().distance(Vec3::NEG_Z) < 0.01, "heads {}", gait.velocity);
        assert_near("phase offset", gait.phase_offset, 0.3, 0.02);
        assert_eq!([gait.contact[0].len(), gait.contact[1].len()], [1, 1]);
        assert_near("left landing", gait.contact[0][0].start, 0.0, 1e-6);
        assert_near("left lift-off", gait.contact[0][0].end, 0.6, 0.04);
        assert_near("right landing", gait.contact[1][0].start, 0.5, 0.03);
        assert_near("right lift-off", gait.contact[1][0].end, 1.1, 0.04);
        assert_near("sole", gait.sole_height[0], 0.0, 1e-3);
    }

    #[test]
    fn a_run_has_flight() {
        let gait = Walker { speed: 3.5, duty: 0.35, duration: 0.7, ..WALK }.gait();
        assert_near("speed", gait.speed, 3.5, 0.05);
        assert_near("stance", gait.contact[0][0].end, 0.35, 0.05);
        assert_eq!([0, 1].map(|foot| gait.contact_weight(foot, 0.43)), [0.0; 2], "both feet are off the ground");
    }

    #[test]
    fn root_motion_counts_as_speed() {
        let gait = Walker { root_motion: true, ..WALK }.gait();
        assert_near("speed", gait.speed, 1.4, 0.02);
        assert_near("lift-off", gait.contact[0][0].end, 0.6, 0.05);
    }

    #[test]
    fn walking_backward_heads_backward() {
        let gait = Walker { speed: -1.0, ..WALK }.gait();
        assert_near("speed", gait.velocity.z, 1.0, 0.02);
    }

    #[test]
    fn standing_feet_always_stand() {
        let gait = Walker { speed: 0.0, duty: 1.0, ..WALK }.gait();
        assert_eq!((gait.speed, gait.stride, gait.phase_offset), (0.0, 0.0, 0.0));
        assert_eq!(gait.contact, [vec![Contact { start: 0.0, end: 1.0 }], vec![Contact { start: 0.0, end: 1.0 }]]);
        assert_eq!(
            (gait.contact_weight(0, 0.7), gait.phase_to_landing(1, 0.2), gait.phase_to_lift(0, 0.2)),
            (1.0, Some(0.0), None)
        );
    }

    #[test]
    fn a_clip_of_no_length_stands() {
        let skeleton = WALK.skeleton();
        let clip = ClipCurves::default().bake(&skeleton);
        let gait = Gait::analyze(&clip, &skeleton, &WALK.legs());
        assert_eq!((gait.speed, gait.contact_weight(0, 0.5)), (0.0, 1.0));
        assert_eq!((gait.phase_at(3.0, 0.0), gait.time_at(0.4, 0.0)), (0.0, 0.0));
    }

    #[test]
    fn written_stances_take_the_place_of_found_ones() {
        let mut gait = WALK.gait();
        gait.set_contacts([vec![Contact { start: 0.25, end: 0.75 }], vec![Contact { start: 0.75, end: 1.25 }]]);
        gait.set_speed(2.0, 1.0);
        assert_eq!((gait.phase_offset, gait.stride), (0.25, 2.0));
        assert_eq!(gait.contact[1], vec![Contact { start: 0.5, end: 1.0 }]);
    }

    #[test]
    fn edges_of_a_stance_are_half_firm() {
        let gait = WALK.gait();
        let Contact { start, end } = gait.contact[1][0];
        for edge in [start, end] {
            assert_near("weight", gait.contact_weight(1, edge), 0.5, 1e-3);
        }
        assert_eq!([start - 0.03, start + 0.03].map(|phase| gait.contact_weight(1, phase)), [0.0, 1.0]);
        assert_eq!(gait.contact_weight(1, f32::NAN), gait.contact_weight(1, 0.0));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn bodies_of_any_size_walk_alike(size in 0.3f32..3.0, duty in 0.5f32..0.7, lands in 0.0f32..1.0) {
            // Equal Froude number: speed and duration grow with the square root of the leg.
            let root = size.sqrt();
            let gait = Walker { size, speed: 1.3 * root, duration: root, duty, lands, ..WALK }.gait();
            prop_assert!((gait.speed / root - 1.3).abs() < 0.03, "speed {} at size {size}", gait.speed);
            prop_assert_eq!(gait.contact[0].len(), 1);
            let stance = gait.contact[0][0].end;
            prop_assert!((stance - duty).abs() < 0.05, "stance {stance}, not {duty}");
            let shift = wrapped(gait.phase_offset - lands + 0.5) - 0.5;
            prop_assert!(shift.abs() < 0.03, "lands at {}, not {lands}", gait.phase_offset);
        }

        #[test]
        fn weights_and_waits_stay_in_range(phase in -3.0f32..3.0, foot in 0usize..2) {
            let gait = WALK.gait();
            let weight = gait.contact_weight(foot, phase);
            prop_assert!((0.0..=1.0).contains(&weight), "weight {weight}");
            let (landing, lift) = (gait.phase_to_landing(foot, phase).unwrap(), gait.phase_to_lift(foot, phase).unwrap());
            prop_assert!((0.0..=1.0).contains(&landing) && (0.0..=1.0).contains(&lift), "{landing}, {lift}");
            prop_assert!(landing == 0.0 || lift == 0.0, "swings and stands at once");
        }
    }
}
