//! Parts told from where joints are at rest: hips, knees and ankles along a leg, a trunk between legs and arms.
//!
//! Rest positions in the file's space.

use bevy::math::Vec3;

use super::tree::{Pair, Tree};
use crate::{anim::skeleton::JointIndex, math::rotation::direction_or};

/// A bone that leads downward: cosine of its angle from straight down.
const STEEP: f32 = 0.64;
/// Thighs and shins, or the halves that twist joints make of them, are at least this share of a leg.
const BONE_SHARE: f32 = 0.12;
/// A knee or elbow lies between these shares of its limb.
const MIDDLE: (f32, f32) = (0.2, 0.8);
/// Toes are at least this share of the leg before the ankle.
const TOES_AHEAD: f32 = 0.04;
/// A first arm joint that is less than this share as far from the middle as the next is a shoulder.
const SHOULDER: f32 = 0.5;

/// Joints of a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct LegShape {
    pub(super) upper: JointIndex,
    pub(super) lower: JointIndex,
    pub(super) foot: JointIndex,
    pub(super) toes: Option<JointIndex>,
}

/// Joints of an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ArmShape {
    pub(super) shoulder: Option<JointIndex>,
    pub(super) upper: JointIndex,
    pub(super) lower: JointIndex,
    pub(super) hand: JointIndex,
}

/// Hip, knee, ankle and toes along `limb`, a path from the pelvis to the ground.
pub(super) fn leg(tree: &Tree, limb: &[JointIndex], up: Vec3) -> Option<LegShape> {
    let length = tree.length(limb);
    let steep = |bone: &[JointIndex]| {
        let way = tree.at(bone[1]) - tree.at(bone[0]);
        -way.dot(up) > STEEP * way.length() && way.length() >= BONE_SHARE * length
    };
    let hip = limb.windows(2).position(steep)?;
    let ankle = limb.windows(2).rposition(steep)? + 1;
    let lower = middle(tree, &limb[hip..=ankle])?;
    let foot = limb[ankle];
    Some(LegShape { upper: limb[hip], lower, foot, toes: toes(tree, foot, length, up) })
}

/// The joint inside of `path` nearest to its middle.
pub(super) fn middle(tree: &Tree, path: &[JointIndex]) -> Option<JointIndex> {
    let whole = tree.length(path);
    let share = |place: usize| tree.length(&path[..=place]) / whole;
    let inside = (1..path.len().saturating_sub(1)).filter(|&place| share(place) > MIDDLE.0 && share(place) < MIDDLE.1);
    let nearest = inside.min_by(|&a, &b| (share(a) - 0.5).abs().total_cmp(&(share(b) - 0.5).abs()));
    nearest.map(|place| path[place])
}

/// What hangs on the ankle farthest ahead of it, or behind: heels are nearer than toes.
pub(super) fn toes(tree: &Tree, foot: JointIndex, leg: f32, up: Vec3) -> Option<JointIndex> {
    let away = |joint: JointIndex| {
        let way = tree.at(joint) - tree.at(foot);
        (way - up * way.dot(up)).length()
    };
    let far = tree.children(foot).iter().copied().filter(|&joint| away(joint) >= TOES_AHEAD * leg);
    far.max_by(|&a, &b| away(a).total_cmp(&away(b)))
}

/// Shoulder, elbow and wrist along `limb`, a path from the trunk to the farthest finger.
pub(super) fn arm(tree: &Tree, limb: &[JointIndex], pair: &Pair, centre: Vec3) -> Option<ArmShape> {
    let aside = |joint: JointIndex| (tree.at(joint) - centre).dot(pair.side).abs();
    let first = usize::from(limb.len() > 3 && aside(limb[0]) < SHOULDER * aside(limb[1]));
    // Fingers fan out from the hand; without them it is the third joint.
    let fan = (first + 2..limb.len()).find(|&place| tree.children(limb[place]).len() > 2);
    let hand = fan.unwrap_or(first + 2);
    let path = limb.get(first..=hand)?;
    let lower = middle(tree, path).or_else(|| path.get(1).copied())?;
    Some(ArmShape { shoulder: (first > 0).then(|| limb[0]), upper: limb[first], lower, hand: limb[hand] })
}

/// From the joint over `pelvis` up to the top of the body, none of `legs` among it.
pub(super) fn trunk(tree: &Tree, pelvis: JointIndex, legs: &[JointIndex], up: Vec3) -> Vec<JointIndex> {
    let free = tree.children(pelvis).iter().copied().filter(|child| !legs.contains(child));
    let paths = free.map(|child| tree.path_to_end(child, |end| tree.at(end).dot(up)));
    let top = |path: &Vec<JointIndex>| path.last().map_or(f32::NEG_INFINITY, |&end| tree.at(end).dot(up));
    let higher = |path: &Vec<JointIndex>| top(path) > tree.at(pelvis).dot(up);
    paths.filter(higher).max_by(|a, b| top(a).total_cmp(&top(b))).unwrap_or_default()
}

/// Neck and head among the joints `above` the arms, lowest first; `flesh` tells how many vertices a joint moves.
pub(super) fn head(
    above: &[JointIndex],
    flesh: impl Fn(JointIndex) -> usize,
) -> (Option<JointIndex>, Option<JointIndex>) {
    let most = above.iter().copied().enumerate().rev().max_by_key(|&(_, joint)| flesh(joint));
    let place = match most {
        Some((place, joint)) if flesh(joint) > 0 => place,
        // Without vertices: a neck, then a head; what may follow is its top.
        _ => above.len().min(2).saturating_sub(1),
    };
    let neck = place.checked_sub(1).and_then(|place| above.get(place));
    (neck.copied(), above.get(place).copied())
}

/// Whether the trunk from one pair of limbs to the other lies rather than stands.
pub(super) fn lies(tree: &Tree, one: &Pair, other: &Pair, up: Vec3) -> bool {
    let start = |pair: &Pair| 0.5 * (tree.at(pair.limbs[0][0]) + tree.at(pair.limbs[1][0]));
    let way = direction_or(start(one) - start(other), Vec3::ZERO);
    way.dot(up).abs() < core::f32::consts::FRAC_1_SQRT_2
}
