//! The few rows that the README shows, as a table in its text. Pure.

use crate::testing::gauntlet::{Course, Feet, Row};

/// Worlds that the README shows, each walked over.
const WORLDS: [&str; 6] = ["flat", "ramp 20°", "stairs up", "stairs down", "rubble", "hills"];
/// The tape that is played on them.
const TAPE: &str = "walk";
/// Between these lines of the README the table stands.
const MARKS: [&str; 2] = ["<!-- surefoot gauntlet --readme -->\n", "<!-- end -->\n"];
/// What is shown of a row: heading, and its key.
const FIGURES: [(&str, &str); 5] = [
    ("plants drift, mm (p95)", "drift_p95_mm"),
    ("skate, cm/s", "skate_cm_s"),
    ("sunk, mm (max)", "penetration_max_mm"),
    ("float, mm (p95)", "float_p95_mm"),
    ("pelvis, m/s² (p99)", "pelvis_p99_m_s2"),
];

/// Whether the README shows this course.
pub(super) fn shows(course: &Course) -> bool {
    course.tape.name == TAPE && WORLDS.contains(&course.world.name.as_str())
}

/// `text` with the table of `rows` between the marks; `None` where it has no marks.
pub(super) fn updated(text: &str, rows: &[Row]) -> Option<String> {
    let (before, rest) = text.split_once(MARKS[0])?;
    let (_, after) = rest.split_once(MARKS[1])?;
    Some([before, MARKS[0], &table(rows), MARKS[1], after].concat())
}

fn table(rows: &[Row]) -> String {
    let heads: String = FIGURES.iter().map(|(head, _)| format!(" {head} |")).collect();
    let rules: String = FIGURES.iter().map(|_| "---:|").collect();
    let lines: String = rows.iter().map(line).collect();
    format!("\n| walking on | feet |{heads}\n|---|---|{rules}\n{lines}\n")
}

fn line(row: &Row) -> String {
    let (world, feet) = match row.feet {
        Feet::Placed => (row.world.as_str(), "**placed**"),
        Feet::AsClips => ("", "without foot IK"),
        Feet::BuiltIn => ("", "Bevy's own player"),
    };
    let measured = row.bars.rows(&row.measures);
    let figure = |key: &str| measured.iter().find(|row| row.key == key).and_then(|row| row.value).map(digits);
    let figures: String =
        FIGURES.iter().map(|(_, key)| format!(" {} |", figure(key).unwrap_or_else(|| "–".to_owned()))).collect();
    format!("| {world} | {feet} |{figures}\n")
}

/// To a tenth below 100.
fn digits(value: f32) -> String {
    if value < 99.95 { format!("{value:.1}") } else { format!("{value:.0}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        measure::{bars::Bars, summary::Measures},
        testing::gauntlet::courses,
    };

    fn row(feet: Feet) -> Row {
        Row {
            world: "flat".to_owned(),
            tape: "walk".to_owned(),
            feet,
            measures: Measures { skate: 1.5, ..Measures::default() },
            bars: Bars::flat(),
            breaches: Vec::new(),
            frames: Vec::new(),
        }
    }

    #[test]
    fn the_table_takes_the_place_of_the_last_one() {
        let text = format!("before\n{}old\n{}after\n", MARKS[0], MARKS[1]);
        let new = updated(&text, &[row(Feet::Placed), row(Feet::BuiltIn)]).unwrap();
        assert!(new.starts_with("before\n") && new.ends_with("after\n") && !new.contains("old"), "{new}");
        assert!(new.contains("| flat | **placed** | 0.0 | 1.5 |") && new.contains("|  | Bevy's own player |"), "{new}");
        assert_eq!(updated(&new, &[row(Feet::Placed), row(Feet::BuiltIn)]).unwrap(), new, "a second time");
        assert_eq!(updated("no marks", &[]), None);
    }

    #[test]
    fn the_readme_has_the_marks_and_the_gauntlet_its_rows() {
        assert!(updated(include_str!("../../../README.md"), &[]).is_some(), "no marks");
        assert_eq!(courses().iter().filter(|course| shows(course)).count(), WORLDS.len());
    }
}
