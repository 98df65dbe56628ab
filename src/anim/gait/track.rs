//! Finds contacts: the soles of both feet over a clip, the ground that passes under them, who stands when.
//!
//! Model space, metres, +Y up; samples are even steps through the clip, both ends included.

use bevy::math::{Quat, Vec3};

use super::{Contact, Gait};
use crate::{
    anim::{clip::Clip, leg::Leg, pose::Pose, skeleton::Skeleton},
    math::rotation::{angle_between, from_scaled_axis},
};

/// Samples per second of clip, and how many at least and at most.
const SAMPLES: (f32, usize, usize) = (200.0, 128, 1024);
/// A leg of this length takes the thresholds below as they are; others scale them.
const LEG: f32 = 0.875;
/// Metres over the ground below which a point of the sole may land, and above which it has left.
const HEIGHT: (f32, f32) = (0.012, 0.025);
/// Speeds against the ground below which a point may land, and above which it has left: m/s, and share of ground speed.
const SPEED: [(f32, f32); 2] = [(0.15, 0.3), (0.3, 0.5)];
/// What a clean clip's edges are cut by: metres over the ground, m/s against it, share of ground speed.
const SHARP: (f32, f32, f32) = (0.006, 0.06, 0.04);
/// Seconds of the frames in which the hips' acceleration is told.
const FRAME: f32 = 1.0 / 60.0;
/// Share of time that the lower foot is nearer to the ground than the ground height taken: a dip is not the ground.
const DIPS: f32 = 0.25;
/// Ground speed below this, m/s, is standing.
const STANDING: f32 = 0.08;
/// Seconds below which a gap in a stance is noise, and below which a stance is.
const GAP: f32 = 0.03;
/// Shares of a loop below which a gap in a stance is noise, and below which a stance is: a swing takes a third of a
/// stride, a sprinter's stance a quarter.
const LOOP: (f32, f32) = (0.1, 0.08);
/// Share of the time that a foot is low and goes the ground's way in which it goes at its speed: with less, the clip is too
/// fanciful to tell stances by speed.
const EVEN: f32 = 0.7;
/// Share of the ground's speed from which on a low foot goes its way.
const ALONG: f32 = 0.25;
/// Metres over the ground that the lower foot rises to in a flight at least: a run's is over it by some centimetres.
const FLIGHT: f32 = 0.012;
/// Metres over the model's ground plane above which the lower sole is in the air for good.
const AIRBORNE: f32 = 0.1;

/// Sole points over the clip.
pub(super) struct Track {
    duration: f32,
    looping: bool,
    /// Size of the character against [`LEG`].
    size: f32,
    /// By sample, foot, point: position in model space, turned with the root.
    points: Vec<[[Vec3; 3]; 2]>,
    /// Turn of the root over the clip.
    whole_turn: Quat,
    /// Horizontal velocity of the hips over the clip, m/s: root motion left in the clip.
    drift: Vec3,
    /// Largest angular speed of a leg's joint, rad/s.
    leg_speed: f32,
    /// By sample: height of the middle between both hip joints.
    hips: Vec<f32>,
}

