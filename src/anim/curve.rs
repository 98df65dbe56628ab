//! Key-frame curves with the exact meaning glTF gives them: the truth that resampled clips are checked against.
//!
//! Times in seconds. Before the first key the first value holds, after the last key the last.

use bevy::math::{Quat, Vec3};

/// How values between keys come about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// A key's value holds until the next key.
    Step,
    /// Straight from key to key; rotations along the shortest arc at constant speed.
    #[default]
    Linear,
    /// Cubic Hermite splines. Three values a key: in-tangent, value, out-tangent.
    CubicSpline,
}

/// Why keys make no curve.
#[derive(thiserror::Error, Clone, Debug, PartialEq)]
pub enum CurveError {
    /// No key at all.
    #[error("it has no keys")]
    Empty,
    /// Times and values don't go together.
    #[error("{keys} keys need {expected} values, but there are {values}")]
    Count {
        /// How many key times there are.
        keys: usize,
        /// How many values they need.
        expected: usize,
        /// How many values there are.
        values: usize,
    },
    /// Times have to grow from key to key.
    #[error("the time of key {key}, {time} s, is not after the key before it, at {previous} s")]
    Order {
        /// Index of the key.
        key: usize,
        /// Its time in seconds.
        time: f32,
        /// The time of the key before in seconds.
        previous: f32,
    },
    /// A time or value is NaN or infinite.
    #[error("key {key} is not a finite number")]
    NotFinite {
        /// Index of the key.
        key: usize,
    },
    /// A rotation of length zero.
    #[error("the rotation of key {key} has length zero")]
    ZeroRotation {
        /// Index of the key.
        key: usize,
    },
}

/// What a curve can hold.
pub trait CurveValue: Copy {
    /// Between two keys, `t` in 0..=1.
    fn between(from: Self, to: Self, t: f32) -> Self;
    /// Weighted sum of four values: the form of a cubic Hermite spline.
    fn weighted(values: [Self; 4], weights: [f32; 4]) -> Self;
    /// All parts times `factor`, as a tangent is scaled.
    #[must_use]
    fn scaled(self, factor: f32) -> Self;
    /// Whether all parts are finite.
    fn is_finite(self) -> bool;
}

impl CurveValue for f32 {
    fn between(from: Self, to: Self, t: f32) -> Self {
        from + (to - from) * t
    }

    fn weighted(values: [Self; 4], weights: [f32; 4]) -> Self {
        values.iter().zip(weights).map(|(value, weight)| value * weight).sum()
    }

    fn scaled(self, factor: f32) -> Self {
        self * factor
    }

    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }
}

impl CurveValue for Vec3 {
    fn between(from: Self, to: Self, t: f32) -> Self {
        from.lerp(to, t)
    }

    fn weighted(values: [Self; 4], weights: [f32; 4]) -> Self {
        values.iter().zip(weights).map(|(&value, weight)| value * weight).sum()
    }

    fn scaled(self, factor: f32) -> Self {
        self * factor
    }

    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }
}

impl CurveValue for Quat {
    fn between(from: Self, to: Self, t: f32) -> Self {
        from.slerp(to, t)
    }

    fn weighted(values: [Self; 4], weights: [f32; 4]) -> Self {
        let sum = values.iter().zip(weights).fold(Self::from_xyzw(0.0, 0.0, 0.0, 0.0), |sum, (&v, w)| sum + v * w);
        if sum.length_squared() > 1e-12 { sum.normalize() } else { values[0] }
    }

    fn scaled(self, factor: f32) -> Self {
        self * factor
    }

    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }
}

/// One channel's keys.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve<T> {
    times: Vec<f32>,
    values: Vec<T>,
    interpolation: Interpolation,
}

