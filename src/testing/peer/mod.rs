//! Holds a glTF file's motion against a peer: the engine's own import and `AnimationPlayer` of the same file.
//!
//! Every joint at 60 times of every clip, in model space. Where the engine cannot play something, an exact evaluation in
//! double precision stands in for it, and the report says so.
//!
//! ```no_run
//! use surefoot::testing::peer::compare;
//!
//! let comparison = compare("my_rig.glb".as_ref()).expect("both load it");
//! println!("{comparison}");
//! assert!(comparison.holds());
//! ```

mod blind;
mod engine;
mod exact;
mod report;

use std::{path::Path, sync::Arc};

use bevy::math::{Affine3A, Vec3, Vec3A};
use gltf::Gltf;

pub use self::report::{Comparison, JointError, Judged, MAX_DEGREES, MAX_MILLIMETRES, MAX_SHARE};
use self::{blind::Blind, engine::Engine, exact::Exact};
use crate::{
    anim::{
        clip::Clip,
        pose::{Pose, rotation_of},
        skeleton::JointIndex,
    },
    math::rotation::angle_between,
    rig::{
        Rig,
        gltf::{container::Container, error::RigError},
    },
};

/// Times of each clip at which joints are compared.
pub const TIMES: usize = 60;
/// Metres of height that errors are scaled to.
const HEIGHT: f32 = 1.8;
/// A figure flatter than this share of its largest side is measured by that side instead of its height.
const FLAT: f32 = 0.1;
/// Axes shorter than this share of a matrix's longest have no direction.
const SQUASHED: f32 = 1e-4;

