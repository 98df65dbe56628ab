//! A clip of one skeleton played by another: same parts of a body, other joint axes, other lengths, another rest pose.
//!
//! Turns are taken against the rest pose, in model space, joint by joint; what the two rest postures differ by (arms out or
//! down) is made up for by [`Part::offset`]. The pelvis goes as far as the legs are long, and the legs are then put by IK so
//! that each sole is as high as the source's and its ball goes the same way, scaled: contacts stay contacts. Where feet of other
//! proportions would have a leg stretch farther than the source's, the pelvis is lower throughout the clip.

use bevy::math::{Quat, Vec3};

use super::{
    clip::Clip,
    ik::two_bone::{self, Extension, Limb},
    leg::Leg,
    pose::Pose,
    skeleton::{JointIndex, Skeleton},
};
use crate::math::rotation::twist_about;

/// Extension from which legs resist, and the most they reach, where the source's doesn't reach farther.
const EXTENSION: Extension = Extension { soft: 0.97, hard: 0.99 };

/// Share of the leg's length by which a pelvis is lower than its source's at most.
const LOWEST: f32 = 0.05;

/// A joint that follows joints of another skeleton.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// The joint that is turned.
    pub to: JointIndex,
    /// Joints of the source; the turn lies between theirs.
    pub from: [JointIndex; 2],
    /// How far between: 0 as the first, 1 as the second.
    pub between: f32,
    /// The joint of the source against which `amount` counts: what carries the limb. `None`: level ground, for feet, so that
    /// what is flat stays flat.
    pub carrier: Option<JointIndex>,
    /// Share of the turn that is taken, 1 all of it.
    pub amount: f32,
    /// Turn in model space from the joint's rest to where it is when the source rests.
    pub offset: Quat,
}

/// The carrier of a body, by pairs of source and target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pelvis {
    /// Its joint in the source.
    pub from: JointIndex,
    /// Its joint here.
    pub to: JointIndex,
    /// Legs of the source and legs here, where feet shall hold; `[left, right]`.
    pub legs: Option<[[Leg; 2]; 2]>,
}

/// How one skeleton follows another.
#[derive(Clone, Debug)]
pub struct Retarget<'a> {
    /// The source.
    pub from: &'a Skeleton,
    /// Who follows.
    pub to: &'a Skeleton,
    /// Joints that turn.
    pub parts: Vec<Part>,
    /// What moves the body; `None` for what has none.
    pub pelvis: Option<Pelvis>,
    /// Metres here for a metre of the source.
    pub length: f32,
    /// Share of the pelvis' motion against rest that is taken, 1 all of it.
    pub sway: f32,
}

