//! Which numbers a species' rows hold, and where: the joints that any of its clips moves.

use bevy::math::{Quat, Vec3};

use super::{
    aligned::Rows32,
    frames::Frames,
    lanes::{LANES, Row},
    rows::RowSource,
};
use crate::anim::skeleton::{JointIndex, JointTransform, Skeleton};

/// Changes below this are rounding: a channel that moves less is at rest.
const STILL: f32 = 1e-6;

/// Which joints move at all in a species' clips, in the order of the rows.
#[derive(Clone, Debug, Default)]
pub(super) struct Channels {
    pub(super) rotations: Vec<JointIndex>,
    pub(super) translations: Vec<JointIndex>,
    pub(super) scales: Vec<JointIndex>,
    /// The row of the rest pose.
    pub(super) rest: Rows32,
}

/// What a joint does at one moment, between frames.
#[derive(Clone, Copy)]
pub(super) struct Moment {
    rotation: Quat,
    translation: Vec3,
    scale: Vec3,
}

impl Channels {
    pub(super) fn new(skeleton: &Skeleton, frames: &Frames, clips: &[RowSource]) -> Self {
        let mut moves = vec![[false; 3]; skeleton.len()];
        let mut pose = skeleton.rest().to_vec();
        for source in clips {
            for frame in 0..source.clip.frame_count() {
                source.sample(skeleton, frame, &mut pose);
                for ((joint, rest), moves) in pose.iter().zip(skeleton.rest()).zip(&mut moves) {
                    let still = if source.difference_from.is_some() { JointTransform::IDENTITY } else { *rest };
                    let side = if joint.rotation.dot(still.rotation) < 0.0 { -still.rotation } else { still.rotation };
                    let turned = (joint.rotation - side).to_array().into_iter().map(f32::abs).fold(0.0, f32::max);
                    moves[0] |= turned > STILL;
                    moves[1] |= (joint.translation - still.translation).abs().max_element() > STILL;
                    moves[2] |= (joint.scale - still.scale).abs().max_element() > STILL;
                }
            }
        }
        let moving = |kind: usize| skeleton.joints().filter(|joint| moves[joint.index()][kind]).collect::<Vec<_>>();
        let mut channels =
            Self { rotations: moving(0), translations: moving(1), scales: moving(2), rest: Rows32::default() };
        let moment = |joint: JointIndex| Moment::new(frames, joint, skeleton.rest()[joint.index()], false);
        channels.rest = channels.row(moment).into_iter().collect();
        channels
    }

    /// Vectors of a quarter of all rotations: how many times eight joints turn.
    pub(super) fn tiles(&self) -> usize {
        self.rotations.len().div_ceil(LANES)
    }

    /// The first vector of translations.
    pub(super) fn translation_start(&self) -> usize {
        4 * self.tiles()
    }

    /// The first vector of scales.
    pub(super) fn scale_start(&self) -> usize {
        self.translation_start() + (3 * self.translations.len()).div_ceil(LANES)
    }

    /// Vectors of a row.
    pub(super) fn width(&self) -> usize {
        self.scale_start() + (3 * self.scales.len()).div_ceil(LANES)
    }

    /// Place of a joint's rotation among those that move.
    pub(super) fn rotation_place(&self, joint: JointIndex) -> Option<usize> {
        self.rotations.binary_search(&joint).ok()
    }

    /// Place of the x of a joint's translation among the numbers behind the rotations; y and z follow at steps of as many
    /// translations as there are.
    pub(super) fn translation_place(&self, joint: JointIndex) -> Option<usize> {
        self.translations.binary_search(&joint).ok()
    }

    /// The same for its scale.
    pub(super) fn scale_place(&self, joint: JointIndex) -> Option<usize> {
        let start = (self.scale_start() - self.translation_start()) * LANES;
        self.scales.binary_search(&joint).ok().map(|slot| start + slot)
    }

    /// One weight a number; one vector for eight rotations.
    pub(super) fn mask_row(&self, mask: &[f32]) -> Rows32 {
        let mut row = vec![[0.0; LANES]; self.width() - 3 * self.tiles()];
        let numbers = row.as_flattened_mut();
        for (number, joint) in numbers.iter_mut().zip(&self.rotations) {
            *number = mask[joint.index()];
        }
        for (start, joints) in self.vector_runs() {
            let start = start - 3 * self.tiles() * LANES;
            for (place, joint) in (0..3).flat_map(|_| joints).enumerate() {
                numbers[start + place] = mask[joint.index()];
            }
        }
        row.into_iter().collect()
    }

    /// Where translations and scales begin, and whose they are.
    pub(super) fn vector_runs(&self) -> [(usize, &[JointIndex]); 2] {
        [(self.translation_start() * LANES, &self.translations), (self.scale_start() * LANES, &self.scales)]
    }

    pub(super) fn row(&self, moment: impl Fn(JointIndex) -> Moment) -> Vec<Row> {
        let mut row = vec![[0.0; LANES]; self.width()];
        let numbers = row.as_flattened_mut();
        for (slot, joint) in self.rotations.iter().enumerate() {
            for (part, value) in moment(*joint).rotation.to_array().into_iter().enumerate() {
                numbers[rotation_place(slot, part)] = value;
            }
        }
        for (kind, (start, joints)) in self.vector_runs().into_iter().enumerate() {
            for (slot, joint) in joints.iter().enumerate() {
                let moment = moment(*joint);
                let value = if kind == 0 { moment.translation } else { moment.scale };
                for (part, value) in value.to_array().into_iter().enumerate() {
                    numbers[start + part * joints.len() + slot] = value;
                }
            }
        }
        row
    }

    /// The vectors of a row that rows of 16 bits hold, in order.
    pub(super) fn stored(&self, parts: usize) -> impl Iterator<Item = usize> {
        let rotations = (0..self.tiles()).flat_map(move |tile| (0..parts).map(move |part| 4 * tile + part));
        rotations.chain(self.translation_start()..self.width())
    }
}

/// Place of one part of a rotation among the numbers of a row.
pub(super) fn rotation_place(slot: usize, part: usize) -> usize {
    (4 * (slot / LANES) + part) * LANES + slot % LANES
}

impl Moment {
    pub(super) fn new(frames: &Frames, joint: JointIndex, local: JointTransform, is_difference: bool) -> Self {
        let rotation =
            if is_difference { frames.own_turn(joint, local.rotation) } else { frames.rotation(joint, local.rotation) };
        Self { rotation, translation: frames.translation(joint, local.translation), scale: local.scale }
    }
}
