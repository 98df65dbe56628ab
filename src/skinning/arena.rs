//! Everyone's palettes in one array, ready to be copied to the GPU.
//!
//! Written by the CPU each frame (model space), read by `upload`, laid out as `shaders/skinning.wgsl` reads it.

use core::ops::Range;

use bevy::{
    color::{ColorToComponents, LinearRgba},
    prelude::Resource,
};

use super::{
    layout::{InstanceRecord, JointMatrix},
    ranges::Ranges,
};

/// A piece of the arena: matrices, and the record that names them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SkinRange {
    first: u32,
    len: u32,
    instance: u32,
}

impl SkinRange {
    /// How many matrices it has.
    #[must_use]
    pub fn len(self) -> usize {
        self.len as usize
    }

    /// Whether it has no matrix.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.len == 0
    }

    /// Where it begins among all matrices.
    #[must_use]
    pub fn first(self) -> usize {
        self.first as usize
    }

    /// Index of its record: what a mesh's `MeshTag` holds. 0 is drawn unskinned.
    #[must_use]
    pub fn instance(self) -> u32 {
        self.instance
    }

    fn indices(self) -> Range<usize> {
        self.first as usize..(self.first + self.len) as usize
    }
}

/// The arena cannot grow as far as a palette needs.
#[derive(thiserror::Error, Clone, Copy, Debug, PartialEq, Eq)]
#[error("no room for {wanted} joint matrices: {used} are in use and this GPU holds {limit}; despawn characters first")]
pub struct ArenaFull {
    /// Matrices asked for.
    pub wanted: u32,
    /// Matrices in use.
    pub used: u32,
    /// Matrices that one storage buffer holds, in two halves.
    pub limit: u32,
}

/// What changed since the GPU last took it.
#[derive(Clone, Debug, Default)]
pub(super) struct Pending {
    /// Matrices that were written.
    pub(super) written: Vec<Range<u32>>,
    /// Any record.
    pub(super) instances: bool,
    /// Matrices that had no last frame.
    pub(super) fresh: Vec<Range<u32>>,
}

/// Every palette of every character, as the GPU reads it. Matrix 0 is the identity, record 0 is [`InstanceRecord::PLAIN`].
#[derive(Resource, Clone, Debug)]
pub struct SkinArena {
    matrices: Vec<JointMatrix>,
    ranges: Ranges,
    instances: Vec<InstanceRecord>,
    free_instances: Vec<u32>,
    matrix_capacity: u32,
    instance_capacity: u32,
    matrix_limit: u32,
    pub(super) pending: Pending,
}

impl SkinArena {
    /// Room for `joint_count` matrices before it first grows.
    #[must_use]
    pub fn with_capacity(joint_count: u32) -> Self {
        let mut arena = Self {
            matrices: Vec::with_capacity(joint_count as usize),
            ranges: Ranges::default(),
            instances: vec![InstanceRecord::PLAIN],
            free_instances: vec![],
            matrix_capacity: joint_count.max(1),
            instance_capacity: (joint_count / 32).max(16),
            matrix_limit: u32::MAX,
            pending: Pending { instances: true, ..Pending::default() },
        };
        arena.ranges.take(1, u32::MAX);
        arena.matrices.push(JointMatrix::IDENTITY);
        arena
    }

    /// Takes `joint_count` matrices, all identity, and a record that names them.
    ///
    /// # Errors
    /// When the GPU cannot hold as many.
    pub fn allocate(&mut self, joint_count: u32) -> Result<SkinRange, ArenaFull> {
        let full = ArenaFull { wanted: joint_count, used: self.ranges.end(), limit: self.matrix_limit };
        let first = if joint_count == 0 { 0 } else { self.ranges.take(joint_count, self.matrix_limit).ok_or(full)? };
        let end = self.ranges.end();
        while self.matrix_capacity < end {
            self.matrix_capacity = self.matrix_capacity.saturating_mul(2).min(self.matrix_limit);
        }
        if self.matrices.len() < end as usize {
            self.matrices.resize(end as usize, JointMatrix::IDENTITY);
        }
        let record = InstanceRecord { first, count: joint_count.max(1), ..InstanceRecord::PLAIN };
        let range = SkinRange { first, len: joint_count, instance: self.allocate_instance(record) };
        self.matrices[range.indices()].fill(JointMatrix::IDENTITY);
        note(&mut self.pending.written, first..first + joint_count);
        note(&mut self.pending.fresh, first..first + joint_count);
        Ok(range)
    }

    /// Gives a range back. What still names its record is drawn unskinned until the record is taken anew.
    pub fn free(&mut self, range: SkinRange) {
        if range.instance == 0 || self.instances.get(range.instance as usize).is_none() {
            return;
        }
        self.ranges.give_back(range.first, range.len);
        self.instances[range.instance as usize] = InstanceRecord::PLAIN;
        self.free_instances.push(range.instance);
        self.pending.instances = true;
    }

    /// The matrices of `range`, to be written: `model_from_joint * inverse_bind`, slot by slot.
    pub fn matrices_mut(&mut self, range: SkinRange) -> &mut [JointMatrix] {
        note(&mut self.pending.written, range.first..range.first + range.len);
        self.matrices.get_mut(range.indices()).unwrap_or_default()
    }

