//! The shape of the code, read from its own text: which layer imports which, and what no file may hold.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Layers by height; those of one height do not know each other, except where `SAME_HEIGHT` says so.
const HEIGHTS: &[(&str, u32)] = &[
    ("math", 0),
    ("anim", 1),
    ("rig", 2),
    ("character", 3),
    ("skinning", 3),
    ("measure", 3),
    ("debug", 3),
    ("plugins", 4),
    ("testing", 5),
    ("terrain", 5),
    ("camera", 5),
    ("game", 6),
];

/// Arrows between layers of one height: skinning, the measures and the debug views read what characters produce.
const SAME_HEIGHT: &[(&str, &str)] = &[("skinning", "character"), ("measure", "character"), ("debug", "character")];

/// Layers that work in any game, whatever walks in it.
const STRANGERS_TO_CHARACTERS: &[&str] = &["terrain", "camera"];

/// The stages of a character in the order the data flows; `schedule` is the spine that all know.
const STAGES: &[&str] =
    &["schedule", "intent", "motion", "locomotion", "animator", "foot_ik", "look", "aim", "chains", "ease", "attach"];

/// No file is longer, so that each holds one idea.
const MAX_LINES: usize = 400;

/// One `.rs` file of `src/`.
struct Source {
    path: PathBuf,
    /// Modules from the crate's root, such as `["anim", "ik", "two_bone"]`. Empty for files of binaries.
    module: Vec<String>,
    /// The text without comments, strings and the tests at its end.
    code: String,
}

