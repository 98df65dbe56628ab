//! A clip made anew for another skeleton, frame by frame.

use super::{ClipCurves, JointCurves, MorphCurves};
use crate::anim::{
    clip::Clip,
    curve::{Curve, CurveValue, Interpolation},
    pose::Pose,
    skeleton::{JointIndex, JointTransform, Skeleton},
};

impl Clip {
    /// The clip for skeleton `to`: `write` makes, of each frame's pose of `from`, the local transforms of `to`, which come at
    /// rest. Morph weights move over to what `partner` says of their nodes.
    #[must_use]
    pub fn rebuilt(
        &self,
        from: &Skeleton,
        to: &Skeleton,
        partner: impl Fn(JointIndex) -> Option<JointIndex>,
        mut write: impl FnMut(&Pose, &mut [JointTransform]),
    ) -> Self {
        let count = self.frame_count().max(1);
        let times: Vec<f32> =
            (0..count).map(|frame| self.duration * frame as f32 / (count - 1).max(1) as f32).collect();
        let mut pose = Pose::rest(from);
        let mut frames = Vec::with_capacity(count);
        for &time in &times {
            self.sample_held(from, time, pose.locals_mut());
            pose.update_model(from);
            let mut locals = to.rest().to_vec();
            write(&pose, &mut locals);
            frames.push(locals);
        }
        let joints = to.joints().map(|joint| {
            let of = |frame: &Vec<JointTransform>| frame[joint.index()];
            JointCurves {
                joint,
                rotation: curve(&times, frames.iter().map(|frame| of(frame).rotation)),
                translation: curve(&times, frames.iter().map(|frame| of(frame).translation)),
                scale: curve(&times, frames.iter().map(|frame| of(frame).scale)),
            }
        });
        let curves = ClipCurves {
            name: self.name.clone(),
            looping: Some(self.looping),
            ground_speed: self.ground_speed,
            joints: joints.collect(),
            morphs: self.morph_curves(&times, partner),
        };
        let baked = curves.bake_at(to, self.frame_rate());
        Self { speed: self.speed, lead: self.lead, ..baked }
    }

    fn morph_curves(&self, times: &[f32], partner: impl Fn(JointIndex) -> Option<JointIndex>) -> Vec<MorphCurves> {
        let of_node = |&(node, count): &(JointIndex, usize)| {
            let mut weights = vec![0.0; count];
            let mut tracks = vec![Vec::with_capacity(times.len()); count];
            for &time in times {
                self.morph_weights(node, time, &mut weights);
                tracks.iter_mut().zip(&weights).for_each(|(track, &weight)| track.push(weight));
            }
            let weights = tracks.into_iter().filter_map(|track| curve(times, track.into_iter())).collect();
            Some(MorphCurves { node: partner(node)?, weights })
        };
        self.frames.morphs.iter().filter_map(of_node).collect()
    }
}

/// Numbers without end or none at all give no curve: the joint stays at rest.
fn curve<T: CurveValue>(times: &[f32], values: impl Iterator<Item = T>) -> Option<Curve<T>> {
    Curve::new(times.to_vec(), values.collect(), Interpolation::Linear).ok()
}
