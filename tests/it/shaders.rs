//! The functions of `shaders/skinning.wgsl`, run on the GPU over whole meshes and held against `anim::skin`.

use bevy::{
    math::{Affine3A, Quat, Vec3, Vec4, ops},
    mesh::{Mesh, VertexAttributeValues},
};
use surefoot::{
    anim::skin::{Influences, SkinVertex, skinned},
    skinning::{
        JointMatrix, SkinArena, SkinRange,
        mesh::{ATTRIBUTE_SKIN_SLOTS, ATTRIBUTE_SKIN_WEIGHTS},
        skin_mesh,
    },
};

use crate::render_support::{adapter, tube, tube_palette};

/// Metres between a vertex of the GPU and of the CPU.
const POSITION_TOLERANCE: f32 = 1e-4;
/// Radians, about, between two normals.
const NORMAL_TOLERANCE: f32 = 1e-3;

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
struct VertexIn {
    position: [f32; 4],
    normal: [f32; 4],
    tangent: [f32; 4],
    slots: [u16; 4],
    weights: [u16; 4],
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct VertexOut {
    position: [f32; 4],
    normal: [f32; 4],
    tangent: [f32; 4],
    previous: [f32; 4],
}

/// What both sides skin.
struct Case {
    vertices: Vec<VertexIn>,
    now: Vec<Affine3A>,
    last: Vec<Affine3A>,
}

impl Case {
    /// A tube of our own format, at two moments.
    fn tube(rings: usize, sides: usize, joint_count: usize, time: f32) -> Self {
        let mesh = skin_mesh(&tube(rings, sides, joint_count), joint_count, 0).unwrap();
        let [now, last] = [time, time - 0.1].map(|time| tube_palette(joint_count, time, 0.7));
        Self { vertices: vertices(&mesh), now, last }
    }
}

fn vertices(mesh: &Mesh) -> Vec<VertexIn> {
    use VertexAttributeValues::{Float32x3, Uint16x4, Unorm16x4};
    let attribute = |id| mesh.attribute(id);
    let (Some(Float32x3(positions)), Some(Float32x3(normals)), Some(Uint16x4(slots)), Some(Unorm16x4(weights))) = (
        attribute(Mesh::ATTRIBUTE_POSITION),
        attribute(Mesh::ATTRIBUTE_NORMAL),
        attribute(ATTRIBUTE_SKIN_SLOTS),
        attribute(ATTRIBUTE_SKIN_WEIGHTS),
    ) else {
        panic!("a skinned mesh has all four attributes");
    };
    (0..positions.len())
        .map(|i| VertexIn {
            position: Vec3::from(positions[i]).extend(1.0).to_array(),
            normal: Vec3::from(normals[i]).extend(0.0).to_array(),
            tangent: Vec3::from(normals[i]).any_orthonormal_vector().extend(-1.0).to_array(),
            slots: slots[i],
            weights: weights[i],
        })
        .collect()
}

fn on_cpu(palette: &[Affine3A], vertex: &VertexIn) -> SkinVertex {
    let influences = Influences { slots: vertex.slots, weights: vertex.weights };
    skinned(
        palette,
        influences,
        SkinVertex {
            position: Vec4::from(vertex.position).truncate(),
            normal: Vec4::from(vertex.normal).truncate(),
            tangent: Vec4::from(vertex.tangent),
        },
    )
}

/// A device that runs the shader's functions.
struct Bench {
    device: wgpu::Device,
    queue: wgpu::Queue,
    pipeline: wgpu::ComputePipeline,
}

impl Bench {
    fn new() -> Self {
        let adapter = adapter();
        let (device, queue) = bevy::tasks::block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))
            .expect("a driver with compute");
        // The two lines that belong to the engine's preprocessor.
        let functions = include_str!("../../shaders/skinning.wgsl")
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
    fn run(&self, vertices: &[VertexIn], instance: u32, now: &SkinArena, last: &SkinArena) -> Vec<VertexOut> {
        use wgpu::BufferUsages as Usage;
        let half = u32::try_from(last.all_matrices().len()).unwrap();
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
            pass.dispatch_workgroups(u32::try_from(vertices.len().div_ceil(64)).unwrap(), 1, 1);
        }
        encoder.copy_buffer_to_buffer(&out, 0, &copy, 0, out_bytes);
        self.queue.submit([encoder.finish()]);
        copy.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("the copy can be read"));
        self.device.poll(wgpu::PollType::wait_indefinitely()).expect("the GPU finishes");
        let bytes = copy.slice(..).get_mapped_range().to_vec();
        bytemuck::pod_collect_to_vec(&bytes)
    }

    /// Largest distances of a case between both sides: this frame's positions, normals, and last frame's positions.
    fn compare(&self, case: &Case) -> [f32; 3] {
        let (now, range) = arena_of(&case.now);
        let (last, _) = arena_of(&case.last);
        let moved = self.run(&case.vertices, range.instance(), &now, &last);
        let mut worst = [0.0f32; 3];
        for (vertex, gpu) in case.vertices.iter().zip(&moved) {
            let cpu = on_cpu(&case.now, vertex);
            let previous = on_cpu(&case.last, vertex).position;
            let direction = |a: [f32; 4], b: Vec3| Vec4::from(a).truncate().distance(b);
            worst[0] = worst[0].max(direction(gpu.position, cpu.position));
            worst[1] = worst[1].max(direction(gpu.normal, cpu.normal));
            worst[1] = worst[1].max(Vec4::from(gpu.tangent).distance(cpu.tangent));
            worst[2] = worst[2].max(direction(gpu.previous, previous));
        }
        worst
    }
}

