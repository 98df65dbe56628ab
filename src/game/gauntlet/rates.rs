//! What differs from 60 frames a second, as a table. Pure.

use core::fmt::{self, Display, Formatter};

use crate::testing::gauntlet::rates::{Alike, Pair};

/// Width of the first column: the longest name of a row.
const NAME: usize = 36;
/// Behind a figure over its bar.
const OVER: char = '!';

/// All courses at other frame rates.
pub(super) struct Rates<'a>(pub(super) &'a [Alike]);

impl Display for Rates<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<NAME$}  {:>3}  {:>6}  differs: at 60 Hz → there", "world, tape", "Hz", "end mm")?;
        for alike in self.0 {
            let name = format!("{}, {}", alike.world, alike.tape);
            let differ: Vec<String> = alike.pairs.iter().filter(|pair| pair.differs()).map(told).collect();
            let differ = if differ.is_empty() { "-".to_owned() } else { differ.join(", ") };
            writeln!(f, "{name:<NAME$}  {:>3}  {:>6.1}  {differ}", alike.hertz, alike.away * 1000.0)?;
        }
        let pairs = || self.0.iter().flat_map(|alike| &alike.pairs);
        let count = |of: fn(&Pair) -> bool| pairs().filter(|pair| of(pair)).count();
        let over = |pair: &Pair| pair.other > pair.row.limit && pair.usual <= pair.row.limit;
        writeln!(
            f,
            "of {} measures {} differ by more than a fifth, {} of them by more than a tenth of their bar; {} are over their bar there \
             alone ({OVER})",
            pairs().count(),
            count(Pair::differs_at_all),
            count(Pair::differs),
            pairs().filter(|pair| over(pair)).count(),
        )
    }
}

/// A measure at both rates.
fn told(pair: &Pair) -> String {
    let over = if pair.other > pair.row.limit { OVER.to_string() } else { String::new() };
    format!("{} {:.2} → {:.2}{over} {}", pair.row.name, pair.usual, pair.other, pair.row.unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{bars::Bars, summary::Measures};

    #[test]
    fn what_differs_is_named_with_both_figures() {
        let row = Bars::default().rows(&Measures::default())[3];
        let pair = |other: f32| Pair { row, usual: 1.0, other, allowed: 0.2 };
        let alike = |other: f32| Alike {
            world: "hills".to_owned(),
            tape: "walk".to_owned(),
            hertz: 30.0,
            away: 0.002,
            pairs: vec![pair(other)],
        };
        let text = Rates(&[alike(1.1), alike(2.5)]).to_string();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[1].ends_with("2.0  -"), "{text}");
        assert!(lines[2].ends_with("skate 1.00 → 2.50! cm/s"), "{text}");
        assert!(lines[3].starts_with("of 2 measures 1 differ by more than a fifth, 1 of them"), "{text}");
    }
}
