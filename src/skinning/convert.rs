//! Turns the engine's glTF meshes and materials into skinned ones, once each, shared by every character.

use std::sync::Arc;

use bevy::{
    asset::AssetMut,
    ecs::system::SystemParam,
    gltf::{GltfMaterial, GltfMesh},
    platform::collections::HashMap,
    prelude::*,
};

use super::{
    bounds::SlotBox,
    material::{SkinExtension, SkinnedMaterial},
    mesh::{SkinMeshError, morph_names, rigid_mesh, skin_mesh, skin_mesh_by, slot_boxes},
};
use crate::rig::Influences;

/// A mesh ready to be drawn with a [`SkinnedMaterial`].
#[derive(Clone, Debug)]
pub(super) struct ConvertedMesh {
    pub(super) mesh: Handle<Mesh>,
    /// Box of what each palette slot moves, in the mesh's space.
    pub(super) boxes: Arc<[SlotBox]>,
    /// Names of its morph targets.
    pub(super) morphs: Arc<[String]>,
}

/// How a source mesh is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Binding {
    /// To the glTF skin of this index, which has `slot_count` joints; vertices without weights ride on `unweighted`.
    Skin { skin: usize, slot_count: usize, unweighted: u16 },
    /// All of it to one joint.
    Rigid,
}

/// What was converted so far, by source. An entry goes when its source does.
#[derive(Resource, Default)]
pub(super) struct Converted {
    meshes: HashMap<(AssetId<Mesh>, Binding), Result<ConvertedMesh, SkinMeshError>>,
    materials: HashMap<Option<AssetId<GltfMaterial>>, ConvertedMaterial>,
}

struct ConvertedMaterial {
    source: Option<Handle<StandardMaterial>>,
    skinned: Option<Handle<SkinnedMaterial>>,
}

/// Everything a conversion reads and writes.
#[derive(SystemParam)]
pub(super) struct Converter<'w> {
    server: Res<'w, AssetServer>,
    gltf_meshes: Res<'w, Assets<GltfMesh>>,
    standard: Res<'w, Assets<StandardMaterial>>,
    meshes: ResMut<'w, Assets<Mesh>>,
    skinned: ResMut<'w, Assets<SkinnedMaterial>>,
    converted: ResMut<'w, Converted>,
}

impl Converter<'_> {
    /// A glTF mesh, once it and all its primitives are loaded.
    pub(super) fn gltf_mesh(&self, handle: &Handle<GltfMesh>) -> Option<GltfMesh> {
        let mesh = self.gltf_meshes.get(handle)?;
        mesh.primitives.iter().all(|primitive| self.meshes.contains(&primitive.mesh)).then(|| mesh.clone())
    }

    /// The converted mesh of `source`, which is loaded. `influences` are the rig's for it, mended on import.
    pub(super) fn mesh(
        &mut self,
        source: &Handle<Mesh>,
        binding: Binding,
        influences: Option<&Influences>,
    ) -> Result<ConvertedMesh, SkinMeshError> {
        let key = (source.id(), binding);
        if let Some(done) = self.converted.meshes.get(&key) {
            return done.clone();
        }
        let done = self.convert_mesh(source, binding, influences);
        self.converted.meshes.insert(key, done.clone());
        done
    }

    fn convert_mesh(
        &mut self,
        source: &Handle<Mesh>,
        binding: Binding,
        influences: Option<&Influences>,
    ) -> Result<ConvertedMesh, SkinMeshError> {
        let source = self.meshes.get(source).ok_or(SkinMeshError::Unreadable)?;
        let (mesh, slot_count) = match binding {
            Binding::Skin { slot_count, unweighted, .. } => {
                // The engine splits vertices of a mesh that came without normals; then only its own attributes fit.
                let fitting = influences.filter(|influences| influences.joints.len() == source.count_vertices());
                let mesh = match fitting {
                    Some(by) => skin_mesh_by(source, &by.joints, &by.weights, slot_count, unweighted)?,
                    None => skin_mesh(source, slot_count, unweighted)?,
                };
                (mesh, slot_count)
            }
            // The boxes, made first, find out whether the mesh can be read.
            Binding::Rigid => (slot_boxes(source, 1).map(|_| rigid_mesh(source))?, 1),
        };
        let boxes = slot_boxes(&mesh, slot_count)?.into();
        let morphs = morph_names(&mesh).into();
        Ok(ConvertedMesh { mesh: self.meshes.add(mesh), boxes, morphs })
    }

    /// The skinned material for a glTF material; `None` while it loads.
    pub(super) fn material(&mut self, source: Option<&Handle<GltfMaterial>>) -> Option<Handle<SkinnedMaterial>> {
        let Self { server, standard, skinned, converted, .. } = self;
        let entry = converted.materials.entry(source.map(Handle::id)).or_insert_with(|| ConvertedMaterial {
            // The engine keeps its own conversion under the glTF material's label + "/std".
            source: source.and_then(|source| server.get_path(source.id())).map(|path| {
                let label = format!("{}/std", path.label().unwrap_or_default());
                server.load(path.into_owned().with_label(label))
            }),
            skinned: None,
        });
        if entry.skinned.is_none() {
            let base = match &entry.source {
                // What glTF says of a mesh without a material.
                None => StandardMaterial { metallic: 1.0, perceptual_roughness: 1.0, ..default() },
                Some(source) if server.load_state(source).is_failed() => StandardMaterial::default(),
                Some(source) => standard.get(source)?.clone(),
            };
            entry.skinned = Some(skinned.add(SkinnedMaterial { base, extension: SkinExtension }));
        }
        entry.skinned.clone()
    }
}

/// Follows the sources: what was removed is forgotten, what was changed is converted anew.
pub(super) fn follow_sources(
    mut mesh_events: MessageReader<AssetEvent<Mesh>>,
    mut material_events: MessageReader<AssetEvent<StandardMaterial>>,
    mut gltf_events: MessageReader<AssetEvent<GltfMaterial>>,
    standard: Res<Assets<StandardMaterial>>,
    mut skinned: ResMut<Assets<SkinnedMaterial>>,
    mut converted: ResMut<Converted>,
) {
    for event in mesh_events.read() {
        if let AssetEvent::Removed { id } | AssetEvent::Modified { id } = event {
            converted.meshes.retain(|(source, _), _| source != id);
        }
    }
    for event in gltf_events.read() {
        if let AssetEvent::Removed { id } = event {
            converted.materials.remove(&Some(*id));
        }
    }
    for event in material_events.read() {
        let AssetEvent::Modified { id } = event else { continue };
        let done = converted.materials.values().find(|done| done.source.as_ref().is_some_and(|s| s.id() == *id));
        if let Some(target) = done.and_then(|done| done.skinned.as_ref())
            && let Some(material) = skinned.get_mut(target).map(AssetMut::into_inner)
            && let Some(base) = standard.get(*id)
        {
            material.base = base.clone();
        }
    }
}
