//! The joints of a body as a tree in space: who hangs below whom, where, and which limbs are mirror images.
//!
//! Rest positions in the file's space.

use bevy::math::{Affine3A, Vec3};

use crate::{
    anim::{
        pose::Pose,
        skeleton::{JointIndex, Skeleton},
    },
    math::rotation::direction_or,
};

/// Legs take at least this share of a body's height.
const LEG_SHARE: f32 = 0.25;
/// They lead down by at least this share of their length.
const DOWN_SHARE: f32 = 0.7;
/// Feet end within this share of the height over the lowest joint.
const FOOT_SHARE: f32 = 0.15;
/// Arms are at least this share of the height long.
const ARM_SHARE: f32 = 0.2;
/// Two limbs are a pair if they differ from mirror images by less than this share of their length.
const UNLIKE: f32 = 0.2;
/// What counts for the file's own up axis against others that fit as well.
const UPRIGHT_BONUS: f32 = 0.1;

/// Joints, at rest, that carry something of the body.
pub(super) struct Tree<'a> {
    pub(super) skeleton: &'a Skeleton,
    /// By joint: its rest position.
    at: Vec<Vec3>,
    /// By joint: what hangs on it.
    children: Vec<Vec<JointIndex>>,
    kept: Vec<JointIndex>,
    /// Largest extent along an axis.
    size: f32,
}

/// Two limbs that mirror each other.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    /// Where they meet.
    pub(super) above: JointIndex,
    /// From the joint below `above` to the end.
    pub(super) limbs: [Vec<JointIndex>; 2],
    /// Unit vector from the second to the first.
    pub(super) side: Vec3,
    score: f32,
}

/// Limbs that reach the ground, under the up axis that fits best.
#[derive(Clone, Debug)]
pub(super) struct Legs {
    pub(super) up: Vec3,
    /// Best first.
    pub(super) pairs: Vec<Pair>,
}

impl<'a> Tree<'a> {
    /// The tree of `body` joints and what carries them.
    pub(super) fn new(skeleton: &'a Skeleton, body: &[JointIndex]) -> Self {
        let mut in_file = skeleton.clone();
        in_file.model_from_root = Affine3A::IDENTITY;
        let rest = Pose::rest(&in_file);
        let mut keeps = vec![false; skeleton.len()];
        for &joint in body {
            let mut walk = Some(joint);
            while let Some(at) = walk.filter(|at| !keeps[at.index()]) {
                keeps[at.index()] = true;
                walk = skeleton.parent(at);
            }
        }
        let mut children = vec![Vec::new(); skeleton.len()];
        let kept: Vec<JointIndex> = skeleton.joints().filter(|joint| keeps[joint.index()]).collect();
        for &joint in &kept {
            if let Some(parent) = skeleton.parent(joint) {
                children[parent.index()].push(joint);
            }
        }
        let at = skeleton.joints().map(|joint| rest.position(joint)).collect();
        let mut tree = Self { skeleton, at, children, kept, size: 0.0 };
        let extents = Vec3::AXES.map(|axis| tree.extent(axis)).map(|(low, high)| high - low);
        tree.size = extents.into_iter().fold(f32::MIN_POSITIVE, f32::max);
        tree
    }

    pub(super) fn at(&self, joint: JointIndex) -> Vec3 {
        self.at[joint.index()]
    }

    pub(super) fn children(&self, joint: JointIndex) -> &[JointIndex] {
        &self.children[joint.index()]
    }

    /// Limbs that reach the ground; `up` where it is known.
    pub(super) fn legs(&self, up: Option<Vec3>) -> Option<Legs> {
        let axes = [Vec3::Y, Vec3::Z, Vec3::NEG_Z, Vec3::NEG_Y, Vec3::X, Vec3::NEG_X];
        let axes: &[Vec3] = up.as_ref().map_or(&axes, core::slice::from_ref);
        let legs = axes.iter().map(|&up| Legs { up, pairs: self.leg_pairs(up) });
        let score = |legs: &Legs| {
            let upright = if legs.up == Vec3::Y { UPRIGHT_BONUS } else { 0.0 };
            legs.pairs.first().map_or(f32::NEG_INFINITY, |pair| pair.score + upright)
        };
        legs.filter(|legs| !legs.pairs.is_empty()).max_by(|a, b| score(a).total_cmp(&score(b)))
    }