impl Retarget<'_> {
    /// `clip` of the source, for who follows. Scales and the motion of joints without a part are left out.
    #[must_use]
    pub fn clip(&self, clip: &Clip) -> Clip {
        let rests = [Pose::rest(self.from), Pose::rest(self.to)];
        let mut pose = Pose::rest(self.to);
        let lower = self.lower(&rests, clip);
        let partner = |node: JointIndex| self.parts.iter().find(|part| part.from[0] == node).map(|part| part.to);
        let mut moved = clip.rebuilt(self.from, self.to, partner, |source, out| {
            pose.locals_mut().copy_from_slice(out);
            self.follow(&rests, source, lower, &mut pose);
            self.hold(&rests, source, &mut pose);
            out.copy_from_slice(pose.locals());
        });
        moved.ground_speed = clip.ground_speed.map(|speed| speed * self.length);
        moved
    }

    /// Metres by which the pelvis is lower than the source's throughout `clip`, so that legs with other feet stretch no
    /// farther than its do.
    fn lower(&self, rests: &[Pose; 2], clip: &Clip) -> f32 {
        let Some([from, to]) = self.pelvis.and_then(|pelvis| pelvis.legs) else { return 0.0 };
        let (mut source, mut pose) = (rests[0].clone(), rests[1].clone());
        let mut lower = 0.0f32;
        let steps = clip.frame_count().saturating_sub(1).max(1);
        for step in 0..=steps {
            clip.sample_held(self.from, clip.duration * step as f32 / steps as f32, source.locals_mut());
            source.update_model(self.from);
            pose.locals_mut().copy_from_slice(rests[1].locals());
            self.follow(rests, &source, 0.0, &mut pose);
            for (from, to) in from.iter().zip(&to) {
                let down = pose.position(to.upper) - self.ankle(rests, &source, [from, to], &pose);
                let reach = extension(&source, from).soft * to.length();
                let height = (reach * reach - down.with_y(0.0).length_squared()).max(0.0).sqrt();
                lower = lower.max((down.y - height).min(LOWEST * to.length()));
            }
        }
        lower
    }

    /// Puts `pose`, at rest, where `source` has it, the pelvis `lower`, legs not yet on their feet.
    fn follow(&self, rests: &[Pose; 2], source: &Pose, lower: f32, pose: &mut Pose) {
        let [from_rest, to_rest] = rests;
        let turn = |joint: JointIndex| source.rotation(joint) * from_rest.rotation(joint).inverse();
        // Parents come first, so each joint's parent has its place.
        for joint in self.to.joints() {
            let mut local = pose.local(joint);
            if let Some(part) = self.parts.iter().find(|part| part.to == joint) {
                let own = turn(part.from[0]).slerp(turn(part.from[1]), part.between);
                let carrier = part.carrier.map_or_else(|| twist_about(own, Vec3::Y), turn);
                let own = carrier * Quat::IDENTITY.slerp(carrier.inverse() * own, part.amount);
                let rotation = own * part.offset * to_rest.rotation(joint);
                local.rotation = (pose.parent_rotation(self.to, joint).inverse() * rotation).normalize();
            }
            if let Some(pelvis) = self.pelvis.filter(|pelvis| pelvis.to == joint) {
                let way = source.position(pelvis.from) - from_rest.position(pelvis.from);
                let at = to_rest.position(joint) + way * (self.length * self.sway) - Vec3::Y * lower;
                let above = self.to.parent(joint).map_or(self.to.model_from_root, |parent| pose.model(parent));
                local.translation = above.inverse().transform_point3(at);
            }
            pose.set_local(joint, local);
            pose.update_joint(self.to, joint);
        }
    }

    /// Where a foot's ankle has to be so that its ball goes the source's way, scaled, and its sole is as high.
    fn ankle(&self, rests: &[Pose; 2], source: &Pose, [from, to]: [&Leg; 2], pose: &Pose) -> Vec3 {
        let lowest =
            |leg: &Leg, pose: &Pose| leg.sole().map(|point| point.position(pose).y).into_iter().reduce(f32::min);
        let height = |leg: &Leg, pose: &Pose| lowest(leg, pose).unwrap_or_default();
        let [from_rest, to_rest] = rests;
        let mut wanted =
            to.ball.position(to_rest) + (from.ball.position(source) - from.ball.position(from_rest)) * self.length;
        wanted -= to.ball.position(pose);
        wanted.y =
            height(to, to_rest) + (height(from, source) - height(from, from_rest)) * self.length - height(to, pose);
        pose.position(to.foot) + wanted
    }

    /// Puts the legs on their feet.
    fn hold(&self, rests: &[Pose; 2], source: &Pose, pose: &mut Pose) {
        let Some((pelvis, [from, to])) = self.pelvis.and_then(|pelvis| Some((pelvis, pelvis.legs?))) else { return };
        let turn = source.rotation(pelvis.from) * rests[0].rotation(pelvis.from).inverse();
        for (from, to) in from.iter().zip(&to) {
            let ankle = self.ankle(rests, source, [from, to], pose);
            self.put(to, ankle, turn * Vec3::NEG_Z, extension(source, from), pose);
        }
    }

    /// Turns a leg so that its ankle is there, its foot as it is.
    fn put(&self, to: &Leg, ankle: Vec3, forward: Vec3, extension: Extension, pose: &mut Pose) {
        let limb = Limb {
            root: pose.position(to.upper),
            middle: pose.position(to.lower),
            end: pose.position(to.foot),
            pole: forward,
        };
        let solution = two_bone::solve(&limb, ankle, extension);
        let foot_rotation = pose.rotation(to.foot);
        pose.rotate_model(self.to, to.upper, solution.upper_delta);
        let lower = solution.lower_delta * pose.rotation(to.lower);
        pose.update_model_below(self.to, to.upper);
        pose.rotate_model(self.to, to.lower, lower * pose.rotation(to.lower).inverse());
        pose.update_model_below(self.to, to.lower);
        pose.rotate_model(self.to, to.foot, foot_rotation * pose.rotation(to.foot).inverse());
        pose.update_model_below(self.to, to.upper);
    }
}

/// How far a leg stretches that follows `leg` of the source.
fn extension(source: &Pose, leg: &Leg) -> Extension {
    let stretched = (source.position(leg.upper).distance(source.position(leg.foot)) / leg.length()).min(1.0);
    Extension { soft: EXTENSION.soft.max(stretched), hard: EXTENSION.hard.max(stretched) }
}

impl Clip {
    /// The clip for a skeleton that has the same joints under other numbers: `partners` are joints of `from` and of `to`.
    #[must_use]
    pub fn renumbered(&self, from: &Skeleton, to: &Skeleton, partners: &[(JointIndex, JointIndex)]) -> Self {
        let partner = |joint: JointIndex| partners.iter().find(|pair| pair.0 == joint).map(|pair| pair.1);
        self.rebuilt(from, to, partner, |source, out| {
            for &(a, b) in partners {
                out[b.index()] = source.local(a);
            }
        })
    }

    /// The clip `factor` times as long.
    #[must_use]
    pub fn stretched(mut self, factor: f32) -> Self {
        self.duration *= factor;
        self.lead *= factor;
        self.ground_speed = self.ground_speed.map(|speed| speed / factor);
        let frames = &mut self.frames;
        frames.rate /= factor;
        frames.keyed_from *= factor;
        frames.keyed = frames.keyed.drain(..).map(|keys| keys.stretched(factor)).collect();
        frames.keyed_morphs = frames.keyed_morphs.drain(..).map(|keys| keys.stretched(factor)).collect();
        self
    }

    /// The clip with `joint` moved by `by` in its parent's space throughout.
    #[must_use]
    pub fn moved(mut self, skeleton: &Skeleton, joint: JointIndex, by: Vec3) -> Self {
        let frames = &mut self.frames;
        let (width, rotations) = (frames.width(), 4 * frames.rotations.len());
        if let Some(place) = frames.translations.iter().position(|&other| other == joint) {
            for row in frames.rows.chunks_exact_mut(width) {
                let values = &mut row[rotations + 3 * place..][..3];
                values.iter_mut().zip(by.to_array()).for_each(|(value, by)| *value += by);
            }
        } else if let Some(still) = frames.still_translations.iter_mut().find(|still| still.0 == joint) {
            still.1 += by;
        } else {
            frames.still_translations.push((joint, skeleton.rest()[joint.index()].translation + by));
        }
        for keys in frames.keyed.iter_mut().filter(|keys| keys.joint == joint) {
            keys.translation = keys.translation.take().map(|curve| curve.moved(by));
        }
        self
    }
}