/// Why there is no comparison.
#[derive(thiserror::Error, Debug)]
pub enum PeerError {
    /// The file, or one that it names, cannot be read.
    #[error("can't read `{path}`: {reason}")]
    Io {
        /// Which.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// This crate's import refuses the file.
    #[error("`{path}`: {error}")]
    Refused {
        /// Which.
        path: String,
        /// Why.
        error: Box<RigError>,
    },
    /// This crate's import refuses a part of it.
    #[error(transparent)]
    Rig(#[from] RigError),
    /// The engine's import refuses it.
    #[error("the engine cannot load it: {0}")]
    Engine(String),
}

/// Reads a `.glb` or `.gltf` file with the buffers beside it.
///
/// # Errors
/// [`PeerError::Io`] and [`PeerError::Refused`].
pub fn load_rig(file: &Path) -> Result<Rig, PeerError> {
    let refused = |error| PeerError::Refused { path: file.display().to_string(), error: Box::new(error) };
    Rig::from_slice(&bytes(file)?, beside(file)).map_err(refused)
}

/// Compares what this crate and the engine make of every clip of `file`, or of its rest pose if it has none.
///
/// # Errors
/// When this crate refuses the file. Where the engine does, [`Comparison::refusal`] says so.
pub fn compare(file: &Path) -> Result<Comparison, PeerError> {
    compare_rig(&load_rig(file)?, file)
}

/// As [`compare`], for a rig that is said to be that of `file`.
///
/// # Errors
/// When the file cannot be read.
pub fn compare_rig(rig: &Rig, file: &Path) -> Result<Comparison, PeerError> {
    let bytes = bytes(file)?;
    let buffers = Container::parse(&bytes)?.buffers(&mut beside(file))?;
    let source = Gltf::from_slice_without_validation(&bytes).map_err(|error| RigError::Json(error.to_string()))?;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let folder = file.parent().unwrap_or(Path::new(""));
    let folder = folder.canonicalize().map_err(|error| io(folder, &error))?;
    let (engine, refusal) = match blind::unloadable(&source.document) {
        Some(reason) => (None, Some(reason.to_owned())),
        None => match Engine::load(&folder, &name) {
            Ok(engine) => (Some(engine), None),
            Err(error) => (None, Some(error.to_string())),
        },
    };
    let mut witnesses =
        Witnesses { engine, exact: Exact::read(&source.document, &buffers), blind: Blind::read(&source.document) };
    let metre = HEIGHT / height(rig);
    let clips = match rig.clips.len() {
        0 => vec![witnesses.compare(rig, None, metre)],
        count => (0..count).map(|clip| witnesses.compare(rig, Some(clip), metre)).collect(),
    };
    Ok(Comparison { joints: rig.skeleton.len(), refusal, clips })
}

/// Those whose word counts.
struct Witnesses {
    /// `None` where it cannot load the file.
    engine: Option<Engine>,
    exact: Exact,
    blind: Blind,
}

impl Witnesses {
    /// Compares one clip, or the rest pose. `metre` scales errors to a figure of 1.8 m.
    fn compare(&mut self, rig: &Rig, index: Option<usize>, metre: f32) -> Judged {
        let clip = index.map(|clip| &rig.clips[clip]);
        let mut judged = Judged { clip: clip.map_or("rest pose", |clip| &clip.name).to_owned(), ..Judged::default() };
        let mut pose = Pose::rest(&rig.skeleton);
        let model_from_file = rig.skeleton.model_from_root;
        for time in 0..if clip.is_some() { TIMES } else { 1 } {
            // A loop's end is its start; other clips are asked for their last pose too.
            let steps = if clip.is_some_and(|clip| clip.looping) { TIMES } else { TIMES - 1 };
            let time = clip.map_or(0.0, |clip| clip.duration * time as f32 / steps as f32);
            if let Some(clip) = clip {
                clip.sample(&rig.skeleton, time, pose.locals_mut());
                pose.update_model(&rig.skeleton);
            }
            if let Some(engine) = &mut self.engine {
                engine.pose(index, time);
            }
            let exact = self.exact.sample(index, time);
            for (node, joint) in rig.node_joints.iter().enumerate() {
                let Some(joint) = *joint else { continue };
                let ours = pose.model(joint);
                let error = |file_from_node: Affine3A| error(&ours, &(model_from_file * file_from_node), metre);
                let from_exact = error(exact[node].as_affine3a());
                judged.exact = judged.exact.max(from_exact);
                let Some(engine) = &self.engine else {
                    judged.stand_in = judged.stand_in.max(from_exact);
                    continue;
                };
                match (self.blind.reason(index, node), engine.node(node)) {
                    (None, Some(place)) => {
                        let weights = weights(clip, engine, node, joint, time);
                        judged.engine = judged.engine.max(JointError { weights, ..error(place.affine()) });
                    }
                    (reason, _) => judged.stand_in(rig.skeleton.name(joint), reason, from_exact),
                }
            }
        }
        judged
    }
}

/// How far the morph weights of `clip` are from the engine's.
fn weights(clip: Option<&Arc<Clip>>, engine: &Engine, node: usize, joint: JointIndex, time: f32) -> f32 {
    let Some((clip, theirs)) = clip.zip(engine.weights(node)) else { return 0.0 };
    let mut ours = vec![0.0; theirs.len()];
    if !clip.morph_weights(joint, time, &mut ours) {
        return 0.0;
    }
    ours.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

/// How far `ours` is from `theirs`, both `model_from_joint` in metres.
fn error(ours: &Affine3A, theirs: &Affine3A, metre: f32) -> JointError {
    let axes = |matrix: &Affine3A| [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(Vec3A::length);
    let (own, other) = (axes(ours), axes(theirs));
    let largest = own.into_iter().chain(other).fold(f32::MIN_POSITIVE, f32::max);
    let scale = own.into_iter().zip(other).map(|(a, b)| (a - b).abs() / largest).fold(0.0, f32::max);
    let directed = own.into_iter().chain(other).all(|length| length > SQUASHED * largest);
    let turn = if directed { angle_between(rotation_of(ours), rotation_of(theirs)) } else { 0.0 };
    JointError {
        millimetres: ours.translation.distance(theirs.translation) * metre * 1000.0,
        degrees: turn.to_degrees(),
        scale,
        weights: 0.0,
    }
}

/// Height at rest of the joints and of what hangs on them, metres in model space.
fn height(rig: &Rig) -> f32 {
    let rest = Pose::rest(&rig.skeleton);
    let joints = rest.positions();
    let corners = rest.models().iter().zip(&rig.joint_bounds).filter_map(|(joint, bounds)| Some((joint, (*bounds)?)));
    let corners =
        corners.flat_map(|(joint, bounds)| [bounds.min, bounds.max].map(|at| joint.transform_point3(at.into())));
    let (low, high) =
        joints.chain(corners).fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    let size = if low.is_finite() { high - low } else { Vec3::ONE };
    let height = if size.y > FLAT * size.max_element() { size.y } else { size.max_element() };
    if height > 0.0 { height } else { 1.0 }
}

fn bytes(file: &Path) -> Result<Vec<u8>, PeerError> {
    std::fs::read(file).map_err(|error| io(file, &error))
}

/// Reads buffers that lie beside `file`.
fn beside(file: &Path) -> impl FnMut(&str) -> Result<Vec<u8>, String> {
    let folder = file.parent().map(Path::to_path_buf).unwrap_or_default();
    move |uri| std::fs::read(folder.join(uri)).map_err(|error| error.to_string())
}

fn io(path: &Path, error: &std::io::Error) -> PeerError {
    PeerError::Io { path: path.display().to_string(), reason: error.to_string() }
}
