//! Turns a limb of every character of a block onto its goal: [`two_bone`] with lanes = characters.
//!
//! Reads and writes matrices and positions (model space, metres) of the limb's joints and of what hangs between them.

use fearless_simd::{Simd, prelude::*};

use super::{
    Actor,
    lanes::{Floats, LANES, Mask, Mat3s, Quats, Row, Vec3s, load, splat},
    model::{JointRows, Placed},
    species::Limb,
};
use crate::anim::ik::two_bone::{Extension, SHORTEST_BONE, STRAIGHT, soften};

/// Goals of one limb in lanes.
#[derive(Default)]
struct GoalRows {
    target: [Row; 3],
    pole: [Row; 3],
    end_turn: [Row; 4],
    /// 1 where there is a goal.
    there: Row,
}

/// Turns the limb of index `index` onto the goals of `actors`. All joints up to its end are placed.
#[inline(always)]
pub(super) fn reach<S: Simd>(simd: S, limb: &Limb, index: usize, actors: &[Actor], joints: &mut [JointRows]) {
    let Some(goals) = goal_rows(index, actors) else { return };
    let (target, pole) = (Vec3s::load(simd, &goals.target), Vec3s::load(simd, &goals.pole));
    let there = load(simd, &goals.there);

    let end = Placed::load(simd, &joints[limb.end]);
    let animated = Animated {
        root: Placed::load(simd, &joints[limb.upper]).position,
        middle: Placed::load(simd, &joints[limb.lower]).position,
        end: end.position,
        pole,
    };
    let solved = solve(simd, &animated, target, limb.extension);
    // Lanes without a goal are turned by nothing.
    let asked = there.simd_gt(splat(simd, 0.5)) & solved.possible;
    let still = Quats::identity(simd);
    let upper = Mat3s::from_quats(simd, Quats::select(asked, solved.upper, still));
    let lower = Mat3s::from_quats(simd, Quats::select(asked, solved.lower, still));
    let end_turn = Mat3s::from_quats(simd, Quats::select(asked, Quats::load(simd, &goals.end_turn), still));
    let middle = Vec3s::select(asked, solved.middle, animated.middle);

    for place in &limb.with_upper {
        turn(simd, &mut joints[*place], &upper, animated.root, animated.root);
    }
    for place in &limb.with_lower {
        turn(simd, &mut joints[*place], &lower, animated.middle, middle);
    }
    let position = Vec3s::select(asked, solved.end, animated.end);
    Placed { matrix: end_turn.times(&end.matrix), position }.store(&mut joints[limb.end]);
}

/// Turns a joint by `turn` about `from`, which goes to `to`.
#[inline(always)]
fn turn<S: Simd>(simd: S, joint: &mut JointRows, turn: &Mat3s<S>, from: Vec3s<S>, to: Vec3s<S>) {
    let old = Placed::load(simd, joint);
    let position = turn.moved(old.position.minus(from), to);
    Placed { matrix: turn.times(&old.matrix), position }.store(joint);
}

fn goal_rows(limb: usize, actors: &[Actor]) -> Option<GoalRows> {
    let mut rows: Option<GoalRows> = None;
    for (lane, actor) in actors.iter().enumerate() {
        let Some(goal) = actor.goals.get(limb).copied().flatten() else { continue };
        let rows = rows.get_or_insert_default();
        for axis in 0..3 {
            rows.target[axis][lane] = goal.target[axis];
            rows.pole[axis][lane] = goal.pole[axis];
        }
        for (row, part) in rows.end_turn.iter_mut().zip(goal.end_turn.to_array()) {
            row[lane] = part;
        }
        rows.there[lane] = 1.0;
    }
    rows
}

/// A limb as the clips left it; see [`two_bone::Limb`](crate::anim::ik::two_bone::Limb).
struct Animated<S: Simd> {
    root: Vec3s<S>,
    middle: Vec3s<S>,
    end: Vec3s<S>,
    pole: Vec3s<S>,
}

/// What turns it onto its target; see [`two_bone::Solution`](crate::anim::ik::two_bone::Solution).
struct Solved<S: Simd> {
    upper: Quats<S>,
    lower: Quats<S>,
    middle: Vec3s<S>,
    end: Vec3s<S>,
    possible: Mask<S>,
}

