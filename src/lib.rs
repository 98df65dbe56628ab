//! Characters whose feet stay where they land.
//!
//! Layers, bottom to top; a file imports lower layers, or earlier stages of its own:
//! [`math`] → [`anim`] → [`rig`] → [`character`] → `skinning`, [`measure`], `debug` → [`testing`] → `terrain`, `camera` → `game`.
//!
//! A model of your own: [Bring your own character](rig::guide).
//!
//! Model space everywhere: metres, +Y up, the character faces -Z.

pub mod anim;
pub mod character;
pub mod math;
pub mod measure;
pub mod rig;
pub mod testing;

#[cfg(feature = "game")]
pub mod camera;
#[cfg(feature = "render")]
pub mod debug;
#[cfg(feature = "game")]
pub mod game;
#[cfg(feature = "render")]
pub mod skinning;
#[cfg(feature = "game")]
pub mod terrain;

mod plugins;

pub use plugins::SurefootPlugins;

/// The code of the README compiles.
#[cfg(all(doctest, feature = "game"))]
#[doc = include_str!("../README.md")]
struct Readme;
