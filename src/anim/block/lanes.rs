//! Lanes: one number of eight joints, or of eight characters, side by side; vectors, quaternions and matrices of them.
//!
//! Everything here is inlined into the kernels, which run with the widest instructions that the machine has: eight lanes
//! are one register with AVX2, two with SSE2 and NEON.

use fearless_simd::{Simd, f32x4, f32x8, i16x8, mask32x8, prelude::*};

/// How many numbers lie side by side.
pub(super) const LANES: usize = 8;
/// Numbers of eight joints or characters in memory.
pub(super) type Row = [f32; LANES];
/// The same in registers.
pub(super) type Floats<S> = f32x8<S>;
/// Yes or no for each lane.
pub(super) type Mask<S> = mask32x8<S>;

/// Shortest squared length that has a direction; as in `math::rotation`.
const TINY_SQUARED: f32 = 1e-16;
/// Squared length of a quaternion that says nothing.
const TINIEST_SQUARED: f32 = 1e-12;
/// Cosine below which two directions count as opposite; as in `math::rotation`.
const OPPOSITE: f32 = -0.999_999;

#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, value: f32) -> Floats<S> {
    Floats::simd_from(simd, value)
}

#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, row: &Row) -> Floats<S> {
    Floats::from_slice(simd, row)
}

#[inline(always)]
pub(super) fn store<S: Simd>(value: Floats<S>, row: &mut Row) {
    value.store_slice(row);
}

/// Short integers as floats.
#[inline(always)]
pub(super) fn load_shorts<S: Simd>(simd: S, row: &[i16; LANES]) -> Floats<S> {
    let (low, high) = i16x8::from_slice(simd, row).widen();
    f32x4::float_from(low).combine(f32x4::float_from(high))
}

#[inline(always)]
pub(super) fn select<S: Simd>(mask: Mask<S>, yes: Floats<S>, no: Floats<S>) -> Floats<S> {
    mask.select(yes, no)
}

/// `1 / sqrt(squared)` for 0.75 ..= 1, the squared length of what lies straight between two unit quaternions of one side.
///
/// A parabola within 0.03 % of it, then one step of Newton's: within 2e-7, without division or root. Below, for joints that
/// turn by more than 120° from frame to frame, it is up to 0.1 % off.
#[inline(always)]
pub(super) fn inverse_length_between_units<S: Simd>(simd: S, squared: Floats<S>) -> Floats<S> {
    let guess = squared.mul_add(splat(simd, PARABOLA[2]), splat(simd, PARABOLA[1]));
    let guess = guess.mul_add(squared, splat(simd, PARABOLA[0]));
    guess * (guess * guess).mul_add(squared * -0.5, splat(simd, 1.5))
}

/// Coefficients of the parabola with the least relative error (Remez).
const PARABOLA: [f32; 3] = [2.012982, -1.540551, 0.527734];

/// `base - a * b`.
#[inline(always)]
fn less<S: Simd>(base: Floats<S>, a: Floats<S>, b: Floats<S>) -> Floats<S> {
    (-a).mul_add(b, base)
}

/// A vector in each lane.
#[derive(Clone, Copy)]
pub(super) struct Vec3s<S: Simd> {
    pub(super) x: Floats<S>,
    pub(super) y: Floats<S>,
    pub(super) z: Floats<S>,
}

impl<S: Simd> Vec3s<S> {
    #[inline(always)]
    pub(super) fn new(x: Floats<S>, y: Floats<S>, z: Floats<S>) -> Self {
        Self { x, y, z }
    }

    #[inline(always)]
    pub(super) fn splat(simd: S, [x, y, z]: [f32; 3]) -> Self {
        Self::new(splat(simd, x), splat(simd, y), splat(simd, z))
    }

    #[inline(always)]
    pub(super) fn load(simd: S, [x, y, z]: &[Row; 3]) -> Self {
        Self::new(load(simd, x), load(simd, y), load(simd, z))
    }

    #[inline(always)]
    pub(super) fn store(self, [x, y, z]: &mut [Row; 3]) {
        store::<S>(self.x, x);
        store::<S>(self.y, y);
        store::<S>(self.z, z);
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }

    #[inline(always)]
    pub(super) fn minus(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }

