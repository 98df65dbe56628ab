//! Import of glTF files: every quirk of the format that is read, and every fault that is told.

mod clips;
mod containers;
mod expressions;
mod malformed;
mod skeletons;
#[expect(clippy::float_cmp, reason = "numbers come out as they went in")]
mod vertices;

use bevy::math::{Quat, Vec3};
use serde_json::json;
use surefoot::{
    anim::{pose::Pose, skeleton::JointIndex},
    math::rotation::angle_between,
    rig::{Rig, gltf::error::RigError},
};

use crate::gltf_file::{Body, GltfFile, triangle};

fn no_files(uri: &str) -> Result<Vec<u8>, String> {
    Err(format!("no test has the file {uri}"))
}

fn load(file: &GltfFile) -> Result<Rig, RigError> {
    Rig::from_slice(&file.glb(), no_files)
}

fn rig(file: &GltfFile) -> Rig {
    load(file).expect("the file is good")
}

/// What the error says; the file must not load.
fn fault(file: &GltfFile) -> String {
    load(file).expect_err("the file is bad").to_string()
}

fn near(a: Vec3, b: Vec3) -> bool {
    a.distance(b) < 1e-5
}

/// A glTF file on whose node `node0` a clip plays `path`.
fn animated(path: &str, times: &[f32], values: &[f32], interpolation: Option<&str>) -> GltfFile {
    let mut file = GltfFile::new();
    file.push("nodes", json!({ "translation": [5.0, 0.0, 0.0] }));
    file.clip("move", &[(0, path, times, values)]);
    if let Some(interpolation) = interpolation {
        file.root["animations"][0]["samplers"][0]["interpolation"] = json!(interpolation);
    }
    file
}

fn translation_at(rig: &Rig, time: f32) -> Vec3 {
    let mut pose = Pose::rest(&rig.skeleton);
    rig.clips[0].sample(&rig.skeleton, time, pose.locals_mut());
    pose.local(JointIndex(0)).translation
}
