//! The table of measures below a film. Pure.

use crate::measure::summary::{Frame, Measures, summarize};

/// Figures of one measure, and what they may be on rough ground.
struct Row {
    name: &'static str,
    unit: &'static str,
    figures: Vec<f32>,
    bars: &'static [f32],
}

/// The measures of a walk as lines of text: what was measured, the bar it is held to, and whether it stays below.
#[must_use]
pub fn of(frames: &[Frame]) -> String {
    let measures = summarize(frames);
    let mut text = format!("{:<36}{:>22}{:>18}\n", "measure", "walk", "bar");
    for row in rows(&measures) {
        let join = |numbers: &[f32]| numbers.iter().map(|number| short(*number)).collect::<Vec<_>>().join(" / ");
        let good = row.figures.iter().zip(row.bars).all(|(figure, bar)| figure <= bar);
        let name = format!("{}, {}", row.name, row.unit);
        let mark = if good { "" } else { "  over" };
        text += &format!("{name:<36}{:>22}{:>18}{mark}\n", join(&row.figures), join(row.bars));
    }
    text + &format!("from {} frames with {} stances", frames.len(), measures.stances)
}

fn rows(measures: &Measures) -> Vec<Row> {
    let row = |name, unit, figures: &[f32], bars| Row { name, unit, figures: figures.to_vec(), bars };
    vec![
        row(
            "plant drift median/p95/max",
            "mm",
            &[measures.drift_median, measures.drift_p95, measures.drift_max],
            &[1.0, 5.0, 20.0],
        ),
        row("skate", "cm/s", &[measures.skate], &[2.0]),
        row("penetration p99/max", "mm", &[measures.penetration_p99, measures.penetration_max], &[5.0, 15.0]),
        row("float p95", "mm", &[measures.float_p95], &[10.0]),
        row("knee bent backward", "frames", &[measures.knee_hyperextended as f32], &[0.0]),
        row("knee change max", "deg/frame", &[measures.knee_change], &[24.0]),
        row("leg extension max", "ratio", &[measures.extension_max], &[0.995]),
        row("pelvis acceleration p99/max", "m/s2", &[measures.pelvis_p99, measures.pelvis_max], &[15.0, 30.0]),
        row("reach missed mean/max", "mm", &[measures.reach_mean, measures.reach_max], &[1.0, 5.0]),
    ]
}

/// Whole numbers whole, small ones with as many digits as say something.
fn short(number: f32) -> String {
    if number.abs() >= 10.0 || (number - number.round()).abs() < 1e-6 {
        format!("{number:.0}")
    } else if number.abs() >= 1.0 {
        format!("{number:.1}")
    } else {
        format!("{number:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measure_over_its_bar_is_marked_and_one_below_is_not() {
        let good = Measures::default();
        let bad = Measures { skate: 2.5, ..Measures::default() };
        let over = |measures: &Measures| {
            rows(measures)
                .iter()
                .filter(|row| row.figures.iter().zip(row.bars).any(|(figure, bar)| figure > bar))
                .count()
        };
        assert_eq!([over(&good), over(&bad)], [0, 1], "measures over their bars");
    }

    #[test]
    fn a_walk_of_no_frames_still_makes_a_table() {
        let table = of(&[]);
        assert!(table.contains("plant drift") && table.contains("from 0 frames"), "{table}");
    }
}