impl<T: CurveValue> Curve<T> {
    /// A curve through `values` at `times` (seconds); [`Interpolation::CubicSpline`] takes three values a key.
    ///
    /// # Errors
    /// When there is no key, the counts don't match, a number isn't finite or the times don't grow.
    pub fn new(times: Vec<f32>, values: Vec<T>, interpolation: Interpolation) -> Result<Self, CurveError> {
        if times.is_empty() {
            return Err(CurveError::Empty);
        }
        let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let (keys, expected) = (times.len(), times.len() * per_key);
        if values.len() != expected {
            return Err(CurveError::Count { keys, expected, values: values.len() });
        }
        if let Some(key) = times.iter().position(|time| !time.is_finite()) {
            return Err(CurveError::NotFinite { key });
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            return Err(CurveError::NotFinite { key: index / per_key });
        }
        if let Some(before) = times.windows(2).position(|pair| pair[1] <= pair[0]) {
            return Err(CurveError::Order { key: before + 1, time: times[before + 1], previous: times[before] });
        }
        Ok(Self { times, values, interpolation })
    }

    /// Key times in seconds, growing.
    #[must_use]
    pub fn times(&self) -> &[f32] {
        &self.times
    }

    /// How values between keys come about.
    #[must_use]
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// Whether it stands on one value and jumps to another.
    #[must_use]
    pub fn jumps(&self) -> bool
    where
        T: PartialEq,
    {
        self.interpolation == Interpolation::Step && self.values.windows(2).any(|pair| pair[0] != pair[1])
    }

    /// Bytes of all keys.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.times.as_slice()) + size_of_val(self.values.as_slice())
    }

    /// Time of the last key in seconds.
    #[must_use]
    pub fn end(&self) -> f32 {
        self.times.last().copied().unwrap_or(0.0)
    }

    /// The value at `time` seconds.
    #[must_use]
    pub fn sample(&self, time: f32) -> T {
        let next = self.times.partition_point(|&key| key <= time);
        let last = self.times.len() - 1;
        if next == 0 || next > last {
            return self.key_value(if next == 0 { 0 } else { last });
        }
        let key = next - 1;
        let span = self.times[next] - self.times[key];
        let t = (time - self.times[key]) / span;
        match self.interpolation {
            Interpolation::Step => self.key_value(key),
            Interpolation::Linear => T::between(self.key_value(key), self.key_value(next), t),
            Interpolation::CubicSpline => {
                let (t2, t3) = (t * t, t * t * t);
                let values =
                    [self.key_value(key), self.values[3 * key + 2], self.key_value(next), self.values[3 * next]];
                let weights =
                    [2.0 * t3 - 3.0 * t2 + 1.0, span * (t3 - 2.0 * t2 + t), 3.0 * t2 - 2.0 * t3, span * (t3 - t2)];
                T::weighted(values, weights)
            }
        }
    }

    /// The curve `factor` times as long, which is more than 0.
    #[must_use]
    pub fn stretched(mut self, factor: f32) -> Self {
        self.times.iter_mut().for_each(|time| *time *= factor);
        if self.interpolation == Interpolation::CubicSpline {
            // Tangents are per second.
            for tangent in (0..self.values.len()).filter(|index| index % 3 != 1) {
                let value = self.values[tangent];
                self.values[tangent] = T::scaled(value, 1.0 / factor);
            }
        }
        self
    }

    fn key_value(&self, key: usize) -> T {
        match self.interpolation {
            Interpolation::CubicSpline => self.values[3 * key + 1],
            Interpolation::Step | Interpolation::Linear => self.values[key],
        }
    }
}

impl Curve<Vec3> {
    /// The curve with `by` added to every value.
    #[must_use]
    pub fn moved(mut self, by: Vec3) -> Self {
        let cubic = self.interpolation == Interpolation::CubicSpline;
        for (_, value) in self.values.iter_mut().enumerate().filter(|(index, _)| !cubic || index % 3 == 1) {
            *value += by;
        }
        self
    }
}

