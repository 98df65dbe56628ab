//! The mannequin's own meshes, blinking and breathing in poses of its own clips.

use bevy::{
    asset::RenderAssetUsages,
    math::{Affine3A, Vec3},
    mesh::{Mesh, PrimitiveTopology},
};
use surefoot::{
    anim::skin::MorphDelta,
    character::animator::CharacterPose,
    rig::Rig,
    skinning::mesh::skin_mesh_by,
    testing::{Stage, World},
};

use super::{Case, stages, vertices};

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/mannequin.glb");

/// Vertices of a primitive, and by target how far each goes.
struct Part {
    name: String,
    case: Case,
}

/// Every primitive of the mannequin's mesh, in the pose of `palettes`.
fn parts(rig: &Rig, palettes: &[Vec<Affine3A>; 2]) -> Vec<Part> {
    let file = gltf::Gltf::open(FILE).expect("the mannequin is here");
    let mesh = file.meshes().next().expect("it has a mesh");
    let binding = &rig.meshes[0];
    let part = |(primitive, by): (gltf::Primitive, &surefoot::rig::Influences)| {
        let reader = primitive.reader(|_| file.blob.as_deref());
        let positions: Vec<_> = reader.read_positions().expect("positions").collect();
        let normals: Vec<_> = reader.read_normals().expect("normals").collect();
        let targets = reader.read_morph_targets().map(|(moves, ..)| {
            let moves = moves.expect("its targets move vertices");
            moves.map(|by| MorphDelta { position: Vec3::from(by), ..MorphDelta::default() }).collect()
        });
        let mesh = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
            .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals);
        let mesh = skin_mesh_by(&mesh, &by.joints, &by.weights, palettes[0].len(), 0).expect("it can be skinned");
        let case = Case { targets: targets.collect(), ..Case::new(vertices(&mesh), palettes.clone()) };
        Part { name: primitive.material().name().unwrap_or_default().to_owned(), case }
    };
    mesh.primitives().zip(&binding.influences).map(part).collect()
}

#[test]
fn the_mannequin_blinks_and_breathes_as_on_the_cpu() {
    let mut stage = Stage::on(&World::flat());
    let walker = stage.spawn_walker().expect("the mannequin loads");
    let rig = stage.asset(walker).expect("loaded").rig.clone();
    let skin = &rig.skins[rig.meshes[0].skin.expect("it is skinned")];
    let mut palette = |speed: f32| {
        stage.walk(walker, Vec3::NEG_Z * speed).run_for(0.7);
        skin.palette(&stage.get::<CharacterPose>(walker).expect("bound").pose).collect::<Vec<_>>()
    };
    let poses = [palette(0.0), palette(1.4), palette(4.0)];
    let stages = stages();
    let moments =
        [([0, 1], [[1.0, 0.6], [0.0, 0.1]]), ([1, 2], [[0.35, 0.0], [0.9, 1.0]]), ([2, 2], [[0.0, 0.0], [1.0, 1.0]])];
    for (frames, weights) in moments {
        for Part { name, mut case } in parts(&rig, &frames.map(|pose| poses[pose].clone())) {
            let farthest =
                |target: &Vec<MorphDelta>| target.iter().map(|delta| delta.position.length()).fold(0.0, f32::max);
            let [blink, breath] = [farthest(&case.targets[0]), farthest(&case.targets[1])];
            assert!(blink.max(breath) > 1e-3 || name == "visor", "{name}: targets move {blink} m and {breath} m");
            case.weights = weights.to_vec();
            for (stage, pass) in &stages {
                case.hold(&format!("{name} with weights {weights:?}"), stage, *pass);
            }
        }
    }
}