/// An arena in which others stand before and behind the palette.
fn arena_of(palette: &[Affine3A]) -> (SkinArena, SkinRange) {
    let mut arena = SkinArena::with_capacity(16);
    let far = JointMatrix::from(Affine3A::from_translation(Vec3::splat(1e3)));
    let before = arena.allocate(17).unwrap();
    arena.matrices_mut(before).fill(far);
    let range = arena.allocate(u32::try_from(palette.len()).unwrap()).unwrap();
    for (matrix, affine) in arena.matrices_mut(range).iter_mut().zip(palette) {
        *matrix = (*affine).into();
    }
    let behind = arena.allocate(5).unwrap();
    arena.matrices_mut(behind).fill(far);
    (arena, range)
}

#[test]
fn every_vertex_is_where_the_cpu_puts_it() {
    let bench = Bench::new();
    for time in [0.0, 0.4, 1.3, 2.9] {
        let case = Case::tube(28, 16, 8, time);
        let [position, normal, previous] = bench.compare(&case);
        assert!(position < POSITION_TOLERANCE, "at {time} s a vertex is {position} m off");
        assert!(normal < NORMAL_TOLERANCE, "at {time} s a normal is {normal} off");
        assert!(previous < POSITION_TOLERANCE, "at {time} s a vertex of the last frame is {previous} m off");
    }
}

#[test]
fn three_hundred_joints_and_five_thousand_vertices_are_too() {
    let bench = Bench::new();
    let case = Case::tube(400, 12, 300, 1.1);
    assert!(case.vertices.len() > 5_000, "{} vertices", case.vertices.len());
    assert!(case.vertices.iter().any(|v| v.slots.iter().any(|slot| *slot > 290)), "far slots are in use");
    let [position, normal, previous] = bench.compare(&case);
    assert!(position < POSITION_TOLERANCE, "a vertex is {position} m off");
    assert!(normal < NORMAL_TOLERANCE, "a normal is {normal} off");
    assert!(previous < POSITION_TOLERANCE, "a vertex of the last frame is {previous} m off");
}

#[test]
fn quantised_weights_put_a_vertex_within_a_tenth_of_a_millimetre() {
    let joint_count = 40;
    let source = tube(60, 8, joint_count);
    let palette = tube_palette(joint_count, 0.9, 0.2);
    let (Some(VertexAttributeValues::Float32x4(weights)), Some(VertexAttributeValues::Uint16x4(slots))) =
        (source.attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT), source.attribute(Mesh::ATTRIBUTE_JOINT_INDEX))
    else {
        panic!("the tube has weights");
    };
    let vertices = vertices(&skin_mesh(&source, joint_count, 0).unwrap());
    let mut worst = 0.0f32;
    for (vertex, (weights, slots)) in vertices.iter().zip(weights.iter().zip(slots)) {
        let position = Vec4::from(vertex.position).truncate();
        let exact: Vec3 = (0..4).map(|i| palette[usize::from(slots[i])].transform_point3(position) * weights[i]).sum();
        worst = worst.max(on_cpu(&palette, vertex).position.distance(exact));
    }
    assert!(worst < POSITION_TOLERANCE, "a vertex is {worst} m off");
}

#[test]
fn mirrored_sheared_and_flattened_palettes_give_the_same_normals() {
    let bench = Bench::new();
    let mesh = skin_mesh(&tube(8, 12, 2), 2, 0).unwrap();
    let turn = Quat::from_scaled_axis(Vec3::new(0.4, 1.0, -0.3));
    let shear = Affine3A::from_cols(Vec3::X.into(), Vec3::new(0.6, 1.0, 0.0).into(), Vec3::Z.into(), Vec3::Y.into());
    let cases = [
        ("mirrored", Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)) * Affine3A::from_quat(turn)),
        ("uneven", Affine3A::from_scale_rotation_translation(Vec3::new(0.3, 2.0, 1.0), turn, Vec3::X)),
        ("sheared", shear),
        ("flat", Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0))),
        ("nothing", Affine3A::from_scale(Vec3::ZERO)),
    ];
    for (name, affine) in cases {
        let case = Case { vertices: vertices(&mesh), now: vec![affine; 2], last: vec![Affine3A::IDENTITY; 2] };
        let [position, normal, _] = bench.compare(&case);
        assert!(position < POSITION_TOLERANCE, "{name}: a vertex is {position} m off");
        assert!(normal < NORMAL_TOLERANCE, "{name}: a normal is {normal} off");
    }
}

#[test]
fn a_mesh_without_a_palette_or_with_too_small_a_one_never_reads_a_neighbours() {
    let bench = Bench::new();
    let mut vertices = Case::tube(4, 6, 8, 0.0).vertices;
    vertices.truncate(20);
    let palette: Vec<_> = (0..3).map(|i| Affine3A::from_translation(Vec3::Y * ops::sqrt(i as f32))).collect();
    let (arena, range) = arena_of(&palette);
    for (instance, palette) in [(0, &[Affine3A::IDENTITY][..]), (range.instance(), &palette)] {
        for (vertex, gpu) in vertices.iter().zip(bench.run(&vertices, instance, &arena, &arena)) {
            let cpu = on_cpu(palette, vertex).position;
            let gpu = Vec4::from(gpu.position).truncate();
            assert!(gpu.distance(cpu) < POSITION_TOLERANCE, "instance {instance}: {gpu} is not {cpu}");
        }
    }
}
