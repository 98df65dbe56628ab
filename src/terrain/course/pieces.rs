//! The pieces of the course, group by group.
//!
//! World space, metres; the plaza lies at y = 0.

use bevy::math::{Quat, Vec2, Vec3, ops};

use super::{Piece, STEP};
use crate::{
    math::dice::Dice,
    terrain::{
        Heightfield,
        landscape::{HOLLOW, on_land},
        palette::Tint,
        platform::MovingPlatform,
        shape::Shape,
    },
};

/// Height of the deck between the ramps, metres.
const DECK: f32 = 0.8;

fn flight(steps: u32, base: f32) -> Shape {
    Shape::Stairs { steps, rise: STEP.x, run: STEP.y, width: 2.4, base }
}

fn block(x: f32, y: f32, z: f32) -> Shape {
    Shape::Block { size: Vec3::new(x, y, z) }
}

/// Two flights up with a landing between them, one long flight down, handrails at the top.
pub(super) fn stairs(pieces: &mut Vec<Piece>) {
    let (x, half) = (-10.0, 5.0 * STEP.y);
    let (landing, top) = (5.0 * STEP.x, 10.0 * STEP.x);
    let at = |z: f32| Vec3::new(x, 0.0, z);
    let mut z = 12.6;
    let mut along = |length: f32| {
        z -= length;
        at(z + length * 0.5)
    };
    pieces.push(Piece::new("stairs up", flight(5, 0.0), Tint::Concrete, along(half)));
    let middle = along(1.1);
    pieces.push(Piece::new("landing", block(2.4, landing, 1.1), Tint::Concrete, middle));
    pieces.push(Piece::new("stairs up", flight(5, landing), Tint::Concrete, along(half)));
    let summit = along(1.3);
    pieces.push(Piece::new("top of the stairs", block(2.4, top, 1.3), Tint::Concrete, summit));
    pieces.push(Piece::new("stairs down", flight(10, 0.0), Tint::Concrete, along(2.0 * half)).turned(180.0));
    for side in [-1.16, 1.16] {
        let rail = Shape::Rail { length: 1.3, height: 0.95 };
        let position = summit + Vec3::new(side, top, 0.0);
        pieces.push(Piece::new("handrail", rail, Tint::Steel, position).turned(90.0));
        let rail = Shape::Rail { length: 1.1, height: 0.95 };
        let position = middle + Vec3::new(side, landing, 0.0);
        pieces.push(Piece::new("handrail", rail, Tint::Steel, position).turned(90.0));
    }
}

/// A deck with 10° and 30° ramps on the west and a 20° ramp on the east; its fourth quarter is a drop.
pub(super) fn ramps(pieces: &mut Vec<Piece>) {
    let (west, depth, width) = (-1.7, 2.2, 2.4);
    let ramp = |name, degrees: f32, east: bool, z: f32| {
        let length = DECK / ops::tan(degrees.to_radians());
        let x = if east { west + depth + length * 0.5 } else { west - length * 0.5 };
        let shape = Shape::Ramp { size: Vec3::new(width - 0.1, DECK, length) };
        Piece::new(name, shape, Tint::Wood, Vec3::new(x, 0.0, z)).turned(if east { 90.0 } else { -90.0 })
    };
    pieces.push(ramp("ramp of 10 degrees", 10.0, false, 0.0));
    pieces.push(ramp("ramp of 30 degrees", 30.0, false, -width));
    pieces.push(ramp("ramp of 20 degrees", 20.0, true, 0.0));
    let deck = Shape::Deck { size: Vec3::new(2.0 * width, DECK, depth) };
    let middle = Vec3::new(west + depth * 0.5, 0.0, -width * 0.5);
    pieces.push(Piece::new("deck", deck, Tint::DarkWood, middle).turned(90.0));
}

/// Loose boxes of up to 15 cm.
pub(super) fn rubble(pieces: &mut Vec<Piece>) {
    const SIZES: [Vec3; 6] = [
        Vec3::new(0.46, 0.1, 0.34),
        Vec3::new(0.38, 0.14, 0.3),
        Vec3::new(0.52, 0.07, 0.4),
        Vec3::new(0.3, 0.12, 0.26),
        Vec3::new(0.6, 0.09, 0.28),
        Vec3::new(0.34, 0.15, 0.34),
    ];
    let mut dice = Dice::new(11);
    for column in 0..11 {
        for row in 0..8 {
            if dice.roll() < 0.12 {
                continue;
            }
            let x = 3.5 + 0.4 * column as f32 + dice.between(-0.12, 0.12);
            let z = 0.41 * (row as f32 - 3.5) + dice.between(-0.12, 0.12);
            let size = SIZES[dice.pick(SIZES.len())];
            let tint = [Tint::Concrete, Tint::DarkConcrete, Tint::Stone, Tint::Stone, Tint::Wood][dice.pick(5)];
            let lean = Quat::from_scaled_axis(dice.direction().with_y(0.0) * 0.06);
            let shape = Shape::Block { size };
            // Sunk by what the lean would lift, so that nothing is higher than 15 cm or hovers.
            let sunk = Vec3::new(x, -0.03, z);
            pieces.push(Piece { rotation: lean * dice.turn(), ..Piece::new("rubble", shape, tint, sunk) });
        }
    }
}