impl Curve<Quat> {
    /// A curve of rotations; key values are made one long.
    ///
    /// # Errors
    /// As [`Curve::new`], and when a rotation has length zero.
    pub fn rotation(times: Vec<f32>, mut values: Vec<Quat>, interpolation: Interpolation) -> Result<Self, CurveError> {
        let cubic = interpolation == Interpolation::CubicSpline;
        for (index, value) in values.iter_mut().enumerate() {
            if cubic && index % 3 != 1 {
                continue;
            }
            let length = value.length();
            if length < 1e-6 {
                return Err(CurveError::ZeroRotation { key: if cubic { index / 3 } else { index } });
            }
            // Unit within rounding stays as the file has it, bit for bit.
            if (length - 1.0).abs() > 1e-6 {
                *value /= length;
            }
        }
        Self::new(times, values, interpolation)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "key values come out as they went in")]
mod tests {
    use core::f32::consts::FRAC_PI_2;

    use super::*;
    use crate::math::rotation::angle_between;

    #[test]
    fn values_hold_before_the_first_and_after_the_last_key() {
        let curve = Curve::new(vec![0.5, 1.0], vec![2.0, 4.0], Interpolation::Linear).unwrap();
        assert_eq!([curve.sample(0.0), curve.sample(0.75), curve.sample(9.0)], [2.0, 3.0, 4.0]);
    }

    #[test]
    fn a_step_jumps_at_its_key_and_not_before() {
        let curve = Curve::new(vec![0.0, 1.0], vec![2.0, 4.0], Interpolation::Step).unwrap();
        assert_eq!([curve.sample(0.999), curve.sample(1.0)], [2.0, 4.0]);
    }

    #[test]
    fn linear_rotations_turn_at_constant_speed_the_short_way() {
        let keys = vec![Quat::IDENTITY, -Quat::from_rotation_y(FRAC_PI_2)];
        let curve = Curve::rotation(vec![0.0, 1.0], keys, Interpolation::Linear).unwrap();
        let third = curve.sample(1.0 / 3.0);
        let error = angle_between(third, Quat::from_rotation_y(FRAC_PI_2 / 3.0));
        assert!(error < 1e-5, "off by {error} rad");
    }

    #[test]
    fn a_cubic_spline_meets_its_keys_and_tangents() {
        // One segment of x(t) = t³ over two seconds: value and slope at both ends.
        let curve =
            Curve::new(vec![0.0, 2.0], vec![0.0, 0.0, 0.0, 12.0, 8.0, 0.0], Interpolation::CubicSpline).unwrap();
        for time in [0.0, 0.3, 1.0, 1.7, 2.0_f32] {
            let (got, want) = (curve.sample(time), time * time * time);
            assert!((got - want).abs() < 1e-5, "at {time} s: {got}, not {want}");
        }
    }

    #[test]
    fn one_key_is_a_constant() {
        let curve = Curve::new(vec![0.3], vec![7.0], Interpolation::Linear).unwrap();
        assert_eq!([curve.sample(0.0), curve.sample(0.3), curve.sample(1.0)], [7.0; 3]);
    }

    #[test]
    fn bad_keys_are_refused_by_name() {
        let fails = |times: Vec<f32>, values: Vec<f32>| {
            Curve::new(times, values, Interpolation::Linear).expect_err("keys are bad").to_string()
        };
        assert_eq!(fails(vec![], vec![]), "it has no keys");
        assert_eq!(fails(vec![0.0, 1.0], vec![1.0]), "2 keys need 2 values, but there are 1");
        assert_eq!(fails(vec![0.0, f32::NAN], vec![1.0, 1.0]), "key 1 is not a finite number");
        assert_eq!(fails(vec![0.0, 1.0], vec![1.0, f32::INFINITY]), "key 1 is not a finite number");
        assert_eq!(
            fails(vec![0.0, 1.0, 1.0], vec![1.0; 3]),
            "the time of key 2, 1 s, is not after the key before it, at 1 s"
        );
        let zero = Curve::rotation(vec![0.0], vec![Quat::from_xyzw(0.0, 0.0, 0.0, 0.0)], Interpolation::Step);
        assert_eq!(zero.err(), Some(CurveError::ZeroRotation { key: 0 }));
    }
}
