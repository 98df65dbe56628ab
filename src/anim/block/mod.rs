//! Poses of many characters at once, straight to their palettes.
//!
//! The scalar functions of [`anim`](super) say what is meant; here the same is done for blocks of eight characters, with the
//! best instructions of the machine, found out at run time. Nothing is allocated once a [`Workspace`] has grown to its
//! species.
//!
//! ```text
//! clips          one row a frame, runs of joints                      shared by all       rows
//!   │ sample + blend + layers: lanes = joints, character by character                     sample
//! poses          [character][x8 y8 z8 w8 | … | translations | scales] 8 × 1.2 KB
//!   │ transpose, eight joints at a time
//! lanes          [joint][x y z w][character], [number][character]     1 KB
//!   │ model: lanes = characters, parents first; limbs when their end is reached           model, limb
//! matrices       [joint][9 of the matrix, 3 of the position][character]   26 KB
//!   │ palette: rows of each slot, turned to characters                                    palette
//! caller's slice [character][slot][3][4]                              48 bytes a slot, written once
//! ```
//! The sizes are those of 67 joints. A block works in the first and second cache, clips stay in the second.

mod aligned;
mod channels;
mod frames;
mod lanes;
mod limb;
mod locals;
mod model;
mod palette;
mod rows;
mod sample;
mod species;
mod transpose;

use bevy::math::{Quat, Vec3};
use fearless_simd::{Level, Simd, dispatch};

use super::{level, matrix::JointMatrix};
use aligned::Rows32;
use lanes::LANES;
pub use locals::{ClipSet, LocalWorkspace};
use model::Lanes;
pub use rows::{Precision, RowSource, Rows, RowsReport};
pub use species::{LimbJoints, Species, SpeciesError, SpeciesParts};

/// A clip of a blend.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Play {
    /// Index among the species' clips.
    pub clip: usize,
    /// Seconds; wrapped or held as the clip says.
    pub time: f32,
    /// Share among the clips of the layer; they need not sum to one. Zero or less counts for nothing.
    pub weight: f32,
}

/// What a layer does to the layers below.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerMode {
    /// Takes their place, as far as its weight goes.
    #[default]
    Override,
    /// Is added on top: its clips are differences.
    Add,
}

/// A blend of clips. The lowest layer lies on the rest pose.
#[derive(Clone, Copy, Debug, Default)]
pub struct Layer<'a> {
    /// What it does to those below.
    pub mode: LayerMode,
    /// How much of it, 0..=1.
    pub weight: f32,
    /// Index among the species' masks: how much of it for each joint.
    pub mask: Option<usize>,
    /// Its clips. Without any of positive weight the layer does nothing.
    pub clips: &'a [Play],
}

/// Where the end of a limb goes. Model space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Where the end joint goes, metres.
    pub target: Vec3,
    /// Where the middle joint points when the limb is straight.
    pub pole: Vec3,
    /// Turns the end joint from its animated rotation: the identity keeps a foot's sole as the clip holds it.
    pub end_turn: Quat,
}

/// What one character does in this frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Actor<'a> {
    /// Lowest first.
    pub layers: &'a [Layer<'a>],
    /// By limb of the species; limbs without one stay as animated.
    pub goals: &'a [Option<Goal>],
    /// Where its palette begins in the slice of matrices.
    pub palette: usize,
}

/// How far to go: for measuring what a stage costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Until {
    /// Clips sampled and blended.
    Sampled,
    /// Matrices of all joints, without goals.
    Modelled,
    /// The same with limbs on their goals.
    Reached,
    /// All.
    Written,
}

/// Which instructions to use.
#[derive(Clone, Copy, Debug)]
pub struct Instructions(Level);

impl Instructions {
    /// The best that this machine has. Lanes are eight even with AVX-512, whose many registers still save a tenth on Intel's
    /// processors; AMD's are faster with AVX2.
    #[must_use]
    pub fn best() -> Self {
        Self(level::best())
    }

    /// AVX2, where this machine has it.
    #[must_use]
    pub fn avx2() -> Option<Self> {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        return Level::new().as_avx2().map(|avx2| Self(Level::Avx2(avx2)));
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        None
    }

    /// Those that every machine of the target has: SSE2 on x86-64.
    #[must_use]
    pub fn baseline() -> Self {
        Self(Level::baseline())
    }
}

impl Default for Instructions {
    fn default() -> Self {
        Self::best()
    }
}

/// Memory of one thread for blocks; grows to the largest species it meets.
#[derive(Clone, Debug, Default)]
pub struct Workspace {
    instructions: Instructions,
    plan: sample::Plan,
    layer: Rows32,
    poses: Rows32,
    /// Translations and scales, one number after the other: lanes = characters.
    numbers: Rows32,
    /// [`JointRows`](model::JointRows), twelve rows each.
    joints: Rows32,
    /// Palettes of lanes that nobody has.
    spare: Vec<JointMatrix>,
}

impl Workspace {
    /// For `instructions`; [`Workspace::default`] takes the best.
    #[must_use]
    pub fn with(instructions: Instructions) -> Self {
        Self { instructions, ..Self::default() }
    }

    fn fit(&mut self, species: &Species) {
        let (width, channels) = (species.tracks.channels.width(), &species.tracks.channels);
        self.layer.grow(width);
        self.poses.grow(width * LANES);
        self.numbers.grow((width - channels.translation_start()) * LANES);
        self.joints.grow(species.places() * 12);
        self.spare.resize(self.spare.len().max(species.slots.len() * LANES), JointMatrix::IDENTITY);
    }
}

/// Poses `actors` and writes their palettes: `model_from_joint * inverse_bind`, slot by slot.
///
/// A palette that does not fit into `matrices` is left out, and so is a clip that the species hasn't.
pub fn pose(species: &Species, actors: &[Actor], work: &mut Workspace, matrices: &mut [JointMatrix]) {
    pose_until(species, actors, work, matrices, Until::Written);
}

/// As [`pose`], but stops after a stage.
pub fn pose_until(
    species: &Species,
    actors: &[Actor],
    work: &mut Workspace,
    matrices: &mut [JointMatrix],
    until: Until,
) {
    let level = work.instructions.0;
    dispatch!(level, simd => run(simd, species, actors, work, matrices, until));
}

#[inline(always)]
fn run<S: Simd>(
    simd: S,
    species: &Species,
    actors: &[Actor],
    work: &mut Workspace,
    matrices: &mut [JointMatrix],
    until: Until,
) {
    work.fit(species);
    let joints = work.joints.as_chunks_mut::<3>().0.as_chunks_mut::<4>().0;
    model::place_roots(simd, species, joints);
    let (tracks, width) = (&species.tracks, species.tracks.channels.width());
    for block in actors.chunks(LANES) {
        for (actor, pose) in block.iter().zip(work.poses.chunks_mut(width.max(1))) {
            work.plan.make(tracks, actor.layers);
            sample::sample::<S, false>(simd, tracks, &work.plan, &mut work.layer[..width], &mut pose[..width]);
        }
        if until == Until::Sampled {
            continue;
        }
        sample::transpose_numbers(simd, tracks, &work.poses, &mut work.numbers);
        let lanes = Lanes { poses: &work.poses, numbers: &work.numbers };
        let reaching = if until == Until::Modelled { &[] } else { block };
        model::place_joints(simd, species, &lanes, joints, reaching);
        if until == Until::Written {
            palette::write(simd, species, joints, block, matrices, &mut work.spare);
        }
    }
}

#[cfg(test)]
mod tests;
