//! Figures from recorded frames. Pure. Definitions: see each field of [`Measures`]; lengths in the unit that its name says.

use bevy::{math::ops, prelude::*};

use super::{
    frame::{FootFrame, Frame},
    pelvis::accelerations,
    start::{Starts, starts},
};

/// What a run measured. `None`: nothing in the run could be measured so.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// Per stance the largest horizontal travel of the planted ball in the ground's frame, mm: the median stance.
    pub drift_median: f32,
    /// The same, 95th percentile.
    pub drift_p95: f32,
    /// The same, worst stance.
    pub drift_max: f32,
    /// Mean over frames of v · (2 − 2^clamp(h/2.5 cm, 0, 1)), v the horizontal speed over the ground of the lowest sole
    /// point of both feet (the mean of those within 1 mm of it) and h its height halfway through the frame, cm/s.
    ///
    /// After Zhang et al. 2018, "Mode-Adaptive Neural Networks", 8.1.
    pub skate: f32,
    /// Depth of sole points under ground, mm, 99th percentile of frames.
    pub penetration_p99: f32,
    /// The deepest, mm.
    pub penetration_max: f32,
    /// Height of the lowest sole point over ground in stance, mm, 95th percentile.
    pub float_p95: f32,
    /// Frames with a knee bent backward.
    pub knee_hyperextended: usize,
    /// Largest change of a knee, degrees per 1/60 s.
    pub knee_change: f32,
    /// Largest distance from hip to ankle over the leg's length.
    pub extension_max: f32,
    /// Largest angular speed of a joint over the largest of the clips then playing.
    ///
    /// While no gait plays, half of the slowest gait counts: feet step where the ground or a turn asks for it.
    pub pop_speed: f32,
    /// Largest change of a joint's model-space velocity from frame to frame, over the largest of the clips then playing.
    pub pop_jump: f32,
    /// Vertical acceleration of the pelvis, m/s², 99th percentile; without jumps, falls and their landings.
    pub pelvis_p99: f32,
    /// The largest.
    pub pelvis_max: f32,
    /// The largest within 0.3 s after a landing from a jump or fall.
    pub pelvis_landing: Option<f32>,
    /// Distance by which an ankle missed a target within the leg's reach, mm, mean.
    pub reach_mean: Option<f32>,
    /// The largest.
    pub reach_max: Option<f32>,
    /// Frames from an intent to the first change of the pose of one who stands, that frame included; the slowest start.
    pub start_frames: Option<f32>,
    /// Seconds until 63 % of a walk's speed; the slowest start.
    pub walk_63: Option<f32>,
    /// Seconds until 90 % of a walk's speed.
    pub walk_90: Option<f32>,
    /// Seconds until 63 % of a run's speed; the slowest start.
    pub run_63: Option<f32>,
    /// Seconds until 90 % of a run's speed.
    pub run_90: Option<f32>,
    /// How many stances the figures come from.
    pub stances: usize,
}

/// Height in metres below which a foot's sliding counts.
const SKATE_HEIGHT: f32 = 0.025;
/// Metres within which sole points count as equally low.
const SAME_HEIGHT: f32 = 0.001;
/// Bend in radians from which a knee is bent backward; rounding is less.
const BACKWARD: f32 = -0.5 * core::f32::consts::PI / 180.0;

/// Seconds over which the change of a knee is told.
const KNEE_STEP: f32 = 1.0 / 60.0;

/// Figures of a run, in order of time.
#[must_use]
pub fn summarize(frames: &[Frame]) -> Measures {
    summarize_all(&[frames])
}

