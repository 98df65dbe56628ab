//! The undersuit from neck to wrist and ankle.

use glam::Vec3;

use super::{
    field::{blend, bone, ellipsoid},
    loft::{Loft, Section, section},
};

const TORSO: Loft = Loft {
    axes: [Vec3::Y, Vec3::X, Vec3::Z],
    square: 0.35,
    sections: &[
        trunk(0.860, 0.100, 0.058, 0.078),
        trunk(0.900, 0.146, 0.082, 0.104),
        trunk(0.950, 0.160, 0.092, 0.113),
        trunk(1.005, 0.152, 0.094, 0.100),
        trunk(1.060, 0.136, 0.091, 0.083),
        trunk(1.110, 0.129, 0.092, 0.078),
        trunk(1.170, 0.136, 0.101, 0.086),
        trunk(1.240, 0.152, 0.115, 0.101),
        trunk(1.305, 0.165, 0.121, 0.110),
        trunk(1.360, 0.170, 0.109, 0.112),
        trunk(1.405, 0.158, 0.086, 0.104),
        trunk(1.440, 0.122, 0.063, 0.088),
        trunk(1.470, 0.078, 0.046, 0.070),
        trunk(1.500, 0.055, 0.036, 0.058),
    ],
};

const ARM: Loft = Loft {
    axes: [Vec3::X, Vec3::Y, Vec3::Z],
    square: 0.0,
    sections: &[
        section(0.130, [1.402, -0.014], [0.058, 0.060, 0.060, 0.062]),
        section(0.185, [1.412, -0.014], [0.060, 0.060, 0.061, 0.061]),
        section(0.240, [1.415, -0.016], [0.056, 0.055, 0.056, 0.056]),
        section(0.310, [1.415, -0.017], [0.046, 0.047, 0.049, 0.048]),
        section(0.375, [1.415, -0.018], [0.042, 0.043, 0.046, 0.046]),
        section(0.435, [1.415, -0.019], [0.038, 0.038, 0.039, 0.042]),
        section(0.480, [1.415, -0.020], [0.036, 0.037, 0.036, 0.040]),
        section(0.520, [1.415, -0.020], [0.039, 0.040, 0.041, 0.039]),
        section(0.560, [1.415, -0.019], [0.040, 0.041, 0.044, 0.040]),
        section(0.620, [1.415, -0.017], [0.035, 0.036, 0.040, 0.037]),
        section(0.690, [1.415, -0.015], [0.028, 0.028, 0.034, 0.033]),
        section(0.740, [1.415, -0.014], [0.023, 0.023, 0.030, 0.030]),
        section(0.775, [1.415, -0.014], [0.021, 0.021, 0.029, 0.029]),
    ],
};

const LEG: Loft = Loft {
    axes: [Vec3::Y, Vec3::X, Vec3::Z],
    square: 0.0,
    sections: &[
        section(0.070, [0.088, -0.012], [0.032, 0.032, 0.034, 0.036]),
        section(0.130, [0.088, -0.012], [0.034, 0.033, 0.035, 0.039]),
        section(0.200, [0.088, -0.009], [0.038, 0.036, 0.039, 0.044]),
        section(0.280, [0.088, -0.006], [0.048, 0.044, 0.044, 0.057]),
        section(0.350, [0.089, -0.003], [0.056, 0.051, 0.048, 0.066]),
        section(0.400, [0.089, 0.000], [0.057, 0.053, 0.050, 0.065]),
        section(0.460, [0.088, 0.005], [0.053, 0.051, 0.053, 0.056]),
        section(0.508, [0.088, 0.008], [0.053, 0.051, 0.058, 0.052]),
        section(0.555, [0.088, 0.008], [0.056, 0.053, 0.061, 0.056]),
        section(0.620, [0.089, 0.006], [0.064, 0.058, 0.069, 0.065]),
        section(0.700, [0.090, 0.004], [0.072, 0.065, 0.078, 0.074]),
        section(0.780, [0.090, 0.002], [0.078, 0.072, 0.083, 0.083]),
        section(0.850, [0.089, 0.000], [0.080, 0.077, 0.085, 0.093]),
        section(0.910, [0.088, -0.002], [0.079, 0.074, 0.083, 0.100]),
        section(0.960, [0.086, -0.004], [0.070, 0.068, 0.076, 0.090]),
    ],
};

/// A section of the trunk at height `y`: half width, reach to the front, reach to the back.
const fn trunk(y: f32, half: f32, front: f32, back: f32) -> Section {
    section(y, [0.0, 0.0], [half, half, front, back])
}

/// Metres from `p` to the undersuit, negative inside; the same on both sides of x = 0.
#[must_use]
pub fn undersuit(p: Vec3) -> f32 {
    let p = Vec3::new(p.x.abs(), p.y, p.z);
    let chest = ellipsoid(p, Vec3::new(0.078, 1.315, 0.062), Vec3::new(0.078, 0.062, 0.060));
    let blade = ellipsoid(p, Vec3::new(0.090, 1.340, -0.066), Vec3::new(0.070, 0.085, 0.050));
    let seat = ellipsoid(p, Vec3::new(0.078, 0.905, -0.062), Vec3::new(0.072, 0.070, 0.062));
    let trapezius = bone(p, Vec3::new(0.025, 1.485, -0.030), Vec3::new(0.165, 1.432, -0.020), 0.042, 0.040);
    let neck = bone(p, Vec3::new(0.0, 1.440, -0.016), Vec3::new(0.0, 1.600, 0.006), 0.057, 0.052);
    let skull = ellipsoid(p, Vec3::new(0.0, 1.672, 0.004), Vec3::new(0.070, 0.100, 0.088));
    let mut trunk = TORSO.field(p);
    trunk = blend(trunk, chest, 0.035);
    trunk = blend(trunk, blade, 0.040);
    trunk = blend(trunk, seat, 0.050);
    trunk = blend(trunk, trapezius, 0.050);
    trunk = blend(trunk, blend(neck, skull, 0.020), 0.040);
    trunk = blend(trunk, ARM.field(p), 0.060);
    blend(trunk, LEG.field(p), 0.050)
}

/// Metres from `p` to the left shoulder's ball and the arm without the trunk: what a cap lies on that turns with the arm.
#[must_use]
pub fn shoulder(p: Vec3) -> f32 {
    blend(p.distance(Vec3::new(0.190, 1.413, -0.015)) - 0.066, ARM.field(p), 0.030)
}
