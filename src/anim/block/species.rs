//! What all characters of one kind share: skeleton, skin and limbs, turned into constants for the kernels.

use bevy::math::{Affine3A, Mat3, Vec3};

use super::{
    aligned::Rows32,
    channels::Channels,
    frames::Frames,
    rows::{RowSource, Rows},
};
use crate::anim::{
    ik::two_bone::Extension,
    skeleton::{JointIndex, JointTransform, Skeleton},
    skin::Skin,
};

/// Matrices this close to the identity count as it.
const SAME: f32 = 2e-6;

/// A limb with two bones that IK turns, from its root to its end; see [`two_bone`](crate::anim::ik::two_bone).
#[derive(Clone, Copy, Debug)]
pub struct LimbJoints {
    /// Hip or shoulder.
    pub upper: JointIndex,
    /// Knee or elbow, somewhere below `upper`.
    pub lower: JointIndex,
    /// Ankle or wrist, somewhere below `lower`.
    pub end: JointIndex,
    /// How far it stretches.
    pub extension: Extension,
}

/// What a [`Species`] is made of.
#[derive(Clone, Copy, Debug)]
pub struct SpeciesParts<'a> {
    /// Joints.
    pub skeleton: &'a Skeleton,
    /// What a palette consists of.
    pub skin: &'a Skin,
    /// Limbs for IK, none of them below another.
    pub limbs: &'a [LimbJoints],
    /// All clips that its characters play.
    pub clips: &'a [RowSource<'a>],
    /// Masks that layers may name: a weight in 0..=1 for every joint.
    pub masks: &'a [&'a [f32]],
}

/// Why a species can't be made.
#[derive(thiserror::Error, Clone, Debug, PartialEq)]
pub enum SpeciesError {
    /// A limb's joints don't hang on each other.
    #[error("limb {limb}: `{below}` does not hang below `{above}`")]
    Limb {
        /// Index of the limb.
        limb: usize,
        /// The joint that should be further down.
        below: String,
        /// The joint that should be further up.
        above: String,
    },
    /// A mask or a reference pose has not one entry a joint.
    #[error("{what} {index} has {found} entries for {joints} joints")]
    Count {
        /// `mask` or `reference pose of clip`.
        what: &'static str,
        /// Which of them.
        index: usize,
        /// Its entries.
        found: usize,
        /// The skeleton's joints.
        joints: usize,
    },
    /// A clip's rows alone don't tell its motion, and here only rows are read.
    #[error("clip {index} (`{name}`) keeps keys beside its frames: play it by `Clip::sample`")]
    Keyed {
        /// Index of the clip.
        index: usize,
        /// Its name.
        name: String,
    },
    /// The skin names a joint that the skeleton hasn't.
    #[error("palette slot {slot} names joint {joint} of {joints}")]
    Slot {
        /// The palette slot.
        slot: usize,
        /// What it names.
        joint: usize,
        /// How many joints there are.
        joints: usize,
    },
}

/// Skeleton, skin, limbs, clips and masks of one kind of character, ready to be posed in blocks.
#[derive(Clone, Debug)]
pub struct Species {
    pub(super) above_roots: [[f32; 4]; 3],
    pub(super) joints: Vec<Joint>,
    pub(super) slots: Vec<Slot>,
    pub(super) rests: Vec<Rest>,
    pub(super) limbs: Vec<Limb>,
    pub(super) tracks: Tracks,
    frames: Frames,
}

/// What sampling reads: clips in rows, and masks in the order of their numbers.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracks {
    pub(super) channels: Channels,
    pub(super) clips: Vec<Rows>,
    pub(super) masks: Vec<Rows32>,
}

/// Its rows.
pub(super) type Matrix = [[f32; 3]; 3];

/// Constants of a joint. What few joints need is kept elsewhere: all of them are read for every block.
#[derive(Clone, Debug)]
pub(super) struct Joint {
    /// Place of the parent's matrix: 0 is what stands above the roots, 1 the first joint.
    pub(super) parent: usize,
    pub(super) rotation: Track<Box<Matrix>>,
    pub(super) translation: Track<[f32; 3]>,
    pub(super) scale: Track<Box<Matrix>>,
    /// What the scales along the joint's axes are multiplied with and add up to in the matrix between frames, which is
    /// symmetric: its elements xx, yy, zz, xy, xz, yz.
    pub(super) scale_parts: Box<[[f32; 3]; 6]>,
    /// The limb that ends here.
    pub(super) ends: Option<usize>,
}

