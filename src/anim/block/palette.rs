//! Writes palettes: lanes = characters, turned back to one matrix after the other.
//!
//! Reads placed joints, writes `model_from_joint * inverse_bind` in rows, each once.

use fearless_simd::{Simd, f32x4, prelude::*};

use super::{
    Actor,
    lanes::{LANES, Mat3s, Vec3s, four, transpose},
    model::{JointRows, Placed},
    species::Species,
};
use crate::anim::skin::JointMatrix;

/// Writes the palettes of `actors`, one lane each. `spare` has room for the palettes of a block.
#[inline(always)]
pub(super) fn write<S: Simd>(
    simd: S,
    species: &Species,
    joints: &[JointRows],
    actors: &[Actor],
    matrices: &mut [JointMatrix],
    spare: &mut [JointMatrix],
) {
    let count = species.slots.len();
    let mut places = [const { 0..0 }; LANES];
    for (place, actor) in places.iter_mut().zip(actors) {
        let place_of_all = actor.palette..actor.palette.saturating_add(count);
        if place_of_all.end <= matrices.len() {
            *place = place_of_all;
        }
    }
    debug_assert!(places.iter().take(actors.len()).all(|p| p.len() == count), "every palette has its place");
    let palettes = matrices.get_disjoint_mut(places);
    debug_assert!(palettes.is_ok(), "no two palettes share a place");
    let Ok(palettes) = palettes else { return };
    // Lanes of nobody are written, too: all of one length, no matrix needs to look for its palette's end.
    let mut spare = spare.chunks_exact_mut(count.max(1));
    let [a, b, c, d, e, f, g, h] = palettes.map(|palette| match palette.len() == count {
        true => palette,
        false => spare.next().unwrap_or_default(),
    });
    if [&a, &b, &c, &d, &e, &f, &g, &h].iter().any(|palette| palette.len() < count) {
        return;
    }
    let (a, b, c, d) = (&mut a[..count], &mut b[..count], &mut c[..count], &mut d[..count]);
    let (e, f, g, h) = (&mut e[..count], &mut f[..count], &mut g[..count], &mut h[..count]);
    for (index, slot) in species.slots.iter().enumerate().take(count) {
        let joint = match slot.rest {
            None => &joints[slot.joint],
            Some(rest) => &with_rest(simd, &joints[slot.joint], rest, slot.offset),
        };
        let offset = if slot.rest.is_some() { [0.0; 3] } else { slot.offset };
        for row in 0..3 {
            let first = quads(simd, joint, row, 0, offset);
            first[0].store_slice(&mut a[index].0[row]);
            first[1].store_slice(&mut b[index].0[row]);
            first[2].store_slice(&mut c[index].0[row]);
            first[3].store_slice(&mut d[index].0[row]);
            let last = quads(simd, joint, row, 1, offset);
            last[0].store_slice(&mut e[index].0[row]);
            last[1].store_slice(&mut f[index].0[row]);
            last[2].store_slice(&mut g[index].0[row]);
            last[3].store_slice(&mut h[index].0[row]);
        }
    }
}

/// A joint with what is left of the inverse bind matrix: `offset` first, then `rest`.
#[inline(always)]
fn with_rest<S: Simd>(simd: S, joint: &JointRows, rest: [[f32; 3]; 3], offset: [f32; 3]) -> JointRows {
    let placed = Placed::load(simd, joint);
    let position = placed.matrix.moved(Vec3s::splat(simd, offset), placed.position);
    let mut turned = JointRows::default();
    Placed { matrix: placed.matrix.times(&Mat3s::splat(simd, rest)), position }.store(&mut turned);
    turned
}

/// One row of the matrix of four characters: the joint's row, and where `offset` of the joint is.
#[inline(always)]
fn quads<S: Simd>(simd: S, joint: &JointRows, row: usize, half: usize, offset: [f32; 3]) -> [f32x4<S>; 4] {
    let [x, y, z] = &joint[row];
    let (x, y, z) = (four(simd, x, half), four(simd, y, half), four(simd, z, half));
    let place = four(simd, &joint[3][row], half);
    let place = x.mul_add(offset[0], y.mul_add(offset[1], z.mul_add(offset[2], place)));
    transpose(x, y, z, place)
}
