//! Hands out ranges of a growing array and takes them back. Pure; units are elements.

/// Ranges in use and free, as an array that grows at its end.
#[derive(Clone, Debug, Default)]
pub struct Ranges {
    /// Free ranges below `end` as (first, length), by first; no two touch.
    free: Vec<(u32, u32)>,
    end: u32,
}

impl Ranges {
    /// First element beyond every range in use.
    #[must_use]
    pub fn end(&self) -> u32 {
        self.end
    }

    /// Takes `len` elements: the smallest free range that holds them, else new ones at the end.
    ///
    /// `None` when the end would pass `limit`.
    pub fn take(&mut self, len: u32, limit: u32) -> Option<u32> {
        let best = (0..self.free.len()).filter(|i| self.free[*i].1 >= len).min_by_key(|i| self.free[*i].1);
        if let Some(best) = best {
            let (first, free) = self.free[best];
            if free == len {
                self.free.remove(best);
            } else {
                self.free[best] = (first + len, free - len);
            }
            return Some(first);
        }
        let first = self.end;
        self.end = first.checked_add(len).filter(|end| *end <= limit)?;
        Some(first)
    }

    /// Gives `len` elements from `first` back. They must have been taken.
    pub fn give_back(&mut self, first: u32, len: u32) {
        if len == 0 {
            return;
        }
        let at = self.free.partition_point(|free| free.0 < first);
        debug_assert!(first + len <= self.end, "only what was taken comes back");
        debug_assert!(at == 0 || self.free[at - 1].0 + self.free[at - 1].1 <= first, "given back twice");
        debug_assert!(at == self.free.len() || first + len <= self.free[at].0, "given back twice");
        self.free.insert(at, (first, len));
        if at + 1 < self.free.len() && first + len == self.free[at + 1].0 {
            self.free[at].1 += self.free.remove(at + 1).1;
        }
        if at > 0 && self.free[at - 1].0 + self.free[at - 1].1 == first {
            self.free[at - 1].1 += self.free.remove(at).1;
        }
        if let Some(last) = self.free.last().copied()
            && last.0 + last.1 == self.end
        {
            self.end = last.0;
            self.free.pop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_comes_back_is_handed_out_again() {
        let mut ranges = Ranges::default();
        let first: Vec<u32> = (0..4).map(|_| ranges.take(10, 100).unwrap()).collect();
        ranges.give_back(first[1], 10);
        assert_eq!(ranges.take(10, 100), Some(first[1]));
        assert_eq!(ranges.end(), 40);
    }

    #[test]
    fn neighbours_join_and_the_end_comes_down() {
        let mut ranges = Ranges::default();
        for _ in 0..4 {
            ranges.take(10, 100);
        }
        ranges.give_back(0, 10);
        ranges.give_back(20, 10);
        ranges.give_back(10, 10);
        assert_eq!(ranges.take(30, 100), Some(0), "three joined tens hold thirty");
        ranges.give_back(30, 10);
        assert_eq!(ranges.end(), 30);
    }

    #[test]
    fn the_limit_holds() {
        let mut ranges = Ranges::default();
        assert_eq!(ranges.take(11, 10), None);
        assert_eq!(ranges.take(10, 10), Some(0));
        assert_eq!(ranges.take(1, 10), None);
    }

    proptest! {
        #[test]
        fn ranges_never_overlap(steps in prop::collection::vec((any::<bool>(), 1u32..20, any::<prop::sample::Index>()), 1..200)) {
            let mut ranges = Ranges::default();
            let mut taken: Vec<(u32, u32)> = vec![];
            for (give, len, which) in steps {
                if give && !taken.is_empty() {
                    let (first, len) = taken.swap_remove(which.index(taken.len()));
                    ranges.give_back(first, len);
                } else {
                    taken.push((ranges.take(len, u32::MAX).unwrap(), len));
                }
                let mut sorted = taken.clone();
                sorted.sort_unstable();
                for pair in sorted.windows(2) {
                    prop_assert!(pair[0].0 + pair[0].1 <= pair[1].0, "{:?} and {:?} overlap", pair[0], pair[1]);
                }
                let used: u32 = taken.iter().map(|t| t.1).sum();
                let free: u32 = ranges.free.iter().map(|f| f.1).sum();
                prop_assert_eq!(used + free, ranges.end());
            }
        }
    }
}
