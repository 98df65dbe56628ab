//! The mannequin's clips, for bodies that bring none.

use std::sync::LazyLock;

use bevy::log::error;

use super::Rig;

/// The file that this crate's mannequin is made of.
static BYTES: &[u8] = include_bytes!("../../assets/mannequin.glb");

/// Read once, when the first body needs it.
static MANNEQUIN: LazyLock<Rig> = LazyLock::new(|| {
    Rig::from_slice(BYTES, |uri| Err(format!("`{uri}` is not part of this crate"))).unwrap_or_else(|fault| {
        error!("the mannequin that comes with this crate can't be read: {fault}");
        Rig::default()
    })
});

/// The mannequin, whose clips are called as the standard states are.
pub(super) fn mannequin() -> &'static Rig {
    &MANNEQUIN
}
