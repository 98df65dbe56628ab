//! The gauntlet's rows as JSON. Pure.

use serde_json::{Map, Value, json};

use crate::{
    measure::bars,
    testing::gauntlet::{Feet, Row},
};

/// `{"rows": [{"world", "tape", "foot_ik", "measures": {name: value}, "bars": {name: limit}, "pass"}]}`.
///
/// Names end in their unit. Rows of Bevy's own player have ", built-in" behind the tape. What could not be measured in a row is left out of its measures and bars.
pub(super) fn text(rows: &[Row]) -> String {
    format!("{:#}\n", json!({ "rows": rows.iter().map(row).collect::<Vec<_>>() }))
}

fn row(row: &Row) -> Value {
    let table = row.bars.rows(&row.measures);
    let measured = || table.iter().filter_map(|line| Some((line, line.value?)));
    let map = |of: fn(&bars::Row, f32) -> f32| -> Map<String, Value> {
        measured().map(|(line, value)| (line.key.to_owned(), number(of(line, value)))).collect()
    };
    json!({
        "world": row.world,
        "tape": tape(row),
        "foot_ik": row.feet == Feet::Placed,
        "measures": map(|_, value| value),
        "bars": map(|line, _| line.limit),
        "pass": row.breaches.is_empty(),
    })
}

/// Bevy's own player has rows of its own.
fn tape(row: &Row) -> String {
    if row.feet == Feet::BuiltIn { format!("{}, built-in", row.tape) } else { row.tape.clone() }
}

/// To a millionth, so that 0.995 isn't 0.9950000047683716.
fn number(value: f32) -> Value {
    Value::from((f64::from(value) * 1e6).round() / 1e6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{bars::Bars, summary::Measures};

    #[test]
    fn a_row_says_all_that_was_measured_and_its_bars() {
        let (bars, measures) = (Bars::flat(), Measures { skate: 1.5, ..Measures::default() });
        let row = Row {
            world: "flat".to_owned(),
            tape: "walk".to_owned(),
            feet: Feet::Placed,
            breaches: bars.check(&measures),
            measures,
            bars,
            frames: Vec::new(),
        };
        let value: Value = serde_json::from_str(&text(&[row])).unwrap();
        let row = &value["rows"][0];
        assert_eq!((&row["world"], &row["tape"]), (&json!("flat"), &json!("walk")));
        assert_eq!((&row["foot_ik"], &row["pass"]), (&json!(true), &json!(false)));
        assert_eq!((&row["measures"]["skate_cm_s"], &row["bars"]["skate_cm_s"]), (&json!(1.5), &json!(1.0)));
        assert_eq!(row["bars"]["leg_extension"], json!(0.995));
        assert!(row["measures"].get("walk_90_s").is_none(), "nobody walked off in {row}");
    }
}
