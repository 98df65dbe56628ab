//! What a comparison found, as numbers and as a table. Pure.

use core::fmt;
use std::collections::BTreeMap;

/// Millimetres a joint may be off, on a figure 1.8 m high.
pub const MAX_MILLIMETRES: f32 = 0.1;
/// Degrees a joint may be off.
pub const MAX_DEGREES: f32 = 0.05;
/// Share by which an axis of a joint may be too long or too short, and by which a morph weight may be off.
pub const MAX_SHARE: f32 = 1e-3;

/// How far a joint is from where it should be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct JointError {
    /// Distance on a figure 1.8 m high.
    pub millimetres: f32,
    /// Angle between the two rotations in model space.
    pub degrees: f32,
    /// Difference in length of an axis, as a share of the longest.
    pub scale: f32,
    /// Difference of a morph weight of the joint's mesh.
    pub weights: f32,
}

impl JointError {
    /// The larger of each figure. NaN counts as infinitely large.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        let larger = |a: f32, b: f32| if a.is_nan() || b.is_nan() { f32::INFINITY } else { a.max(b) };
        Self {
            millimetres: larger(self.millimetres, other.millimetres),
            degrees: larger(self.degrees, other.degrees),
            scale: larger(self.scale, other.scale),
            weights: larger(self.weights, other.weights),
        }
    }

    /// Whether no figure is beyond its bound.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.millimetres <= MAX_MILLIMETRES && self.degrees <= MAX_DEGREES && self.scale.max(self.weights) <= MAX_SHARE
    }
}

/// One clip, judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judged {
    /// Its name.
    pub clip: String,
    /// Largest error against the engine, over all joints that it can play.
    pub engine: JointError,
    /// Largest error against the exact evaluation, over all joints.
    pub exact: JointError,
    /// Largest error against the exact evaluation, over the joints that the engine cannot play.
    pub stand_in: JointError,
    /// Joints that the engine cannot play, and why.
    pub blind: BTreeMap<String, &'static str>,
}

impl Judged {
    /// A joint that the engine cannot play, held against the exact evaluation.
    pub(super) fn stand_in(&mut self, joint: &str, reason: Option<&'static str>, error: JointError) {
        self.stand_in = self.stand_in.max(error);
        self.blind.entry(joint.to_owned()).or_insert(reason.unwrap_or("it was not spawned"));
    }

    /// Largest error against the engine, or against what stands in for it.
    #[must_use]
    pub fn error(&self) -> JointError {
        self.engine.max(self.stand_in)
    }
}

/// All clips of a file, judged. As text: a line a clip, and last `max joint error X mm, Y deg`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// Joints of the file's skeleton.
    pub joints: usize,
    /// Why the engine cannot load the file; then exact curves stand in for all of it.
    pub refusal: Option<String>,
    /// One a clip; the rest pose where there is none.
    pub clips: Vec<Judged>,
}

impl Comparison {
    /// Largest error of all.
    #[must_use]
    pub fn error(&self) -> JointError {
        self.clips.iter().fold(JointError::default(), |sum, clip| sum.max(clip.error()))
    }

    /// Whether all errors are within bounds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.error().holds()
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:32} {:>22} {:>22}", "clip", "against the engine", "against exact curves")?;
        for clip in &self.clips {
            let [engine, exact] =
                [clip.engine, clip.exact].map(|error| format!("{:.4} mm, {:.4} deg", error.millimetres, error.degrees));
            let played = self.joints - clip.blind.len().min(self.joints);
            let engine = if played == 0 || self.refusal.is_some() { "not played".to_owned() } else { engine };
            let mark = if clip.error().holds() { "" } else { "  <- beyond bounds" };
            writeln!(f, "{:32} {engine:>22} {exact:>22}{mark}", clip.clip)?;
            for (what, share) in [("lengths of axes", clip.error().scale), ("morph weights", clip.error().weights)] {
                if share > MAX_SHARE {
                    writeln!(f, "    {what} off by {share:.4}")?;
                }
            }
        }
        if let Some(reason) = &self.refusal {
            writeln!(f, "the engine cannot play any of it: {reason}; exact curves stand in")?;
        }
        let mut told: BTreeMap<&'static str, Vec<&str>> = BTreeMap::new();
        for (joint, reason) in self.clips.iter().flat_map(|clip| &clip.blind) {
            let joints = told.entry(reason).or_default();
            if !joints.contains(&joint.as_str()) {
                joints.push(joint);
            }
        }
        for (reason, joints) in told {
            let named = joints.iter().take(3).copied().collect::<Vec<_>>().join("`, `");
            let more = if joints.len() > 3 { format!(" and {} more", joints.len() - 3) } else { String::new() };
            writeln!(f, "the engine cannot play `{named}`{more}: {reason}; exact curves stand in")?;
        }
        let worst = self.error();
        write!(f, "max joint error {:.4} mm, {:.4} deg", worst.millimetres, worst.degrees)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(millimetres: f32, degrees: f32) -> Judged {
        Judged { engine: JointError { millimetres, degrees, ..JointError::default() }, ..Judged::default() }
    }

    #[test]
    fn the_last_line_holds_the_largest_figures_of_all_clips() {
        let comparison = Comparison { joints: 3, refusal: None, clips: vec![judged(0.02, 0.03), judged(0.05, 0.01)] };
        let text = comparison.to_string();
        assert_eq!(text.lines().last(), Some("max joint error 0.0500 mm, 0.0300 deg"), "{text}");
        assert!(comparison.holds(), "{text}");
    }

    #[test]
    fn a_figure_beyond_its_bound_or_not_a_number_does_not_hold() {
        for (millimetres, degrees) in [(0.11, 0.0), (0.0, 0.051), (f32::NAN, 0.0)] {
            let comparison = Comparison { joints: 3, refusal: None, clips: vec![judged(millimetres, degrees)] };
            assert!(!comparison.holds(), "{millimetres} mm, {degrees} deg hold");
        }
    }

    #[test]
    fn joints_that_the_engine_cannot_play_are_named_with_the_reason() {
        let mut clip = judged(0.0, 0.0);
        clip.stand_in("tail", Some("no scene holds it"), JointError { millimetres: 0.2, ..JointError::default() });
        let comparison = Comparison { joints: 3, refusal: None, clips: vec![clip] };
        let text = comparison.to_string();
        assert!(text.contains("`tail`: no scene holds it; exact curves stand in"), "{text}");
        assert!(!comparison.holds(), "0.2 mm against the exact curves hold:\n{text}");
    }
}