impl Track {
    /// Samples `clip`, its root turned evenly by `angle` radians about +Y.
    pub(super) fn new(clip: &Clip, skeleton: &Skeleton, legs: &[Leg; 2], angle: f32) -> Self {
        let (rate, least, most) = SAMPLES;
        let count = ((clip.duration * rate) as usize).clamp(least, most);
        let mut pose = Pose::rest(skeleton);
        let mut hips = [Vec3::ZERO; 2];
        let mut heights = Vec::with_capacity(count);
        let mut points = Vec::with_capacity(count);
        let mut before: Option<[[Quat; 3]; 2]> = None;
        let mut widest: f32 = 0.0;
        for sample in 0..=count {
            // The last sample is the end itself, not the start again.
            let held = Clip::time_of(sample, count, clip.duration);
            clip.sample_held(skeleton, held, pose.locals_mut());
            pose.update_model(skeleton);
            let turn = from_scaled_axis(Vec3::Y * (angle * sample as f32 / count as f32));
            points.push([0, 1].map(|foot| legs[foot].sole().map(|point| turn * point.position(&pose))));
            let middle = 0.5 * (pose.position(legs[0].upper) + pose.position(legs[1].upper));
            if sample == 0 {
                hips[0] = middle;
            }
            hips[1] = middle;
            heights.push(middle.y);
            let turns = legs.map(|leg| leg.joints().map(|joint| pose.local(joint).rotation));
            if let Some(before) = before.replace(turns) {
                let (now, before) = (turns.as_flattened(), before.as_flattened());
                widest =
                    now.iter().zip(before).map(|(now, before)| angle_between(*now, *before)).fold(widest, f32::max);
            }
        }
        let drift = if clip.duration > 0.0 { (hips[1] - hips[0]) / clip.duration } else { Vec3::ZERO };
        Self {
            duration: clip.duration,
            looping: clip.looping,
            size: (0.5 * (legs[0].length() + legs[1].length()) / LEG).max(1e-3),
            points,
            whole_turn: from_scaled_axis(Vec3::Y * angle),
            drift: Vec3::new(drift.x, 0.0, drift.z),
            leg_speed: if clip.duration > 0.0 { widest * count as f32 / clip.duration } else { 0.0 },
            hips: heights,
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
            let end = self.whole_turn.inverse() * (at(count) - at(count - 1));
            return (at(1) - at(0) + end) / (2.0 * step);
        }
        let (before, after) = (sample.saturating_sub(1), (sample + 1).min(count));
        (at(after) - at(before)) / (step * (after - before) as f32)
    }

    fn height(&self, sample: usize, foot: usize, point: usize) -> f32 {
        self.points[sample][foot][point].y
    }

    /// The lower of heel and ball at a sample. Tips don't count: stylised feet push them through the ground.
    fn lowest(&self, sample: usize, foot: usize) -> usize {
        usize::from(self.height(sample, foot, 1) < self.height(sample, foot, 0))
    }

    pub(super) fn gait(&self) -> Gait {
        Gait { leg_speed: self.leg_speed, heave: self.heave(), ..self.steps() }
    }

    /// Largest vertical acceleration of the hips as frames of [`FRAME`] show it, m/s².
    fn heave(&self) -> f32 {
        let count = self.count();
        let step = ((FRAME * count as f32 / self.duration.max(FRAME)) as usize).max(1);
        let seconds = step as f32 * self.duration.max(1e-3) / count as f32;
        let at = |sample: usize| self.hips[if self.looping { sample % count } else { sample.min(count) }];
        let samples = if self.looping { count } else { count.saturating_sub(2 * step) };
        let bends = (0..samples).map(|sample| at(sample + 2 * step) - 2.0 * at(sample + step) + at(sample));
        bends.map(f32::abs).fold(0.0, f32::max) / (seconds * seconds)
    }

