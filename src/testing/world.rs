//! Grounds to walk on, as data. Metres; walkers start at the origin on ground of height 0 and go along -Z.

use core::f32::consts::FRAC_PI_2;

use avian3d::prelude::*;
use bevy::{math::ops, prelude::*};

/// A solid's form.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Full lengths along its axes.
    Box(Vec3),
    /// Heights over a square grid, `[x][z]`, centred, and its side length.
    Heightfield(Vec<Vec<f32>>, f32),
}

/// One solid.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Its form.
    pub shape: Shape,
    /// Where its centre is.
    pub transform: Transform,
    /// Velocity in m/s and turn rate about +Y in rad/s, for what moves.
    pub motion: Option<(Vec3, f32)>,
}

/// Ground to walk on.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// For tables and failures.
    pub name: String,
    /// What it is made of.
    pub pieces: Vec<Piece>,
}

impl Piece {
    /// A box that stands still.
    #[must_use]
    pub fn block(size: Vec3, transform: Transform) -> Self {
        Self { shape: Shape::Box(size), transform, motion: None }
    }

    /// The collider of its shape.
    #[must_use]
    pub fn collider(&self) -> Collider {
        match &self.shape {
            Shape::Box(size) => Collider::cuboid(size.x, size.y, size.z),
            Shape::Heightfield(heights, side) => Collider::heightfield(heights.clone(), Vec3::new(*side, 1.0, *side)),
        }
    }
}

impl World {
    fn new(name: &str, pieces: Vec<Piece>) -> Self {
        Self { name: name.to_owned(), pieces }
    }

    /// A plain.
    #[must_use]
    pub fn flat() -> Self {
        Self::new("flat", vec![floor()])
    }

    /// A plane that rises along -Z by `degrees`, through the origin.
    #[must_use]
    pub fn slope(degrees: f32) -> Self {
        let turn = Quat::from_rotation_x(degrees.to_radians());
        let centre = turn * Vec3::new(0.0, -0.5, 0.0);
        let transform = Transform::from_translation(centre).with_rotation(turn);
        Self::new(&format!("slope {degrees}°"), vec![Piece::block(Vec3::new(80.0, 1.0, 80.0), transform)])
    }

    /// A plain, from z = -3 on a ramp of `degrees` up to a plateau 2 m high.
    #[must_use]
    pub fn ramp(degrees: f32) -> Self {
        let rise = 2.0;
        let angle = degrees.to_radians();
        let run = rise / ops::tan(angle);
        let length = rise / ops::sin(angle);
        let turn = Quat::from_rotation_x(angle);
        let middle = Vec3::new(0.0, rise / 2.0, -3.0 - run / 2.0);
        let ramp = Piece::block(
            Vec3::new(6.0, 1.0, length),
            Transform::from_translation(middle - turn * Vec3::Y * 0.5).with_rotation(turn),
        );
        let top = Vec3::new(0.0, rise - 1.0, -3.0 - run - 10.0);
        let plateau = Piece::block(Vec3::new(6.0, 2.0, 20.0), Transform::from_translation(top));
        Self::new(&format!("ramp {degrees}°"), vec![floor(), ramp, plateau])
    }

    /// A plain, from z = -3 on `steps` stairs of the given riser and tread up to a plateau.
    #[must_use]
    pub fn stairs_up(steps: usize, riser: f32, tread: f32) -> Self {
        let mut pieces = vec![floor()];
        for step in 0..steps {
            let height = riser * (step + 1) as f32;
            let front = -3.0 - tread * step as f32;
            let depth = if step + 1 == steps { 20.0 } else { tread };
            let centre = Vec3::new(0.0, height / 2.0, front - depth / 2.0);
            pieces.push(Piece::block(Vec3::new(6.0, height, depth), Transform::from_translation(centre)));
        }
        Self::new("stairs up", pieces)
    }

    /// A plateau; from z = -3 on `steps` stairs down to a plain.
    #[must_use]
    pub fn stairs_down(steps: usize, riser: f32, tread: f32) -> Self {
        let bottom = -riser * steps as f32;
        let plain = Piece::block(Vec3::new(200.0, 1.0, 200.0), Transform::from_xyz(0.0, bottom - 0.5, 0.0));
        let mut pieces = vec![plain];
        for step in 0..steps {
            let top = -riser * step as f32;
            let front = if step == 0 { 20.0 } else { -3.0 - tread * (step - 1) as f32 };
            let back = -3.0 - tread * step as f32;
            let (height, depth) = (top - bottom, front - back);
            let centre = Vec3::new(0.0, bottom + height / 2.0, (front + back) / 2.0);
            pieces.push(Piece::block(Vec3::new(6.0, height, depth), Transform::from_translation(centre)));
        }
        Self::new("stairs down", pieces)
    }

    /// A plain strewn with flat boxes up to 15 cm high.
    #[must_use]
    pub fn rubble() -> Self {
        let mut pieces = vec![floor()];
        let mut seed = 0x9E37_79B9u32;
        let mut random = || {
            // xorshift32: the same rubble everywhere.
            seed ^= seed << 13;
            seed ^= seed >> 17;
            seed ^= seed << 5;
            (seed >> 8) as f32 / 16_777_216.0
        };
        for _ in 0..220 {
            let size = Vec3::new(0.25 + 0.5 * random(), 0.03 + 0.12 * random(), 0.25 + 0.5 * random());
            let place = Vec3::new(6.0 * random() - 3.0, size.y / 2.0, -1.5 - 16.0 * random());
            let turn = Quat::from_rotation_y(FRAC_PI_2 * random());
            pieces.push(Piece::block(size, Transform::from_translation(place).with_rotation(turn)));
        }
        Self::new("rubble", pieces)
    }

    /// Rolling ground: waves of some metres' length, slopes to about 20°.
    #[must_use]
    pub fn hills() -> Self {
        let (count, side) = (161, 80.0f32);
        let at = |i: usize| (i as f32 / (count - 1) as f32 - 0.5) * side;
        let height = |x: f32, z: f32| {
            let wave = |angle: f32, length: f32, size: f32| {
                let along = x * ops::cos(angle) + z * ops::sin(angle);
                size * (ops::cos(along * core::f32::consts::TAU / length) - 1.0)
            };
            wave(0.4, 9.0, 0.3) + wave(1.9, 5.3, 0.12) + wave(2.8, 14.0, 0.5)
        };
        let heights = (0..count).map(|x| (0..count).map(|z| height(at(x), at(z))).collect()).collect();
        let piece = Piece { shape: Shape::Heightfield(heights, side), transform: Transform::IDENTITY, motion: None };
        Self::new("hills", vec![piece])
    }

    /// A plain with a wall across the way at z = -4.
    #[must_use]
    pub fn wall() -> Self {
        let wall = Piece::block(Vec3::new(20.0, 3.0, 0.5), Transform::from_xyz(0.0, 1.5, -4.25));
        Self::new("wall", vec![floor(), wall])
    }
}

fn floor() -> Piece {
    Piece::block(Vec3::new(200.0, 1.0, 200.0), Transform::from_xyz(0.0, -0.5, 0.0))
}