/// Figures of several runs together, each in order of time.
#[must_use]
pub fn summarize_all(runs: &[&[Frame]]) -> Measures {
    let frames = || runs.iter().copied().flatten();
    let feet = || frames().flat_map(|frame| &frame.feet);
    let mut drifts: Vec<f32> = runs.iter().flat_map(|run| drifts(run)).collect();
    let depth = |heights: &mut dyn Iterator<Item = f32>| heights.map(|height| -height).fold(0.0f32, f32::max);
    let mut penetration: Vec<f32> = feet().map(|foot| depth(&mut foot.heights()) * 1000.0).collect();
    let stances = frames().filter(|frame| frame.grounded).flat_map(|frame| &frame.feet).filter(|foot| foot.stance);
    let mut float: Vec<f32> = stances.filter_map(FootFrame::lowest).map(|(_, h)| h.max(0.0) * 1000.0).collect();
    let mut reach: Vec<f32> = feet().filter_map(|foot| foot.missed).map(|missed| missed * 1000.0).collect();
    let reach_mean = (!reach.is_empty()).then(|| reach.iter().sum::<f32>() / reach.len() as f32);
    let (mut pelvis, mut landing) = (Vec::new(), None);
    for run in runs {
        let found = accelerations(run);
        pelvis.extend(found.on_ground);
        landing = found.landing.into_iter().chain(landing).reduce(f32::max);
    }
    let starts = runs.iter().map(|run| starts(run)).fold(Starts::default(), Starts::slowest);
    let largest = |of: &dyn Fn(&Frame) -> f32| frames().map(of).fold(0.0, f32::max);
    Measures {
        stances: drifts.len(),
        drift_median: percentile(&mut drifts, 0.5),
        drift_p95: percentile(&mut drifts, 0.95),
        drift_max: percentile(&mut drifts, 1.0),
        skate: skate(runs),
        penetration_p99: percentile(&mut penetration, 0.99),
        penetration_max: percentile(&mut penetration, 1.0),
        float_p95: percentile(&mut float, 0.95),
        knee_hyperextended: feet().filter(|foot| foot.knee < BACKWARD).count(),
        knee_change: knee_change(runs),
        extension_max: feet().map(|foot| foot.extension).fold(0.0, f32::max),
        pop_speed: largest(&|frame| over(frame.joint_speed, frame.peak.joint_speed)),
        pop_jump: largest(&|frame| over(frame.velocity_jump, frame.peak.velocity_jump)),
        pelvis_p99: percentile(&mut pelvis, 0.99),
        pelvis_max: percentile(&mut pelvis, 1.0),
        pelvis_landing: landing,
        reach_mean,
        reach_max: reach_mean.map(|_| percentile(&mut reach, 1.0)),
        start_frames: starts.frames,
        walk_63: starts.walk.map(|[most, _]| most),
        walk_90: starts.walk.map(|[_, nearly]| nearly),
        run_63: starts.run.map(|[most, _]| most),
        run_90: starts.run.map(|[_, nearly]| nearly),
    }
}

/// `value` over `reference`; 0 where no clip says what is usual.
fn over(value: f32, reference: f32) -> f32 {
    if reference > 0.0 { value / reference } else { 0.0 }
}

/// Largest change of a knee, degrees per 1/60 s; at higher frame rates over as many frames as that takes.
fn knee_change(runs: &[&[Frame]]) -> f32 {
    let mut largest = 0.0f32;
    for run in runs {
        let mut first = 0;
        for frame in *run {
            while run.get(first + 1).is_some_and(|next| next.time <= frame.time - 0.99 * KNEE_STEP) {
                first += 1;
            }
            let before = &run[first];
            let share = (frame.time - before.time) / KNEE_STEP;
            if share > 0.9 {
                let changes = before.feet.iter().zip(&frame.feet).map(|(a, b)| (b.knee - a.knee).abs() / share);
                largest = changes.fold(largest, f32::max);
            }
        }
    }
    largest.to_degrees()
}

/// Per stance the largest horizontal distance of the planted ball from where it was planted, mm.
fn drifts(frames: &[Frame]) -> Vec<f32> {
    let mut stances = Vec::new();
    for side in 0..2 {
        let mut start: Option<Vec3> = None;
        let mut furthest = 0.0f32;
        for foot in frames.iter().map(|frame| &frame.feet[side]) {
            match (foot.planted_ball, start) {
                (Some(ball), Some(first)) => furthest = furthest.max((ball - first).length() * 1000.0),
                (Some(ball), None) => {
                    start = Some(ball);
                    furthest = 0.0;
                }
                (None, Some(_)) => {
                    stances.push(furthest);
                    start = None;
                }
                (None, None) => {}
            }
        }
        if start.is_some() {
            stances.push(furthest);
        }
    }
    stances
}

fn skate(runs: &[&[Frame]]) -> f32 {
    let (mut sum, mut count) = (0.0f32, 0usize);
    for pair in runs.iter().flat_map(|run| run.windows(2)) {
        let dt = (pair[1].time - pair[0].time).max(1e-4);
        // One foot of a walker stands while the other passes close over the ground: the lowest points are asked.
        let points = || pair[0].feet.iter().zip(&pair[1].feet).flat_map(|(before, after)| steps(before, after));
        let lowest = points().map(|(height, _)| height).fold(f32::MAX, f32::min);
        let (mut slid, mut asked) = (0.0f32, 0usize);
        for (height, moved) in points().filter(|(height, _)| *height <= lowest + SAME_HEIGHT) {
            let share = 2.0 - ops::exp2((height / SKATE_HEIGHT).clamp(0.0, 1.0));
            slid += moved.with_y(0.0).length() / dt * share * 100.0;
            asked += 1;
        }
        if asked > 0 {
            sum += slid / asked as f32;
            count += 1;
        }
    }
    if count == 0 { 0.0 } else { sum / count as f32 }
}

