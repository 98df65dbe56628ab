//! A device that runs the vertex stage of `shaders/character.wgsl` and reads back every vertex.
//!
//! Each vertex is a point of its own, drawn as an instance of its own, on a target of one pixel.

use bevy::{
    asset::{AssetId, uuid::Uuid},
    math::Mat4,
    shader::{Shader, ShaderCache, ShaderCacheError, ShaderCacheSource, ShaderDefVal, ValidateShader},
};
use surefoot::{anim::skin::MorphDelta, skinning::SkinArena};
use wgpu::{BufferUsages as Usage, VertexFormat};

use super::stand_ins;
use crate::render_support::adapter;

/// A vertex as the buffer has it.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct VertexIn {
    pub(super) position: [f32; 3],
    pub(super) normal: [f32; 3],
    pub(super) tangent: [f32; 4],
    pub(super) slots: [u16; 4],
    pub(super) weights: [u16; 4],
}

/// What the vertex stage makes of a vertex, world space.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct Moved {
    pub(super) position: [f32; 4],
    pub(super) normal: [f32; 4],
    pub(super) tangent: [f32; 4],
    pub(super) previous: [f32; 4],
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Scene {
    world_from_model: Mat4,
    previous_world_from_model: Mat4,
    vertex_count: u32,
    target_count: u32,
    pad: [u32; 2],
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Record {
    first_vertex_index: u32,
    morph_descriptor_index: u32,
    tag: u32,
    /// 1: not mirrored.
    flags: u32,
}

/// A pass of the engine, as far as its vertex stage differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pass {
    /// The main pass: no positions of the last frame.
    Main,
    /// The prepass with motion vectors.
    Prepass,
}

/// What is drawn: a mesh, its targets, and where it is in this frame and was in the last.
pub(super) struct Draw<'a> {
    pub(super) vertices: &'a [VertexIn],
    /// By target, then by vertex.
    pub(super) targets: &'a [Vec<MorphDelta>],
    /// This frame's weight and the last frame's, by target.
    pub(super) weights: &'a [[f32; 2]],
    /// This frame's place and the last frame's.
    pub(super) world_from_model: [Mat4; 2],
    /// Record of the palette in both arenas.
    pub(super) instance: u32,
    /// This frame's palettes, and the last frame's of the same layout.
    pub(super) arenas: [&'a SkinArena; 2],
}

/// Vertices of others before the mesh's own, as where meshes share a buffer.
const BEFORE: usize = 3;

/// Shader, and where the engine has normals in this pass.
fn definitions(pass: Pass) -> (Vec<ShaderDefVal>, u32) {
    let mut names = vec!["VERTEX_NORMALS", "VERTEX_TANGENTS", "MORPH_TARGETS", "SUREFOOT_SKIN", "VERTEX_COLORS"];
    names.push("VERTEX_OUTPUT_INSTANCE_INDEX");
    if pass == Pass::Prepass {
        names.extend(["PREPASS_PIPELINE", "MOTION_VECTOR_PREPASS", "HAS_PREVIOUS_MORPH"]);
    }
    let mut definitions: Vec<ShaderDefVal> = names.into_iter().map(ShaderDefVal::from).collect();
    definitions.push(ShaderDefVal::UInt("MATERIAL_BIND_GROUP".to_owned(), 0));
    (definitions, if pass == Pass::Prepass { 3 } else { 1 })
}

/// The shipped shader of this pass, put together as the engine does it.
fn character_module(device: &wgpu::Device, pass: Pass) -> wgpu::ShaderModule {
    fn load(
        device: &wgpu::Device,
        source: ShaderCacheSource,
        _: &ValidateShader,
    ) -> Result<wgpu::ShaderModule, ShaderCacheError> {
        let ShaderCacheSource::Naga(module) = source else { panic!("it is written in WGSL") };
        let source = wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module));
        Ok(device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some("character.wgsl"), source }))
    }
    let mut cache = ShaderCache::new(device.clone(), device.features(), wgpu::DownlevelFlags::all(), load);
    let mut sources = stand_ins::modules();
    sources.push(include_str!("../../../shaders/skinning.wgsl").to_owned());
    sources.push(include_str!("../../../shaders/character.wgsl").to_owned());
    let mut last = AssetId::<Shader>::default();
    for (index, source) in sources.into_iter().enumerate() {
        last = AssetId::Uuid { uuid: Uuid::from_u128(index as u128) };
        cache.set_shader(last, Shader::from_wgsl(source, format!("{index}.wgsl")));
    }
    let module = cache.get(0, last, &definitions(pass).0).unwrap_or_else(|error| panic!("{error}"));
    module.as_ref().clone()
}

/// A device that runs the vertex stage of one pass.
pub(super) struct VertexStage {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::RenderPipeline,
}