    #[inline(always)]
    pub(super) fn times(self, factor: Floats<S>) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> Floats<S> {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z * other.z))
    }

    /// `self.dot(other) + base`.
    #[inline(always)]
    pub(super) fn dot_plus(self, other: Self, base: Floats<S>) -> Floats<S> {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z.mul_add(other.z, base)))
    }

    #[inline(always)]
    pub(super) fn cross(self, other: Self) -> Self {
        Self::new(
            self.y.mul_sub(other.z, self.z * other.y),
            self.z.mul_sub(other.x, self.x * other.z),
            self.x.mul_sub(other.y, self.y * other.x),
        )
    }

    #[inline(always)]
    pub(super) fn length(self) -> Floats<S> {
        self.dot(self).sqrt()
    }

    #[inline(always)]
    pub(super) fn is_finite(self) -> Mask<S> {
        // Infinity times zero is not a number, and a number that isn't is not equal to itself.
        let zero = (self.x * 0.0) + (self.y * 0.0) + (self.z * 0.0);
        zero.simd_eq(zero)
    }

    #[inline(always)]
    pub(super) fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Self::new(select::<S>(mask, yes.x, no.x), select::<S>(mask, yes.y, no.y), select::<S>(mask, yes.z, no.z))
    }

    /// One long, or `fallback` where it has no direction.
    #[inline(always)]
    pub(super) fn direction_or(self, simd: S, fallback: Self) -> Self {
        let squared = self.dot(self);
        let has = squared.simd_gt(splat(simd, TINY_SQUARED)) & squared.simd_le(splat(simd, f32::MAX));
        Self::select(has, self.times(splat(simd, 1.0) / squared.sqrt()), fallback)
    }

    /// Some unit vector at right angles.
    #[inline(always)]
    pub(super) fn any_perpendicular(self, simd: S) -> Self {
        let zero = splat(simd, 0.0);
        let (across_x, across_y) = (Self::new(zero, self.z, -self.y), Self::new(-self.z, zero, self.x));
        let along_x = self.x.max(-self.x).simd_ge(self.length() * 0.7);
        Self::select(along_x, across_y, across_x).direction_or(simd, Self::splat(simd, [0.0, 0.0, 1.0]))
    }
}

/// A quaternion in each lane.
#[derive(Clone, Copy)]
pub(super) struct Quats<S: Simd> {
    pub(super) x: Floats<S>,
    pub(super) y: Floats<S>,
    pub(super) z: Floats<S>,
    pub(super) w: Floats<S>,
}

impl<S: Simd> Quats<S> {
    #[inline(always)]
    pub(super) fn new(x: Floats<S>, y: Floats<S>, z: Floats<S>, w: Floats<S>) -> Self {
        Self { x, y, z, w }
    }

    #[inline(always)]
    pub(super) fn load(simd: S, [x, y, z, w]: &[Row; 4]) -> Self {
        Self::new(load(simd, x), load(simd, y), load(simd, z), load(simd, w))
    }

    #[inline(always)]
    pub(super) fn store(self, [x, y, z, w]: &mut [Row; 4]) {
        store::<S>(self.x, x);
        store::<S>(self.y, y);
        store::<S>(self.z, z);
        store::<S>(self.w, w);
    }

    #[inline(always)]
    pub(super) fn identity(simd: S) -> Self {
        let zero = splat(simd, 0.0);
        Self::new(zero, zero, zero, splat(simd, 1.0))
    }

    #[inline(always)]
    pub(super) fn times(self, factor: Floats<S>) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor, self.w * factor)
    }

    /// `self + other * factor`.
    #[inline(always)]
    pub(super) fn plus_times(self, other: Self, factor: Floats<S>) -> Self {
        Self::new(
            other.x.mul_add(factor, self.x),
            other.y.mul_add(factor, self.y),
            other.z.mul_add(factor, self.z),
            other.w.mul_add(factor, self.w),
        )
    }

    /// Straight from `self` to `other`, not one long.
    #[inline(always)]
    pub(super) fn toward(self, other: Self, share: Floats<S>) -> Self {
        Self::new(
            (other.x - self.x).mul_add(share, self.x),
            (other.y - self.y).mul_add(share, self.y),
            (other.z - self.z).mul_add(share, self.z),
            (other.w - self.w).mul_add(share, self.w),
        )
    }

    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> Floats<S> {
        self.x.mul_add(other.x, self.y.mul_add(other.y, self.z.mul_add(other.z, self.w * other.w)))
    }

    #[inline(always)]
    pub(super) fn select(mask: Mask<S>, yes: Self, no: Self) -> Self {
        Self::new(
            select(mask, yes.x, no.x),
            select(mask, yes.y, no.y),
            select(mask, yes.z, no.z),
            select(mask, yes.w, no.w),
        )
    }

    /// One long, or the identity where it has no length.
    #[inline(always)]
    pub(super) fn normalized_or_identity(self, simd: S) -> Self {
        let squared = self.dot(self);
        let has = squared.simd_gt(splat(simd, TINIEST_SQUARED));
        let inverse = splat(simd, 1.0) / squared.sqrt();
        let inverse = select::<S>(has, inverse, splat(simd, 0.0));
        let mut unit = self.times(inverse);
        unit.w = select::<S>(has, unit.w, splat(simd, 1.0));
        unit
    }

    /// Turns by `other`, then by `self`.
    #[inline(always)]
    pub(super) fn after(self, other: Self) -> Self {
        let (a, b) = (self, other);
        Self::new(
            less::<S>(a.w.mul_add(b.x, a.x.mul_add(b.w, a.y * b.z)), a.z, b.y),
            less::<S>(a.w.mul_add(b.y, a.y.mul_add(b.w, a.z * b.x)), a.x, b.z),
            less::<S>(a.w.mul_add(b.z, a.z.mul_add(b.w, a.x * b.y)), a.y, b.x),
            less::<S>(less::<S>(a.w.mul_sub(b.w, a.x * b.x), a.y, b.y), a.z, b.z),
        )
    }

    /// The least rotation that turns unit vector `from` into `to`.
    #[inline(always)]
    pub(super) fn shortest_arc(simd: S, from: Vec3s<S>, to: Vec3s<S>) -> Self {
        let (cos, cross) = (from.dot(to), from.cross(to));
        let arc = Self::new(cross.x, cross.y, cross.z, cos + 1.0).normalized_or_identity(simd);
        let (opposite, half) = (cos.simd_lt(splat(simd, OPPOSITE)), from.any_perpendicular(simd));
        Self::new(
            select::<S>(opposite, half.x, arc.x),
            select::<S>(opposite, half.y, arc.y),
            select::<S>(opposite, half.z, arc.z),
            select::<S>(opposite, splat(simd, 0.0), arc.w),
        )
    }
}

