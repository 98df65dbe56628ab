//! The shape of the land: noise hills, steep banks and paths around a flat plaza, walled in by higher hills.
//!
//! World space, metres. Everything follows from the seed; the designed features stand in the tables below.

use bevy::math::{Vec2, Vec3, ops};
use fastnoise_lite::{FastNoiseLite, FractalType, NoiseType};

use super::Heightfield;

/// Half extents of the plaza in metres, along X and Z.
pub const PLAZA: Vec2 = Vec2::new(20.0, 14.0);
/// Radius of the plaza's corners in metres.
pub const PLAZA_CORNER: f32 = 5.0;
/// Cells along one side of the land.
pub const CELLS: usize = 512;
/// Side of a cell in metres.
pub const CELL_SIZE: f32 = 0.5;

/// Height of the rolling hills over their mean, metres.
const HILLS: f32 = 5.5;
/// Height of the steep banks, metres.
const BANK: f32 = 2.2;
/// Height of the small bumps that make feet work, metres.
const BUMPS: f32 = 0.09;
/// Metres from the plaza's edge to the full hills.
const EASE: f32 = 14.0;
/// Half width of a path in metres, and of its soft edge.
const PATH: (f32, f32) = (0.9, 1.4);
/// Depth to which feet have worn the paths, metres.
const WORN: f32 = 0.07;
/// The border hills begin this far from the middle and rise this high, metres.
const RIM: (f32, f32, f32) = (84.0, 128.0, 12.5);

/// The hill on which the walk over the course begins: centre, radius and height in metres.
const MOUND: (Vec2, f32, f32) = (Vec2::new(-10.0, 23.5), 4.2, 2.3);
/// The hollow that the stepping stones cross: centre, radius and depth in metres.
pub(super) const HOLLOW: (Vec2, f32, f32) = (Vec2::new(8.0, 21.5), 5.0, 0.4);

/// Paths from the plaza into the hills, as corner points in metres.
const PATHS: [&[Vec2]; 4] = [
    &[
        Vec2::new(-10.0, 13.0),
        Vec2::new(-10.0, 19.0),
        Vec2::new(-13.0, 28.0),
        Vec2::new(-9.0, 42.0),
        Vec2::new(-20.0, 62.0),
        Vec2::new(-12.0, 90.0),
        Vec2::new(4.0, 120.0),
    ],
    &[
        Vec2::new(19.0, -2.0),
        Vec2::new(30.0, -4.0),
        Vec2::new(46.0, 6.0),
        Vec2::new(70.0, 0.0),
        Vec2::new(92.0, -22.0),
        Vec2::new(122.0, -18.0),
    ],
    &[
        Vec2::new(-19.0, 0.0),
        Vec2::new(-32.0, -5.0),
        Vec2::new(-52.0, 8.0),
        Vec2::new(-78.0, -8.0),
        Vec2::new(-122.0, 4.0),
    ],
    &[
        Vec2::new(2.0, -13.0),
        Vec2::new(4.0, -28.0),
        Vec2::new(-8.0, -46.0),
        Vec2::new(6.0, -74.0),
        Vec2::new(-6.0, -122.0),
    ],
];

/// The land's shape, before it is sampled into a [`Heightfield`].
pub struct Landscape {
    hills: FastNoiseLite,
    banks: FastNoiseLite,
    bumps: FastNoiseLite,
    patches: FastNoiseLite,
}

/// What covers the ground at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cover {
    /// How much of it is trodden path, 0..=1.
    pub path: f32,
    /// How bare the wet hollow and the like are, 0..=1.
    pub bare: f32,
}

impl Landscape {
    /// The land that grows from `seed`.
    #[must_use]
    pub fn new(seed: i32) -> Self {
        let fractal = |seed, wavelength: f32, octaves| {
            let mut noise = FastNoiseLite::with_seed(seed);
            noise.set_noise_type(Some(NoiseType::OpenSimplex2));
            noise.set_frequency(Some(1.0 / wavelength));
            noise.set_fractal_type(Some(FractalType::FBm));
            noise.set_fractal_octaves(Some(octaves));
            noise.set_fractal_gain(Some(0.4));
            noise
        };
        Self {
            hills: fractal(seed, 74.0, 3),
            banks: fractal(seed.wrapping_add(1), 58.0, 2),
            bumps: fractal(seed.wrapping_add(2), 3.4, 2),
            patches: fractal(seed.wrapping_add(3), 9.0, 3),
        }
    }

    /// The land sampled to 256 × 256 m.
    #[must_use]
    pub fn heightfield(&self) -> Heightfield {
        Heightfield::from_fn(CELLS, CELL_SIZE, |x, z| self.height(x, z))
    }

