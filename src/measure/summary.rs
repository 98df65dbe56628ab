//! Figures from recorded frames. Pure. Definitions: see each field of [`Measures`]; lengths in the unit that its name says.

use bevy::{math::ops, prelude::*};

/// One foot in one frame, world space, metres.
#[derive(Clone, Copy, Debug, Default)]
pub struct FootFrame {
    /// Heel, ball and toe tip of the final pose.
    pub sole: [Vec3; 3],
    /// Ground height below each of them; `None` over an abyss.
    pub ground: [Option<f32>; 3],
    /// The ball in the frame of the ground that it is planted on, while it is planted on the ball.
    pub planted_ball: Option<Vec3>,
    /// Whether the foot is in stance.
    pub stance: bool,
    /// Metres by which the ankle missed its target.
    pub missed: f32,
    /// Distance from hip to ankle over the leg's length.
    pub extension: f32,
    /// Bend of the knee in radians, negative when bent backward.
    pub knee: f32,
}

/// One frame of one character.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Seconds since the recording began.
    pub time: f32,
    /// Left and right foot.
    pub feet: [FootFrame; 2],
    /// World height of the pelvis joint.
    pub pelvis: f32,
    /// World position of the root.
    pub root: Vec3,
    /// Whether the character stands on ground.
    pub grounded: bool,
    /// Largest angular speed of any joint against its parent, rad/s.
    pub joint_speed: f32,
    /// Largest change, since the last frame, of any joint's velocity in model space, m/s.
    pub velocity_jump: f32,
}

/// What a run measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// Per stance the largest horizontal travel of the planted ball in the ground's frame, mm: the median stance.
    pub drift_median: f32,
    /// The same, 95th percentile.
    pub drift_p95: f32,
    /// The same, worst stance.
    pub drift_max: f32,
    /// Mean over frames of v · (2 − 2^clamp(h/2.5 cm, 0, 1)), v the horizontal speed of the lowest sole point and h its
    /// height over ground, cm/s (Zhang et al. 2018, "Mode-Adaptive Neural Networks", 8.1).
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
    /// Vertical acceleration of the pelvis, m/s², 99th percentile.
    pub pelvis_p99: f32,
    /// The largest.
    pub pelvis_max: f32,
    /// Distance by which an ankle missed its target, mm, mean.
    pub reach_mean: f32,
    /// The largest.
    pub reach_max: f32,
    /// Largest angular speed of a joint, degrees/s.
    pub joint_speed_max: f32,
    /// Largest change of a joint's model-space velocity from frame to frame, m/s.
    pub velocity_jump_max: f32,
    /// How many stances the figures come from.
    pub stances: usize,
}

/// Height in metres below which a foot's sliding counts.
const SKATE_HEIGHT: f32 = 0.025;

/// Figures of a run, in order of time.
#[must_use]
pub fn summarize(frames: &[Frame]) -> Measures {
    let mut drifts = drifts(frames);
    let mut penetration = Vec::new();
    let mut float = Vec::new();
    let mut reach = Vec::new();
    let mut knee_change = 0.0f32;
    let mut hyperextended = 0;
    let mut extension: f32 = 0.0;
    for frame in frames {
        for foot in &frame.feet {
            let depth = heights(foot).map(|height| -height).fold(0.0f32, f32::max);
            penetration.push(depth * 1000.0);
            if foot.stance
                && frame.grounded
                && let Some(lowest) = heights(foot).min_by(f32::total_cmp)
            {
                float.push(lowest.max(0.0) * 1000.0);
            }
            reach.push(foot.missed * 1000.0);
            extension = extension.max(foot.extension);
            hyperextended += usize::from(foot.knee < -0.5f32.to_radians());
        }
    }
    for pair in frames.windows(2) {
        let dt = (pair[1].time - pair[0].time).max(1e-4);
        for (before, after) in pair[0].feet.iter().zip(&pair[1].feet) {
            let per_frame = (after.knee - before.knee).abs() / dt / 60.0;
            knee_change = knee_change.max(per_frame.to_degrees());
        }
    }
    let mut accelerations: Vec<f32> = frames
        .windows(3)
        .map(|f| {
            let (a, b) = ((f[1].time - f[0].time).max(1e-4), (f[2].time - f[1].time).max(1e-4));
            (((f[2].pelvis - f[1].pelvis) / b - (f[1].pelvis - f[0].pelvis) / a) / (0.5 * (a + b))).abs()
        })
        .collect();
    let mean = |values: &[f32]| if values.is_empty() { 0.0 } else { values.iter().sum::<f32>() / values.len() as f32 };
    Measures {
        stances: drifts.len(),
        drift_median: percentile(&mut drifts, 0.5),
        drift_p95: percentile(&mut drifts, 0.95),
        drift_max: percentile(&mut drifts, 1.0),
        skate: skate(frames),
        penetration_p99: percentile(&mut penetration, 0.99),
        penetration_max: percentile(&mut penetration, 1.0),
        float_p95: percentile(&mut float, 0.95),
        knee_hyperextended: hyperextended,
        knee_change,
        extension_max: extension,
        pelvis_p99: percentile(&mut accelerations, 0.99),
        pelvis_max: percentile(&mut accelerations, 1.0),
        reach_mean: mean(&reach),
        reach_max: percentile(&mut reach, 1.0),
        joint_speed_max: frames.iter().map(|f| f.joint_speed).fold(0.0, f32::max).to_degrees(),
        velocity_jump_max: frames.iter().map(|f| f.velocity_jump).fold(0.0, f32::max),
    }
}

