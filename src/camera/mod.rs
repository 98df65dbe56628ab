//! Layer 4: the third-person camera. Knows nothing of characters.
//!
//! [`orbit`] says where the camera wants to be, [`follow`] smooths its way there, [`collision`] keeps it out of walls and ground,
//! [`plugin`] runs all three after everything else has moved.

pub mod collision;
pub mod config;
pub mod follow;
pub mod orbit;
pub mod plugin;

pub use config::OrbitCameraConfig;
pub use orbit::{CameraInput, OrbitCamera, OrbitCameraState};
pub use plugin::{CameraPlugin, CameraSystems};