#[test]
fn no_file_imports_a_layer_above_its_own() {
    let mut wrong = Vec::new();
    for source in library_sources() {
        let Some(own) = source.module.first() else { continue };
        for path in used_paths(&source) {
            let Some(other) = path.first() else { continue };
            let (Some(own_height), Some(other_height)) = (height(own), height(other)) else { continue };
            let sideways = own != other && own_height == other_height;
            let sideways = sideways && !SAME_HEIGHT.contains(&(own.as_str(), other.as_str()));
            let strangers = STRANGERS_TO_CHARACTERS.contains(&own.as_str()) && (1..=3).contains(&other_height);
            if other_height > own_height || sideways || strangers {
                wrong.push(format!("{}: {own} imports {}", source.path.display(), path.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "{} arrows point up:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn every_module_of_the_crate_has_a_height() {
    let unknown: Vec<_> = library_sources()
        .into_iter()
        .filter(|source| source.module.first().is_some_and(|layer| height(layer).is_none()))
        .map(|source| source.path.display().to_string())
        .collect();
    assert!(unknown.is_empty(), "not in HEIGHTS of tests/it/layers.rs: {unknown:?}");
}

#[test]
fn no_stage_of_a_character_imports_a_later_one() {
    let stage = |module: &[String]| {
        let [layer, stage, ..] = module else { return None };
        (layer == "character").then(|| STAGES.iter().position(|name| name == stage)).flatten()
    };
    let mut wrong = Vec::new();
    for source in library_sources() {
        let Some(own) = stage(&source.module) else { continue };
        for path in used_paths(&source) {
            if stage(&path).is_some_and(|other| other > own) {
                wrong.push(format!("{}: {} imports {}", source.path.display(), STAGES[own], path.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "{} arrows point to later stages:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn maths_and_animation_know_no_ecs() {
    const ECS: &[&str] = &[
        "World",
        "Handle",
        "Time",
        "Commands",
        "Component",
        "Resource",
        "Query",
        "Res",
        "ResMut",
        "Entity",
        "Assets",
        "App",
        "Plugin",
        "Local",
        "Single",
    ];
    let mut wrong = Vec::new();
    for source in library_sources() {
        if !matches!(source.module.first().map(String::as_str), Some("math" | "anim")) {
            continue;
        }
        for (number, line) in source.code.lines().enumerate() {
            for word in words(line).filter(|word| ECS.contains(word)) {
                wrong.push(format!("{}:{}: {word}", source.path.display(), number + 1));
            }
        }
    }
    assert!(wrong.is_empty(), "ECS types under math/ or anim/:\n{}", wrong.join("\n"));
}

#[test]
fn every_file_is_short_enough_to_hold_one_idea() {
    let long: Vec<_> = ["src", "tests", "examples", "benches", "shaders"]
        .iter()
        .flat_map(|folder| files_under(&root().join(folder), &["rs", "wgsl"]))
        .map(|path| (fs::read_to_string(&path).unwrap().lines().count(), path))
        .filter(|(lines, _)| *lines > MAX_LINES)
        .collect();
    assert!(long.is_empty(), "more than {MAX_LINES} lines: {long:?}");
}

#[test]
fn no_code_is_unsafe() {
    let unsafe_files: Vec<_> = all_sources()
        .into_iter()
        .filter(|source| words(&source.code).any(|word| word == "unsafe"))
        .map(|source| source.path)
        .collect();
    assert!(unsafe_files.is_empty(), "unsafe in {unsafe_files:?}");
}

#[test]
fn no_file_names_a_path_of_one_machine() {
    // Split, so that this very file passes.
    let marks = [concat!("/ro", "ot/"), concat!("/ho", "me/"), concat!("/wo", "rk/"), concat!("/Us", "ers/")];
    let mut wrong = Vec::new();
    for folder in ["src", "tests", "examples", "benches", "shaders", "script", ".ci", "assets"] {
        for path in files_under(&root().join(folder), &[]) {
            let Ok(text) = fs::read_to_string(&path) else { continue };
            for mark in marks.iter().filter(|mark| text.contains(**mark)) {
                wrong.push(format!("{} holds {mark}", path.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn without_features_the_crate_needs_no_renderer_and_no_window() {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--no-default-features", "--edges", "normal", "--prefix", "none"])
        .current_dir(root())
        .output()
        .expect("cargo runs");
    let tree = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "cargo tree failed: {}", String::from_utf8_lossy(&output.stderr));
    let names: Vec<_> = tree.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(names.contains(&"bevy_ecs"), "cargo tree lists no bevy_ecs; it said:\n{tree}");
    for heavy in ["wgpu", "winit", "bevy_pbr", "bevy_render", "bevy_winit", "bevy_ui", "gilrs"] {
        assert!(!names.contains(&heavy), "{heavy} is in the tree of a headless build");
    }
}

#[test]
fn a_group_of_imports_is_read_as_single_paths() {
    let source =
        source_of("game/film/sheet.rs", "use crate::{anim::{pose::Pose, skin}, math};\nuse super::frames::Frame;");
    let paths: Vec<_> = used_paths(&source).iter().map(|path| path.join("::")).collect();
    assert_eq!(paths, ["anim::pose::Pose", "anim::skin", "math", "game::film::frames::Frame"]);
}

#[test]
fn an_arrow_in_the_middle_of_code_is_seen() {
    let source = source_of("rig/mod.rs", "fn f() { crate::game::play::run(); } // crate::testing\n\"crate::terrain\"");
    let paths: Vec<_> = used_paths(&source).iter().map(|path| path.join("::")).collect();
    assert_eq!(paths, ["game::play::run"]);
}

fn height(layer: &str) -> Option<u32> {
    HEIGHTS.iter().find(|(name, _)| *name == layer).map(|(_, height)| *height)
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// All files under `folder`, in order; only those with one of `endings` if any are given.
fn files_under(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let Ok(entries) = fs::read_dir(folder) else { return files };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            files.extend(files_under(&path, endings));
        } else if endings.is_empty() || path.extension().is_some_and(|end| endings.iter().any(|e| end == *e)) {
            files.push(path);
        }
    }
    files.sort();
    files
}

fn all_sources() -> Vec<Source> {
    let src = root().join("src");
    files_under(&src, &["rs"])
        .into_iter()
        .map(|path| {
            let text = fs::read_to_string(&path).unwrap();
            source_of(&path.strip_prefix(&src).unwrap().to_string_lossy(), &text)
        })
        .collect()
}

fn library_sources() -> Vec<Source> {
    let sources: Vec<_> = all_sources().into_iter().filter(|source| !source.module.is_empty()).collect();
    assert!(sources.len() > 10, "only {} sources found", sources.len());
    sources
}

fn source_of(path: &str, text: &str) -> Source {
    let mut module: Vec<String> = path.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if module.last().is_some_and(|name| name == "mod") {
        module.pop();
    }
    if matches!(module[0].as_str(), "main" | "lib" | "bin") {
        module.clear();
    }
    Source { path: path.into(), module, code: code_of(text) }
}

/// Blanks comments and strings, and ends at the unit tests, which may use anything. Keeps line numbers.
fn code_of(text: &str) -> String {
    let mut code = String::new();
    for line in text.lines() {
        if line.starts_with("#[cfg(test)]") {
            break;
        }
        let mut quoted = false;
        let mut rest = line.chars().peekable();
        while let Some(letter) = rest.next() {
            match letter {
                '\\' if quoted => {
                    rest.next();
                }
                '"' => quoted = !quoted,
                '/' if !quoted && rest.peek() == Some(&'/') => break,
                _ if !quoted => code.push(letter),
                _ => {}
            }
        }
        code.push('\n');
    }
    code
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|letter: char| !letter.is_alphanumeric() && letter != '_').filter(|word| !word.is_empty())
}

/// Every path from the crate's root that the file's code names, in order.
fn used_paths(source: &Source) -> Vec<Vec<String>> {
    let code = &source.code;
    let mut starts = BTreeMap::new();
    for keyword in ["crate::", "super::", "surefoot::"] {
        for (at, _) in code.match_indices(keyword) {
            let before = code[..at].chars().next_back();
            let inside_word = before.is_some_and(|letter| letter.is_alphanumeric() || letter == '_' || letter == ':');
            if !inside_word {
                starts.insert(at, keyword);
            }
        }
    }
    let mut paths = Vec::new();
    for (at, keyword) in starts {
        let mut base = source.module.clone();
        let mut rest = &code[at..];
        if keyword == "super::" {
            while let Some(above) = rest.strip_prefix("super::") {
                base.pop();
                rest = above;
            }
        } else {
            base.clear();
            rest = &rest[keyword.len()..];
        }
        expand(base, rest, &mut paths);
    }
    paths
}

/// Reads one path or `{group}` of paths at the start of `text`; returns what follows it.
fn expand<'a>(mut base: Vec<String>, text: &'a str, paths: &mut Vec<Vec<String>>) -> &'a str {
    let text = text.trim_start();
    if let Some(mut rest) = text.strip_prefix('{') {
        loop {
            rest = expand(base.clone(), rest, paths).trim_start();
            match rest.chars().next() {
                Some(',') => rest = &rest[1..],
                Some('}') => return &rest[1..],
                // `name as other`, or the end of a broken file.
                Some(_) => rest = rest.find([',', '}']).map_or("", |end| &rest[end..]),
                None => return rest,
            }
            if let Some(after) = rest.trim_start().strip_prefix('}') {
                return after;
            }
        }
    }
    let end = text.find(|letter: char| !letter.is_alphanumeric() && letter != '_').unwrap_or(text.len());
    if end > 0 && &text[..end] != "self" {
        base.push(text[..end].to_owned());
    }
    match text[end..].strip_prefix("::") {
        Some(rest) if end > 0 => expand(base, rest, paths),
        _ => {
            paths.push(base);
            &text[end..]
        }
    }
}
