//! How far each measure may go, and which went too far. Pure.

use core::fmt::{self, Display, Formatter};

use super::{summary::Measures, table::short};

/// The most that each measure may be. Units as in [`Measures`].
#[derive(Clone, Debug, PartialEq)]
pub struct Bars {
    /// Plant drift of the median stance, mm. Default 1.
    pub drift_median: f32,
    /// Plant drift, 95th percentile, mm. Default 5.
    pub drift_p95: f32,
    /// Plant drift of the worst stance, mm. Default 20.
    pub drift_max: f32,
    /// Skate, cm/s. Default 2; 1 on [`Bars::flat`] ground.
    pub skate: f32,
    /// Penetration, 99th percentile, mm. Default 5.
    pub penetration_p99: f32,
    /// Penetration, mm. Default 15.
    pub penetration_max: f32,
    /// Float, 95th percentile, mm. Default 10.
    pub float_p95: f32,
    /// Frames with a knee bent backward. Default 0.
    pub knee_hyperextended: f32,
    /// Change of a knee, degrees per 1/60 s. Default 24.
    pub knee_change: f32,
    /// Hip to ankle over the leg's length. Default 0.995.
    pub extension: f32,
    /// Angular speed of a joint over the clips'. Default 2.
    pub pop_speed: f32,
    /// Velocity jump of a joint over the clips'. Default 2.
    pub pop_jump: f32,
    /// Pelvis acceleration, 99th percentile, m/s². Default 15.
    pub pelvis_p99: f32,
    /// Pelvis acceleration, m/s². Default 30.
    pub pelvis_max: f32,
    /// Pelvis acceleration in landings, m/s². Default 60.
    pub pelvis_landing: f32,
    /// Reach missed on average, mm. Default 1.
    pub reach_mean: f32,
    /// Reach missed, mm. Default 5.
    pub reach_max: f32,
    /// Frames to the first change of the pose. Default 2.
    pub start_frames: f32,
    /// Seconds to 63 % of a walk. Default 0.2.
    pub walk_63: f32,
    /// Seconds to 90 % of a walk. Default 0.4.
    pub walk_90: f32,
    /// Seconds to 63 % of a run. Default 0.35.
    pub run_63: f32,
    /// Seconds to 90 % of a run. Default 0.6.
    pub run_90: f32,
}

impl Default for Bars {
    fn default() -> Self {
        Self {
            drift_median: 1.0,
            drift_p95: 5.0,
            drift_max: 20.0,
            skate: 2.0,
            penetration_p99: 5.0,
            penetration_max: 15.0,
            float_p95: 10.0,
            knee_hyperextended: 0.0,
            knee_change: 24.0,
            extension: 0.995,
            pop_speed: 2.0,
            pop_jump: 2.0,
            pelvis_p99: 15.0,
            pelvis_max: 30.0,
            pelvis_landing: 60.0,
            reach_mean: 1.0,
            reach_max: 5.0,
            start_frames: 2.0,
            walk_63: 0.2,
            walk_90: 0.4,
            run_63: 0.35,
            run_90: 0.6,
        }
    }
}

/// One measure and the most it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Its name for machines, unit included.
    pub key: &'static str,
    /// Its name for people.
    pub name: &'static str,
    /// Unit of value and limit.
    pub unit: &'static str,
    /// What was measured; `None` where nothing could be.
    pub value: Option<f32>,
    /// The most it may be.
    pub limit: f32,
}

/// Share of a limit that rounding may add.
const ROUNDING: f32 = 1e-4;

impl Row {
    /// Whether it stays below its bar.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.value.is_none_or(|value| value <= self.limit * (1.0 + ROUNDING))
    }
}

/// A measure over its bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breach {
    /// Its name for people.
    pub name: &'static str,
    /// Unit of value and limit.
    pub unit: &'static str,
    /// What was measured.
    pub value: f32,
    /// The most it may be.
    pub limit: f32,
}

impl Display for Breach {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { name, unit, value, limit } = self;
        write!(f, "{name}: {} {unit}, bar {} {unit}", short(*value), short(*limit))
    }
}

impl Bars {
    /// For level ground, where feet have no reason to slide at all.
    #[must_use]
    pub fn flat() -> Self {
        Self { skate: 1.0, ..Self::default() }
    }

