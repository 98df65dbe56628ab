//! How much of the sky the pieces hide from the ground around them: a soft dark rim that seats them on it.
//!
//! World space, metres; one value per vertex of the [`Heightfield`].

use bevy::math::{Vec2, Vec3};

use super::{Heightfield, Piece, landscape::rise};

/// How dark the ground gets right beside a piece, 0..=1.
const DARKEST: f32 = 0.5;
/// Farthest that a piece darkens the ground, metres; a low piece reaches as far as it is high.
const REACH: f32 = 1.1;

/// Darkness at every vertex of a [`Heightfield`], 0..=1.
pub struct Shade {
    values: Vec<f32>,
    cells: usize,
    cell_size: f32,
}

impl Shade {
    /// The shade of all `pieces` that stand still.
    #[must_use]
    pub fn of<'a>(pieces: impl IntoIterator<Item = &'a Piece>, field: &Heightfield) -> Self {
        let side = field.cells() + 1;
        let mut shade = Self { values: vec![0.0; side * side], cells: field.cells(), cell_size: field.cell_size() };
        for piece in pieces.into_iter().filter(|piece| piece.motion.is_none()) {
            let reach = piece.shape.height().clamp(0.1, REACH);
            let wide = piece.shape.reach() + reach;
            let (low, high) = (shade.line(piece.position - wide), shade.line(piece.position + wide));
            for x in low.0..=high.0 {
                for z in low.1..=high.1 {
                    let vertex = field.vertex(x, z);
                    // A piece high up, like a beam or a lamp, leaves the ground alone.
                    if piece.position.y - vertex.y > REACH {
                        continue;
                    }
                    let local = piece.rotation.inverse() * (vertex - piece.position);
                    let off = piece.shape.outside(Vec2::new(local.x, local.z));
                    let dark = DARKEST * (1.0 - rise(off, -0.2, reach));
                    let value = &mut shade.values[x * side + z];
                    *value = value.max(dark);
                }
            }
        }
        shade
    }

    /// Darkness at the vertex nearest to a world position.
    #[must_use]
    pub fn at(&self, x: f32, z: f32) -> f32 {
        let (x, z) = self.line(Vec3::new(x, 0.0, z));
        self.values[x * (self.cells + 1) + z]
    }

    fn line(&self, at: Vec3) -> (usize, usize) {
        let nearest = |coordinate: f32| {
            let line = (coordinate / self.cell_size + self.cells as f32 * 0.5).round();
            line.clamp(0.0, self.cells as f32) as usize
        };
        (nearest(at.x), nearest(at.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::course;

    #[test]
    fn the_ground_is_dark_beside_the_stairs_and_light_in_the_open() {
        let field = Heightfield::from_fn(64, 0.5, |_, _| 0.0);
        let shade = Shade::of(&course::pieces(&field), &field);
        let (beside, open) = (shade.at(-11.3, 8.0), shade.at(-6.0, -11.0));
        assert!(beside > 0.3, "{beside} beside the stairs");
        assert!(open < 0.01, "{open} in the open");
    }
}