    fn steps(&self) -> Gait {
        let ground = self.ground();
        if ground > AIRBORNE * self.size {
            return Gait { sole_height: [ground; 2], looping: self.looping, strides: 1, ..Gait::default() };
        }
        let mut passing = self
            .ground_velocity(|sample, foot, point| self.height(sample, foot, point) < ground + HEIGHT.1 * self.size);
        let mut stands = [self.stance(0, ground, passing), self.stance(1, ground, passing)];
        // Once more with what stands: swing's low passes no longer count.
        if stands.iter().flatten().any(|stands| *stands) {
            passing = self.ground_velocity(|sample, foot, _| stands[foot][sample % self.count()]);
            stands = [0, 1].map(|foot| self.sharpened(foot, ground, passing, &self.stance(foot, ground, passing)));
            let low = [0, 1].map(|foot| self.low(foot, ground, passing));
            let time = |stands: &[bool]| stands.iter().filter(|stands| **stands).count() as f32;
            let fanciful = |foot: usize| time(&stands[foot]) < EVEN * time(&low[foot]);
            if self.looping && (fanciful(0) || fanciful(1)) {
                passing = self.mean_velocity(&low);
                stands = low;
            }
        }

        if self.looping {
            self.without_false_flight(ground, &mut stands);
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
            median(heights.collect()).unwrap_or(ground)
        });
        let mut gait =
            Gait { velocity, speed: velocity.length(), sole_height, looping: self.looping, ..Gait::default() };
        gait.set_contacts(contact);
        gait.set_speed(gait.speed, self.duration);
        gait
    }

    /// Height of the ground: that of the lower sole, most of the time that it is low.
    fn ground(&self) -> f32 {
        let lower = |sample| {
            let of_foot = |foot| self.height(sample, foot, self.lowest(sample, foot));
            f32::min(of_foot(0), of_foot(1))
        };
        quantile((0..self.points.len()).map(lower).collect(), DIPS).unwrap_or(0.0)
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

    /// By sample: whether the foot is low over ground at height `ground` and goes the way of `passing`, at whatever speed.
    fn low(&self, foot: usize, ground: f32, passing: Vec3) -> Vec<bool> {
        let low = |sample: usize| {
            let point = self.lowest(sample, foot);
            let along = self.velocity(sample, foot, point).dot(passing) > ALONG * passing.length_squared();
            along && self.height(sample, foot, point) < ground + HEIGHT.1 * self.size
        };
        self.without_noise((0..self.count()).map(low).collect())
    }

    /// Horizontal velocity of the ground past the character at which its feet go as far back as in these stances.
    fn mean_velocity(&self, stands: &[Vec<bool>; 2]) -> Vec3 {
        let standing = |foot: usize| (0..self.count()).filter(move |&sample| stands[foot][sample]);
        let of_foot = |foot| standing(foot).map(move |sample| self.velocity(sample, foot, self.lowest(sample, foot)));
        let velocities: Vec<Vec3> = of_foot(0).chain(of_foot(1)).collect();
        let sum: Vec3 = velocities.iter().sum();
        (sum / velocities.len().max(1) as f32).with_y(0.0)
    }

    /// By sample: whether the foot stands on ground at height `ground` that moves with `passing`.
    fn stance(&self, foot: usize, ground: f32, passing: Vec3) -> Vec<bool> {
        let count = self.count();
        let near = |sample: usize, standing: bool| {
            let height = if standing { HEIGHT.1 } else { HEIGHT.0 } * self.size;
            let (slow, share) = SPEED[usize::from(standing)];
            let speed = slow * self.size.sqrt() + share * passing.length();
            self.is_near(sample, foot, ground + height, passing, speed)
        };
        let mut stands = vec![false; count];
        let mut standing = near(0, false);
        // Twice round, so that a loop starts as it ends.
        for step in 0..if self.looping { 2 * count } else { count } {
            let sample = step % count;
            standing = near(sample, standing);
            stands[sample] = standing;
        }
        self.without_noise(stands)
    }

    /// Stances with edges as sharp as the clip is clean: the middle of each tells how still its feet stand.
    fn sharpened(&self, foot: usize, ground: f32, passing: Vec3, stands: &[bool]) -> Vec<bool> {
        let count = stands.len();
        if stands.iter().all(|stands| *stands) {
            return stands.to_vec();
        }
        let mut sharp = vec![false; count];
        for (start, length) in runs(stands, true, self.looping) {
            let middle = start + length / 4..=start + length - 1 - length / 4;
            let (mut heights, mut slips) = (Vec::new(), Vec::new());
            for sample in middle.map(|sample| sample % count) {
                let stillest = (0..3)
                    .filter(|&point| self.height(sample, foot, point) < ground + HEIGHT.1 * self.size)
                    .map(|point| (self.slip(sample, foot, point, passing), self.height(sample, foot, point) - ground))
                    .min_by(|a, b| a.0.total_cmp(&b.0));
                if let Some((slip, height)) = stillest {
                    slips.push(slip);
                    heights.push(height);
                }
            }
            let usual = |values: Vec<f32>| 2.0 * quantile(values, 0.9).unwrap_or(0.0);
            let height = usual(heights).clamp(SHARP.0 * self.size, HEIGHT.1 * self.size);
            let (least, most) = (SHARP.1 * self.size.sqrt() + SHARP.2 * passing.length(), SPEED[1]);
            let most = most.0 * self.size.sqrt() + most.1 * passing.length();
            let speed = usual(slips).clamp(least, most);
            let near = |sample: &usize| self.is_near(*sample % count, foot, ground + height, passing, speed);
            let mut run = start..start + length;
            if let (Some(first), last) = (run.find(near), run.rfind(near)) {
                (first..=last.unwrap_or(first)).for_each(|sample| sharp[sample % count] = true);
            }
        }
        self.without_noise(sharp)
    }

    /// Whether a point of the sole is below `height` and slower than `speed` against the ground.
    fn is_near(&self, sample: usize, foot: usize, height: f32, passing: Vec3, speed: f32) -> bool {
        (0..3).any(|point| self.height(sample, foot, point) < height && self.slip(sample, foot, point, passing) < speed)
    }

    /// Horizontal speed of a point against the ground, m/s.
    fn slip(&self, sample: usize, foot: usize, point: usize, passing: Vec3) -> f32 {
        let slip = self.velocity(sample, foot, point) - passing;
        Vec3::new(slip.x, 0.0, slip.z).length()
    }

    /// Gaps and stances too short to be any taken out.
    fn without_noise(&self, mut stands: Vec<bool>) -> Vec<bool> {
        let count = stands.len();
        let least = GAP * self.size.sqrt() / self.duration.max(GAP);
        let samples = |share: f32| ((share * count as f32) as usize).min(count / 4);
        let (gap, stance) = if self.looping { (least.max(LOOP.0), least.max(LOOP.1)) } else { (least, least) };
        clean(&mut stands, false, samples(gap), self.looping);
        clean(&mut stands, true, samples(stance), self.looping);
        stands
    }

    /// Who flies has both feet off the ground at some moment. Where a clip only drags them over it, or pushes them into it, the
    /// foot that stood stands on as long as it is low, and then the other, at whatever speed they go.
    fn without_false_flight(&self, ground: f32, stands: &mut [Vec<bool>; 2]) {
        let count = self.count();
        let flight = ground + FLIGHT * self.size;
        let low = |sample: usize, foot: usize| (0..3).any(|point| self.height(sample, foot, point) < flight);
        let in_air: Vec<bool> = (0..count).map(|sample| !stands[0][sample] && !stands[1][sample]).collect();
        for (start, length) in runs(&in_air, true, true).filter(|&(_, length)| length < count) {
            let gap = || (start..start + length).map(|sample| sample % count);
            let last = usize::from(stands[1][(start + count - 1) % count]);
            let next = usize::from(stands[1][(start + length) % count]);
            let stays = gap().take_while(|&sample| low(sample, last)).count();
            if gap().skip(stays).all(|sample| low(sample, next)) {
                gap().take(stays).for_each(|sample| stands[last][sample] = true);
                gap().skip(stays).for_each(|sample| stands[next][sample] = true);
            }
        }
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

fn median(values: Vec<f32>) -> Option<f32> {
    quantile(values, 0.5)
}

/// The value that a `share` of `values` lies below.
fn quantile(mut values: Vec<f32>, share: f32) -> Option<f32> {
    values.sort_by(f32::total_cmp);
    let place = share * values.len().saturating_sub(1) as f32;
    let (below, above) = (values.get(place as usize)?, values.get(place.ceil() as usize)?);
    Some(below + (above - below) * place.fract())
}
