//! Where the coordinates of a plate lie: rays from inside the figure to its surface.

use glam::{Vec2, Vec3};

use crate::turn::unit;

/// A family of rays, by two coordinates.
#[derive(Clone, Copy, Debug)]
pub enum Chart {
    /// Around an axis: x = degrees from `first` toward `second`, y = metres along `along`.
    Around { base: Vec3, along: Vec3, first: Vec3, second: Vec3 },
    /// Around a centre: x = degrees from `first` toward `second`, y = degrees toward `pole`.
    Ball { center: Vec3, pole: Vec3, first: Vec3, second: Vec3 },
}

/// The trunk: 0° is the front, 90° the left side; heights.
pub const TRUNK: Chart =
    Chart::Around { base: Vec3::new(0.0, 0.0, -0.005), along: Vec3::Y, first: Vec3::Z, second: Vec3::X };
/// The left leg: 0° is the front, 90° the outer side; heights.
pub const LEG: Chart =
    Chart::Around { base: Vec3::new(0.088, 0.0, 0.0), along: Vec3::Y, first: Vec3::Z, second: Vec3::X };
/// The left arm: 0° is up (outward once the arm hangs), 90° the front; distances from the middle.
pub const ARM: Chart =
    Chart::Around { base: Vec3::new(0.0, 1.415, -0.017), along: Vec3::X, first: Vec3::Y, second: Vec3::Z };
/// The left foot: 0° is up, 90° the outer side; distances to the front.
pub const FOOT: Chart =
    Chart::Around { base: Vec3::new(0.090, 0.024, 0.0), along: Vec3::Z, first: Vec3::Y, second: Vec3::X };
/// The head: x = degrees up from straight ahead, over the crown; y = degrees to the left.
pub const HEAD: Chart =
    Chart::Ball { center: Vec3::new(0.0, 1.655, 0.0), pole: Vec3::X, first: Vec3::Z, second: Vec3::Y };
/// The head from the left ear.
pub const EAR: Chart =
    Chart::Ball { center: Vec3::new(0.0, 1.655, -0.002), pole: Vec3::Y, first: Vec3::X, second: Vec3::Z };
/// The left toes: x = degrees up from straight ahead; y = degrees to the left.
pub const TOES: Chart =
    Chart::Ball { center: Vec3::new(0.092, 0.022, 0.125), pole: Vec3::X, first: Vec3::Z, second: Vec3::Y };

impl Chart {
    fn ray(&self, at: Vec2) -> (Vec3, Vec3) {
        let (cos, sin) = unit(at.x);
        match *self {
            Self::Around { base, along, first, second } => (base + along * at.y, first * cos + second * sin),
            Self::Ball { center, pole, first, second } => {
                let (level, rise) = unit(at.y);
                (center, (first * cos + second * sin) * level + pole * rise)
            }
        }
    }

    /// Where the ray at `at` leaves the inside of `field`.
    #[must_use]
    pub fn surface(&self, at: Vec2, field: &dyn Fn(Vec3) -> f32) -> Vec3 {
        const STEP: f32 = 0.004;
        let (origin, toward) = self.ray(at);
        let mut inside = 0.0;
        while field(origin + toward * (inside + STEP)) < 0.0 && inside < 0.4 {
            inside += STEP;
        }
        let mut outside = inside + STEP;
        for _ in 0..14 {
            let middle = 0.5 * (inside + outside);
            if field(origin + toward * middle) < 0.0 {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        origin + toward * inside
    }
}