    /// Height in metres at a world position; exactly 0 on the plaza.
    #[must_use]
    pub fn height(&self, x: f32, z: f32) -> f32 {
        let at = Vec2::new(x, z);
        let open = plaza_distance(at);
        if open <= 0.0 {
            return 0.0;
        }
        let path = path_weight(at);
        let hills = self.hills.get_noise_2d(x, z) * HILLS;
        let bank = rise(self.banks.get_noise_2d(x, z), 0.16, 0.3) * BANK * (1.0 - rise(path, 0.0, 0.7));
        // The walk over the course begins on plain grass.
        let bank = bank * rise(at.distance(MOUND.0), MOUND.1 * 2.0, MOUND.1 * 4.0);
        let bumps = self.bumps.get_noise_2d(x, z) * BUMPS * (1.0 - 0.7 * path);
        let rim = rise(at.abs().max_element(), RIM.0, RIM.1) * RIM.2;
        let hollow = 1.0 - rise(at.distance(HOLLOW.0), HOLLOW.1 * 0.35, HOLLOW.1);
        let level = 1.0 - rise(at.distance(HOLLOW.0), HOLLOW.1, HOLLOW.1 * 2.4);
        let wild = (hills + bank + rim) * rise(open, 0.0, EASE) * (1.0 - level);
        let near = (bumps - WORN * path) * rise(open, 0.0, 2.0);
        wild + near + mound(at) * rise(open, 0.0, 4.0) - hollow * HOLLOW.2
    }

    /// What covers the ground at a world position.
    #[must_use]
    pub fn cover(&self, x: f32, z: f32) -> Cover {
        let at = Vec2::new(x, z);
        let bare = 1.0 - rise(at.distance(HOLLOW.0), HOLLOW.1 * 0.5, HOLLOW.1 * 1.05);
        Cover { path: path_weight(at), bare }
    }

    /// Broad patches of the meadow, 0..=1.
    #[must_use]
    pub fn patch(&self, x: f32, z: f32) -> f32 {
        (0.5 + 0.6 * self.patches.get_noise_2d(x, z)).clamp(0.0, 1.0)
    }
}

/// Metres from the plaza's edge, negative inside it.
#[must_use]
pub fn plaza_distance(at: Vec2) -> f32 {
    let beyond = at.abs() - PLAZA + PLAZA_CORNER;
    beyond.max(Vec2::ZERO).length() + beyond.max_element().min(0.0) - PLAZA_CORNER
}

/// A point as high as the land and `above` metres more.
pub(super) fn on_land(field: &Heightfield, at: Vec2, above: f32) -> Vec3 {
    field.point(at.x, at.y) + Vec3::Y * above
}

fn mound(at: Vec2) -> f32 {
    let (centre, radius, height) = MOUND;
    height * ops::exp(-at.distance_squared(centre) / (2.0 * radius * radius))
}

/// 1 in the middle of a path, 0 beside it.
fn path_weight(at: Vec2) -> f32 {
    let nearest = PATHS
        .iter()
        .flat_map(|path| path.windows(2).map(|ends| segment_distance(at, ends[0], ends[1])))
        .fold(f32::INFINITY, f32::min);
    1.0 - rise(nearest, PATH.0, PATH.0 + PATH.1)
}

fn segment_distance(at: Vec2, from: Vec2, to: Vec2) -> f32 {
    let (way, along) = (to - from, at - from);
    let share = (along.dot(way) / way.length_squared().max(1e-12)).clamp(0.0, 1.0);
    along.distance(way * share)
}

/// Smoothly from 0 at `from` to 1 at `to`.
pub(super) fn rise(value: f32, from: f32, to: f32) -> f32 {
    let share = ((value - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_of_the_land_is_pleasant_to_walk_and_some_is_steep() {
        let field = Landscape::new(7).heightfield();
        let (mut gentle, mut steep, mut all) = (0, 0, 0);
        for x in (-92..92).map(|x| x as f32 + 0.2) {
            for z in (-92..92).map(|z| z as f32 + 0.3) {
                let degrees = ops::acos(field.normal(x, z).y.clamp(-1.0, 1.0)).to_degrees();
                all += 1;
                gentle += i32::from(degrees < 25.0);
                steep += i32::from(degrees > 32.0);
            }
        }
        let (gentle, steep) = (gentle as f32 / all as f32, steep as f32 / all as f32);
        assert!(gentle > 0.85, "only {:.0} % is less than 25 degrees steep", gentle * 100.0);
        assert!(steep > 0.001 && steep < 0.1, "{:.2} % is more than 32 degrees steep", steep * 100.0);
    }

    #[test]
    fn the_plaza_is_flat() {
        let field = Landscape::new(7).heightfield();
        for (x, z) in [(0.0, 0.0), (-19.0, 3.0), (12.3, 12.9), (17.0, -11.0)] {
            let height = field.height(x, z);
            assert!(height.abs() < 1e-6, "{height} m at {x}, {z}");
        }
    }

    #[test]
    fn the_border_is_higher_than_the_middle() {
        let field = Landscape::new(7).heightfield();
        for (x, z) in [(126.0, 0.0), (-126.0, 40.0), (10.0, 126.0), (0.0, -126.0)] {
            let height = field.height(x, z);
            assert!(height > 8.0, "{height} m at {x}, {z}");
        }
    }

    #[test]
    fn one_seed_gives_one_land() {
        assert_eq!(Landscape::new(3).heightfield(), Landscape::new(3).heightfield());
        assert_ne!(Landscape::new(3).heightfield(), Landscape::new(4).heightfield());
    }
}
