//! Layer 4: ground, obstacles and sky. Knows nothing of characters.
//!
//! [`landscape`] shapes a [`heightfield`], which becomes a [`collider`] and a [`mesh`] on the same triangles.
//! [`course`] lists the obstacles, [`shape`] makes each one's mesh and collider, [`platform`] moves the moving ones.
//! [`plugin`] spawns all of it: [`TerrainPlugin`] without a GPU, [`TerrainLookPlugin`] and [`SkyPlugin`] for the eyes.

pub mod boulder;
pub mod collider;
pub mod course;
pub mod facets;
pub mod heightfield;
pub mod landscape;
pub mod material;
pub mod mesh;
pub mod palette;
pub mod platform;
pub mod plugin;
pub mod scatter;
pub mod shade;
pub mod shape;
pub mod sky;

pub use course::Piece;
pub use heightfield::Heightfield;
pub use platform::{MovingPlatform, PlatformSystems};
pub use plugin::{Ground, TerrainLookPlugin, TerrainPlugin};
pub use sky::{SkyPlugin, SkyView};
