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

/// Writes the palettes of `actors`, one lane each.
#[inline(always)]
pub(super) fn write<S: Simd>(
    simd: S,
    species: &Species,
    joints: &[JointRows],
    actors: &[Actor],
    matrices: &mut [JointMatrix],
) {
    let mut places = [const { 0..0 }; LANES];
    for (place, actor) in places.iter_mut().zip(actors) {
        let place_of_all = actor.palette..actor.palette.saturating_add(species.slots.len());
        if place_of_all.end <= matrices.len() {
            *place = place_of_all;
        }
    }
    debug_assert!(
        places.iter().take(actors.len()).all(|p| p.len() == species.slots.len()),
        "every palette has its place"
    );
    let palettes = matrices.get_disjoint_mut(places);
    debug_assert!(palettes.is_ok(), "no two palettes share a place");
    let Ok(palettes) = palettes else { return };
    for (index, slot) in species.slots.iter().enumerate() {
        let joint = match slot.rest {
            None => &joints[slot.joint],
            Some(rest) => &with_rest(simd, &joints[slot.joint], rest, slot.offset),
        };
        let offset = if slot.rest.is_some() { [0.0; 3] } else { slot.offset };
        for half in 0..2 {
            let x = quads(simd, joint, 0, half, offset);
            let y = quads(simd, joint, 1, half, offset);
            let z = quads(simd, joint, 2, half, offset);
            for lane in 0..4 {
                if let Some(matrix) = palettes[4 * half + lane].get_mut(index) {
                    x[lane].store_slice(&mut matrix.0[0]);
                    y[lane].store_slice(&mut matrix.0[1]);
                    z[lane].store_slice(&mut matrix.0[2]);
                }
            }
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
