//! Motion held against a peer: the engine's own import and player of the same file, joint by joint and picture by picture.

mod limb;
mod pictures;
mod rigs;

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde_json::json;
use surefoot::testing::peer::{Comparison, compare, compare_rig, load_rig};

use crate::gltf_file::GltfFile;

/// Rigs that the engine cannot play whole, and why.
const BLIND: [(&str, &str); 5] = [
    ("integer_keys", "its rotations are integers, whose rounding the engine leaves in"),
    ("lone_keys", "its spline has one key"),
    ("sparse_times", "its key times are sparse"),
    ("outside_the_scene", "no scene holds it"),
    ("twins", "another node has the same path of names"),
];

/// Writes a rig where the engine's loader can read it.
fn written(name: &str, file: &GltfFile) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("peer");
    fs::create_dir_all(&folder).expect("the target folder can be written");
    let path = folder.join(name).with_extension("glb");
    fs::write(&path, file.glb()).expect("the target folder can be written");
    path
}

fn compared(path: &Path) -> Comparison {
    compare(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn every_quirk_moves_as_in_the_engine() {
    let mut wrong = Vec::new();
    for (name, file) in rigs::all() {
        let comparison = compared(&written(name, &file));
        if !comparison.holds() {
            wrong.push(format!("{name}:\n{comparison}"));
        }
        let clip = &comparison.clips[0];
        assert!(clip.exact.millimetres > 0.0, "{name}: not a bit of rounding: nothing was compared");
        assert_eq!(comparison.refusal.is_some(), name == "quantised", "{name}: {:?}", comparison.refusal);
        let blind = BLIND.iter().find(|(rig, _)| *rig == name).map(|(_, reason)| *reason);
        let reasons: Vec<_> = clip.blind.values().copied().collect();
        assert!(reasons.iter().all(|reason| Some(*reason) == blind), "{name}: {reasons:?}, not {blind:?}");
        assert_eq!(reasons.is_empty(), blind.is_none(), "{name}: {reasons:?}, not {blind:?}");
    }
    assert!(wrong.is_empty(), "{} rigs move otherwise:\n{}", wrong.len(), wrong.join("\n\n"));
}

#[test]
fn the_mannequin_moves_as_in_the_engine() {
    let comparison = compared(&Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/mannequin.glb"));
    assert!(comparison.holds() && comparison.clips.len() > 10, "{comparison}");
}

#[test]
fn a_joint_out_of_place_is_found() {
    let rig = |x: f32| {
        let (_, mut file) = rigs::all().swap_remove(1);
        file.root["nodes"][1]["translation"] = json!([x, limb::STEP, 0.0]);
        file.root["animations"] = json!([]);
        file
    };
    let theirs = written("shifted", &rig(0.002));
    let ours = load_rig(&written("unshifted", &rig(0.0))).expect("it loads");
    let comparison = compare_rig(&ours, &theirs).expect("the engine loads it, too");
    // 2 mm on a figure of four steps and what the tube adds, told for one of 1.8 m.
    let error = comparison.error().millimetres;
    assert!((1.0..3.0).contains(&error) && !comparison.holds(), "{comparison}");
}

#[test]
fn buffers_beside_the_file_are_found() {
    let (_, file) = rigs::all().swap_remove(1);
    let glb = written("beside", &file);
    let path = glb.with_extension("gltf");
    fs::write(path.with_file_name("beside.bin"), &file.bin).expect("the target folder can be written");
    fs::write(&path, file.gltf("beside.bin")).expect("the target folder can be written");
    assert_eq!(compared(&path), compared(&glb));
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let error = compare(Path::new("no/such/rig.glb")).expect_err("there is no such file").to_string();
    assert!(error.starts_with("can't read `no/such/rig.glb`: "), "{error}");
}