/// [`two_bone::solve`](crate::anim::ik::two_bone::solve), line by line.
#[inline(always)]
fn solve<S: Simd>(simd: S, limb: &Animated<S>, target: Vec3s<S>, extension: Extension) -> Solved<S> {
    let one = splat(simd, 1.0);
    let (upper, lower) = (limb.middle.minus(limb.root), limb.end.minus(limb.middle));
    let (a, b) = (upper.length(), lower.length());
    let possible =
        target.is_finite() & (a + b).simd_le(splat(simd, f32::MAX)) & a.min(b).simd_gt(splat(simd, SHORTEST_BONE));
    let wanted = target.minus(limb.root);
    let difference = (a - b).max(b - a) + SHORTEST_BONE;
    let reach = softened::<S>(wanted.length(), a + b, extension).max(difference);
    let animated = limb.end.minus(limb.root);
    let old_axis = animated.direction_or(simd, upper.direction_or(simd, Vec3s::splat(simd, [0.0, -1.0, 0.0])));
    let new_axis = wanted.direction_or(simd, old_axis);
    let swing = Quats::shortest_arc(simd, old_axis, new_axis);
    let swing_matrix = Mat3s::from_quats(simd, swing);
    let zero = Vec3s::splat(simd, [0.0; 3]);
    // At right angles to the new axis, as it was to the old one.
    let bend = swing_matrix.moved(bend_direction(simd, upper, limb.pole, old_axis), zero);
    let cos = (a * a + reach * reach - b * b) / (a * reach * 2.0);
    let cos = cos.max(-1.0).min(1.0);
    let sin = (one - cos * cos).max(0.0).sqrt();
    let middle = limb.root.plus(new_axis.times(a * cos)).plus(bend.times(a * sin));
    let end = limb.root.plus(new_axis.times(reach));
    let (swung_upper, swung_lower) = (swing_matrix.moved(upper, zero), swing_matrix.moved(lower, zero));
    // Bones keep their lengths.
    let (per_a, per_b) = (one / a, one / b);
    let (new_upper, new_lower) = (middle.minus(limb.root).times(per_a), end.minus(middle).times(per_b));
    Solved {
        upper: Quats::shortest_arc(simd, swung_upper.times(per_a), new_upper).after(swing),
        lower: Quats::shortest_arc(simd, swung_lower.times(per_b), new_lower).after(swing),
        middle,
        end,
        possible,
    }
}

/// Unit direction from the reach axis toward the middle joint; the pole's where the limb is straight.
#[inline(always)]
fn bend_direction<S: Simd>(simd: S, upper: Vec3s<S>, pole: Vec3s<S>, axis: Vec3s<S>) -> Vec3s<S> {
    let one = splat(simd, 1.0);
    let off_axis = off(upper, axis);
    let length = off_axis.length();
    let sine = length / upper.length();
    let share = (sine * (1.0 / STRAIGHT) - 1.0).max(0.0).min(1.0);
    if share.simd_ge(one).all_true() {
        return off_axis.times(one / length);
    }
    let pole = off(pole, axis).direction_or(simd, axis.any_perpendicular(simd));
    let bent = off_axis.direction_or(simd, pole);
    pole.times(one - share).plus(bent.times(share)).direction_or(simd, bent)
}

/// The part of `vector` at right angles to the unit vector `axis`.
#[inline(always)]
fn off<S: Simd>(vector: Vec3s<S>, axis: Vec3s<S>) -> Vec3s<S> {
    vector.minus(axis.times(vector.dot(axis)))
}

/// [`soften`] in each lane. Few limbs are stretched so far that it costs more than a comparison.
#[inline(always)]
fn softened<S: Simd>(wanted: Floats<S>, length: Floats<S>, extension: Extension) -> Floats<S> {
    let mut reach = wanted.min(length * extension.hard);
    if wanted.simd_le(length * extension.soft).all_true() {
        return reach;
    }
    for lane in 0..LANES {
        reach[lane] = soften(wanted[lane], length[lane], extension);
    }
    reach
}