/// Where a joint's channel comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Track<T> {
    /// Rotation and scale only: none.
    Identity,
    /// The same in every clip.
    Still(T),
    /// The place of a rotation among those that move, or of an x among the numbers behind them.
    Moving(usize),
}

/// Constants of a palette slot.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    /// Place of the joint's matrix, as [`Joint::parent`]; or behind those of all joints, of a [`Rest`].
    pub(super) joint: usize,
    /// Inverse bind translation in the joint's frame.
    pub(super) offset: [f32; 3],
}

/// What is left of an inverse bind matrix that is not its joint's frame's inverse.
#[derive(Clone, Debug)]
pub(super) struct Rest {
    /// Place of the joint's matrix, as [`Joint::parent`].
    pub(super) joint: usize,
    /// Where the joint's matrix with this one goes.
    pub(super) place: usize,
    /// Inverse bind translation in the joint's frame.
    pub(super) offset: [f32; 3],
    pub(super) matrix: Matrix,
}

/// Constants of a limb. Places as [`Joint::parent`].
#[derive(Clone, Debug)]
pub(super) struct Limb {
    pub(super) upper: usize,
    pub(super) lower: usize,
    pub(super) end: usize,
    /// Joints that go with the upper bone, and with the lower one; without the end.
    pub(super) with_upper: Vec<usize>,
    pub(super) with_lower: Vec<usize>,
    pub(super) extension: Extension,
}

impl Species {
    /// Prepares one.
    ///
    /// # Errors
    /// When a limb, mask, reference pose or palette slot does not fit the skeleton, or a clip [keeps keys].
    ///
    /// [keeps keys]: crate::anim::clip::Clip::is_keyed
    pub fn new(parts: &SpeciesParts) -> Result<Self, SpeciesError> {
        parts.check()?;
        let skeleton = parts.skeleton;
        let frames = Frames::new(skeleton, parts.skin);
        let channels = Channels::new(skeleton, &frames, parts.clips);
        let above = frames.root;
        let root = skeleton.model_from_root;
        let root_turn = Mat3::from(root.matrix3) * Mat3::from_quat(above.turn.conjugate()) * (1.0 / above.scale);
        let mut joints: Vec<_> =
            skeleton.joints().map(|joint| Joint::new(skeleton, &frames, &channels, joint)).collect();
        let limbs: Vec<_> = parts.limbs.iter().map(|limb| limb_of(skeleton, limb)).collect();
        for (index, limb) in limbs.iter().enumerate() {
            joints[limb.end - 1].ends = Some(index);
        }
        let mut rests = Vec::new();
        let slots = parts.skin.joints.iter().zip(&parts.skin.inverse_bind);
        let slots =
            slots.map(|(joint, inverse)| Slot::new(&frames, *joint, &inverse.to_affine(), &mut rests)).collect();
        let clips = parts.clips.iter().map(|source| Rows::new(skeleton, &frames, &channels, source)).collect();
        let masks = parts.masks.iter().map(|mask| channels.mask_row(mask)).collect();
        Ok(Self {
            above_roots: rows_with(root_turn, root.translation.into()),
            joints,
            slots,
            rests,
            limbs,
            tracks: Tracks { channels, clips, masks },
            frames,
        })
    }

    /// How many matrices blocks place: what is above the roots, joints, and those with a rest.
    pub(super) fn places(&self) -> usize {
        1 + self.joints.len() + self.rests.len()
    }

    /// How many joints a character has.
    #[must_use]
    pub fn joint_count(&self) -> usize {
        self.joints.len()
    }

    /// How many matrices a character's palette has.
    #[must_use]
    pub fn slot_count(&self) -> usize {
        self.slots.len()
    }

    /// The clips, in the order they were given.
    #[must_use]
    pub fn clips(&self) -> &[Rows] {
        &self.tracks.clips
    }

    /// Writes every joint of a clip's frame in its parent's space, as the kernels read it. Slow: for checks.
    pub fn frame_of_clip(&self, skeleton: &Skeleton, clip: usize, frame: usize, out: &mut [JointTransform]) {
        self.tracks.clips[clip].frame(skeleton, &self.frames, &self.tracks.channels, frame, out);
    }
}

