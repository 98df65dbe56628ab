//! Sine and cosine from additions and multiplications alone, so that every machine bakes the same bytes.

/// Cosine and sine of an angle in degrees.
#[must_use]
pub fn unit(degrees: f32) -> (f32, f32) {
    (sine(f64::from(degrees) + 90.0) as f32, sine(f64::from(degrees)) as f32)
}

fn sine(degrees: f64) -> f64 {
    let turned = degrees - 360.0 * (degrees / 360.0).round();
    let folded = if turned > 90.0 {
        180.0 - turned
    } else if turned < -90.0 {
        -180.0 - turned
    } else {
        turned
    };
    let x = folded.to_radians();
    let square = x * x;
    // Taylor's series, from the last term: at 90° what it leaves out is under 1e-9.
    let terms = [156.0, 110.0, 72.0, 42.0, 20.0, 6.0];
    x * terms.iter().fold(1.0, |sum, divisor| 1.0 - square / divisor * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarters_and_sixths_are_exact_to_a_millionth() {
        for (degrees, cos, sin) in
            [(0.0, 1.0, 0.0), (90.0, 0.0, 1.0), (-150.0, -0.866_025_4, -0.5), (420.0, 0.5, 0.866_025_4)]
        {
            let (c, s) = unit(degrees);
            assert!((c - cos).abs() < 1e-6 && (s - sin).abs() < 1e-6, "{degrees}°: cos {c}, sin {s}");
        }
    }
}