/// Heights of the sole's points over the ground below them, metres.
fn heights(foot: &FootFrame) -> impl Iterator<Item = f32> {
    foot.sole.iter().zip(foot.ground).filter_map(|(point, ground)| ground.map(|ground| point.y - ground))
}

/// Per stance the largest horizontal distance of the planted ball from where it was planted, mm.
fn drifts(frames: &[Frame]) -> Vec<f32> {
    let mut stances = Vec::new();
    for side in 0..2 {
        let mut start: Option<Vec3> = None;
        let mut furthest = 0.0f32;
        for foot in frames.iter().map(|frame| &frame.feet[side]) {
            match (foot.planted_ball, start) {
                (Some(ball), Some(first)) => furthest = furthest.max((ball - first).with_y(0.0).length() * 1000.0),
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

fn skate(frames: &[Frame]) -> f32 {
    let (mut sum, mut count) = (0.0f32, 0usize);
    for pair in frames.windows(2) {
        let dt = (pair[1].time - pair[0].time).max(1e-4);
        for (before, after) in pair[0].feet.iter().zip(&pair[1].feet) {
            let heights = after.sole.iter().zip(after.ground).enumerate();
            let lowest = heights.filter_map(|(i, (p, g))| g.map(|g| (i, p.y - g))).min_by(|a, b| a.1.total_cmp(&b.1));
            let Some((point, height)) = lowest else { continue };
            let speed = (after.sole[point] - before.sole[point]).with_y(0.0).length() / dt;
            let share = 2.0 - ops::exp2((height / SKATE_HEIGHT).clamp(0.0, 1.0));
            sum += speed * share * 100.0;
            count += 1;
        }
    }
    if count == 0 { 0.0 } else { sum / count as f32 }
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

    #[test]
    fn a_sliding_foot_drifts_and_skates() {
        let frames: Vec<Frame> = (0..61).map(|i| frame(i as f32 / 60.0, i as f32 * 0.001, 0.0)).collect();
        let got = summarize(&frames);
        assert!((got.drift_max - 60.0).abs() < 0.1, "drift {} mm", got.drift_max);
        assert!((got.skate - 6.0).abs() < 0.1, "skate {} cm/s", got.skate);
    }

    #[test]
    fn a_sunk_foot_penetrates_and_a_raised_one_floats() {
        let sunk: Vec<Frame> = (0..10).map(|i| frame(i as f32 / 60.0, 0.0, -0.02)).collect();
        assert!((summarize(&sunk).penetration_max - 20.0).abs() < 1e-3);
        let raised: Vec<Frame> = (0..10).map(|i| frame(i as f32 / 60.0, 0.0, 0.03)).collect();
        assert!((summarize(&raised).float_p95 - 30.0).abs() < 1e-3);
    }
}
