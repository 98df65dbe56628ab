//! What moves, in a grid that is made anew in every tick: a crowd asks who is near in a tenth of the time that the physics engine's tree
//! takes, into which all that has moved was put one by one.
//!
//! World space, metres. Reads the bounds of kinematic colliders, characters' mostly, as the last physics step left them.

use avian3d::{collider_tree::ColliderTrees, prelude::ColliderAabb};
use bevy::prelude::*;

use super::{CharacterMotion, heightfield::Span};

/// Side of a cell.
const CELL: f32 = 2.0;
/// Kinematic colliders up to which looking at all of them is no slower than a search.
const MOST_OTHERS: usize = 16;

/// Kinematic colliders.
#[derive(Resource, Debug, Default)]
pub(in crate::character) struct Movers {
    /// Where in `small` each bucket begins, and where the last ends. Several cells may share a bucket.
    starts: Vec<u32>,
    small: Vec<Mover>,
    /// Those that are larger than a cell.
    large: Vec<Mover>,
    /// Half the largest side of those that aren't.
    reach: Vec2,
    /// Those that are no character's.
    others: Vec<Entity>,
    /// How many there were.
    count: usize,
    unsorted: Vec<Mover>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Mover {
    bounds: Span,
    collider: Option<Entity>,
    /// Of its middle.
    cell: IVec2,
}

fn cell(place: Vec2) -> IVec2 {
    (place / CELL).floor().as_ivec2()
}

fn flat(place: Vec3) -> Vec2 {
    Vec2::new(place.x, place.z)
}

impl Movers {
    fn bucket(&self, cell: IVec2) -> usize {
        let mixed = (cell.x as u32).wrapping_mul(0x9E37_79B1) ^ (cell.y as u32).wrapping_mul(0x85EB_CA77);
        // The upper bits are mixed best.
        (mixed.wrapping_mul(0x9E37_79B1) >> 16) as usize % (self.starts.len() - 1)
    }

    fn clear(&mut self) {
        self.small.clear();
        self.large.clear();
        self.others.clear();
        self.unsorted.clear();
        (self.count, self.reach) = (0, Vec2::ZERO);
    }

    fn add(&mut self, collider: Entity, bounds: Span) {
        let (middle, half) = (flat(bounds.least + bounds.most) * 0.5, flat(bounds.most - bounds.least) * 0.5);
        let mover = Mover { bounds, collider: Some(collider), cell: cell(middle) };
        if half.max_element() <= 0.5 * CELL {
            self.reach = self.reach.max(half);
            self.unsorted.push(mover);
        } else {
            self.large.push(mover);
        }
    }

    /// Sorts all that was added into buckets.
    fn sort(&mut self) {
        let buckets = (2 * self.unsorted.len()).next_power_of_two();
        self.starts.clear();
        self.starts.resize(buckets + 1, 0);
        for index in 0..self.unsorted.len() {
            let bucket = self.bucket(self.unsorted[index].cell);
            self.starts[bucket] += 1;
        }
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        self.small.resize(self.unsorted.len(), Mover::default());
        for index in 0..self.unsorted.len() {
            let mover = self.unsorted[index];
            let bucket = self.bucket(mover.cell);
            self.starts[bucket] -= 1;
            self.small[self.starts[bucket] as usize] = mover;
        }
    }

    /// Calls `found` with each that reaches into the span.
    pub(super) fn near(&self, span: Span, mut found: impl FnMut(Entity)) {
        let mut meet = |mover: &Mover| {
            if let Some(collider) = mover.collider.filter(|_| mover.bounds.meets(span)) {
                found(collider);
            }
        };
        self.large.iter().for_each(&mut meet);
        if self.small.is_empty() {
            return;
        }
        let (from, to) = (cell(flat(span.least) - self.reach), cell(flat(span.most) + self.reach));
        let cells = to.as_i64vec2() - from.as_i64vec2() + 1;
        if cells.x.saturating_mul(cells.y) > self.small.len() as i64 {
            return self.small.iter().for_each(meet);
        }
        for x in from.x..=to.x {
            for y in from.y..=to.y {
                let (cell, bucket) = (IVec2::new(x, y), self.bucket(IVec2::new(x, y)));
                let movers = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
                self.small[movers].iter().filter(|mover| mover.cell == cell).for_each(&mut meet);
            }
        }
    }

    /// The kinematic colliders that are no character's; `None` where there are many, or where `trees` have others by now.
    pub(in crate::character) fn others(&self, trees: &ColliderTrees) -> Option<&[Entity]> {
        let known = self.count == trees.kinematic_tree.proxies.len() && self.others.len() <= MOST_OTHERS;
        known.then_some(&self.others)
    }
}

/// Finds what moves where it is now.
pub(super) fn find_movers(
    trees: Res<ColliderTrees>,
    bounds: Query<(&ColliderAabb, Has<CharacterMotion>)>,
    mut movers: ResMut<Movers>,
) {
    movers.clear();
    for (_, proxy) in trees.kinematic_tree.proxies.iter() {
        movers.count += 1;
        let Ok((bounds, is_character)) = bounds.get(proxy.collider) else { continue };
        movers.add(proxy.collider, Span { least: bounds.min, most: bounds.max });
        if !is_character {
            movers.others.push(proxy.collider);
        }
    }
    movers.sort();
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn span() -> impl Strategy<Value = Span> {
        let corner = prop::array::uniform3(-12.0f32..12.0);
        (corner, prop::array::uniform3(0.0f32..3.0)).prop_map(|(least, size)| {
            let least = Vec3::from(least);
            Span { least, most: least + Vec3::from(size) }
        })
    }

    proptest! {
        #[test]
        fn who_is_near_is_found_once(all in prop::collection::vec(span(), 0..60), asked in prop::collection::vec(span(), 8)) {
            let mut movers = Movers::default();
            for _ in 0..2 {
                // The second time in the memory of the first.
                movers.clear();
                for (index, span) in all.iter().enumerate() {
                    movers.add(Entity::from_raw_u32(index as u32).unwrap(), *span);
                }
                movers.sort();
            }
            for span in asked {
                let mut found = Vec::new();
                movers.near(span, |collider| found.push(collider.index_u32() as usize));
                found.sort_unstable();
                let wanted: Vec<usize> = (0..all.len()).filter(|index| all[*index].meets(span)).collect();
                prop_assert_eq!(found, wanted);
            }
        }
    }

    #[test]
    fn nonsense_is_near_nothing_and_asks_for_nothing() {
        let mut movers = Movers::default();
        movers.add(Entity::PLACEHOLDER, Span { least: Vec3::NAN, most: Vec3::NAN });
        movers.add(Entity::PLACEHOLDER, Span { least: Vec3::ZERO, most: Vec3::ONE });
        movers.sort();
        let mut found = 0;
        movers.near(Span { least: Vec3::splat(-1e30), most: Vec3::splat(1e30) }, |_| found += 1);
        assert_eq!(found, 1, "the sound one alone");
        movers.near(Span { least: Vec3::NAN, most: Vec3::NAN }, |_| found += 1);
        assert_eq!(found, 1, "a span of nonsense meets nothing");
    }
}