/// A 3×3 matrix in each lane, by rows.
#[derive(Clone, Copy)]
pub(super) struct Mat3s<S: Simd>(pub(super) [Vec3s<S>; 3]);

impl<S: Simd> Mat3s<S> {
    /// Of unit quaternions.
    #[inline(always)]
    pub(super) fn from_quats(simd: S, q: Quats<S>) -> Self {
        Self::from_scaled_quats(simd, q, splat(simd, 2.0))
    }

    /// Of quaternions of any length; the identity where they have none, and something near it where they have hardly any.
    #[inline(always)]
    pub(super) fn from_any_quats(simd: S, q: Quats<S>) -> Self {
        let squared = q.dot(q);
        Self::from_scaled_quats(simd, q, splat(simd, 2.0) / squared.max(TINIEST_SQUARED))
    }

    /// `scale` is two over the squared length.
    #[inline(always)]
    fn from_scaled_quats(simd: S, q: Quats<S>, scale: Floats<S>) -> Self {
        let one = splat(simd, 1.0);
        let (x2, y2, z2) = (q.x * scale, q.y * scale, q.z * scale);
        let (wx, wy, wz) = (q.w * x2, q.w * y2, q.w * z2);
        let (yy, zz, without_xx) = (q.y * y2, q.z * z2, (-q.x).mul_add(x2, one));
        Self([
            Vec3s::new(one - yy - zz, q.x.mul_sub(y2, wz), q.x.mul_add(z2, wy)),
            Vec3s::new(q.x.mul_add(y2, wz), without_xx - zz, q.y.mul_sub(z2, wx)),
            Vec3s::new(q.x.mul_sub(z2, wy), q.y.mul_add(z2, wx), without_xx - yy),
        ])
    }

    #[inline(always)]
    pub(super) fn splat(simd: S, [a, b, c]: [[f32; 3]; 3]) -> Self {
        Self([Vec3s::splat(simd, a), Vec3s::splat(simd, b), Vec3s::splat(simd, c)])
    }

    #[inline(always)]
    pub(super) fn times(&self, other: &Self) -> Self {
        let [a, b, c] = self.0;
        Self([other.row_times(a), other.row_times(b), other.row_times(c)])
    }

    /// `row * self`.
    #[inline(always)]
    pub(super) fn row_times(&self, row: Vec3s<S>) -> Vec3s<S> {
        let [x, y, z] = self.0;
        Vec3s::new(
            row.x.mul_add(x.x, row.y.mul_add(y.x, row.z * z.x)),
            row.x.mul_add(x.y, row.y.mul_add(y.y, row.z * z.y)),
            row.x.mul_add(x.z, row.y.mul_add(y.z, row.z * z.z)),
        )
    }

    /// `self * vector + base`.
    #[inline(always)]
    pub(super) fn moved(&self, vector: Vec3s<S>, base: Vec3s<S>) -> Vec3s<S> {
        let [a, b, c] = self.0;
        Vec3s::new(a.dot_plus(vector, base.x), b.dot_plus(vector, base.y), c.dot_plus(vector, base.z))
    }
}
