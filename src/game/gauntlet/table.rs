//! The gauntlet's rows as a table: each with foot IK, below it the same without, and as Bevy's own player has it. Pure.

use core::fmt::{self, Display, Formatter};

use crate::{
    measure::{
        bars::{self, Bars},
        summary::Measures,
    },
    testing::gauntlet::{Feet, Row},
};

/// Figures that stand together.
struct Column {
    head: &'static str,
    parts: &'static str,
    keys: &'static [&'static str],
    width: usize,
}

const fn column(head: &'static str, parts: &'static str, keys: &'static [&'static str], width: usize) -> Column {
    Column { head, parts, keys, width }
}

const COLUMNS: &[Column] = &[
    column("drift mm", "med/p95/max", &["drift_median_mm", "drift_p95_mm", "drift_max_mm"], 16),
    column("skate", "cm/s", &["skate_cm_s"], 6),
    column("sunk mm", "p99/max", &["penetration_p99_mm", "penetration_max_mm"], 10),
    column("float", "p95 mm", &["float_p95_mm"], 7),
    column("knee", "°/fr/back", &["knee_change_deg", "knee_backward_frames"], 9),
    column("leg", "max", &["leg_extension"], 7),
    column("pop", "turn/jump", &["pop_speed", "pop_jump"], 10),
    column("pelvis m/s²", "p99/max/land", &["pelvis_p99_m_s2", "pelvis_max_m_s2", "pelvis_landing_m_s2"], 15),
    column("reach mm", "mean/max", &["reach_mean_mm", "reach_max_mm"], 10),
    column("start", "frames", &["start_frames"], 6),
    column("walk s", "63/90 %", &["walk_63_s", "walk_90_s"], 11),
    column("run s", "63/90 %", &["run_63_s", "run_90_s"], 11),
];

/// Width of the first column: the longest name of a row.
const NAME: usize = 36;
/// Behind a figure over its bar.
const OVER: char = '!';

/// All rows as a table.
pub(super) struct Comparison<'a>(pub(super) &'a [Row]);

impl Display for Comparison<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let heads: String = COLUMNS.iter().map(|column| format!("  {:<1$}", column.head, column.width)).collect();
        let parts: String = COLUMNS.iter().map(|column| format!("  {:<1$}", column.parts, column.width)).collect();
        writeln!(f, "{:<NAME$}  feet{}", "", heads.trim_end())?;
        writeln!(f, "{:<NAME$}  by  {}", "world, tape", parts.trim_end())?;
        for row in self.0 {
            let by = match row.feet {
                Feet::Placed => "IK",
                Feet::AsClips => "clip",
                Feet::BuiltIn => "bevy",
            };
            let name = if row.feet == Feet::Placed { format!("{}, {}", row.world, row.tape) } else { String::new() };
            writeln!(f, "{name:<NAME$}  {by:<4}{}", line(row).trim_end())?;
        }
        let placed = || self.0.iter().filter(|row| row.feet == Feet::Placed);
        let over = placed().filter(|row| !row.breaches.is_empty()).count();
        let bars = Bars::default().rows(&Measures::default());
        writeln!(f, "{:<NAME$}  bar {}", "", figures(&bars, |row| Some(row.limit)).trim_end())?;
        let flat = brief(Bars::flat().skate);
        writeln!(
            f,
            "{over} of {} rows with foot IK are over a bar ({OVER}); skate on the flat: {flat}",
            placed().count()
        )
    }
}

fn line(row: &Row) -> String {
    figures(&row.bars.rows(&row.measures), |row| row.value)
}

/// One line of figures; those over their bar are marked.
fn figures(rows: &[bars::Row], of: impl Fn(&bars::Row) -> Option<f32>) -> String {
    let figure = |key: &&str| {
        let row = rows.iter().find(|row| row.key == *key)?;
        let value = of(row)?;
        let over = if value > row.limit && !row.holds() { OVER.to_string() } else { String::new() };
        let digits = if row.unit == "of leg" { format!("{value:.3}") } else { brief(value) };
        Some(digits + &over)
    };
    let cell = |column: &Column| {
        let parts: Vec<String> = column.keys.iter().map(|key| figure(key).unwrap_or_else(|| "-".to_owned())).collect();
        let none = parts.iter().all(|part| part == "-");
        let text = if none { "-".to_owned() } else { parts.join("/") };
        format!("  {text:<0$}", column.width)
    };
    COLUMNS.iter().map(cell).collect()
}

/// Two or three digits.
fn brief(value: f32) -> String {
    let text = match value.abs() {
        size if size >= 10.0 || (size - size.round()).abs() < 1e-6 => format!("{value:.0}"),
        size if size >= 0.95 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    };
    if text == "-0" { "0".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(feet: Feet, skate: f32) -> Row {
        let (bars, measures) = (Bars::flat(), Measures { skate, ..Measures::default() });
        Row {
            world: "flat".to_owned(),
            tape: "walk".to_owned(),
            feet,
            breaches: bars.check(&measures),
            measures,
            bars,
            frames: Vec::new(),
        }
    }

    #[test]
    fn a_row_stands_over_the_same_without_foot_ik_and_marks_what_is_over() {
        let text = Comparison(&[row(Feet::Placed, 0.5), row(Feet::AsClips, 1.5)]).to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[2].starts_with("flat, walk") && lines[2].contains("IK") && !lines[2].contains(OVER), "{text}");
        assert!(lines[3].trim_start().starts_with("clip") && lines[3].contains("1.5!"), "{text}");
        assert!(lines[4].contains("1/5/20") && lines[5].starts_with("0 of 1 rows"), "{text}");
    }

    #[test]
    fn every_measure_has_its_place() {
        let shown: Vec<&str> = COLUMNS.iter().flat_map(|column| column.keys).copied().collect();
        for row in Bars::default().rows(&Measures::default()) {
            assert!(shown.contains(&row.key), "{} is in no column", row.key);
        }
        assert_eq!(shown.len(), Bars::default().rows(&Measures::default()).len(), "a column of something else");
    }
}
