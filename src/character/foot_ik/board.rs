//! How a sole lies on ground that is no plane: as a stiff board does, on the edges that carry it.
//!
//! One dimension, metres: along the foot from the ball, heights over the ball's ground. Pure.

use arrayvec::ArrayVec;

use super::ground::{PROPPED, SoleShape, TOLERATED};

/// Metres between the places of a sole where its ground is looked at, at most, and how many there are at most.
const APART: f32 = 0.1;
const MOST: usize = 12;
/// Metres of height between two places from which on an edge is looked for between them, and the halvings that takes.
const EDGE: f32 = 0.02;
const HALVINGS: u8 = 4;
/// Steepest slope, rise over run, of a sole that rests on two edges: 31°.
const STEEP: f32 = 0.6;

/// Ground under a sole, heel first: places along the foot, and heights.
pub(super) struct Profile(ArrayVec<(f32, f32), { 2 * MOST }>);

impl Profile {
    /// The ground under `share` of `sole`'s length, as `height` tells it: under heel, waist and tip, and under a long sole at
    /// as many places as it takes that nothing of a step's size lies between them.
    pub(super) fn of(sole: SoleShape, share: f32, height: impl Fn(f32) -> f32) -> Self {
        let apart = APART.max((sole.heel + sole.tip) / (MOST - 3) as f32);
        let count = |length: f32, least: usize| ((length / apart).ceil() as usize).clamp(least, MOST);
        let (behind, ahead) = (count(sole.heel, 2), count(sole.tip, 1));
        let backward = (1..=behind).rev().map(|place| -sole.heel * place as f32 / behind as f32);
        let forward = (1..=ahead).map(|place| sole.tip * place as f32 / ahead as f32);
        let places = backward.chain(forward).map(|along| along * share).take(MOST);
        Self(places.map(|along| (along, height(along))).collect())
    }

    /// Places, and how high the ground there is over a line through the ball with this slope.
    pub(super) fn over(&self, slope: f32) -> impl Iterator<Item = (f32, f32)> {
        self.0.iter().map(move |(along, height)| (*along, height - slope * along))
    }

    /// Metres by which a line with this slope has to be over the ball not to be in the ground anywhere.
    fn lift(&self, slope: f32) -> f32 {
        self.over(slope).map(|point| point.1).fold(0.0, f32::max)
    }

    /// Adds the upper ends of steps that lie between two places; there is room for one each.
    fn find_edges(&mut self, size: f32, height: impl Fn(f32) -> f32) {
        let mut places = self.0.clone();
        places.insert(places.iter().filter(|place| place.0 < 0.0).count(), (0.0, 0.0));
        for pair in places.windows(2) {
            let (mut low, mut high) = if pair[0].1 > pair[1].1 { (pair[1], pair[0]) } else { (pair[0], pair[1]) };
            if high.1 - low.1 > EDGE * size {
                for _ in 0..HALVINGS {
                    let along = 0.5 * (low.0 + high.0);
                    let middle = (along, height(along));
                    *if high.1 - middle.1 < middle.1 - low.1 { &mut high } else { &mut low } = middle;
                }
                self.0.push(high);
            }
        }
    }
}

/// How a sole rests: its slope along the foot, and the ball's height over the ground below it in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    pub(super) slope: f32,
    pub(super) lift: f32,
}

/// How `sole` rests over `profile`: as `slope` says, unless it would stick in it; then as a board does, on the two edges
/// that carry it with the ball as low as may be. Nothing rests on what is too high to step on.
pub(super) fn resting(profile: &Profile, slope: f32, sole: SoleShape, height: impl Fn(f32) -> f32) -> Rest {
    let size = sole.size();
    let flat = Rest { slope, lift: 0.0 };
    if profile.lift(slope) <= TOLERATED * size.min(1.0) {
        return flat;
    }
    // A sole that is pitched reaches less far: over other steps, maybe.
    let under = |slope: f32| {
        let mut profile = Profile::of(sole, reach(slope), &height);
        profile.find_edges(size, &height);
        profile
    };
    let first = on_edges(profile, slope);
    let rest = on_edges(&under(on_edges(&under(first.slope), slope).slope), slope);
    let rest = Rest { lift: under(rest.slope).lift(rest.slope), ..rest };
    if rest.lift <= PROPPED * size { rest } else { flat }
}

/// Share of a sole's length that it covers of the ground when it is pitched by `slope`.
fn reach(slope: f32) -> f32 {
    1.0 / (1.0 + slope * slope).sqrt()
}

/// The line that has the ball as low as may be and is nowhere in the ground: on two places that carry it, or as `slope`
/// says.
fn on_edges(profile: &Profile, slope: f32) -> Rest {
    let ball = (0.0, 0.0);
    let behind = || profile.0.iter().filter(|point| point.0 < 0.0).chain([&ball]);
    let ahead = || profile.0.iter().filter(|point| point.0 > 0.0);
    let slopes = behind().flat_map(|a| ahead().map(move |b| (b.1 - a.1) / (b.0 - a.0))).chain([slope]);
    let rests = slopes.filter(|slope| slope.is_finite()).map(|slope| {
        let slope = slope.clamp(-STEEP, STEEP);
        Rest { slope, lift: profile.lift(slope) }
    });
    rests.min_by(|a, b| a.lift.total_cmp(&b.lift)).unwrap_or(Rest { slope, lift: 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stairs of 17 by 29 cm that rise ahead, the ball `on` metres behind an edge.
    fn stairs(on: f32) -> impl Fn(f32) -> f32 {
        move |along: f32| ((along - on) / 0.29).floor().max(-20.0) * 0.17 + 0.17
    }

    #[test]
    fn a_board_over_stairs_is_in_none_of_their_edges_and_touches_one() {
        let sole = SoleShape { heel: 0.66, tip: 0.28, ankle: 0.4, ankle_height: 0.2, bends: false };
        for centimetres in 1..29u8 {
            let height = stairs(0.01 * f32::from(centimetres));
            let rest = resting(&Profile::of(sole, 1.0, &height), 0.0, sole, &height);
            let reach = reach(rest.slope);
            let over = (0..=940).map(|place| {
                let along = (0.001 * f32::from(i16::try_from(place).expect("small")) - 0.66) * reach;
                rest.lift + rest.slope * along - height(along)
            });
            let least = over.fold(f32::MAX, f32::min);
            assert!((-0.012..0.012).contains(&least), "{centimetres} cm before an edge: {least} m over the nearest");
        }
    }
}
