//! The program's command line: help, clear words about what the machine lacks, and a film.

use std::{
    fs,
    path::PathBuf,
    process::{Command, Output},
};

/// The program, without a display.
fn surefoot() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_surefoot"));
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The program's own lines on standard error; drivers may add theirs.
fn own_lines(output: &Output) -> Vec<String> {
    text(&output.stderr).lines().filter(|line| line.starts_with("surefoot: ")).map(str::to_owned).collect()
}

/// An empty folder for one test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn help_explains_every_flag_and_the_controls() {
    let output = surefoot().arg("--help").output().unwrap();
    let help = text(&output.stdout);
    assert!(output.status.success(), "--help failed: {}", text(&output.stderr));
    for word in [
        "film",
        "gauntlet",
        "--out",
        "--seconds",
        "--size",
        "--fps",
        "--seed",
        "--telemetry",
        "--fullscreen",
        "--scene",
        "view",
        "WASD",
        "F3",
    ] {
        assert!(help.contains(word), "{word} is not in the help:\n{help}");
    }
}

#[test]
fn a_wrong_flag_is_refused_with_the_right_form() {
    let output = surefoot().args(["film", "--size", "big"]).output().unwrap();
    let words = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{words}");
    assert!(words.contains("WxH"), "does not say what a size looks like: {words}");
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_driver_one_line_says_what_to_install() {
    let output = surefoot().arg("film").env("VK_DRIVER_FILES", "/nonexistent.json").output().unwrap();
    let lines = own_lines(&output);
    let all = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{all}");
    assert_eq!(lines.len(), 1, "not one line: {all}");
    assert!(lines[0].contains("sudo apt-get install -y libvulkan1 mesa-vulkan-drivers"), "{all}");
    assert!(!all.contains("panicked"), "{all}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_display_that_does_not_answer_is_told_in_one_line() {
    let output = surefoot().env("DISPLAY", ":4093").output().unwrap();
    let lines = own_lines(&output);
    let all = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{all}");
    assert_eq!(lines.len(), 1, "not one line: {all}");
    assert!(lines[0].contains("DISPLAY=:4093"), "does not name the display: {all}");
    assert!(!all.contains("panicked"), "{all}");
}

#[test]
fn a_scene_is_one_sheet_and_an_unknown_one_is_told_which_there_are() {
    let folder = Folder::new("scene");
    let film = |scene: &str| {
        surefoot().args(["film", "--scene", scene, "--size", "96x72", "--out"]).arg(&folder.0).output().unwrap()
    };
    let output = film("idle");
    assert!(output.status.success(), "exit {:?}: {}", output.status.code(), text(&output.stderr));
    let sheet = image::open(folder.0.join("idle.png")).unwrap();
    assert!(sheet.width() > 4 * 400 && sheet.height() > 300, "the sheet is {}x{}", sheet.width(), sheet.height());
    let lines = own_lines(&film("idel"));
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("no scene is called `idel`; there are idle, walk, run"), "{}", lines[0]);
}

#[test]
fn a_film_is_frames_a_contact_sheet_and_a_table() {
    let folder = Folder::new("film");
    let output = surefoot()
        .args(["film", "--seconds", "1", "--fps", "10", "--size", "160x90", "--out"])
        .arg(&folder.0)
        .output()
        .unwrap();
    let (said, warned) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "exit {:?}: {said}{warned}", output.status.code());

    let name = |entry: fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
    let mut names: Vec<_> = fs::read_dir(&folder.0).unwrap().map(|entry| name(entry.unwrap())).collect();
    names.sort();
    let frames: Vec<_> = (0..10).map(|frame| format!("frame_{frame:04}.png")).collect();
    let wanted: Vec<_> = std::iter::once("contact_sheet.png".to_owned()).chain(frames.iter().cloned()).collect();
    assert_eq!(names, wanted);

    let sheet = image::open(folder.0.join("contact_sheet.png")).unwrap();
    assert!(sheet.width() > 4 * 400 && sheet.height() > 300, "the sheet is {}x{}", sheet.width(), sheet.height());
    let first = image::open(folder.0.join(&frames[0])).unwrap().to_rgb8();
    let last = image::open(folder.0.join(&frames[9])).unwrap().to_rgb8();
    assert_eq!(first.dimensions(), (160, 90));
    let colours: std::collections::BTreeSet<_> = first.pixels().map(|pixel| pixel.0).collect();
    assert!(colours.len() > 100, "the first picture has {} colours", colours.len());
    assert!(first != last, "first and last picture are the same");
    assert!(said.contains("plant drift"), "no table of measures in:\n{said}");
}

#[test]
fn the_gauntlet_needs_no_graphics_and_writes_table_json_and_figures() {
    let folder = Folder::new("gauntlet");
    let json = folder.0.join("rows.json");
    let output = surefoot()
        .args(["gauntlet", "--only", "flat stand", "--plot"])
        .arg(folder.0.join("figures"))
        .arg("--json")
        .arg(&json)
        .env("VK_DRIVER_FILES", "/nonexistent.json")
        .output()
        .unwrap();
    let (said, warned) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "exit {:?}: {said}{warned}", output.status.code());
    let line = said.lines().find(|line| line.starts_with("flat, stand")).unwrap_or_else(|| panic!("no row: {said}"));
    assert!(line.contains("IK"), "{line}");
    let value: serde_json::Value = serde_json::from_str(&fs::read_to_string(&json).unwrap()).unwrap();
    let rows = value["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 3, "with foot IK, without, and by Bevy's own player: {value}");
    for row in rows {
        for key in ["world", "tape", "foot_ik", "measures", "bars", "pass"] {
            assert!(row.get(key).is_some(), "{key} is not in {row}");
        }
        assert!(row["measures"]["drift_max_mm"].as_f64().unwrap() >= 0.0, "{row}");
    }
    assert!(folder.0.join("figures/flat_stand_ik.svg").is_file(), "no figure: {said}");
}

#[test]
fn a_gauntlet_without_rows_says_what_there_is() {
    let output = surefoot().args(["gauntlet", "--only", "swamp"]).output().unwrap();
    let lines = own_lines(&output);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output.stderr));
    assert!(lines.len() == 1 && lines[0].contains("rubble") && lines[0].contains("S-curve"), "{lines:?}");
}
