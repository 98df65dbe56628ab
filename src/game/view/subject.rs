//! The model that is looked at: read from its file before any app exists, then put on stage.

use std::{
    collections::BTreeMap,
    ops::RangeInclusive,
    path::{Path, PathBuf},
    sync::Arc,
};

use bevy::{
    asset::{AssetPath, io::AssetSourceBuilder},
    prelude::*,
};

use crate::{
    game::level::Cast,
    rig::{
        Rig,
        binding::BindingReport,
        character::{CharacterAsset, CharacterError},
        character_file::{CharacterFile, Roles},
    },
    skinning::SkinnedModel,
    testing::peer::{PeerError, load_rig},
};

/// Name of the asset source that is the model's folder.
const SOURCE: &str = "view";
/// Metres of stature for which the course is built; others are brought to [`STATURE`].
const STATURES: RangeInclusive<f32> = 1.2..=2.2;
/// Stature of the mannequin, metres.
const STATURE: f32 = 1.8;

/// A model and what it can do.
pub(in crate::game) struct Subject {
    /// Its file's name.
    pub(in crate::game) name: String,
    folder: PathBuf,
    /// As read.
    pub(in crate::game) rig: Rig,
    /// Which joint plays which part.
    pub(in crate::game) binding: BindingReport,
    /// Everything that walking takes, at a size that fits the course, or why it does not walk.
    pub(in crate::game) walker: Result<CharacterAsset, CharacterError>,
}

/// How a model is put on stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::game) enum Part {
    /// It walks if it can.
    Walker,
    /// It is posed and stays where it is.
    Figure,
}

/// The model on stage.
#[derive(Resource, Clone)]
pub(in crate::game) struct Viewed {
    /// Its file's name.
    pub(in crate::game) name: String,
    /// Skeleton, skins and clips, as it is drawn.
    pub(in crate::game) rig: Arc<Rig>,
    /// Whether it walks by itself.
    pub(in crate::game) walks: bool,
}

impl Subject {
    /// Reads `file` and tries to make a character of it.
    ///
    /// # Errors
    /// When it is no readable model. One that cannot walk is no error.
    pub(in crate::game) fn load(file: &Path) -> Result<Self, PeerError> {
        let rig = load_rig(file)?;
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
        let binding = BindingReport::new(&rig, &Roles::Auto);
        let stature = binding.body.as_ref().map_or(STATURE, |body| body.stature);
        let scale = if STATURES.contains(&stature) { 1.0 } else { STATURE / stature };
        let character = CharacterFile { model: name.clone(), scale, ..CharacterFile::default() };
        let walker = CharacterAsset::resolve(character, asset_path(&name), rig.clone(), &BTreeMap::new());
        Ok(Self { name, folder, rig, binding, walker })
    }

    /// Whether it walks.
    pub(in crate::game) fn walks(&self) -> bool {
        self.walker.is_ok()
    }

    /// The rig as it is drawn.
    pub(in crate::game) fn body(&self) -> Arc<Rig> {
        self.walker.as_ref().map_or_else(|_| Arc::new(self.rig.clone()), |walker| walker.rig.clone())
    }

    /// An app that finds the files beside the model.
    pub(in crate::game) fn app(&self) -> App {
        let mut app = App::new();
        app.register_asset_source(SOURCE, AssetSourceBuilder::platform_default(&self.folder.to_string_lossy(), None));
        app
    }

    /// Gives `app`, whose plugins are there and which has not begun, the model for its hero.
    pub(in crate::game) fn enter(&self, app: &mut App, part: Part) {
        let walker = self.walker.as_ref().ok().filter(|_| part == Part::Walker);
        let world = app.world_mut();
        let rig = self.body();
        let cast = match walker {
            Some(walker) => Cast::Character(world.resource_mut::<Assets<CharacterAsset>>().add(walker.clone())),
            None => {
                let rig = world.resource_mut::<Assets<Rig>>().add(Rig::clone(&rig));
                let gltf = world.resource::<AssetServer>().load(asset_path(&self.name));
                Cast::Model(SkinnedModel { gltf, rig })
            }
        };
        world.insert_resource(cast);
        world.insert_resource(Viewed { name: self.name.clone(), rig, walks: walker.is_some() });
    }
}

fn asset_path(name: &str) -> AssetPath<'static> {
    AssetPath::from_path_buf(PathBuf::from(name)).with_source(SOURCE)
}