    /// Every matrix in use, to be written by who poses many characters at once; ranges say whose is whose. Matrix 0 is
    /// nobody's and stays the identity.
    pub fn all_matrices_mut(&mut self) -> &mut [JointMatrix] {
        note(&mut self.pending.written, 0..self.ranges.end());
        &mut self.matrices[..self.ranges.end() as usize]
    }

    /// The matrices of `range` are about to be written.
    pub(super) fn note_written(&mut self, range: SkinRange) {
        note(&mut self.pending.written, range.first..range.first + range.len);
    }

    /// Every matrix in use, to be written by who [noted](Self::note_written) which.
    pub(super) fn bare_matrices_mut(&mut self) -> &mut [JointMatrix] {
        &mut self.matrices[..self.ranges.end() as usize]
    }

    /// The matrices of `range`.
    #[must_use]
    pub fn matrices(&self, range: SkinRange) -> &[JointMatrix] {
        self.matrices.get(range.indices()).unwrap_or_default()
    }

    /// Colours everything drawn with `range`: multiplies the base colour.
    pub fn set_tint(&mut self, range: SkinRange, tint: LinearRgba) {
        let tint = tint.to_f32_array();
        if range.instance != 0
            && let Some(record) = self.instances.get_mut(range.instance as usize)
            && bytemuck::bytes_of(&record.tint) != bytemuck::bytes_of(&tint)
        {
            record.tint = tint;
            self.pending.instances = true;
        }
    }

    /// Every matrix in use, and free ones between.
    #[must_use]
    pub fn all_matrices(&self) -> &[JointMatrix] {
        &self.matrices[..self.ranges.end() as usize]
    }

    /// Every record, used or not.
    #[must_use]
    pub fn all_instances(&self) -> &[InstanceRecord] {
        &self.instances
    }

    /// Matrices and records it holds before it grows.
    #[must_use]
    pub fn capacity(&self) -> Capacity {
        Capacity { matrices: self.matrix_capacity, instances: self.instance_capacity }
    }

    /// Never grows beyond `matrices`.
    pub(super) fn set_limit(&mut self, matrices: u32) {
        self.matrix_limit = matrices.max(self.ranges.end());
        self.matrix_capacity = self.matrix_capacity.min(self.matrix_limit);
    }

    /// Forgets what changed: for worlds that draw nothing.
    pub(super) fn forget_pending(&mut self) {
        self.pending.written.clear();
        self.pending.instances = false;
        self.pending.fresh.clear();
    }

    fn allocate_instance(&mut self, record: InstanceRecord) -> u32 {
        self.pending.instances = true;
        if let Some(instance) = self.free_instances.pop() {
            self.instances[instance as usize] = record;
            return instance;
        }
        self.instances.push(record);
        let count = u32::try_from(self.instances.len()).unwrap_or(u32::MAX);
        while self.instance_capacity < count {
            self.instance_capacity = self.instance_capacity.saturating_mul(2);
        }
        count - 1
    }
}

/// Adds `range` to a list, to its last one where the two touch.
fn note(list: &mut Vec<Range<u32>>, range: Range<u32>) {
    match list.last_mut() {
        Some(last) if last.end == range.start => last.end = range.end,
        _ if range.is_empty() => {}
        _ => list.push(range),
    }
}

/// How much a buffer holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capacity {
    /// Joint matrices per half.
    pub matrices: u32,
    /// Instance records.
    pub instances: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_stays_where_it_is_when_the_arena_grows() {
        let mut arena = SkinArena::with_capacity(4);
        let range = arena.allocate(3).unwrap();
        arena.matrices_mut(range)[2].0[0][3] = 7.0;
        let others: Vec<_> = (0..100).map(|_| arena.allocate(50).unwrap()).collect();
        assert!((arena.matrices(range)[2].0[0][3] - 7.0).abs() < 1e-6);
        assert_eq!(arena.all_instances()[range.instance() as usize].first, 1);
        assert_eq!(arena.capacity(), Capacity { matrices: 8192, instances: 128 });
        assert_eq!(others[99].instance(), 101);
    }

    #[test]
    fn what_is_freed_is_used_again_and_starts_at_identity() {
        let mut arena = SkinArena::with_capacity(64);
        let old = arena.allocate(10).unwrap();
        let keep = arena.allocate(10).unwrap();
        arena.matrices_mut(old).fill(JointMatrix([[9.0; 4]; 3]));
        arena.set_tint(old, LinearRgba::RED);
        arena.free(old);
        assert_eq!(arena.all_instances()[old.instance() as usize], InstanceRecord::PLAIN);
        let new = arena.allocate(10).unwrap();
        assert_eq!((new, arena.matrices(new)[9]), (old, JointMatrix::IDENTITY));
        assert_ne!(keep.instance(), new.instance());
    }

    #[test]
    fn a_full_arena_says_so() {
        let mut arena = SkinArena::with_capacity(8);
        arena.set_limit(8);
        let error = arena.allocate(8).expect_err("one of eight is the identity");
        assert_eq!(error, ArenaFull { wanted: 8, used: 1, limit: 8 });
        assert!(arena.allocate(7).is_ok());
    }

    #[test]
    fn an_empty_palette_is_drawn_unskinned() {
        let mut arena = SkinArena::with_capacity(8);
        let range = arena.allocate(0).unwrap();
        assert!(arena.matrices_mut(range).is_empty());
        assert_eq!(arena.all_instances()[range.instance() as usize], InstanceRecord::PLAIN);
        arena.free(range);
    }
}
