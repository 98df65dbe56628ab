//! Which matrices go into which half of the GPU's buffer, so that one half is this frame and the other the last. Pure.
//!
//! A half that takes its turn holds what was there two frames ago: it needs what was written in this frame and in the last
//! one, and no more.

use core::ops::Range;

use super::arena::Pending;

/// Matrices that needn't be written but are, where that saves a write of its own: 12 KB.
const GAP: u32 = 256;

/// The state of the two halves.
#[derive(Clone, Debug, Default)]
pub(super) struct Halves {
    /// Which half holds this frame: 0 or 1.
    half: u32,
    /// Both halves hold everything that came before the last frame.
    filled: bool,
    /// The last frame's half counts as this frame's.
    settled: bool,
    /// What the half of this frame has and the other one hasn't.
    news: Vec<Range<u32>>,
    runs: Vec<Range<u32>>,
    writes: Vec<Write>,
}

/// Matrices to be copied.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Write {
    /// Into which half.
    pub(super) half: u32,
    /// Which.
    pub(super) run: Range<u32>,
}

impl Halves {
    /// Takes what changed; `count` matrices are in use. Gives the halves of this and the last frame where they are others than
    /// in the frame before.
    pub(super) fn turn(&mut self, pending: &Pending, count: u32) -> Option<[u32; 2]> {
        self.writes.clear();
        let moved = !self.filled || !pending.written.is_empty();
        if !moved {
            let was_settled = core::mem::replace(&mut self.settled, true);
            return (!was_settled).then_some([self.half; 2]);
        }
        let (last, now) = (self.half, 1 - self.half);
        if self.filled {
            self.runs.clone_from(&self.news);
            self.runs.extend_from_slice(&pending.written);
            join(&mut self.runs);
            self.news.clone_from(&pending.written);
            let write = |half: u32, run: &Range<u32>| Write { half, run: run.start..run.end.min(count) };
            self.writes.extend(self.runs.iter().map(|run| write(now, run)));
            self.writes.extend(pending.fresh.iter().map(|run| write(last, run)));
            self.writes.retain(|write| !write.run.is_empty());
        } else {
            self.writes.extend([now, last].map(|half| Write { half, run: 0..count }));
            self.filled = true;
        }
        (self.half, self.settled) = (now, false);
        Some([now, last])
    }

    /// What is to be copied in this frame.
    pub(super) fn writes(&self) -> &[Write] {
        &self.writes
    }
}

/// Sorts runs and joins those that touch, or about do.
fn join(runs: &mut Vec<Range<u32>>) {
    runs.sort_unstable_by_key(|run| run.start);
    runs.dedup_by(|next, run| {
        let near = next.start <= run.end.saturating_add(GAP);
        if near {
            run.end = run.end.max(next.end);
        }
        near
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pending(run: Range<u32>) -> Pending {
        Pending { written: vec![run], ..Pending::default() }
    }

    #[test]
    fn one_of_many_who_moves_is_written_alone() {
        let mut halves = Halves::default();
        halves.turn(&pending(0..55_000), 55_000);
        for _ in 0..3 {
            halves.turn(&pending(5_500..5_555), 55_000);
            let count: usize = halves.writes().iter().map(|write| write.run.len()).sum();
            assert_eq!(count, 55, "{count} matrices are written for one who has 55");
        }
    }

    #[test]
    fn a_crowd_that_moves_is_one_write() {
        let mut halves = Halves::default();
        halves.turn(&pending(0..1), 55_000);
        let written = (0..1_000).map(|index| index * 55..(index + 1) * 55).rev().collect();
        halves.turn(&Pending { written, ..Pending::default() }, 55_000);
        assert_eq!(halves.writes(), [Write { half: 0, run: 0..55_000 }]);
    }

    #[test]
    fn nothing_moves_nothing_is_written_and_both_frames_are_one() {
        let mut halves = Halves::default();
        assert_eq!(halves.turn(&pending(0..10), 10), Some([1, 0]));
        let still = Pending::default();
        assert_eq!(halves.turn(&still, 10), Some([1, 1]), "the last movement is over");
        assert_eq!((halves.turn(&still, 10), halves.writes()), (None, [].as_slice()));
    }

    proptest! {
        #[test]
        fn the_halves_hold_this_frame_and_the_last(
            frames in prop::collection::vec(prop::collection::vec((0u32..3_000, 1u32..60), 0..4), 1..30),
        ) {
            const COUNT: usize = 3_060;
            let (mut arena, mut before) = (vec![0usize; COUNT], vec![0usize; COUNT]);
            let mut buffer = [vec![0usize; COUNT], vec![0usize; COUNT]];
            let (mut halves, mut header) = (Halves::default(), [0, 0]);
            for (frame, runs) in frames.iter().enumerate() {
                let written: Vec<_> = runs.iter().map(|(first, len)| *first..first + len).collect();
                for run in &written {
                    arena[run.start as usize..run.end as usize].fill(frame + 1);
                }
                let first = frame == 0;
                header = halves.turn(&Pending { written, ..Pending::default() }, COUNT as u32).unwrap_or(header);
                for Write { half, run } in halves.writes() {
                    let run = run.start as usize..run.end as usize;
                    buffer[*half as usize][run.clone()].copy_from_slice(&arena[run]);
                }
                prop_assert!(buffer[header[0] as usize] == arena, "frame {frame} is not in half {}", header[0]);
                prop_assert!(first || buffer[header[1] as usize] == before, "what was before frame {frame} is lost");
                before.clone_from(&arena);
            }
        }
    }
}
