//! Writes palettes: lanes = characters, turned back to one matrix after the other.
//!
//! Reads placed joints, writes `model_from_joint * inverse_bind` in rows, each once.

use fearless_simd::{Simd, prelude::*};

use super::{
    Actor,
    lanes::{Floats, LANES, Mat3s, Vec3s, load},
    model::{JointRows, Placed},
    species::{Rest, Species},
    transpose::transpose_halves,
};
use crate::anim::matrix::JointMatrix;

/// Writes the palettes of `actors`, one lane each. `spare` has room for the palettes of a block.
#[inline(always)]
pub(super) fn write<S: Simd>(
    simd: S,
    species: &Species,
    joints: &mut [JointRows],
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
    place_rests(simd, species, joints);
    let (a, b, c, d) = (&mut a[..count], &mut b[..count], &mut c[..count], &mut d[..count]);
    let (e, f, g, h) = (&mut e[..count], &mut f[..count], &mut g[..count], &mut h[..count]);
    for (index, slot) in species.slots.iter().enumerate().take(count) {
        let [ae, bf, cg, dh] = pairs(simd, &joints[slot.joint], slot.offset);
        store(ae, &mut a[index], &mut e[index]);
        store(bf, &mut b[index], &mut f[index]);
        store(cg, &mut c[index], &mut g[index]);
        store(dh, &mut d[index], &mut h[index]);
    }
}

/// The rows of two characters' matrix, each character's one after the other: they share a line of the cache.
#[inline(always)]
fn store<S: Simd>(rows: [Floats<S>; 3], first: &mut JointMatrix, second: &mut JointMatrix) {
    let [x, y, z] = rows;
    let (x, y, z) = (x.split(), y.split(), z.split());
    x.0.store_slice(&mut first.0[0]);
    y.0.store_slice(&mut first.0[1]);
    z.0.store_slice(&mut first.0[2]);
    x.1.store_slice(&mut second.0[0]);
    y.1.store_slice(&mut second.0[1]);
    z.1.store_slice(&mut second.0[2]);
}

/// The rows of the matrix of eight characters, those of the first beside those of the fifth and so on: the joint's rows, and
/// where `offset` of the joint is.
#[inline(always)]
fn pairs<S: Simd>(simd: S, joint: &JointRows, offset: [f32; 3]) -> [[Floats<S>; 3]; 4] {
    let [a, b, c, d] = rows(simd, joint, 0, offset);
    let [e, f, g, h] = rows(simd, joint, 1, offset);
    let [i, j, k, l] = rows(simd, joint, 2, offset);
    [[a, e, i], [b, f, j], [c, g, k], [d, h, l]]
}

/// One row of the matrix of eight characters, the first beside the fifth and so on: the joint's row, and where `offset` of the
/// joint is.
#[inline(always)]
fn rows<S: Simd>(simd: S, joint: &JointRows, row: usize, offset: [f32; 3]) -> [Floats<S>; 4] {
    let axes = Vec3s::load(simd, &joint[row]);
    let place = axes.dot_plus(Vec3s::splat(simd, offset), load(simd, &joint[3][row]));
    transpose_halves(simd, [axes.x, axes.y, axes.z, place])
}

/// Places joints with what is left of their inverse bind matrix, as if they were joints of their own.
#[inline(always)]
fn place_rests<S: Simd>(simd: S, species: &Species, joints: &mut [JointRows]) {
    for Rest { joint, place, offset, matrix } in &species.rests {
        let placed = Placed::load(simd, &joints[*joint]);
        let position = placed.matrix.moved(Vec3s::splat(simd, *offset), placed.position);
        Placed { matrix: placed.matrix.times(&Mat3s::splat(simd, *matrix)), position }.store(&mut joints[*place]);
    }
}
