//! Asset loaders for [`Rig`] (beside bevy's own for the same files) and [`CharacterAsset`], and the plugin of this layer.

use std::collections::BTreeMap;

use bevy::{
    asset::{AssetLoader, AssetPath, LoadContext, ReadAssetBytesError, io::Reader},
    log::warn,
    platform::collections::HashMap,
    prelude::*,
};

use super::{
    Rig,
    character::{CharacterAsset, CharacterError},
    character_file::{CharacterFile, CharacterFileError},
    gltf::{container::Container, error::RigError},
};

/// Registers the assets of this layer and their loaders. Needs bevy's `AssetPlugin`; no rendering.
pub struct RigPlugin;

impl Plugin for RigPlugin {
    fn build(&self, app: &mut App) {
        app.init_asset::<Rig>()
            .init_asset::<CharacterAsset>()
            .register_asset_loader(RigLoader)
            .register_asset_loader(CharacterLoader);
    }
}

/// Loads a [`Rig`]: `asset_server.load::<Rig>("a.glb")`.
///
/// It claims no file extension, so that `load::<Gltf>` and labels like `a.glb#Mesh0` stay with bevy's loader.
#[derive(TypePath)]
pub struct RigLoader;

/// Why a rig didn't load.
#[derive(thiserror::Error, Debug)]
pub enum RigLoadError {
    /// The file can't be read.
    #[error("can't read `{path}`: {error}")]
    Io {
        /// The file.
        path: String,
        /// What the asset source says.
        error: String,
    },
    /// The file is no usable glTF.
    #[error("`{path}`: {error}")]
    Rig {
        /// The file.
        path: String,
        /// What is wrong in it.
        error: RigError,
    },
}

impl AssetLoader for RigLoader {
    type Asset = Rig;
    type Settings = ();
    type Error = RigLoadError;

    async fn load(&self, reader: &mut dyn Reader, _: &(), context: &mut LoadContext<'_>) -> Result<Rig, RigLoadError> {
        let path = context.path().clone();
        let mut bytes = Vec::new();
        reader
            .read_to_end(&mut bytes)
            .await
            .map_err(|error| RigLoadError::Io { path: path.to_string(), error: error.to_string() })?;
        read_rig(&bytes, path, context).await
    }
}

/// Loads a [`CharacterAsset`] from `*.character.ron` and the glTF files it names.
///
/// A model itself, `load::<CharacterAsset>("x.glb")`, makes a character with everything at its default.
///
/// Names are resolved here, so a wrong one is a load error, and a reload that fails keeps the last good character.
#[derive(TypePath)]
pub struct CharacterLoader;

/// Why a character didn't load.
#[derive(thiserror::Error, Debug)]
pub enum CharacterLoadError {
    /// The file can't be read.
    #[error("can't read it: {0}")]
    Io(#[from] std::io::Error),
    /// The file is not text.
    #[error("it is not UTF-8 text: {0}")]
    Text(#[from] core::str::Utf8Error),
    /// A field is wrong.
    #[error(transparent)]
    File(#[from] CharacterFileError),
    /// A file name is no path.
    #[error("`{name}` is no asset path: {error}")]
    Path {
        /// As written.
        name: String,
        /// What is wrong.
        error: String,
    },
    /// A glTF file is wrong.
    #[error(transparent)]
    Rig(#[from] RigLoadError),
    /// A name names nothing.
    #[error(transparent)]
    Character(#[from] CharacterError),
}

impl AssetLoader for CharacterLoader {
    type Asset = CharacterAsset;
    type Settings = ();
    type Error = NamedLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        _: &(),
        context: &mut LoadContext<'_>,
    ) -> Result<CharacterAsset, NamedLoadError> {
        let file = context.path().to_string();
        load_character(reader, context).await.map_err(|error| NamedLoadError { file, error })
    }

    fn extensions(&self) -> &[&str] {
        &["character.ron"]
    }
}

/// Why a file didn't load, with the file's name.
#[derive(thiserror::Error, Debug)]
#[error("`{file}`: {error}")]
pub struct NamedLoadError {
    /// The `.character.ron`.
    pub file: String,
    /// What is wrong.
    pub error: CharacterLoadError,
}

async fn load_character(
    reader: &mut dyn Reader,
    context: &mut LoadContext<'_>,
) -> Result<CharacterAsset, CharacterLoadError> {
    let mut bytes = Vec::new();
    reader.read_to_end(&mut bytes).await?;
    let base = context.path().clone();
    if let Some(model) = bare_model(&base) {
        let rig = read_rig(&bytes, base.clone(), context).await?;
        let file = CharacterFile { model, ..CharacterFile::default() };
        return Ok(CharacterAsset::resolve(file, base, rig, &BTreeMap::new())?);
    }
    let file = CharacterFile::parse(core::str::from_utf8(&bytes)?)?;
    let beside = |name: &str| {
        base.resolve_embed_str(name)
            .map_err(|error| CharacterLoadError::Path { name: name.to_owned(), error: error.to_string() })
    };
    let model_path = beside(&file.model)?;
    let model = load_rig(model_path.clone(), context).await?;
    let mut others = BTreeMap::new();
    for name in file.clips.values().filter_map(|clip| clip.file.as_ref()).filter(|name| **name != file.model) {
        if !others.contains_key(name) {
            others.insert(name.clone(), load_rig(beside(name)?, context).await?);
        }
    }
    let character = CharacterAsset::resolve(file, model_path, model, &others)?;
    for note in &character.notes {
        warn!("`{base}`: {note}");
    }
    Ok(character)
}

/// The file's name if it is a model rather than a character's file.
fn bare_model(path: &AssetPath) -> Option<String> {
    let extension = path.path().extension()?.to_str()?.to_lowercase();
    let name = path.path().file_name()?.to_str()?;
    matches!(extension.as_str(), "glb" | "gltf" | "vrm").then(|| name.to_owned())
}

/// Reads the file at `path` as a rig and makes it a dependency of the asset that is being loaded.
pub(super) async fn load_rig(path: AssetPath<'static>, context: &mut LoadContext<'_>) -> Result<Rig, RigLoadError> {
    let bytes = context.read_asset_bytes(&path).await.map_err(|error| unreadable(&path, &error))?;
    read_rig(&bytes, path, context).await
}

async fn read_rig(bytes: &[u8], path: AssetPath<'static>, context: &mut LoadContext<'_>) -> Result<Rig, RigLoadError> {
    let broken = |error: RigError| RigLoadError::Rig { path: path.to_string(), error };
    let container = Container::parse(bytes).map_err(broken)?;
    let mut files = HashMap::new();
    let needed: Vec<String> = container.external_buffers().collect();
    for uri in needed {
        let beside = path.resolve_embed_str(&uri).map_err(|error| RigLoadError::Io {
            path: format!("{uri} (a buffer of {path})"),
            error: error.to_string(),
        })?;
        let bytes = context.read_asset_bytes(&beside).await.map_err(|error| unreadable(&beside, &error))?;
        files.insert(uri, bytes);
    }
    let mut resolve = |uri: &str| files.get(uri).cloned().ok_or_else(|| "it was not read".to_owned());
    let rig = Rig::from_container(container, &mut resolve).map_err(broken)?;
    for note in &rig.notes {
        warn!("`{path}`: {note}");
    }
    Ok(rig)
}

fn unreadable(path: &AssetPath, error: &ReadAssetBytesError) -> RigLoadError {
    RigLoadError::Io { path: path.to_string(), error: error.to_string() }
}
