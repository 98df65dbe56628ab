//! The boot's flexible inner: ankle, instep and toe box of the left foot, above the sole.

use glam::Vec3;

use super::{
    field::{blend, bone},
    loft::{Loft, section},
};

const FOOT: Loft = Loft {
    axes: [Vec3::Z, Vec3::X, Vec3::Y],
    square: 0.25,
    sections: &[
        section(-0.060, [0.088, 0.040], [0.020, 0.020, 0.028, 0.030]),
        section(-0.050, [0.088, 0.040], [0.030, 0.029, 0.045, 0.036]),
        section(-0.020, [0.088, 0.036], [0.036, 0.034, 0.062, 0.032]),
        section(0.020, [0.089, 0.032], [0.037, 0.036, 0.066, 0.028]),
        section(0.060, [0.090, 0.028], [0.039, 0.038, 0.050, 0.024]),
        section(0.100, [0.092, 0.026], [0.042, 0.041, 0.0315, 0.022]),
        section(0.135, [0.092, 0.025], [0.042, 0.041, 0.028, 0.021]),
        section(0.165, [0.091, 0.024], [0.035, 0.035, 0.022, 0.020]),
        section(0.182, [0.091, 0.023], [0.024, 0.025, 0.016, 0.018]),
        section(0.190, [0.091, 0.022], [0.012, 0.014, 0.010, 0.012]),
    ],
};

/// Metres from `p` to the left boot's inner, negative inside.
#[must_use]
pub fn boot(p: Vec3) -> f32 {
    let shaft = bone(p, Vec3::new(0.088, 0.060, -0.014), Vec3::new(0.088, 0.135, -0.012), 0.040, 0.041);
    let shaft = shaft.max(p.y - 0.150);
    blend(FOOT.field(p), shaft, 0.040)
}
