//! Grounds to walk on. Metres; walkers start at the origin on ground of height 0 and go along -Z.

use core::f32::consts::{FRAC_PI_2, TAU};

use bevy::{math::ops, prelude::*};

use super::world::{Piece, Shape, World};

impl World {
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
                size * (ops::cos(along * TAU / length) - 1.0)
            };
            wave(0.4, 9.0, 0.3) + wave(1.9, 5.3, 0.12) + wave(2.8, 14.0, 0.5)
        };
        let heights = (0..count).map(|x| (0..count).map(|z| height(at(x), at(z))).collect()).collect();
        let piece = Piece { shape: Shape::Heightfield(heights, side), transform: Transform::IDENTITY, motion: None };
        Self::new("hills", vec![piece])
    }

    /// A crest along the way, from z = -2, whose flanks fall by 15° to both sides: each foot stands on its own.
    #[must_use]
    pub fn ridge() -> Self {
        let angle = 15f32.to_radians();
        let flank = |side: f32| {
            let turn = Quat::from_rotation_z(-side * angle);
            let centre = Vec3::new(0.0, 0.3, -2.0 - 10.0) + turn * Vec3::new(side * 1.5, -0.5, 0.0);
            Piece::block(Vec3::new(3.0, 1.0, 20.0), Transform::from_translation(centre).with_rotation(turn))
        };
        Self::new("ridge", vec![floor(), flank(1.0), flank(-1.0)])
    }

    /// From z = -1.5 on stones of 42 cm, a gap of 18 cm between each, that rise 22 to 26 cm out of a sunken floor.
    #[must_use]
    pub fn stepping_stones() -> Self {
        let sunken = Piece::block(Vec3::new(200.0, 1.0, 200.0), Transform::from_xyz(0.0, -0.5 - 0.24, -0.0));
        let bank = Piece::block(Vec3::new(8.0, 1.0, 11.3), Transform::from_xyz(0.0, -0.5, 4.25));
        let mut pieces = vec![sunken, bank];
        for row in 0..20 {
            for column in -4..=4 {
                // Small unevenness that repeats nowhere near.
                let lift = 0.02 * ops::sin((row * 5 + column * 3) as f32 * 1.7);
                let shift = if row % 2 == 0 { 0.0 } else { 0.3 };
                let centre = Vec3::new(column as f32 * 0.6 + shift, lift - 0.15, -1.7 - row as f32 * 0.6);
                pieces.push(Piece::block(Vec3::new(0.42, 0.3, 0.42), Transform::from_translation(centre)));
            }
        }
        Self::new("stepping stones", pieces)
    }

    /// A plain with pavements of 15 cm and 2 m across the way, from z = -2.5 on, 2 m of road between them.
    #[must_use]
    pub fn curb() -> Self {
        let pavement = |index: usize| {
            let centre = Vec3::new(0.0, 0.0, -3.5 - 4.0 * index as f32);
            Piece::block(Vec3::new(8.0, 0.3, 2.0), Transform::from_translation(centre))
        };
        Self::new("curb", (0..5).map(pavement).chain([floor()]).collect())
    }

    /// A deck that glides sideways at 1 m/s.
    #[must_use]
    pub fn moving_platform() -> Self {
        let deck = Piece::block(Vec3::new(12.0, 1.0, 40.0), Transform::from_xyz(0.0, -0.5, -10.0));
        Self::new("moving platform", vec![Piece { motion: Some((Vec3::X, 0.0)), ..deck }])
    }

    /// A deck that turns by 30° a second about a point 2 m before the walker.
    #[must_use]
    pub fn rotating_platform() -> Self {
        let deck = Piece::block(Vec3::new(24.0, 1.0, 24.0), Transform::from_xyz(0.0, -0.5, -2.0));
        Self::new("rotating platform", vec![Piece { motion: Some((Vec3::ZERO, 30f32.to_radians())), ..deck }])
    }

    /// A plateau whose edge runs along the way 8 cm right of its middle, 3 m over a plain.
    #[must_use]
    pub fn cliff() -> Self {
        let plain = Piece::block(Vec3::new(200.0, 1.0, 200.0), Transform::from_xyz(0.0, -3.5, 0.0));
        let plateau = Piece::block(Vec3::new(20.0, 3.0, 60.0), Transform::from_xyz(CLIFF_EDGE - 10.0, -1.5, -20.0));
        Self::new("cliff edge", vec![plain, plateau])
    }

    /// A plain with a wall across the way at z = -4.
    #[must_use]
    pub fn wall() -> Self {
        let wall = Piece::block(Vec3::new(20.0, 3.0, 0.5), Transform::from_xyz(0.0, 1.5, -4.25));
        Self::new("wall", vec![floor(), wall])
    }
}

/// Metres from the middle of the way to the edge of the cliff.
const CLIFF_EDGE: f32 = 0.08;

fn floor() -> Piece {
    Piece::block(Vec3::new(200.0, 1.0, 200.0), Transform::from_xyz(0.0, -0.5, 0.0))
}
