//! The vertex stage of `shaders/character.wgsl`, run on the GPU over whole meshes and held against `anim::skin`.

mod mannequin;
mod stage;
mod stand_ins;

use bevy::{
    math::{Affine3A, Mat4, Quat, Vec3, Vec4, ops},
    mesh::{Mesh, VertexAttributeValues},
};
use surefoot::{
    anim::skin::{Influences, MorphDelta, SkinVertex, morphed, skinned},
    skinning::{
        JointMatrix, SkinArena, SkinRange,
        mesh::{ATTRIBUTE_SKIN_SLOTS, ATTRIBUTE_SKIN_WEIGHTS},
        skin_mesh,
    },
};

use self::stage::{Draw, Pass, VertexIn, VertexStage, count};
use crate::tube::{tube, tube_palette};

/// Why every allocation here succeeds.
const ROOM: &str = "an arena without a limit has room";
/// Metres between a vertex of the GPU and of the CPU.
const POSITION_TOLERANCE: f32 = 1e-4;
/// Radians, about, between two normals or tangents.
const NORMAL_TOLERANCE: f32 = 1e-3;

/// What both sides move.
struct Case {
    vertices: Vec<VertexIn>,
    /// This frame's palette and the last frame's.
    palettes: [Vec<Affine3A>; 2],
    /// By target, then by vertex.
    targets: Vec<Vec<MorphDelta>>,
    /// This frame's weight and the last frame's, by target.
    weights: Vec<[f32; 2]>,
    /// This frame's place and the last frame's.
    world_from_model: [Affine3A; 2],
}

impl Case {
    fn new(vertices: Vec<VertexIn>, palettes: [Vec<Affine3A>; 2]) -> Self {
        let turn = Quat::from_rotation_y(0.8);
        let world_from_model = [0.0, 0.1].map(|on_the_way| {
            let place = Vec3::new(2.0, 0.5 + on_the_way, -1.5);
            Affine3A::from_scale_rotation_translation(Vec3::new(1.1, 0.9, 1.2), turn, place)
        });
        Self { vertices, palettes, targets: vec![], weights: vec![], world_from_model }
    }

    /// A tube of our own format, at two moments.
    fn tube(rings: usize, sides: usize, joint_count: usize, time: f32) -> Self {
        let mesh = skin_mesh(&tube(rings, sides, joint_count), joint_count, 0).expect("a tube can be skinned");
        Self::new(vertices(&mesh), [time, time - 0.1].map(|time| tube_palette(joint_count, time, 0.7)))
    }

    /// Where the CPU puts a vertex in this frame (0) or the last (1), world space.
    fn on_cpu(&self, index: usize, frame: usize) -> SkinVertex {
        let world_from_model = self.world_from_model[frame];
        let palette: Vec<_> = self.palettes[frame].iter().map(|model| world_from_model * *model).collect();
        let targets = self.targets.iter().zip(&self.weights).map(|(deltas, weight)| (weight[frame], deltas[index]));
        let vertex = &self.vertices[index];
        let moved = skinned(&palette, influences(vertex), morphed(at_rest(vertex), targets));
        let mirrored = world_from_model.matrix3.determinant() < 0.0;
        let handedness = if mirrored { -moved.tangent.w } else { moved.tangent.w };
        SkinVertex { tangent: moved.tangent.truncate().extend(handedness), ..moved }
    }

    /// Holds every vertex of the GPU, in this pass, against the CPU.
    fn hold(&self, what: &str, stage: &VertexStage, pass: Pass) {
        let [(now, range), (last, _)] = [0, 1].map(|frame| arena_of(&self.palettes[frame]));
        let moved = stage.run(&Draw {
            vertices: &self.vertices,
            targets: &self.targets,
            weights: &self.weights,
            world_from_model: self.world_from_model.map(Mat4::from),
            instance: range.instance(),
            arenas: [&now, &last],
        });
        assert_eq!(moved.len(), self.vertices.len(), "{what}: each vertex comes back");
        for (index, gpu) in moved.iter().enumerate() {
            let cpu = self.on_cpu(index, 0);
            let off = |gpu: [f32; 4], cpu: Vec3| Vec4::from(gpu).truncate().distance(cpu);
            let (position, normal) = (off(gpu.position, cpu.position), off(gpu.normal, cpu.normal));
            let tangent = Vec4::from(gpu.tangent).distance(cpu.tangent);
            assert!(position < POSITION_TOLERANCE, "{what}, {pass:?}: vertex {index} is {position} m off");
            assert!(normal < NORMAL_TOLERANCE, "{what}, {pass:?}: normal {index} is {normal} off");
            assert!(tangent < NORMAL_TOLERANCE, "{what}, {pass:?}: tangent {index} is {tangent} off");
            if pass == Pass::Prepass {
                let previous = off(gpu.previous, self.on_cpu(index, 1).position);
                assert!(previous < POSITION_TOLERANCE, "{what}: vertex {index} of the last frame is {previous} m off");
            }
        }
    }
}

