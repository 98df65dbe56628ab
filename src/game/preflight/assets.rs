//! Where is the folder with the mannequin?

use std::{
    env,
    path::{Path, PathBuf},
};

use super::Missing;

/// A file that the right folder holds.
const LANDMARK: &str = "mannequin.character.ron";

/// Finds the assets: beside what `BEVY_ASSET_ROOT` names, the working folder, the program, or the sources it was built from.
///
/// # Errors
/// [`Missing::Assets`] with the folders looked at.
pub fn find() -> Result<PathBuf, Missing> {
    let named = env::var_os("BEVY_ASSET_ROOT").map(PathBuf::from);
    let working = env::current_dir().ok();
    let program = env::current_exe().ok().and_then(|file| file.parent().map(Path::to_path_buf));
    let sources = Some(PathBuf::from(env!("CARGO_MANIFEST_DIR")));
    let folders: Vec<_> =
        [named, working, program, sources].into_iter().flatten().map(|folder| folder.join("assets")).collect();
    folders.iter().find(|folder| folder.join(LANDMARK).is_file()).cloned().ok_or_else(|| {
        let looked: Vec<_> = folders.iter().map(|folder| folder.display().to_string()).collect();
        Missing::Assets { file: LANDMARK, looked: looked.join(", ") }
    })
}
