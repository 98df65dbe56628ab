//! Rows become columns: between lanes = joints, lanes = characters and one matrix after the other.

use fearless_simd::{Level, Simd, f32x4, prelude::*};

use super::lanes::{Floats, Row};

/// The lower halves of two rows side by side, or the upper ones.
#[inline(always)]
pub(super) fn halves<S: Simd>(simd: S, low: &Row, high: &Row, half: usize) -> Floats<S> {
    let four = |row: &Row| f32x4::from_slice(simd, &row[4 * half..4 * half + 4]);
    four(low).combine(four(high))
}

/// In each half of the lanes four rows of four become columns.
#[inline(always)]
pub(super) fn transpose_halves<S: Simd>(simd: S, rows: [Floats<S>; 4]) -> [Floats<S>; 4] {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Level::Avx2(avx2) = simd.level() {
        // `S` is `Avx2` itself; the compiler needs to be told.
        let [a, b, c, d] = rows.map(|row| <[f32; 8]>::from(row).simd_into(avx2));
        return avx2::transpose_halves(avx2, a, b, c, d).map(|row| <[f32; 8]>::from(row).simd_into(simd));
    }
    let [a, b, c, d] = rows;
    let ((a, a_high), (b, b_high), (c, c_high), (d, d_high)) = (a.split(), b.split(), c.split(), d.split());
    let [a, b, c, d] = transpose(a, b, c, d);
    let [a_high, b_high, c_high, d_high] = transpose(a_high, b_high, c_high, d_high);
    [a.combine(a_high), b.combine(b_high), c.combine(c_high), d.combine(d_high)]
}

/// Four rows of four become columns.
#[inline(always)]
fn transpose<S: Simd>(a: f32x4<S>, b: f32x4<S>, c: f32x4<S>, d: f32x4<S>) -> [f32x4<S>; 4] {
    let ((ac_low, ac_high), (bd_low, bd_high)) = (a.interleave(c), b.interleave(d));
    let ((first, second), (third, fourth)) = (ac_low.interleave(bd_low), ac_high.interleave(bd_high));
    [first, second, third, fourth]
}

/// AVX2's shuffles work on both halves at once; the portable ones go across and cost twice as many.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod avx2 {
    #[cfg(target_arch = "x86")]
    use core::arch::x86::{_mm256_unpackhi_ps as zip_high, _mm256_unpacklo_ps as zip_low};
    #[cfg(target_arch = "x86_64")]
    use core::arch::x86_64::{_mm256_unpackhi_ps as zip_high, _mm256_unpacklo_ps as zip_low};

    use fearless_simd::{f32x8, prelude::*, x86::Avx2};

    fearless_simd::kernel!(
        #[inline(always)]
        pub(super) fn transpose_halves(
            avx2: Avx2,
            a: f32x8<Avx2>,
            b: f32x8<Avx2>,
            c: f32x8<Avx2>,
            d: f32x8<Avx2>,
        ) -> [f32x8<Avx2>; 4] {
            let (ac_low, ac_high) = (zip_low(a.into(), c.into()), zip_high(a.into(), c.into()));
            let (bd_low, bd_high) = (zip_low(b.into(), d.into()), zip_high(b.into(), d.into()));
            [
                zip_low(ac_low, bd_low).simd_into(avx2),
                zip_high(ac_low, bd_low).simd_into(avx2),
                zip_low(ac_high, bd_high).simd_into(avx2),
                zip_high(ac_high, bd_high).simd_into(avx2),
            ]
        }
    );
}
