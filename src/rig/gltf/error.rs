//! What can be wrong with a glTF file, each naming the element to mend.

use crate::anim::skeleton::SkeletonError;

/// Why a file gave no rig.
#[derive(thiserror::Error, Clone, Debug, PartialEq)]
pub enum RigError {
    /// Neither glTF JSON nor a whole GLB container.
    #[error("not a whole glTF 2.0 file: {0}")]
    Container(String),
    /// The JSON doesn't read as glTF.
    #[error("glTF JSON: {0}")]
    Json(String),
    /// An element of the JSON breaks a rule of the format.
    #[error("glTF element `{path}`: {problem}")]
    Element {
        /// Its path in the JSON.
        path: String,
        /// What is wrong.
        problem: String,
    },
    /// The file can't be read without an extension that isn't there.
    #[error("the file requires the extension `{0}`, which hides its data from this importer; export without it")]
    Extension(String),
    /// A buffer is missing or too short.
    #[error("buffer {buffer}: {problem}")]
    Buffer {
        /// glTF buffer index.
        buffer: usize,
        /// What is wrong.
        problem: String,
    },
    /// Numbers can't be read.
    #[error("accessor {accessor} ({used_by}): {problem}")]
    Accessor {
        /// glTF accessor index.
        accessor: usize,
        /// What needs it.
        used_by: String,
        /// What is wrong.
        problem: String,
    },
    /// A node breaks the tree or has no usable transform.
    #[error("node `{node}`: {problem}")]
    Node {
        /// Its name.
        node: String,
        /// What is wrong.
        problem: String,
    },
    /// A skin is inconsistent.
    #[error("skin `{skin}`: {problem}")]
    Skin {
        /// Its name.
        skin: String,
        /// What is wrong.
        problem: String,
    },
    /// A clip's channel has bad keys.
    #[error("clip `{clip}`, {channel} of node `{node}`: {problem}")]
    Clip {
        /// Its name.
        clip: String,
        /// The node its channel moves.
        node: String,
        /// Translation, rotation, scale or weights.
        channel: &'static str,
        /// What is wrong.
        problem: String,
    },
    /// A vertex can't be skinned.
    #[error("mesh `{mesh}`, primitive {primitive}, vertex {vertex}: {problem}")]
    Vertex {
        /// Its mesh's name.
        mesh: String,
        /// Index of the primitive in the mesh.
        primitive: usize,
        /// Index of the vertex in the primitive.
        vertex: usize,
        /// What is wrong.
        problem: String,
    },
    /// Vertex data that don't go together.
    #[error("mesh `{mesh}`, primitive {primitive}: {problem}")]
    Primitive {
        /// Its mesh's name.
        mesh: String,
        /// Index of the primitive in the mesh.
        primitive: usize,
        /// What is wrong.
        problem: String,
    },
    /// The joints are no skeleton.
    #[error(transparent)]
    Skeleton(#[from] SkeletonError),
}
