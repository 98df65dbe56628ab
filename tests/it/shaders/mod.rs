//! The functions of `shaders/skinning.wgsl`, run on the GPU over whole meshes and held against `anim::skin`.

mod bench;

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

use self::bench::{Bench, VertexIn, count};
use crate::tube::{tube, tube_palette};

/// Why every allocation here succeeds.
const ROOM: &str = "an arena without a limit has room";
/// Metres between a vertex of the GPU and of the CPU.
const POSITION_TOLERANCE: f32 = 1e-4;
/// Radians, about, between two normals.
const NORMAL_TOLERANCE: f32 = 1e-3;

/// What both sides skin.
struct Case {
    vertices: Vec<VertexIn>,
    now: Vec<Affine3A>,
    last: Vec<Affine3A>,
}

impl Case {
    /// A tube of our own format, at two moments.
    fn tube(rings: usize, sides: usize, joint_count: usize, time: f32) -> Self {
        let mesh = skin_mesh(&tube(rings, sides, joint_count), joint_count, 0).expect("a tube can be skinned");
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

impl Case {
    /// Largest distances between both sides: this frame's positions, normals, and last frame's positions.
    fn compare(&self, bench: &Bench) -> [f32; 3] {
        let (now, range) = arena_of(&self.now);
        let (last, _) = arena_of(&self.last);
        let moved = bench.run(&self.vertices, range.instance(), &now, &last);
        let mut worst = [0.0f32; 3];
        for (vertex, gpu) in self.vertices.iter().zip(&moved) {
            let cpu = on_cpu(&self.now, vertex);
            let previous = on_cpu(&self.last, vertex).position;
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
    let before = arena.allocate(17).expect(ROOM);
    arena.matrices_mut(before).fill(far);
    let range = arena.allocate(count(palette.len())).expect(ROOM);
    for (matrix, affine) in arena.matrices_mut(range).iter_mut().zip(palette) {
        *matrix = (*affine).into();
    }
    let behind = arena.allocate(5).expect(ROOM);
    arena.matrices_mut(behind).fill(far);
    (arena, range)
}

#[test]
fn every_vertex_is_where_the_cpu_puts_it() {
    let bench = Bench::new();
    for time in [0.0, 0.4, 1.3, 2.9] {
        let case = Case::tube(28, 16, 8, time);
        let [position, normal, previous] = case.compare(&bench);
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
    let [position, normal, previous] = case.compare(&bench);
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
        let [position, normal, _] = case.compare(&bench);
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
