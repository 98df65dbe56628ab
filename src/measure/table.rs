//! Measures beside their bars, as text.

use core::fmt::{self, Display, Formatter};

use super::bars::Row;

/// Prints rows as a table with a mark on every bar that doesn't hold.
pub struct Table<'a>(pub &'a [Row]);

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<26} {:>9} {:>9}  unit", "measure", "value", "bar")?;
        for row in self.0 {
            let value = row.value.map_or_else(|| "-".to_owned(), short);
            let mark = if row.holds() { "" } else { "  over" };
            writeln!(f, "{:<26} {value:>9} {:>9}  {}{mark}", row.name, short(row.limit), row.unit)?;
        }
        Ok(())
    }
}

/// Whole numbers whole, small ones with as many digits as say something.
#[must_use]
pub fn short(number: f32) -> String {
    if number.abs() >= 100.0 || (number - number.round()).abs() < 1e-6 {
        format!("{number:.0}")
    } else if number.abs() >= 10.0 {
        format!("{number:.1}")
    } else if number.abs() >= 1.0 {
        format!("{number:.2}")
    } else {
        format!("{number:.3}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{bars::Bars, summary::Measures};

    #[test]
    fn a_measure_over_its_bar_is_marked() {
        let measures = Measures { drift_max: 30.0, ..Measures::default() };
        let text = Table(&Bars::flat().rows(&measures)).to_string();
        let line = text.lines().find(|line| line.starts_with("plant drift, max")).unwrap();
        assert!(line.ends_with("mm  over"), "{line}");
        assert!(!text.lines().any(|line| line.starts_with("skate") && line.ends_with("over")));
    }

    #[test]
    fn numbers_have_the_digits_that_say_something() {
        assert_eq!([0.0, 0.9953, 1.25, 31.04, 250.4].map(short), ["0", "0.995", "1.25", "31.0", "250"]);
    }
}