/// Of each point of a sole: its mean height in two frames, and how far it moved over the ground between them, metres.
fn steps(before: &FootFrame, after: &FootFrame) -> impl Iterator<Item = (f32, Vec3)> {
    (0..3).filter_map(move |point| {
        let [first, second] = [before, after].map(|foot| Some(foot.sole[point].y - foot.ground[point]?));
        Some((0.5 * (first? + second?), after.sole[point] - before.sole[point] - after.carried[point]))
    })
}

/// The value below which `share` of all values lie; 0 of none. Sorts `values`.
fn percentile(values: &mut [f32], share: f32) -> f32 {
    if values.is_empty() {
        return 0.0;
    }
    values.sort_by(f32::total_cmp);
    let index = ((values.len() - 1) as f32 * share).round() as usize;
    values[index]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::Peak;

    fn frame(time: f32, x: f32, height: f32) -> Frame {
        let foot = FootFrame {
            sole: [Vec3::new(x, height, 0.0); 3],
            ground: [Some(0.0); 3],
            planted_ball: Some(Vec3::new(x, 0.0, 0.0)),
            stance: true,
            ..default()
        };
        Frame { time, feet: [foot; 2], grounded: true, ..default() }
    }

    fn frames(count: usize, of: impl Fn(usize) -> Frame) -> Vec<Frame> {
        (0..count).map(of).collect()
    }

    #[test]
    fn a_sliding_foot_drifts_and_skates() {
        let got = summarize(&frames(61, |i| frame(i as f32 / 60.0, i as f32 * 0.001, 0.0)));
        assert!((got.drift_max - 60.0).abs() < 0.1, "drift {} mm", got.drift_max);
        assert!((got.skate - 6.0).abs() < 0.1, "skate {} cm/s", got.skate);
    }

    #[test]
    fn a_foot_that_rides_on_its_ground_does_not_skate() {
        let got = summarize(&frames(61, |i| {
            let mut frame = frame(i as f32 / 60.0, i as f32 * 0.01, 0.0);
            frame.feet.iter_mut().for_each(|foot| foot.carried = [Vec3::X * 0.01; 3]);
            frame
        }));
        assert!(got.skate < 1e-3, "skate {} cm/s", got.skate);
    }

    #[test]
    fn a_sunk_foot_penetrates_and_a_raised_one_floats() {
        let sunk = frames(10, |i| frame(i as f32 / 60.0, 0.0, -0.02));
        assert!((summarize(&sunk).penetration_max - 20.0).abs() < 1e-3);
        let raised = frames(10, |i| frame(i as f32 / 60.0, 0.0, 0.03));
        assert!((summarize(&raised).float_p95 - 30.0).abs() < 1e-3);
    }

    #[test]
    fn a_pop_is_told_against_the_clips_then_playing() {
        let lively = Peak { joint_speed: 8.0, velocity_jump: 0.5 };
        let calm = Peak { joint_speed: 2.0, velocity_jump: 0.1 };
        let got = summarize(&frames(9, |i| {
            let peak = if i < 5 { lively } else { calm };
            Frame { peak, joint_speed: peak.joint_speed, velocity_jump: 0.3, ..frame(i as f32 / 60.0, 0.0, 0.0) }
        }));
        assert!((got.pop_speed - 1.0).abs() < 1e-5, "angular speed {} of the clips'", got.pop_speed);
        assert!((got.pop_jump - 3.0).abs() < 1e-5, "velocity jump {} of the clips'", got.pop_jump);
    }

    #[test]
    fn without_targets_there_is_no_reach_to_miss() {
        assert_eq!(summarize(&frames(5, |i| frame(i as f32 / 60.0, 0.0, 0.0))).reach_max, None);
        let missed = summarize(&frames(5, |i| {
            let mut frame = frame(i as f32 / 60.0, 0.0, 0.0);
            frame.feet[0].missed = Some(0.004);
            frame
        }));
        assert!((missed.reach_max.unwrap() - 4.0).abs() < 1e-4, "missed by {:?} mm", missed.reach_max);
    }
}