impl SpeciesParts<'_> {
    fn check(&self) -> Result<(), SpeciesError> {
        let joints = self.skeleton.len();
        for (slot, joint) in self.skin.joints.iter().enumerate() {
            if joint.index() >= joints {
                return Err(SpeciesError::Slot { slot, joint: joint.index(), joints });
            }
        }
        for (index, limb) in self.limbs.iter().enumerate() {
            for (above, below) in [(limb.upper, limb.lower), (limb.lower, limb.end)] {
                if above == below || below.index() >= joints || !self.skeleton.is_below(below, above) {
                    let name =
                        |joint: JointIndex| self.skeleton.names().get(joint.index()).cloned().unwrap_or_default();
                    return Err(SpeciesError::Limb { limb: index, below: name(below), above: name(above) });
                }
            }
        }
        if let Some(index) = self.clips.iter().position(|source| source.clip.is_keyed()) {
            return Err(SpeciesError::Keyed { index, name: self.clips[index].clip.name.clone() });
        }
        let masks = self.masks.iter().map(|mask| mask.len()).enumerate().map(|(i, found)| ("mask", i, found));
        let references = self.clips.iter().enumerate().filter_map(|(index, source)| {
            source.difference_from.map(|pose| ("reference pose of clip", index, pose.len()))
        });
        match masks.chain(references).find(|(_, _, found)| *found != joints) {
            Some((what, index, found)) => Err(SpeciesError::Count { what, index, found, joints }),
            None => Ok(()),
        }
    }
}

impl Joint {
    fn new(skeleton: &Skeleton, frames: &Frames, channels: &Channels, joint: JointIndex) -> Self {
        let (index, rest) = (joint.index(), skeleton.rest()[joint.index()]);
        let turn = Mat3::from_quat(frames.rotation(joint, rest.rotation));
        let own = frames.joints[index];
        let axes = Mat3::from_quat(own.turn);
        let ratio = frames.above(index).scale / own.scale;
        let [x, y, z] = [axes.row(0), axes.row(1), axes.row(2)];
        let scale = axes * Mat3::from_diagonal(rest.scale * ratio) * axes.transpose();
        Self {
            parent: skeleton.parent(joint).map_or(0, |parent| parent.index() + 1),
            rotation: channels.rotation_place(joint).map_or(Track::still(turn), Track::Moving),
            translation: channels
                .translation_place(joint)
                .map_or(Track::Still(frames.translation(joint, rest.translation).to_array()), Track::Moving),
            scale: channels.scale_place(joint).map_or(Track::still(scale), Track::Moving),
            scale_parts: Box::new([x * x, y * y, z * z, x * y, x * z, y * z].map(|part| (part * ratio).to_array())),
            ends: None,
        }
    }
}

impl Slot {
    fn new(frames: &Frames, joint: JointIndex, inverse_bind: &Affine3A, rests: &mut Vec<Rest>) -> Self {
        let frame = frames.joints[joint.index()].matrix();
        let rest = frame * Mat3::from(inverse_bind.matrix3);
        let (joint, offset) = (joint.index() + 1, (frame * Vec3::from(inverse_bind.translation)).to_array());
        if rest.abs_diff_eq(Mat3::IDENTITY, SAME) {
            return Self { joint, offset };
        }
        let place = 1 + frames.joints.len() + rests.len();
        rests.push(Rest { joint, place, offset, matrix: rows(rest) });
        Self { joint: place, offset: [0.0; 3] }
    }
}

impl Track<Box<Matrix>> {
    fn still(matrix: Mat3) -> Self {
        if matrix.abs_diff_eq(Mat3::IDENTITY, SAME) { Self::Identity } else { Self::Still(Box::new(rows(matrix))) }
    }
}

fn limb_of(skeleton: &Skeleton, joints: &LimbJoints) -> Limb {
    let between = joints.upper.index()..joints.end.index();
    let (with_lower, with_upper) = skeleton
        .joints()
        .filter(|joint| between.contains(&joint.index()) && skeleton.is_below(*joint, joints.upper))
        .partition::<Vec<_>, _>(|joint| skeleton.is_below(*joint, joints.lower));
    let places = |joints: Vec<JointIndex>| joints.into_iter().map(|joint| joint.index() + 1).collect();
    Limb {
        upper: joints.upper.index() + 1,
        lower: joints.lower.index() + 1,
        end: joints.end.index() + 1,
        with_upper: places(with_upper),
        with_lower: places(with_lower),
        extension: joints.extension,
    }
}

fn rows(matrix: Mat3) -> Matrix {
    matrix.transpose().to_cols_array_2d()
}

fn rows_with(matrix: Mat3, translation: Vec3) -> [[f32; 4]; 3] {
    let [a, b, c] = rows(matrix);
    [[a[0], a[1], a[2], translation.x], [b[0], b[1], b[2], translation.y], [c[0], c[1], c[2], translation.z]]
}
