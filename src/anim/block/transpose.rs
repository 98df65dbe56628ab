//! Rows become columns: from lanes = joints to lanes = characters, and on to one matrix after the other.

use fearless_simd::{Level, Simd, f32x4, prelude::*};

use super::lanes::{Floats, Row};

/// The lower halves of two rows side by side, or the upper ones.
#[inline(always)]
pub(super) fn halves<S: Simd>(simd: S, low: &Row, high: &Row, half: usize) -> Floats<S> {
    let four = |row: &Row| f32x4::from_slice(simd, &row[4 * half..4 * half + 4]);
    four(low).combine(four(high))
}

/// In each half of the lanes four rows of four become columns:
///
/// ```text
/// a0 a1 a2 a3 | a4 a5 a6 a7        a0 b0 c0 d0 | a4 b4 c4 d4
/// b0 b1 b2 b3 | b4 b5 b6 b7   ->   a1 b1 c1 d1 | a5 b5 c5 d5
/// c0 c1 c2 c3 | c4 c5 c6 c7        a2 b2 c2 d2 | a6 b6 c6 d6
/// d0 d1 d2 d3 | d4 d5 d6 d7        a3 b3 c3 d3 | a7 b7 c7 d7
/// ```
#[inline(always)]
pub(super) fn transpose_halves<S: Simd>(simd: S, rows: [Floats<S>; 4]) -> [Floats<S>; 4] {
    // `S` is one of these itself; the compiler needs to be told.
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    match simd.level() {
        Level::Avx2(avx2) => {
            let [a, b, c, d] = rows.map(|row| <[f32; 8]>::from(row).simd_into(avx2));
            return x86::with_avx2(avx2, a, b, c, d).map(|row| <[f32; 8]>::from(row).simd_into(simd));
        }
        Level::Avx512(avx512) => {
            let [a, b, c, d] = rows.map(|row| <[f32; 8]>::from(row).simd_into(avx512));
            return x86::with_avx512(avx512, a, b, c, d).map(|row| <[f32; 8]>::from(row).simd_into(simd));
        }
        _ => {}
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

/// The shuffles of x86 work on both halves at once; the portable ones go across and cost twice as many.
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
mod x86 {
    #[cfg(target_arch = "x86")]
    use core::arch::x86::{_mm256_unpackhi_ps as zip_high, _mm256_unpacklo_ps as zip_low};
    #[cfg(target_arch = "x86_64")]
    use core::arch::x86_64::{_mm256_unpackhi_ps as zip_high, _mm256_unpacklo_ps as zip_low};

    use fearless_simd::{
        f32x8,
        prelude::*,
        x86::{Avx2, Avx512},
    };

    macro_rules! transpose_halves {
        ($name:ident, $level:ident) => {
            fearless_simd::kernel!(
                #[inline(always)]
                pub(super) fn $name(
                    simd: $level,
                    a: f32x8<$level>,
                    b: f32x8<$level>,
                    c: f32x8<$level>,
                    d: f32x8<$level>,
                ) -> [f32x8<$level>; 4] {
                    let (ac_low, ac_high) = (zip_low(a.into(), c.into()), zip_high(a.into(), c.into()));
                    let (bd_low, bd_high) = (zip_low(b.into(), d.into()), zip_high(b.into(), d.into()));
                    [
                        zip_low(ac_low, bd_low).simd_into(simd),
                        zip_high(ac_low, bd_low).simd_into(simd),
                        zip_low(ac_high, bd_high).simd_into(simd),
                        zip_high(ac_high, bd_high).simd_into(simd),
                    ]
                }
            );
        };
    }

    transpose_halves!(with_avx2, Avx2);
    transpose_halves!(with_avx512, Avx512);
}
