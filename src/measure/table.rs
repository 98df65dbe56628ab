//! Measures beside their bars, as rows of a table.

use core::fmt::{self, Display, Formatter};

use super::summary::Measures;

/// One measure and the most it may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// What it is.
    pub name: &'static str,
    /// What was measured.
    pub value: f32,
    /// The bar; `None` where there is none.
    pub limit: Option<f32>,
    /// Unit of both.
    pub unit: &'static str,
}

impl Row {
    /// Whether the bar holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.limit.is_none_or(|limit| self.value <= limit)
    }
}

/// All measures, in the order of the table. Bars are for level ground where `level` is true.
#[must_use]
pub fn rows(measures: &Measures, level: bool) -> [Row; 16] {
    let row = |name, value, limit, unit| Row { name, value, limit, unit };
    let m = measures;
    [
        row("plant drift, median", m.drift_median, Some(1.0), "mm"),
        row("plant drift, p95", m.drift_p95, Some(5.0), "mm"),
        row("plant drift, max", m.drift_max, Some(20.0), "mm"),
        row("skate", m.skate, Some(if level { 1.0 } else { 2.0 }), "cm/s"),
        row("penetration, p99", m.penetration_p99, Some(5.0), "mm"),
        row("penetration, max", m.penetration_max, Some(15.0), "mm"),
        row("float, p95", m.float_p95, Some(10.0), "mm"),
        row("knee hyperextended", m.knee_hyperextended as f32, Some(0.0), "frames"),
        row("knee change, max", m.knee_change, Some(24.0), "°/frame"),
        row("leg extension, max", m.extension_max, Some(0.9951), "of leg"),
        row("pelvis acceleration, p99", m.pelvis_p99, Some(15.0), "m/s²"),
        row("pelvis acceleration, max", m.pelvis_max, Some(30.0), "m/s²"),
        row("reach missed, mean", m.reach_mean, Some(1.0), "mm"),
        row("reach missed, max", m.reach_max, Some(5.0), "mm"),
        row("joint speed, max", m.joint_speed_max, None, "°/s"),
        row("stances", m.stances as f32, None, ""),
    ]
}

/// Prints as a table with a mark on every bar that doesn't hold.
pub struct Table<'a>(pub &'a [Row]);

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<26} {:>9} {:>9}  unit", "measure", "value", "bar")?;
        for row in self.0 {
            let limit = row.limit.map_or_else(|| "-".to_owned(), |limit| format!("{limit:.1}"));
            let mark = if row.holds() { "" } else { "  over" };
            writeln!(f, "{:<26} {:>9.2} {:>9}  {}{mark}", row.name, row.value, limit, row.unit)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measure_over_its_bar_is_marked() {
        let measures = Measures { drift_max: 30.0, ..Measures::default() };
        let text = Table(&rows(&measures, true)).to_string();
        let line = text.lines().find(|line| line.starts_with("plant drift, max")).unwrap();
        assert!(line.ends_with("mm  over"), "{line}");
        assert!(!text.lines().any(|line| line.starts_with("skate") && line.ends_with("over")));
    }
}
