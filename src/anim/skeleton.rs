//! Joints: names, parents, rest pose. Parents come before their children, so one pass builds a model pose.

use core::ops::Range;

use bevy::math::{Affine3A, Quat, Vec3};

/// Index of a joint in its [`Skeleton`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JointIndex(pub u16);

impl JointIndex {
    /// As an index into slices.
    #[must_use]
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

/// Where a joint is in its parent's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointTransform {
    /// Metres (of the file's unit, before the skeleton's `model_from_root`).
    pub translation: Vec3,
    /// Unit quaternion.
    pub rotation: Quat,
    /// Factor per axis.
    pub scale: Vec3,
}

impl JointTransform {
    /// No translation, no rotation, scale one.
    pub const IDENTITY: Self = Self { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE };

    /// As a matrix: scale, then rotate, then translate.
    #[must_use]
    pub fn to_affine(self) -> Affine3A {
        Affine3A::from_scale_rotation_translation(self.scale, self.rotation, self.translation)
    }
}

impl Default for JointTransform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

/// What hangs on a joint.
#[derive(Clone, Copy, Debug)]
struct Branch {
    /// The index after the last joint below it.
    end: usize,
    /// How many joints it is, with itself.
    count: usize,
}

/// A tree of joints, parents first.
#[derive(Clone, Debug, Default)]
pub struct Skeleton {
    names: Vec<String>,
    parents: Vec<Option<JointIndex>>,
    rest: Vec<JointTransform>,
    branches: Vec<Branch>,
    /// Turns, scales and moves the file's space into model space (metres, +Y up, faces -Z); applied above every root joint.
    pub model_from_root: Affine3A,
}

/// Why a list of joints is no skeleton.
#[derive(thiserror::Error, Clone, Debug, PartialEq, Eq)]
pub enum SkeletonError {
    /// More joints than a [`JointIndex`] can count.
    #[error("{0} joints; at most 65535 are possible")]
    TooMany(usize),
    /// A parent stands behind its child or is its child.
    #[error("joint `{joint}` comes before its parent (index {parent}); order joints parents first")]
    Order {
        /// The child's name.
        joint: String,
        /// The parent's index.
        parent: u16,
    },
}

impl Skeleton {
    /// A skeleton of `joints`: name, parent and rest transform each, parents first.
    ///
    /// # Errors
    /// When there are more than 65,535 joints, or a parent comes after its child.
    pub fn new(
        joints: impl IntoIterator<Item = (String, Option<JointIndex>, JointTransform)>,
        model_from_root: Affine3A,
    ) -> Result<Self, SkeletonError> {
        let mut skeleton = Self { model_from_root, ..Self::default() };
        for (name, parent, rest) in joints {
            if let Some(parent) = parent
                && parent.index() >= skeleton.names.len()
            {
                return Err(SkeletonError::Order { joint: name, parent: parent.0 });
            }
            skeleton.names.push(name);
            skeleton.parents.push(parent);
            skeleton.rest.push(rest);
        }
        skeleton.branches = (1..=skeleton.len()).map(|end| Branch { end, count: 1 }).collect();
        for (index, parent) in skeleton.parents.iter().enumerate().rev() {
            if let Some(parent) = parent {
                let Branch { end, count } = skeleton.branches[index];
                let above = &mut skeleton.branches[parent.index()];
                *above = Branch { end: above.end.max(end), count: above.count + count };
            }
        }
        if skeleton.len() > usize::from(u16::MAX) {
            return Err(SkeletonError::TooMany(skeleton.len()));
        }
        Ok(skeleton)
    }

    /// How many joints there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there is no joint.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The joint's name.
    #[must_use]
    pub fn name(&self, joint: JointIndex) -> &str {
        &self.names[joint.index()]
    }

    /// All names, by index.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The joint named `name`.
    #[must_use]
    pub fn find(&self, name: &str) -> Option<JointIndex> {
        self.names.iter().position(|n| n == name).and_then(|i| u16::try_from(i).ok()).map(JointIndex)
    }

    /// The joint's parent; `None` for a root.
    #[must_use]
    pub fn parent(&self, joint: JointIndex) -> Option<JointIndex> {
        self.parents[joint.index()]
    }

    /// All parents, by index.
    #[must_use]
    pub fn parents(&self) -> &[Option<JointIndex>] {
        &self.parents
    }

    /// The rest pose: where joints are when nothing plays, each in its parent's space.
    #[must_use]
    pub fn rest(&self) -> &[JointTransform] {
        &self.rest
    }

    /// The same joints with another rest pose.
    #[must_use]
    pub fn with_rest(&self, change: impl FnOnce(&mut [JointTransform])) -> Self {
        let mut other = self.clone();
        change(&mut other.rest);
        other
    }

    /// All joints, parents first.
    pub fn joints(&self) -> impl Iterator<Item = JointIndex> + use<> {
        (0..self.names.len()).filter_map(|i| u16::try_from(i).ok()).map(JointIndex)
    }

    /// Indices of `joint` and all below it, and of whatever lies between them in the order of joints.
    #[must_use]
    pub fn branch(&self, joint: JointIndex) -> Range<usize> {
        joint.index()..self.branches[joint.index()].end
    }

    /// Whether nothing else lies between `joint` and those below it: always so where joints are in depth-first order.
    #[must_use]
    pub fn is_whole_branch(&self, joint: JointIndex) -> bool {
        self.branch(joint).len() == self.branches[joint.index()].count
    }

    /// Whether `joint` is `ancestor` or below it.
    #[must_use]
    pub fn is_below(&self, joint: JointIndex, ancestor: JointIndex) -> bool {
        let mut walk = Some(joint);
        while let Some(at) = walk {
            if at == ancestor {
                return true;
            }
            walk = self.parent(at);
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parent_after_its_child_is_refused() {
        let joints = [("hand".to_owned(), Some(JointIndex(1)), JointTransform::IDENTITY)];
        let error = Skeleton::new(joints, Affine3A::IDENTITY).expect_err("hand has no parent yet");
        assert_eq!(error.to_string(), "joint `hand` comes before its parent (index 1); order joints parents first");
    }

    #[test]
    fn a_branch_is_whole_unless_another_lies_in_between() {
        let joint =
            |name: &str, parent: Option<u16>| (name.to_owned(), parent.map(JointIndex), JointTransform::IDENTITY);
        let joints = [
            joint("hips", None),
            joint("thigh", Some(0)),
            joint("spine", Some(0)),
            joint("head", Some(2)),
            joint("shin", Some(1)),
        ];
        let skeleton = Skeleton::new(joints, Affine3A::IDENTITY).expect("parents come first");
        let branches = [0, 1, 2, 3, 4].map(|joint| {
            let branch = skeleton.branch(JointIndex(joint));
            (branch.start, branch.end, skeleton.is_whole_branch(JointIndex(joint)))
        });
        assert_eq!(branches, [(0, 5, true), (1, 5, false), (2, 4, true), (3, 4, true), (4, 5, true)]);
    }

    #[test]
    fn more_joints_than_an_index_counts_are_refused() {
        let joints = (0..65_536).map(|i| (i.to_string(), None, JointTransform::IDENTITY));
        assert_eq!(Skeleton::new(joints, Affine3A::IDENTITY).err(), Some(SkeletonError::TooMany(65_536)));
    }
}
