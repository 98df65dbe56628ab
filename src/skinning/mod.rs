//! Layer 3: palettes to the GPU. A pose becomes matrices in one shared buffer, and the vertex stage bends meshes by them.
//!
//! Any mesh can be skinned: give an entity a [`Palette`], write model-space matrices through [`SkinArena::matrices_mut`],
//! and draw meshes made by [`skin_mesh`] with a [`SkinnedMaterial`] and [`SkinnedBy`] that entity.
//! [`SkinnedModel`] does all of that for a character's glTF, and a [`Character`](crate::character::Character) gets one
//! when its file is loaded.

pub mod arena;
mod assemble;
pub mod bounds;
mod convert;
pub mod detail;
mod dress;
mod halves;
pub mod layout;
pub mod material;
pub mod mesh;
pub mod mesh_levels;
pub mod model;
pub mod morphs;
pub mod palette;
pub mod ranges;
pub mod simplify;
mod upload;

use bevy::{
    asset::{AssetEventSystems, io::embedded::EmbeddedAssetRegistry},
    camera::visibility::VisibilitySystems,
    pbr::{MaterialPlugin, PbrPlugin},
    prelude::*,
    render::{RenderApp, renderer::RenderDevice},
    transform::TransformSystems,
};
use std::path::{Path, PathBuf};

pub use self::{
    arena::{SkinArena, SkinRange},
    bounds::PoseBounds,
    detail::ScreenDetail,
    layout::JointMatrix,
    material::{SkinExtension, SkinnedMaterial},
    mesh::{SkinMeshError, skin_mesh},
    mesh_levels::MeshLevels,
    model::{SkinPose, SkinnedModel},
    morphs::Morphs,
    palette::{Palette, SkinnedBy, SkinnedMeshes, Tint},
    upload::SkinUpload,
};
pub use crate::character::levels::{DetailLevel, DetailLevels};
use crate::character::schedule::PoseSystems;

/// GPU skinning. Goes after `DefaultPlugins`; without a GPU it keeps palettes on the CPU and draws nothing.
#[derive(Clone, Copy, Debug)]
pub struct SkinningPlugin {
    /// Joint matrices there is room for before the buffer first doubles; 96 bytes of GPU memory each. Default 16,384.
    ///
    /// A character takes about 55. Small: the buffer grows, a frame of some milliseconds, as characters arrive.
    pub initial_joints: u32,
}

impl Default for SkinningPlugin {
    fn default() -> Self {
        Self { initial_joints: 16_384 }
    }
}

impl Plugin for SkinningPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(SkinArena::with_capacity(self.initial_joints))
            .register_type::<Tint>()
            .configure_sets(PostUpdate, PoseSystems::Palette.before(TransformSystems::Propagate))
            .add_systems(
                PostUpdate,
                (palette::apply_tints, (bounds::fit, bounds::apply).chain().after(model::update_palettes))
                    .in_set(PoseSystems::Palette),
            );
        palette::observe(app);
        if app.is_plugin_added::<PbrPlugin>() {
            embed_shaders(app);
            detail::plugin(app);
            mesh_levels::plugin(app);
            app.add_plugins((
                MaterialPlugin::<SkinnedMaterial>::default(),
                model::SkinnedModelPlugin,
                dress::DressPlugin,
            ))
            .add_systems(PostUpdate, upload::remake_bind_groups.before(AssetEventSystems))
            .add_systems(PostUpdate, palette::refresh_morphs.after(VisibilitySystems::CheckVisibility));
            upload::build(app);
        }
    }

    fn finish(&self, app: &mut App) {
        if app.get_sub_app(RenderApp).is_none() {
            app.add_systems(Last, |mut arena: ResMut<SkinArena>| arena.forget_pending());
        }
        if let Some(device) = app.world().get_resource::<RenderDevice>() {
            let matrices = upload::matrix_limit(device);
            app.world_mut().resource_mut::<SkinArena>().set_limit(matrices);
        }
    }
}

/// Keeps shaders that are only imported from being dropped.
#[derive(Resource)]
struct ShaderLibraries {
    #[expect(dead_code, reason = "held, not read")]
    skinning: Handle<Shader>,
}

fn embed_shaders(app: &mut App) {
    let registry = app.world().resource::<EmbeddedAssetRegistry>();
    let files = [
        ("skinning.wgsl", include_bytes!("../../shaders/skinning.wgsl").as_slice()),
        ("character.wgsl", include_bytes!("../../shaders/character.wgsl").as_slice()),
    ];
    for (name, bytes) in files {
        let file = PathBuf::from("shaders").join(name);
        registry.insert_asset(file.clone(), &Path::new("surefoot").join(file), bytes);
    }
    let skinning = app.world().resource::<AssetServer>().load("embedded://surefoot/shaders/skinning.wgsl");
    app.insert_resource(ShaderLibraries { skinning });
}
