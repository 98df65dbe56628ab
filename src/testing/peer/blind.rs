//! What the engine's import cannot play, so that an exact evaluation has to stand in. Nodes by glTF index.

use std::collections::HashMap;

use gltf::{
    Accessor, Document, Semantic,
    accessor::DataType,
    animation::{Channel, Interpolation, Property},
};

/// No scene holds the node: the engine spawns scenes only.
const NO_SCENE: &str = "no scene holds it";
/// Nodes of one path share their curves in the engine.
const SAME_PATH: &str = "another node has the same path of names";
/// The engine skips channels with such key times.
const SPARSE_TIMES: &str = "its key times are sparse";
/// The engine takes the in-tangent for the value.
const LONE_SPLINE_KEY: &str = "its spline has one key";

/// The engine takes them as they are, and a quaternion that is not one long scales and shears what it turns.
const NOT_UNIT: &str = "its rotations are integers, whose rounding the engine leaves in";
/// The engine's loader panics over them.
const QUANTISED: &str = "positions are quantised, which the engine's loader cannot read";

/// Why the engine cannot load the file at all, as far as can be told beforehand.
pub(super) fn unloadable(document: &Document) -> Option<&'static str> {
    let mut primitives = document.meshes().flat_map(|mesh| mesh.primitives());
    let quantised = |accessor: Accessor| accessor.data_type() != DataType::F32;
    primitives.any(|primitive| primitive.get(&Semantic::Positions).is_some_and(quantised)).then_some(QUANTISED)
}

/// Why the engine cannot play each node in each clip.
pub(super) struct Blind {
    parents: Vec<Option<usize>>,
    always: Vec<Option<&'static str>>,
    clips: Vec<Vec<Option<&'static str>>>,
}

impl Blind {
    /// Looks through a sound document.
    pub(super) fn read(document: &Document) -> Self {
        let count = document.nodes().len();
        let mut parents = vec![None; count];
        for node in document.nodes() {
            for child in node.children() {
                parents[child.index()] = Some(node.index());
            }
        }
        let mut always = vec![Some(NO_SCENE); count];
        let mut open: Vec<_> = document.scenes().flat_map(|scene| scene.nodes()).collect();
        while let Some(node) = open.pop() {
            always[node.index()] = None;
            open.extend(node.children());
        }
        let mut animated = vec![false; count];
        for channel in document.animations().flat_map(|clip| clip.channels()) {
            animated[channel.target().node().index()] = true;
        }
        let mut paths: HashMap<Vec<&str>, Vec<usize>> = HashMap::new();
        let names: Vec<Option<&str>> = document.nodes().map(|node| node.name()).collect();
        for node in (0..count).filter(|node| always[*node].is_none()) {
            // The engine numbers nodes without a name, which keeps their paths apart.
            let path: Option<Vec<&str>> = line(&parents, node).map(|node| names[node]).collect();
            paths.entry(path.unwrap_or_default()).or_default().push(node);
        }
        let named = paths.into_iter().filter(|(path, _)| !path.is_empty()).map(|(_, nodes)| nodes);
        for nodes in named.filter(|nodes| nodes.len() > 1 && nodes.iter().any(|node| animated[*node])) {
            nodes.iter().for_each(|node| always[*node] = Some(SAME_PATH));
        }
        let clips = document.animations().map(|clip| {
            let mut blind = vec![None; count];
            for channel in clip.channels() {
                blind[channel.target().node().index()] = oddity(&channel).or(blind[channel.target().node().index()]);
            }
            blind
        });
        Self { clips: clips.collect(), parents, always }
    }

    /// Why the engine's `node` is not where the file puts it in clip number `clip`: its own fault or that of a node above.
    pub(super) fn reason(&self, clip: Option<usize>, node: usize) -> Option<&'static str> {
        let in_clip = |node: usize| clip.and_then(|clip| *self.clips.get(clip)?.get(node)?);
        line(&self.parents, node).find_map(|node| self.always[node].or_else(|| in_clip(node)))
    }
}

/// The node and all above it.
fn line(parents: &[Option<usize>], node: usize) -> impl Iterator<Item = usize> {
    core::iter::successors(Some(node), |node| parents[*node])
}

fn oddity(channel: &Channel) -> Option<&'static str> {
    let sampler = channel.sampler();
    if sampler.input().sparse().is_some() {
        return Some(SPARSE_TIMES);
    }
    let integers = sampler.output().data_type() != DataType::F32;
    if channel.target().property() == Property::Rotation && integers {
        return Some(NOT_UNIT);
    }
    let spline = sampler.interpolation() == Interpolation::CubicSpline;
    (spline && sampler.input().count() == 1).then_some(LONE_SPLINE_KEY)
}
