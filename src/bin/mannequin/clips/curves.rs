//! Curves over time that the clips are drawn with: Fourier series and cubic splines.
//!
//! Angles go in and come out in the unit the figures were written in (mostly degrees); phase is 0..1.

use core::f64::consts::TAU;

/// `mean + Σ cos[k]·cos(2πkφ) + sin[k]·sin(2πkφ)`, k from 1.
#[derive(Clone, Copy, Debug)]
pub struct Fourier {
    pub mean: f64,
    pub cos: [f64; 5],
    pub sin: [f64; 5],
}

impl Fourier {
    /// The value at `phase`, which may lie outside 0..1.
    #[must_use]
    pub fn at(&self, phase: f64) -> f64 {
        (0..5).fold(self.mean, |sum, i| {
            let (sin, cos) = (TAU * (i + 1) as f64 * phase).sin_cos();
            sum + self.cos[i] * cos + self.sin[i] * sin
        })
    }

    /// The same shape about another mean, its swing scaled by `gain`.
    #[must_use]
    pub const fn about(self, mean: f64, gain: f64) -> Self {
        let (mut cos, mut sin) = (self.cos, self.sin);
        let mut i = 0;
        while i < 5 {
            cos[i] *= gain;
            sin[i] *= gain;
            i += 1;
        }
        Self { mean, cos, sin }
    }
}

/// `amplitude·cos(2π·cycles·(phase − peak))`: one harmonic that is largest at phase `peak`.
#[must_use]
pub fn wave(phase: f64, cycles: f64, peak: f64, amplitude: f64) -> f64 {
    amplitude * (TAU * cycles * (phase - peak)).cos()
}

/// A cubic spline through its knots; outside of them it keeps its end values.
#[derive(Clone, Debug)]
pub struct Spline {
    x: Vec<f64>,
    y: Vec<f64>,
    slope: Vec<f64>,
}

impl Spline {
    /// Through `knots` (x ascending) with continuous second derivative and the given slopes at both ends.
    #[must_use]
    pub fn clamped(knots: &[(f64, f64)], first_slope: f64, last_slope: f64) -> Self {
        let n = knots.len();
        let (x, y): (Vec<f64>, Vec<f64>) = knots.iter().copied().unzip();
        let mut matrix = vec![vec![0.0; n + 1]; n];
        (matrix[0][0], matrix[0][n]) = (1.0, first_slope);
        (matrix[n - 1][n - 1], matrix[n - 1][n]) = (1.0, last_slope);
        for i in 1..n - 1 {
            smooth_row(
                &mut matrix[i],
                [i - 1, i, i + 1],
                [x[i] - x[i - 1], x[i + 1] - x[i]],
                [y[i - 1], y[i], y[i + 1]],
            );
        }
        let slope = solve(matrix);
        Self { x, y, slope }
    }

    /// Through `knots` (x ascending), at rest at both ends and level at turning points, so that it never overshoots a
    /// knot; its second derivative jumps at knots.
    #[must_use]
    pub fn level(knots: &[(f64, f64)]) -> Self {
        let (x, y): (Vec<f64>, Vec<f64>) = knots.iter().copied().unzip();
        let n = x.len();
        let rise = |i: usize| (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
        let slope = (0..n)
            .map(|i| {
                if i == 0 || i == n - 1 || rise(i - 1) * rise(i) <= 0.0 {
                    return 0.0;
                }
                let (before, after) = (x[i] - x[i - 1], x[i + 1] - x[i]);
                let (a, b) = (2.0 * after + before, after + 2.0 * before);
                (a + b) / (a / rise(i - 1) + b / rise(i))
            })
            .collect();
        Self { x, y, slope }
    }

    /// `x` a whole turn later where the knots reach that far (a curve that begins late in a stride and ends in the next).
    #[must_use]
    pub fn wrapped(&self, x: f64) -> f64 {
        if x + 1.0 <= self.x[self.x.len() - 1] { x + 1.0 } else { x }
    }

    /// The value at `x`.
    #[must_use]
    pub fn at(&self, x: f64) -> f64 {
        let last = self.x.len() - 1;
        let (first_x, last_x) = (self.x[0], self.x[last]);
        let x = x.clamp(first_x, last_x);
        let i = self.x[1..last].partition_point(|&knot| knot <= x);
        let width = self.x[i + 1] - self.x[i];
        let t = (x - self.x[i]) / width;
        let (s, u) = (1.0 - t, t);
        self.y[i] * s * s * (1.0 + 2.0 * u)
            + self.y[i + 1] * u * u * (1.0 + 2.0 * s)
            + width * s * u * (self.slope[i] * s - self.slope[i + 1] * u)
    }
}

/// The condition that the second derivative is equal on both sides of a knot.
fn smooth_row(row: &mut [f64], [before, here, after]: [usize; 3], [left, right]: [f64; 2], y: [f64; 3]) {
    let target = row.len() - 1;
    row[before] += 1.0 / left;
    row[here] += 2.0 / left + 2.0 / right;
    row[after] += 1.0 / right;
    row[target] = 3.0 * ((y[1] - y[0]) / (left * left) + (y[2] - y[1]) / (right * right));
}

/// Gauss elimination; the last column is the right side. Spline matrices are diagonally dominant, so no pivoting.
fn solve(mut matrix: Vec<Vec<f64>>) -> Vec<f64> {
    let n = matrix.len();
    for pivot in 0..n {
        let (above, below) = matrix.split_at_mut(pivot + 1);
        let source = &above[pivot];
        for row in below {
            let factor = row[pivot] / source[pivot];
            for (value, pivot_value) in row.iter_mut().zip(source) {
                *value -= factor * pivot_value;
            }
        }
    }
    let mut solution = vec![0.0; n];
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|column| matrix[row][column] * solution[column]).sum();
        solution[row] = (matrix[row][n] - known) / matrix[row][row];
    }
    solution
}

/// 0 before `from`, 1 after `to`, in between a rise with zero velocity and acceleration at both ends.
#[must_use]
pub fn ease(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}