/// The vertex stage of every pass.
fn stages() -> [(VertexStage, Pass); 2] {
    [Pass::Main, Pass::Prepass].map(|pass| (VertexStage::new(pass), pass))
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
            position: positions[i],
            normal: normals[i],
            tangent: Vec3::from(normals[i]).any_orthonormal_vector().extend(-1.0).to_array(),
            slots: slots[i],
            weights: weights[i],
        })
        .collect()
}

fn influences(vertex: &VertexIn) -> Influences {
    Influences { slots: vertex.slots, weights: vertex.weights }
}

fn at_rest(vertex: &VertexIn) -> SkinVertex {
    SkinVertex { position: vertex.position.into(), normal: vertex.normal.into(), tangent: vertex.tangent.into() }
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
    for (stage, pass) in stages() {
        for time in [0.0, 0.4, 1.3, 2.9] {
            Case::tube(28, 16, 8, time).hold(&format!("at {time} s"), &stage, pass);
        }
    }
}

#[test]
fn three_hundred_joints_and_five_thousand_vertices_are_too() {
    let case = Case::tube(400, 12, 300, 1.1);
    assert!(case.vertices.len() > 5_000, "{} vertices", case.vertices.len());
    assert!(case.vertices.iter().any(|v| v.slots.iter().any(|slot| *slot > 290)), "far slots are in use");
    case.hold("a long tube", &VertexStage::new(Pass::Prepass), Pass::Prepass);
}

#[test]
fn morph_targets_move_vertices_before_the_skin_does() {
    let stages = stages();
    // Bulges, leans and is pulled up, each by its own weight.
    let targets = |vertices: &[VertexIn]| {
        let bulge = |vertex: &VertexIn| MorphDelta {
            position: 0.2 * Vec3::from(vertex.normal),
            normal: Vec3::new(0.0, 0.5 * vertex.position[1], 0.0),
            tangent: Vec3::new(0.3, 0.0, -0.2),
        };
        let lean = |vertex: &VertexIn| MorphDelta {
            position: Vec3::X * vertex.position[1],
            normal: Vec3::NEG_Y * vertex.normal[0],
            tangent: Vec3::NEG_Y * vertex.tangent[0],
        };
        let lift = |_: &VertexIn| MorphDelta { position: Vec3::Y, ..MorphDelta::default() };
        vec![
            vertices.iter().map(bulge).collect(),
            vertices.iter().map(lean).collect(),
            vertices.iter().map(lift).collect::<Vec<_>>(),
        ]
    };
    for weights in [
        [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0]],
        [[1.0, 0.8], [0.0, 0.3], [0.4, 0.0]],
        [[-0.5, 0.2], [1.5, 1.4], [0.1, 0.1]],
    ] {
        let mut case = Case::tube(12, 9, 6, 1.3);
        case.targets = targets(&case.vertices);
        case.weights = weights.to_vec();
        for (stage, pass) in &stages {
            case.hold(&format!("weights {weights:?}"), stage, *pass);
        }
    }
}

#[test]
fn a_mirrored_character_has_mirrored_normals_and_the_other_handedness() {
    for (stage, pass) in stages() {
        let mut case = Case::tube(8, 6, 4, 0.7);
        case.world_from_model =
            case.world_from_model.map(|place| place * Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0)));
        case.hold("mirrored", &stage, pass);
    }
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
        let position = Vec3::from(vertex.position);
        let exact: Vec3 = (0..4).map(|i| palette[usize::from(slots[i])].transform_point3(position) * weights[i]).sum();
        worst = worst.max(skinned(&palette, influences(vertex), at_rest(vertex)).position.distance(exact));
    }
    assert!(worst < POSITION_TOLERANCE, "a vertex is {worst} m off");
}

#[test]
fn mirrored_sheared_and_flattened_palettes_give_the_same_normals() {
    let stage = VertexStage::new(Pass::Main);
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
        let case = Case::new(vertices(&mesh), [vec![affine; 2], vec![Affine3A::IDENTITY; 2]]);
        case.hold(name, &stage, Pass::Main);
    }
}

#[test]
fn a_mesh_without_a_palette_or_with_too_small_a_one_never_reads_a_neighbours() {
    let stage = VertexStage::new(Pass::Main);
    let mut vertices = Case::tube(4, 6, 8, 0.0).vertices;
    vertices.truncate(20);
    let palette: Vec<_> = (0..3).map(|i| Affine3A::from_translation(Vec3::Y * ops::sqrt(i as f32))).collect();
    let (arena, range) = arena_of(&palette);
    for (instance, palette) in [(0, &[Affine3A::IDENTITY][..]), (range.instance(), &palette)] {
        let moved = stage.run(&Draw {
            vertices: &vertices,
            targets: &[],
            weights: &[],
            world_from_model: [Mat4::IDENTITY; 2],
            instance,
            arenas: [&arena; 2],
        });
        for (vertex, gpu) in vertices.iter().zip(moved) {
            let cpu = skinned(palette, influences(vertex), at_rest(vertex)).position;
            let gpu = Vec4::from(gpu.position).truncate();
            assert!(gpu.distance(cpu) < POSITION_TOLERANCE, "instance {instance}: {gpu} is not {cpu}");
        }
    }
}
