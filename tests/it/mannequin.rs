//! The baked mannequin: what the file promises, and that the baker still makes exactly this file.

use std::{path::Path, process::Command};

use glam::Vec3;
use gltf::mesh::Mode;

const FILE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/mannequin.glb");

fn file() -> Vec<u8> {
    std::fs::read(FILE).unwrap()
}

/// Calls `look` with each primitive of the file's only mesh and a reader of its buffer.
fn primitives(mut look: impl FnMut(&gltf::Primitive, &[u8])) {
    let gltf = gltf::Gltf::from_slice(&file()).unwrap();
    let blob = gltf.blob.clone().unwrap();
    for primitive in gltf.meshes().next().unwrap().primitives() {
        look(&primitive, &blob);
    }
}

fn positions() -> Vec<[f32; 3]> {
    let mut all = Vec::new();
    primitives(|primitive, blob| all.extend(primitive.reader(|_| Some(blob)).read_positions().unwrap()));
    all
}

#[test]
fn baking_again_gives_the_same_bytes() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mannequin.glb");
    let status = Command::new(env!("CARGO_BIN_EXE_mannequin")).arg("--out").arg(&out).status().unwrap();
    assert!(status.success(), "mannequin ended with {status}");
    let (fresh, kept) = (std::fs::read(&out).unwrap(), file());
    let same = fresh.iter().zip(&kept).take_while(|(a, b)| a == b).count();
    assert!(
        fresh == kept,
        "assets/mannequin.glb ({} bytes) is not what `cargo run --bin mannequin` bakes ({} bytes); they differ from byte {same}",
        kept.len(),
        fresh.len()
    );
}

#[test]
fn every_vertex_is_carried_fully_by_joints_that_exist() {
    let gltf = gltf::Gltf::from_slice(&file()).unwrap();
    let joint_count = gltf.skins().next().unwrap().joints().count();
    primitives(|primitive, blob| {
        let reader = primitive.reader(|_| Some(blob));
        let weights = reader.read_weights(0).unwrap().into_f32();
        let joints = reader.read_joints(0).unwrap().into_u16();
        for (i, (weights, joints)) in weights.zip(joints).enumerate() {
            let sum: f32 = weights.iter().sum();
            let name = primitive.material().name().unwrap().to_owned();
            assert!((sum - 1.0).abs() < 1e-6, "{name}: weights of vertex {i} sum to {sum}");
            let highest = joints.into_iter().max().unwrap();
            assert!(usize::from(highest) < joint_count, "{name}: vertex {i} names joint {highest} of {joint_count}");
        }
    });
}

#[test]
fn normals_are_unit_and_no_number_is_broken() {
    primitives(|primitive, blob| {
        let reader = primitive.reader(|_| Some(blob));
        for (i, normal) in reader.read_normals().unwrap().enumerate() {
            let length = normal.iter().map(|c| c * c).sum::<f32>().sqrt();
            assert!((length - 1.0).abs() < 1e-3, "normal {i} has length {length}");
        }
    });
    assert!(positions().iter().flatten().all(|c| c.is_finite()), "a position is not finite");
}

#[test]
fn no_triangle_is_inside_out() {
    primitives(|primitive, blob| {
        let reader = primitive.reader(|_| Some(blob));
        let points: Vec<Vec3> = reader.read_positions().unwrap().map(Vec3::from).collect();
        let normals: Vec<Vec3> = reader.read_normals().unwrap().map(Vec3::from).collect();
        let indices: Vec<usize> = reader.read_indices().unwrap().into_u32().map(|i| i as usize).collect();
        let inverted = indices.chunks(3).filter(|t| {
            let across = (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]);
            across.dot(normals[t[0]] + normals[t[1]] + normals[t[2]]) < 0.0
        });
        let (count, of) = (inverted.count(), indices.len() / 3);
        assert!(count * 500 <= of, "{}: {count} of {of} triangles", primitive.material().name().unwrap());
    });
}

#[test]
fn it_is_detailed_but_light() {
    let mut triangles = 0;
    primitives(|primitive, blob| {
        assert_eq!(primitive.mode(), Mode::Triangles);
        triangles += primitive.reader(|_| Some(blob)).read_indices().unwrap().into_u32().count() / 3;
    });
    assert!((10_000..=17_000).contains(&triangles), "{triangles} triangles");
}

#[test]
fn it_stands_on_the_ground_and_is_one_metre_eighty_tall() {
    let points = positions();
    let low = points.iter().map(|p| p[1]).fold(f32::MAX, f32::min);
    let high = points.iter().map(|p| p[1]).fold(f32::MIN, f32::max);
    assert!(low.abs() < 1e-6, "lowest point at y = {low}");
    assert!((high - 1.80).abs() < 0.01, "highest point at y = {high}");
}

#[test]
fn both_soles_lie_flat_on_the_ground_from_heel_to_tip() {
    for side in [1.0, -1.0] {
        let sole: Vec<[f32; 3]> = positions().into_iter().filter(|p| p[1].abs() < 1e-6 && p[0] * side > 0.0).collect();
        let (heel, tip) = sole.iter().fold((f32::MAX, f32::MIN), |(heel, tip), p| (heel.min(p[2]), tip.max(p[2])));
        assert!((heel + 0.067).abs() < 0.004, "side {side}: the sole begins at z = {heel}");
        assert!((tip - 0.198).abs() < 0.004, "side {side}: the sole ends at z = {tip}");
    }
}

#[test]
fn the_left_half_mirrors_the_right() {
    let half = |side: f32| {
        let near = |p: &[f32; 3]| [p[0] * side, p[1], p[2]].map(|c| (c * 1e4).round() as i32);
        let mut half: Vec<[i32; 3]> = positions().iter().filter(|p| p[0] * side > 1e-3).map(near).collect();
        half.sort_unstable();
        half
    };
    let (left, right) = (half(1.0), half(-1.0));
    let differing = left.iter().filter(|p| right.binary_search(p).is_err()).count();
    assert!(left.len() == right.len(), "{} vertices left, {} right", left.len(), right.len());
    assert!(differing * 50 < left.len(), "{differing} of {} vertices have no mirror image", left.len());
}

#[test]
fn blink_and_breath_are_named_and_do_something_small() {
    let gltf = gltf::Gltf::from_slice(&file()).unwrap();
    let mesh = gltf.meshes().next().unwrap();
    let extras = mesh.extras().as_ref().unwrap().get();
    assert!(extras.contains(r#""targetNames":["blink","breath"]"#), "mesh extras: {extras}");
    let mut largest = [0.0_f32; 2];
    primitives(|primitive, blob| {
        for (morph, (offsets, _, _)) in primitive.reader(|_| Some(blob)).read_morph_targets().enumerate() {
            for offset in offsets.unwrap() {
                largest[morph] = largest[morph].max(offset.iter().map(|c| c * c).sum::<f32>().sqrt());
            }
        }
    });
    assert!((0.004..0.014).contains(&largest[0]), "blink moves {} m", largest[0]);
    assert!((0.008..0.0125).contains(&largest[1]), "breath moves {} m", largest[1]);
}
