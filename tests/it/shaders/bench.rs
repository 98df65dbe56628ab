//! A device that runs the skinning shader's functions in a compute pass.

use surefoot::skinning::SkinArena;

use crate::render_support::adapter;

/// Runs the shader's own functions for every vertex of a mesh: this frame's position, normal and tangent, and the last
/// frame's position.
const ENTRY: &str = "
struct VertexIn { position: vec4<f32>, normal: vec4<f32>, tangent: vec4<f32>, slots: vec2<u32>, weights: vec2<u32> }
struct VertexOut { position: vec4<f32>, normal: vec4<f32>, tangent: vec4<f32>, previous: vec4<f32> }
@group(1) @binding(0) var<storage, read> vertices: array<VertexIn>;
@group(1) @binding(1) var<storage, read_write> moved: array<VertexOut>;
@group(1) @binding(2) var<uniform> tag: vec4<u32>;

@compute @workgroup_size(64)
fn run(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&vertices) { return; }
    let v = vertices[id.x];
    let slots = vec4(v.slots.x & 0xffffu, v.slots.x >> 16u, v.slots.y & 0xffffu, v.slots.y >> 16u);
    let weights = vec4(unpack2x16unorm(v.weights.x), unpack2x16unorm(v.weights.y));
    let m = skin_matrix(tag.x, slots, weights);
    var out: VertexOut;
    out.position = vec4(skin_point(m, v.position.xyz), 1.0);
    out.normal = vec4(skin_normal(m, v.normal.xyz), 0.0);
    out.tangent = vec4(skin_tangent(m, v.tangent.xyz), v.tangent.w);
    out.previous = vec4(skin_point(previous_skin_matrix(tag.x, slots, weights), v.position.xyz), 1.0);
    moved[id.x] = out;
}";

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct VertexIn {
    pub(super) position: [f32; 4],
    pub(super) normal: [f32; 4],
    pub(super) tangent: [f32; 4],
    pub(super) slots: [u16; 4],
    pub(super) weights: [u16; 4],
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct VertexOut {
    pub(super) position: [f32; 4],
    pub(super) normal: [f32; 4],
    pub(super) tangent: [f32; 4],
    pub(super) previous: [f32; 4],
}

/// A device that runs the shader's functions.
pub(super) struct Bench {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::ComputePipeline,
}

impl Bench {
    pub(super) fn new() -> Self {
        let adapter = adapter();
        let (device, queue) = bevy::tasks::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))
            .expect("a driver with compute");
        // The two lines that belong to the engine's preprocessor.
        let functions = include_str!("../../../shaders/skinning.wgsl")
            .replace("#define_import_path surefoot::skinning", "")
            .replace("#{MATERIAL_BIND_GROUP}", "0");
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("skinning.wgsl"),
            source: wgpu::ShaderSource::Wgsl((functions + ENTRY).into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("run"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { device, queue, pipeline }
    }

    fn buffer(&self, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: bytes.len() as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// Skins `vertices` with record `instance` of two arenas: this frame's, and the last frame's of the same layout.
    pub(super) fn run(
        &self,
        vertices: &[VertexIn],
        instance: u32,
        now: &SkinArena,
        last: &SkinArena,
    ) -> Vec<VertexOut> {
        use wgpu::BufferUsages as Usage;
        let half = count(last.all_matrices().len());
        let matrices = [last.all_matrices(), now.all_matrices()].concat();
        let mut instances = bytemuck::cast_slice(&[half, 0, 0, 0]).to_vec();
        instances.extend_from_slice(bytemuck::cast_slice(now.all_instances()));
        let out_bytes = (vertices.len() * size_of::<VertexOut>()) as u64;
        let [out, copy] = [Usage::STORAGE | Usage::COPY_SRC, Usage::MAP_READ | Usage::COPY_DST].map(|usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: out_bytes,
                usage,
                mapped_at_creation: false,
            })
        });
        let groups = [
            vec![
                (100, self.buffer(bytemuck::cast_slice(&matrices), Usage::STORAGE)),
                (101, self.buffer(&instances, Usage::STORAGE)),
            ],
            vec![
                (0, self.buffer(bytemuck::cast_slice(vertices), Usage::STORAGE)),
                (1, out.clone()),
                (2, self.buffer(bytemuck::cast_slice(&[instance, 0, 0, 0]), Usage::UNIFORM)),
            ],
        ];
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            for (index, buffers) in (0..).zip(&groups) {
                let entries: Vec<_> = buffers
                    .iter()
                    .map(|(binding, buffer)| wgpu::BindGroupEntry {
                        binding: *binding,
                        resource: buffer.as_entire_binding(),
                    })
                    .collect();
                let group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: None,
                    layout: &self.pipeline.get_bind_group_layout(index),
                    entries: &entries,
                });
                pass.set_bind_group(index, &group, &[]);
            }
            pass.dispatch_workgroups(count(vertices.len().div_ceil(64)), 1, 1);
        }
        encoder.copy_buffer_to_buffer(&out, 0, &copy, 0, out_bytes);
        self.queue.submit([encoder.finish()]);
        copy.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("the copy can be read"));
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the GPU finishes");
        let bytes = copy.slice(..).get_mapped_range().to_vec();
        bytemuck::pod_collect_to_vec(&bytes)
    }
}

/// As the GPU counts.
pub(super) fn count(items: usize) -> u32 {
    u32::try_from(items).expect("test meshes are small")
}