    fn leg_pairs(&self, up: Vec3) -> Vec<Pair> {
        let (low, high) = self.extent(up);
        let height = high - low;
        let reaches = |limb: &Vec<JointIndex>| {
            let [top, end] =
                [limb.first(), limb.last()].map(|joint| joint.map_or(0.0, |&joint| self.at(joint).dot(up)));
            let drop = top - end;
            let down = drop >= LEG_SHARE * height && drop >= DOWN_SHARE * self.length(limb);
            limb.len() > 2 && down && end - low <= FOOT_SHARE * height
        };
        let mut pairs: Vec<Pair> = Vec::new();
        for &above in &self.kept {
            let limbs = self.children(above).iter().map(|&child| self.path_to_end(child, |end| -self.at(end).dot(up)));
            let limbs: Vec<_> = limbs.filter(reaches).collect();
            pairs.extend(self.best_pair(above, &limbs, up));
        }
        pairs.sort_by(|a, b| b.score.total_cmp(&a.score));
        pairs
    }

    /// The best pair of mirrored limbs that leave `trunk` sideways, arms for instance, none of which holds a joint of `not`.
    pub(super) fn arms(&self, trunk: &[JointIndex], not: &[JointIndex], up: Vec3) -> Option<Pair> {
        let (low, high) = self.extent(up);
        let long = |limb: &Vec<JointIndex>| limb.len() > 2 && self.length(limb) >= ARM_SHARE * (high - low);
        let pairs = trunk.iter().filter_map(|&above| {
            let free = self.children(above).iter().filter(|child| !trunk.contains(child) && !not.contains(child));
            let origin = self.at(above);
            let limbs = free.map(|&child| self.path_to_end(child, |end| self.at(end).distance(origin)));
            self.best_pair(above, &limbs.filter(long).collect::<Vec<_>>(), up)
        });
        pairs.max_by(|a, b| self.length(&a.limbs[0]).total_cmp(&self.length(&b.limbs[0])))
    }

    fn best_pair(&self, above: JointIndex, limbs: &[Vec<JointIndex>], up: Vec3) -> Option<Pair> {
        let mut best: Option<Pair> = None;
        for (place, first) in limbs.iter().enumerate() {
            for second in &limbs[place + 1..] {
                if let Some(pair) = self.pair(above, first, second, up)
                    && best.as_ref().is_none_or(|best| pair.score > best.score)
                {
                    best = Some(pair);
                }
            }
        }
        best
    }

    /// The two limbs as a pair, if they are mirror images.
    fn pair(&self, above: JointIndex, first: &[JointIndex], second: &[JointIndex], up: Vec3) -> Option<Pair> {
        let length = self.length(first).max(self.length(second));
        let apart = |(&a, &b): (&JointIndex, &JointIndex)| self.at(a) - self.at(b);
        let both = || first.iter().zip(second);
        let count = both().count();
        let sum: Vec3 = both().map(apart).sum();
        let side = direction_or(sum - up * sum.dot(up), Vec3::ZERO);
        if side == Vec3::ZERO || sum.dot(side) < 0.02 * length * count as f32 {
            return None;
        }
        let unlike = |apart: Vec3| (apart - side * apart.dot(side)).length();
        let unlike = both().map(apart).map(unlike).sum::<f32>() / (count as f32 * length) + {
            let (a, b) = (self.length(first), self.length(second));
            0.5 * (a - b).abs() / length
        };
        if unlike.is_nan() || unlike > UNLIKE {
            return None;
        }
        let score = length / self.size - unlike + 0.02 * count.min(5) as f32;
        Some(Pair { above, limbs: [first.to_vec(), second.to_vec()], side, score })
    }

    /// From `top` down the tree to the end that `rank` puts highest; the nearer of equals.
    pub(super) fn path_to_end(&self, top: JointIndex, rank: impl Fn(JointIndex) -> f32) -> Vec<JointIndex> {
        let mut best = (f32::NEG_INFINITY, top);
        let mut open = vec![top];
        while let Some(joint) = open.pop() {
            if self.children(joint).is_empty() && rank(joint) > best.0 {
                best = (rank(joint), joint);
            }
            open.extend(self.children(joint));
        }
        self.path(top, best.1)
    }

    /// From `top` to `end` below it, both included.
    pub(super) fn path(&self, top: JointIndex, end: JointIndex) -> Vec<JointIndex> {
        let mut path = vec![end];
        let mut walk = end;
        while let Some(parent) = self.skeleton.parent(walk).filter(|_| walk != top) {
            path.push(parent);
            walk = parent;
        }
        path.reverse();
        path
    }

    /// Along the bones.
    pub(super) fn length(&self, path: &[JointIndex]) -> f32 {
        path.windows(2).map(|bone| self.at(bone[0]).distance(self.at(bone[1]))).sum()
    }

    /// Lowest and highest joint along `up`.
    pub(super) fn extent(&self, up: Vec3) -> (f32, f32) {
        // Joints that carry the whole are often far from it.
        let counts = |joint: &&JointIndex| self.children(**joint).is_empty() || self.children(**joint).len() > 1;
        let heights = self.kept.iter().filter(counts).map(|&joint| self.at(joint).dot(up));
        heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)))
    }
}
