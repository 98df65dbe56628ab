//! glTF bytes → [`Rig`]: skeleton, skins, clips and what vertices say about joints.
//!
//! The file's space stays: `Skeleton::model_from_root` leads from it to model space.

mod accessor;
mod clips;
pub(crate) mod container;
pub mod error;
mod expressions;
mod influences;
mod meshes;
mod nodes;
mod skins;
mod vrm;

use std::sync::Arc;

use self::{accessor::Source, container::Container, error::RigError};
use super::{Rig, character_file::Roles, frame};
use crate::anim::{
    pose::Pose,
    skeleton::{JointIndex, Skeleton},
};

impl Rig {
    /// Reads `.glb` or `.gltf` bytes; `resolve` gives the bytes behind the path of a buffer in another file.
    ///
    /// # Errors
    /// When the file breaks the format's rules; the error names the element.
    pub fn from_slice(
        bytes: &[u8],
        mut resolve: impl FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Self, RigError> {
        Self::from_container(Container::parse(bytes)?, &mut resolve)
    }

    pub(crate) fn from_container(
        mut container: Container,
        resolve: &mut dyn FnMut(&str) -> Result<Vec<u8>, String>,
    ) -> Result<Self, RigError> {
        let buffers = container.buffers(resolve)?;
        let source = Source { json: &container.json, buffers: &buffers };
        let nodes = nodes::read(&container.json, frame::gltf_default())?;
        let mut skins = skins::read(&source, &nodes)?;
        let mut notes = Vec::new();
        let (meshes, vertices) = meshes::read(&source, &nodes, &mut skins, &mut notes)?;
        let curves = clips::read(&source, &nodes)?;
        let told_roles = vrm::roles(&container.json, &nodes);
        let expressions = expressions::read(&container.json, &nodes, &meshes, &mut notes);
        let mut rig = Self {
            skeleton: nodes.skeleton,
            node_joints: nodes.joints,
            skins,
            meshes,
            clips: Vec::new(),
            joint_bounds: vertices.bounds,
            dominated: vertices.dominated,
            told_roles,
            expressions,
            notes,
        };
        // A file that is no humanoid keeps glTF's own axes.
        if let Ok(binding) = rig.bind(&Roles::Auto) {
            rig.skeleton.model_from_root = binding.frame.model_from_root;
            rig.notes.extend(binding.frame.notes);
        }
        let mut pose = Pose::rest(&rig.skeleton);
        if let Some(joint) = lost(&rig.skeleton, &pose) {
            let problem = "where it is at rest is not finite: its transform, or one above it, is too large".to_owned();
            return Err(RigError::Node { node: rig.skeleton.name(joint).to_owned(), problem });
        }
        for curves in &curves {
            let clip = curves.bake(&rig.skeleton);
            for frame in 0..clip.frame_count() {
                let time = frame as f32 / clip.frame_rate().max(f32::MIN_POSITIVE);
                clip.sample(&rig.skeleton, time, pose.locals_mut());
                pose.update_model(&rig.skeleton);
                if let Some(joint) = lost(&rig.skeleton, &pose) {
                    return Err(RigError::Clip {
                        clip: clip.name,
                        node: rig.skeleton.name(joint).to_owned(),
                        channel: "place",
                        problem: format!(
                            "in frame {frame} it is not finite: its keys, or those above it, are too large"
                        ),
                    });
                }
            }
            rig.clips.push(Arc::new(clip));
        }
        Ok(rig)
    }
}

/// The first joint whose place in `pose` is not finite.
fn lost(skeleton: &Skeleton, pose: &Pose) -> Option<JointIndex> {
    skeleton.joints().find(|&joint| !pose.model(joint).is_finite())
}
