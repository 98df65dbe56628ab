//! Rows in memory that begin where a register of eight lanes does, so that none lies across two lines of the cache.

use core::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

use super::lanes::{LANES, Row};

/// As many rows as it has grown to.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows32(Vec<Line>);

#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(32))]
struct Line(Row);

impl Rows32 {
    /// Of at least so many rows; new ones are zero.
    pub(super) fn grow(&mut self, len: usize) {
        self.0.resize(self.0.len().max(len), Line([0.0; LANES]));
    }
}

impl FromIterator<Row> for Rows32 {
    fn from_iter<I: IntoIterator<Item = Row>>(rows: I) -> Self {
        Self(rows.into_iter().map(Line).collect())
    }
}

impl Deref for Rows32 {
    type Target = [Row];

    #[inline(always)]
    fn deref(&self) -> &[Row] {
        bytemuck::cast_slice(&self.0)
    }
}

impl DerefMut for Rows32 {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [Row] {
        bytemuck::cast_slice_mut(&mut self.0)
    }
}
