//! `surefoot view` on the command line: words, verdicts and sheets.

use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

use serde_json::json;

use crate::gltf_file::GltfFile;

/// The program, without a display.
fn view(file: &Path, flags: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_surefoot"));
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command.arg("view").arg(file).args(flags).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn mannequin() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/mannequin.glb")
}

fn folder() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("view");
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A lamp that turns in steps: a mesh, a clip, and no body.
fn lamp(name: &str) -> PathBuf {
    let mut file = GltfFile::new();
    let positions = file.floats("VEC3", &[-0.2, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 1.0, 0.0]);
    file.root["accessors"][positions]["min"] = json!([-0.2, 0.0, 0.0]);
    file.root["accessors"][positions]["max"] = json!([0.2, 1.0, 0.0]);
    let raised = file.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0]);
    let targets = json!([{ "POSITION": raised }]);
    file.push("meshes", json!({ "primitives": [{ "attributes": { "POSITION": positions }, "targets": targets }] }));
    file.push("nodes", json!({ "name": "lamp", "mesh": 0 }));
    file.push("scenes", json!({ "nodes": [0] }));
    file.clip(
        "nod",
        &[(0, "rotation", &[0.0, 0.5, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.6, 0.8, 0.0, 0.0, 0.0, 1.0])],
    );
    file.root["animations"][0]["samplers"][0]["interpolation"] = json!("STEP");
    let path = folder().join(name);
    fs::write(&path, file.glb()).unwrap();
    path
}

#[test]
fn check_tells_what_is_in_a_file_and_draws_nothing() {
    let output = view(&mannequin(), &["--check"]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}{}", text(&output.stderr));
    for words in ["mannequin.glb: ", "1 skin", "clip walk: ", "leftfoot", "it walks; states: "] {
        assert!(said.to_lowercase().contains(words), "{words} is not in:\n{said}");
    }
}

#[test]
fn against_bevy_ends_with_the_largest_error() {
    let output = view(&lamp("steps.glb"), &["--check", "--against-bevy"]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}{}", text(&output.stderr));
    let last = said.lines().last().unwrap_or_default();
    let numbers = last.strip_prefix("max joint error ").and_then(|rest| rest.strip_suffix(" deg"));
    let numbers = numbers.and_then(|rest| rest.split_once(" mm, ")).unwrap_or_else(|| panic!("{said}"));
    let [millimetres, degrees]: [f32; 2] = [numbers.0, numbers.1].map(|number| number.parse().unwrap());
    assert!(millimetres <= 0.1 && degrees <= 0.05, "{last}");
    assert!(said.contains("it does not walk"), "a lamp walks:\n{said}");
}

#[test]
fn what_cannot_be_read_is_told_in_one_line() {
    let broken = folder().join("broken.glb");
    fs::write(&broken, "glTF").unwrap();
    for (file, words) in [(folder().join("none.glb"), "can't read"), (broken, "not a whole glTF 2.0 file")] {
        let output = view(&file, &["--check"]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.starts_with("surefoot: ") && said.lines().count() == 1 && said.contains(words), "{said}");
        assert!(said.contains(&*file.to_string_lossy()), "it does not name {}: {said}", file.display());
    }
}

#[test]
fn a_film_is_one_sheet_of_rest_skeleton_weights_morphs_and_clips() {
    let file = lamp("filmed.glb");
    let folder = folder();
    let flags = ["--film", "--size", "96x72", "--out", &folder.to_string_lossy()];
    let output = view(&file, &flags);
    let (said, warned) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{said}{warned}");
    let sheet = image::open(folder.join("filmed.png")).unwrap().to_rgb8();
    // Three rows of four: rest, skeleton and weights; a morph target; a clip.
    assert!(sheet.width() > 4 * 480 && sheet.height() > 3 * 360, "the sheet is {:?}", sheet.dimensions());
    let tile = |column: u32, row: u32| {
        let (left, top) = (6 + column * 486, 6 + row * (sheet.height() - 6) / 3);
        image::imageops::crop_imm(&sheet, left, top, 480, 360).to_image()
    };
    let differ = |a: &image::RgbImage, b: &image::RgbImage| {
        a.pixels().zip(b.pixels()).filter(|(a, b)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 20)).count()
    };
    let (rest, weights, morphed) = (tile(0, 0), tile(3, 0), tile(0, 1));
    for (name, other) in [("weights", &weights), ("a morph target", &morphed)] {
        let pixels = differ(&rest, other);
        assert!(pixels > 200, "{name} changes {pixels} pixels");
    }
    let (first, second) = (tile(0, 2), tile(2, 2));
    let pixels = differ(&first, &second);
    assert!(pixels > 200, "the clip changes {pixels} pixels");
}
