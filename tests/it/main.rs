//! All integration tests in one binary, since each one links for seconds.

#![expect(unreachable_pub, reason = "modules of one binary share their support")]
#![expect(clippy::unwrap_used, reason = "a test whose scene cannot be set has failed")]

mod actions;
mod arms;
#[cfg(feature = "game")]
mod camera;
mod chains;
mod character_file;
mod character_states;
mod clips;
mod detail;
mod determinism;
mod face;
mod feet;
mod foreign;
mod foreign_feet;
mod gltf_file;
mod heap;
mod layers;
mod locomotion;
mod mannequin;
mod motion;
#[cfg(feature = "render")]
mod peer;
#[cfg(feature = "render")]
mod pictures;
mod probes;
mod quality;
#[cfg(feature = "render")]
mod render_support;
mod reversals;
mod rig;
#[cfg(feature = "render")]
mod shaders;
mod show;
mod support;
#[cfg(feature = "game")]
mod terrain;
#[cfg(feature = "render")]
mod tube;

#[cfg(feature = "game")]
mod cli;
#[cfg(feature = "game")]
mod view;
#[cfg(all(feature = "game", target_os = "linux"))]
mod window;