pub(super) fn boulders(pieces: &mut Vec<Piece>) {
    const PLACES: [(f32, f32, f32); 10] = [
        (10.5, -1.7, 1.1),
        (9.2, 3.0, 1.25),
        (12.5, 1.6, 1.15),
        (14.3, -1.9, 1.1),
        (17.2, -1.2, 1.5),
        (14.2, 3.2, 1.2),
        (12.0, -4.6, 1.9),
        (16.6, -5.2, 1.2),
        (11.3, 4.9, 0.7),
        (8.6, -3.6, 0.7),
    ];
    for (seed, (x, z, radius)) in (1u32..).zip(PLACES) {
        let shape = Shape::Boulder { radius, seed };
        pieces.push(Piece::new("boulder", shape, Tint::Stone, Vec3::new(x, 0.0, z)).turned(47.0 * seed as f32));
    }
}

/// Ledges to jump, a low wall, a curb, a ridge.
pub(super) fn ledges_and_walls(pieces: &mut Vec<Piece>) {
    for (step, height) in [0.3, 0.6, 0.9, 1.2].into_iter().enumerate() {
        let at = Vec3::new(17.4, 0.0, 11.6 - 2.04 * step as f32);
        let tint = if step % 2 == 0 { Tint::Concrete } else { Tint::DarkConcrete };
        pieces.push(Piece::new("ledge", block(2.6, height, 2.0), tint, at));
    }
    pieces.push(Piece::new("low wall", block(0.36, 0.9, 5.0), Tint::Concrete, Vec3::new(-16.2, 0.0, 5.5)));
    pieces.push(Piece::new("coping", block(0.44, 0.06, 5.08), Tint::DarkConcrete, Vec3::new(-16.2, 0.9, 5.5)));
    for segment in 0..8 {
        let at = Vec3::new(-15.0 + 2.02 * segment as f32, 0.0, -12.4);
        pieces.push(Piece::new("curb", block(2.0, 0.15, 0.34), Tint::DarkConcrete, at));
    }
    let ridge = Shape::Ridge { size: Vec3::new(6.0, 0.55, 2.4) };
    pieces.push(Piece::new("ridge", ridge, Tint::Concrete, Vec3::new(-12.5, 0.0, -6.0)).turned(24.0));
}

/// A disc that turns and a slab that glides on two rails.
pub(super) fn platforms(pieces: &mut Vec<Piece>) {
    let hub = Vec3::new(-3.4, 0.0, 7.0);
    let disc = Shape::Disc { radius: 2.4, height: 0.18 };
    let turning = MovingPlatform { from: hub, to: hub, turn: 0.5, ..Default::default() };
    pieces.push(Piece { motion: Some(turning), ..Piece::new("turntable", disc, Tint::Concrete, hub) });

    let (from, to) = (Vec3::new(2.0, 0.05, 9.0), Vec3::new(10.0, 0.05, 9.0));
    let slab = Shape::Deck { size: Vec3::new(2.2, 0.2, 2.4) };
    let gliding = MovingPlatform { from, to, period: 12.0, ..Default::default() };
    pieces.push(Piece { motion: Some(gliding), ..Piece::new("glider", slab, Tint::Accent, from) });
    for side in [-0.8, 0.8] {
        let middle = ((from + to) * 0.5).with_y(0.0) + Vec3::Z * side;
        pieces.push(Piece::new("track", block(10.6, 0.035, 0.12), Tint::Steel, middle));
    }
}

/// Stones across the hollow, in an easy S.
pub(super) fn stepping_stones(field: &Heightfield, pieces: &mut Vec<Piece>) {
    let mut dice = Dice::new(23);
    for stone in 0..14 {
        let along = -4.6 + 0.71 * stone as f32;
        let across = 0.55 * ops::sin(along * 0.9);
        let at = HOLLOW.0 + Vec2::new(across, along);
        let top = dice.between(0.02, 0.12);
        let low = field.height(at.x, at.y).min(0.0) - 0.15;
        let height = top - low;
        let size = Vec3::new(dice.between(0.5, 0.68), height, dice.between(0.46, 0.6));
        let tint = if dice.roll() < 0.5 { Tint::Stone } else { Tint::DarkConcrete };
        let position = Vec3::new(at.x, low, at.y);
        pieces.push(
            Piece::new("stepping stone", Shape::Block { size }, tint, position).turned(dice.between(-40.0, 40.0)),
        );
    }
}

/// The beacon, the gate where the walk enters, a rail to look over.
pub(super) fn landmarks(field: &Heightfield, pieces: &mut Vec<Piece>) {
    let foot = Vec3::new(3.0, 0.0, -10.2);
    pieces.push(Piece::new("beacon's base", block(1.8, 0.4, 1.8), Tint::DarkConcrete, foot));
    let mast = Shape::Mast { height: 8.0, width: 0.7 };
    pieces.push(Piece::new("beacon", mast, Tint::Accent, foot + Vec3::Y * 0.4));
    pieces.push(Piece::new("beacon's lamp", block(0.5, 0.5, 0.5), Tint::Lamp, foot + Vec3::Y * 8.4));
    pieces.push(Piece::new("beacon's roof", block(0.72, 0.08, 0.72), Tint::Steel, foot + Vec3::Y * 8.9));
    for x in [-12.0, -8.0] {
        let foot = on_land(field, Vec2::new(x, 14.6), -0.1);
        pieces.push(Piece::new("gate post", block(0.3, 2.3, 0.3), Tint::DarkConcrete, foot));
        pieces.push(Piece::new("gate post's cap", block(0.38, 0.1, 0.38), Tint::Accent, foot + Vec3::Y * 2.3));
    }
    for segment in 0..3 {
        let at = Vec3::new(-19.2, 0.0, -7.2 + 2.5 * segment as f32);
        let rail = Shape::Rail { length: 2.5, height: 1.0 };
        pieces.push(Piece::new("rail", rail, Tint::Steel, at).turned(90.0));
    }
}
