//! `StandardMaterial` with an own vertex stage: lights, shadows, textures and PBR stay as they are.

use core::sync::atomic::Ordering;

use bevy::{
    ecs::system::{SystemParamItem, lifetimeless::SRes},
    mesh::MeshVertexBufferLayoutRef,
    pbr::{ExtendedMaterial, MaterialExtension, MaterialExtensionKey, MaterialExtensionPipeline},
    prelude::*,
    render::{
        render_resource::{
            AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutEntry, BindingResources, BindingType,
            BufferBindingType, OwnedBindingResource, RenderPipelineDescriptor, ShaderStages,
            SpecializedMeshPipelineError, UnpreparedBindGroup,
        },
        renderer::RenderDevice,
    },
    shader::ShaderRef,
};

use super::{
    mesh::{ATTRIBUTE_SKIN_SLOTS, ATTRIBUTE_SKIN_WEIGHTS},
    upload::SkinArenaGpu,
};

/// The material of skinned meshes. One asset serves every character; colour them apart by [`Tint`](super::Tint).
pub type SkinnedMaterial = ExtendedMaterial<StandardMaterial, SkinExtension>;

/// Adds skinning to a material; there is nothing to set.
#[derive(Asset, TypePath, Clone, Copy, Default, Debug)]
pub struct SkinExtension;

/// Where `shaders/skinning.wgsl` has its two buffers.
const MATRICES_BINDING: u32 = 100;
const INSTANCES_BINDING: u32 = 101;

/// Where `shaders/character.wgsl` has its own vertex attributes.
const SLOTS_LOCATION: u32 = 10;
const WEIGHTS_LOCATION: u32 = 11;

impl AsBindGroup for SkinExtension {
    type Data = ();
    type Param = SRes<SkinArenaGpu>;

    fn label() -> &'static str {
        "surefoot skin"
    }

    fn bind_group_data(&self) -> Self::Data {}

    fn unprepared_bind_group(
        &self,
        _layout: &BindGroupLayout,
        _device: &RenderDevice,
        gpu: &mut SystemParamItem<'_, '_, Self::Param>,
        _force_no_bindless: bool,
    ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
        gpu.bind_groups_made.fetch_add(1, Ordering::Relaxed);
        let matrices = OwnedBindingResource::Buffer(gpu.matrices.clone());
        let instances = OwnedBindingResource::Buffer(gpu.instances.clone());
        Ok(UnpreparedBindGroup {
            bindings: BindingResources(vec![(MATRICES_BINDING, matrices), (INSTANCES_BINDING, instances)]),
        })
    }

    fn bind_group_layout_entries(_device: &RenderDevice, _force_no_bindless: bool) -> Vec<BindGroupLayoutEntry> {
        let entry = |binding| BindGroupLayoutEntry {
            binding,
            visibility: ShaderStages::VERTEX,
            ty: BindingType::Buffer {
                ty: BufferBindingType::Storage { read_only: true },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        };
        vec![entry(MATRICES_BINDING), entry(INSTANCES_BINDING)]
    }
}

fn character_shader() -> ShaderRef {
    "embedded://surefoot/shaders/character.wgsl".into()
}

impl MaterialExtension for SkinExtension {
    fn vertex_shader() -> ShaderRef {
        character_shader()
    }

    fn prepass_vertex_shader() -> ShaderRef {
        character_shader()
    }

    fn deferred_vertex_shader() -> ShaderRef {
        character_shader()
    }

    fn specialize(
        _pipeline: &MaterialExtensionPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        _key: MaterialExtensionKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let vertex = &mut descriptor.vertex;
        if layout.0.contains(ATTRIBUTE_SKIN_SLOTS) && layout.0.contains(ATTRIBUTE_SKIN_WEIGHTS) {
            let skin = layout.0.get_layout(&[
                ATTRIBUTE_SKIN_SLOTS.at_shader_location(SLOTS_LOCATION),
                ATTRIBUTE_SKIN_WEIGHTS.at_shader_location(WEIGHTS_LOCATION),
            ])?;
            vertex.buffers[0].attributes.extend(skin.attributes);
            vertex.shader_defs.push("SUREFOOT_SKIN".into());
        }
        // The tint goes to the fragment stage as a vertex colour; the engine has set this for meshes with own colours.
        if layout.0.contains(Mesh::ATTRIBUTE_COLOR) {
            vertex.shader_defs.push("MESH_COLORS".into());
        } else {
            vertex.shader_defs.push("VERTEX_COLORS".into());
            if let Some(fragment) = &mut descriptor.fragment {
                fragment.shader_defs.push("VERTEX_COLORS".into());
            }
        }
        Ok(())
    }
}
