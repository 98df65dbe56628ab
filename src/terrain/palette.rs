//! The few colours that the built things share.

use bevy::color::{ColorToComponents, LinearRgba, Srgba};

/// A colour of the course.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tint {
    /// Pale warm concrete.
    Concrete,
    /// Darker concrete, for risers and bases.
    DarkConcrete,
    /// Sun-bleached planks.
    Wood,
    /// Older planks and tree trunks.
    DarkWood,
    /// Orange: edges, nosings, everything that moves.
    Accent,
    /// Off-white paint beside the orange.
    Paint,
    /// Dark steel.
    Steel,
    /// Grey-brown rock.
    Stone,
    /// Needles of the pines.
    Needles,
    /// The beacon's lamp, brighter than white.
    Lamp,
}

impl Tint {
    /// Linear red, green and blue; the fourth is how open the place is to the sky, 1 unless darkened.
    #[must_use]
    pub fn linear(self) -> [f32; 4] {
        let hex = match self {
            Self::Concrete => Srgba::rgb_u8(0xC9, 0xC2, 0xB4),
            Self::DarkConcrete => Srgba::rgb_u8(0x93, 0x90, 0x8A),
            Self::Wood => Srgba::rgb_u8(0xC0, 0x98, 0x69),
            Self::DarkWood => Srgba::rgb_u8(0x8A, 0x6A, 0x4C),
            Self::Accent => Srgba::rgb_u8(0xF0, 0x72, 0x22),
            Self::Paint => Srgba::rgb_u8(0xEC, 0xE8, 0xDF),
            Self::Steel => Srgba::rgb_u8(0x3C, 0x44, 0x4D),
            Self::Stone => Srgba::rgb_u8(0x8B, 0x86, 0x7D),
            Self::Needles => Srgba::rgb_u8(0x3F, 0x66, 0x47),
            Self::Lamp => return [4.0, 2.0, 0.7, 1.0],
        };
        LinearRgba::from(hex).to_f32_array()
    }
}

/// `color` made `light` times as bright.
#[must_use]
pub fn scaled([red, green, blue, open]: [f32; 4], light: f32) -> [f32; 4] {
    [red * light, green * light, blue * light, open]
}

/// `color` at a place that sees only `open` of the sky, 0..=1.
#[must_use]
pub fn shaded([red, green, blue, _]: [f32; 4], open: f32) -> [f32; 4] {
    [red, green, blue, open]
}