impl VertexStage {
    pub(super) fn new(pass: Pass) -> Self {
        let (device, queue) = bevy::tasks::block_on(adapter().request_device(&wgpu::DeviceDescriptor::default()))
            .expect("a driver that draws");
        let capture = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("capture"),
            source: wgpu::ShaderSource::Wgsl(stand_ins::CAPTURE.into()),
        });
        let attribute = |format, offset, shader_location| wgpu::VertexAttribute { format, offset, shader_location };
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: None,
            layout: None,
            vertex: wgpu::VertexState {
                module: &character_module(&device, pass),
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[wgpu::VertexBufferLayout {
                    array_stride: size_of::<VertexIn>() as u64,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &[
                        attribute(VertexFormat::Float32x3, 0, 0),
                        attribute(VertexFormat::Float32x3, 12, definitions(pass).1),
                        attribute(VertexFormat::Float32x4, 24, 4),
                        attribute(VertexFormat::Uint16x4, 40, 10),
                        attribute(VertexFormat::Unorm16x4, 48, 11),
                    ],
                }],
            },
            primitive: wgpu::PrimitiveState { topology: wgpu::PrimitiveTopology::PointList, ..Default::default() },
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &capture,
                entry_point: Some("capture"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(wgpu::TextureFormat::Rgba8Unorm.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        Self { device, queue, pipeline }
    }

    fn buffer(&self, bytes: &[u8], usage: Usage) -> wgpu::Buffer {
        let buffer = self.empty(bytes.len() as u64, usage | Usage::COPY_DST);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    fn empty(&self, size: u64, usage: Usage) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
    }

    fn group(&self, index: u32, buffers: &[(u32, &wgpu::Buffer)]) -> wgpu::BindGroup {
        let entries: Vec<_> = buffers
            .iter()
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding: *binding, resource: buffer.as_entire_binding() })
            .collect();
        let layout = self.pipeline.get_bind_group_layout(index);
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries })
    }

    /// Every vertex of `draw`, moved.
    pub(super) fn run(&self, draw: &Draw) -> Vec<Moved> {
        let vertex_count = count(draw.vertices.len());
        let [now, last] = draw.arenas;
        let matrices = [last.all_matrices(), now.all_matrices()].concat();
        let mut instances = bytemuck::cast_slice(&[count(last.all_matrices().len()), 0, 0, 0]).to_vec();
        instances.extend_from_slice(bytemuck::cast_slice(now.all_instances()));
        let [world_from_model, previous_world_from_model] = draw.world_from_model;
        let scene = Scene {
            world_from_model,
            previous_world_from_model,
            vertex_count,
            target_count: count(draw.targets.len()),
            pad: [0; 2],
        };
        let flags = u32::from(world_from_model.determinant() > 0.0);
        let record = Record { first_vertex_index: count(BEFORE), morph_descriptor_index: 0, tag: draw.instance, flags };
        let records = vec![record; draw.vertices.len()];
        // No buffer may be empty.
        let mut deltas: Vec<[[f32; 4]; 3]> = vec![];
        for delta in draw.targets.iter().flatten() {
            deltas.push([delta.position, delta.normal, delta.tangent].map(|moves| moves.extend(0.0).to_array()));
        }
        deltas.push([[f32::NAN; 4]; 3]);
        let weights = [draw.weights, &[[f32::NAN; 2]]].concat();
        let vertices = [&[draw.vertices[0]; BEFORE], draw.vertices].concat();

        let out_bytes = size_of::<Moved>() as u64 * u64::from(vertex_count);
        let out = self.empty(out_bytes, Usage::STORAGE | Usage::COPY_SRC);
        let copy = self.empty(out_bytes, Usage::MAP_READ | Usage::COPY_DST);
        let stored = |bytes: &[u8]| self.buffer(bytes, Usage::STORAGE);
        let matrices = stored(bytemuck::cast_slice(&matrices));
        let [scene, records] = [stored(bytemuck::bytes_of(&scene)), stored(bytemuck::cast_slice(&records))];
        let [deltas, weights] = [stored(bytemuck::cast_slice(&deltas)), stored(bytemuck::cast_slice(&weights))];
        let groups = [
            self.group(0, &[(100, &matrices), (101, &stored(&instances))]),
            self.group(1, &[(0, &scene), (1, &records), (2, &deltas), (3, &weights), (4, &out)]),
        ];
        let vertices = self.buffer(bytemuck::cast_slice(&vertices), Usage::VERTEX);
        let pixel = self.pixel();
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &pixel,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations::default(),
                })],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_vertex_buffer(0, vertices.slice(..));
            for (index, group) in (0..).zip(&groups) {
                pass.set_bind_group(index, group, &[]);
            }
            for instance in 0..vertex_count {
                let vertex = instance + count(BEFORE);
                pass.draw(vertex..vertex + 1, instance..instance + 1);
            }
        }
        encoder.copy_buffer_to_buffer(&out, 0, &copy, 0, out_bytes);
        self.queue.submit([encoder.finish()]);
        copy.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("the copy can be read"));
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the GPU finishes");
        let bytes = copy.slice(..).get_mapped_range().to_vec();
        bytemuck::pod_collect_to_vec(&bytes)
    }

    fn pixel(&self) -> wgpu::TextureView {
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d::default(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba8Unorm,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        });
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }
}

/// As the GPU counts.
pub(super) fn count(items: usize) -> u32 {
    u32::try_from(items).expect("test meshes are small")
}