    /// Every measure beside its bar, in the order of tables.
    #[must_use]
    #[rustfmt::skip]
    pub fn rows(&self, m: &Measures) -> [Row; 22] {
        let row = |key, name, unit, value, limit| Row { key, name, unit, value, limit };
        [
            row("drift_median_mm", "plant drift, median", "mm", Some(m.drift_median), self.drift_median),
            row("drift_p95_mm", "plant drift, p95", "mm", Some(m.drift_p95), self.drift_p95),
            row("drift_max_mm", "plant drift, max", "mm", Some(m.drift_max), self.drift_max),
            row("skate_cm_s", "skate", "cm/s", Some(m.skate), self.skate),
            row("penetration_p99_mm", "penetration, p99", "mm", Some(m.penetration_p99), self.penetration_p99),
            row("penetration_max_mm", "penetration, max", "mm", Some(m.penetration_max), self.penetration_max),
            row("float_p95_mm", "float, p95", "mm", Some(m.float_p95), self.float_p95),
            row("knee_backward_frames", "knee bent backward", "frames", Some(m.knee_hyperextended as f32), self.knee_hyperextended),
            row("knee_change_deg", "knee change, max", "°/frame", Some(m.knee_change), self.knee_change),
            row("leg_extension", "leg extension, max", "of leg", Some(m.extension_max), self.extension),
            row("pop_speed", "pop, angular speed", "of clips", Some(m.pop_speed), self.pop_speed),
            row("pop_jump", "pop, velocity jump", "of clips", Some(m.pop_jump), self.pop_jump),
            row("pelvis_p99_m_s2", "pelvis acceleration, p99", "m/s²", Some(m.pelvis_p99), self.pelvis_p99),
            row("pelvis_max_m_s2", "pelvis acceleration, max", "m/s²", Some(m.pelvis_max), self.pelvis_max),
            row("pelvis_landing_m_s2", "pelvis, landing", "m/s²", m.pelvis_landing, self.pelvis_landing),
            row("reach_mean_mm", "reach missed, mean", "mm", m.reach_mean, self.reach_mean),
            row("reach_max_mm", "reach missed, max", "mm", m.reach_max, self.reach_max),
            row("start_frames", "first pose change", "frames", m.start_frames, self.start_frames),
            row("walk_63_s", "63 % of walking speed", "s", m.walk_63, self.walk_63),
            row("walk_90_s", "90 % of walking speed", "s", m.walk_90, self.walk_90),
            row("run_63_s", "63 % of running speed", "s", m.run_63, self.run_63),
            row("run_90_s", "90 % of running speed", "s", m.run_90, self.run_90),
        ]
    }

    /// The measures over their bars.
    #[must_use]
    pub fn check(&self, measures: &Measures) -> Vec<Breach> {
        let over = self.rows(measures).into_iter().filter(|row| !row.holds());
        over.filter_map(|Row { name, unit, value, limit, .. }| value.map(|value| Breach { name, unit, value, limit }))
            .collect()
    }

    /// For tests: that no measure is over its bar.
    ///
    /// # Panics
    /// When one is; the message names `case` and lists every breach with figure and bar.
    #[track_caller]
    pub fn assert_within(&self, measures: &Measures, case: &str) {
        let breaches = self.check(measures);
        assert!(breaches.is_empty(), "{case}: {}", listed(&breaches));
    }
}

/// Breaches as one sentence.
#[must_use]
pub fn listed(breaches: &[Breach]) -> String {
    breaches.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_measure_over_its_bar_is_named_with_figure_and_bar() {
        let measures = Measures { drift_max: 31.0, skate: 1.5, ..Measures::default() };
        assert_eq!(listed(&Bars::default().check(&measures)), "plant drift, max: 31 mm, bar 20 mm");
        assert_eq!(
            listed(&Bars::flat().check(&measures)),
            "plant drift, max: 31 mm, bar 20 mm; skate: 1.50 cm/s, bar 1 cm/s"
        );
    }

    #[test]
    fn what_was_not_measured_breaks_no_bar_and_nonsense_does() {
        assert!(Bars::flat().check(&Measures::default()).is_empty());
        let broken = Measures { skate: f32::NAN, ..Measures::default() };
        assert_eq!(Bars::flat().check(&broken).len(), 1);
    }

    #[test]
    fn keys_are_unique() {
        let mut keys: Vec<_> = Bars::default().rows(&Measures::default()).iter().map(|row| row.key).collect();
        keys.sort_unstable();
        let count = keys.len();
        keys.dedup();
        assert_eq!(keys.len(), count, "two measures share a key");
    }
}
