//! A clip of one skeleton played by another: same parts of a body, other joint axes, other lengths.
//!
//! Joints in their parent's space; both skeletons' rest poses count as the same posture (both T, or both A).

use bevy::math::{Quat, Vec3};

use super::{
    clip::{Clip, Frames},
    pose::Pose,
    skeleton::{JointIndex, Skeleton},
};

/// Rest poses whose translations differ by less than this share of a joint's length are the same body.
const SAME: f32 = 0.02;

/// How a joint's motion becomes another's.
struct Change {
    to: JointIndex,
    /// `new = before * old * after` for rotations.
    before: Quat,
    after: Quat,
    /// `new = to_rest + before * (old - from_rest) * length` for translations; `None` keeps the target's bone as it is.
    length: Option<f32>,
    from_rest: Vec3,
    to_rest: Vec3,
}

impl Clip {
    /// The clip for skeleton `to`; `pairs` are joints of `from` and who plays their part in `to`.
    ///
    /// Turns are taken relative to each rest pose, in model space. Joints that carry the whole body (`movers` of `to`:
    /// hips and what is above) move by `length` times as far, others keep the lengths of their own skeleton unless
    /// both skeletons have the same. Motion of joints without a partner, scales aside, is left out.
    #[must_use]
    pub fn retargeted(
        &self,
        from: &Skeleton,
        to: &Skeleton,
        pairs: &[(JointIndex, JointIndex)],
        movers: &[JointIndex],
        length: f32,
    ) -> Self {
        let (from_rest, to_rest) = (Pose::rest(from), Pose::rest(to));
        let scale_of = |skeleton: &Skeleton, pose: &Pose, joint: JointIndex| {
            let above = skeleton.parent(joint).map_or(skeleton.model_from_root, |parent| pose.model(parent));
            above.x_axis.length().max(f32::MIN_POSITIVE)
        };
        let same = pairs.iter().all(|&(a, b)| {
            let (a, b) = (from.rest()[a.index()].translation, to.rest()[b.index()].translation);
            a.distance(b) <= SAME * a.length().max(b.length()) + 1e-4
        });
        let change = |joint: JointIndex| {
            let to_joint = pairs.iter().find(|pair| pair.0 == joint)?.1;
            let (a, b) = (from.rest()[joint.index()], to.rest()[to_joint.index()]);
            let before = to_rest.parent_rotation(to, to_joint).inverse() * from_rest.parent_rotation(from, joint);
            let units = scale_of(from, &from_rest, joint) / scale_of(to, &to_rest, to_joint);
            Some(Change {
                to: to_joint,
                before,
                after: a.rotation.inverse() * before.inverse() * b.rotation,
                length: if same || movers.contains(&to_joint) { Some(length * units) } else { None },
                from_rest: a.translation,
                to_rest: b.translation,
            })
        };
        let mut clip = Self { frames: self.frames.changed(change), ..self.clone() };
        clip.report.bytes = clip.frames.bytes();
        clip
    }
}

impl Change {
    fn rotation(&self, old: Quat) -> Quat {
        (self.before * old * self.after).normalize()
    }

    fn translation(&self, old: Vec3, length: f32) -> Vec3 {
        self.to_rest + self.before * (old - self.from_rest) * length
    }
}

impl Frames {
    /// Bytes of rows and constants.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.rows.as_slice())
            + size_of_val(self.still_rotations.as_slice())
            + size_of_val(self.still_translations.as_slice())
            + size_of_val(self.still_scales.as_slice())
    }

    /// Rows and constants with every joint changed, or left out where there is no change.
    fn changed(&self, change: impl Fn(JointIndex) -> Option<Change>) -> Self {
        let mut frames = Self { rate: self.rate, count: self.count, ..Self::default() };
        for &(joint, rotation) in &self.still_rotations {
            if let Some(change) = change(joint) {
                frames.still_rotations.push((change.to, change.rotation(rotation)));
            }
        }
        for &(joint, translation) in &self.still_translations {
            if let Some(change) = change(joint)
                && let Some(length) = change.length
            {
                frames.still_translations.push((change.to, change.translation(translation, length)));
            }
        }
        // (start in the old row, change): what is kept of each row, in order.
        let mut rotations = Vec::new();
        let mut translations = Vec::new();
        for (place, &joint) in self.rotations.iter().enumerate() {
            rotations.extend(change(joint).map(|change| (4 * place, change)));
        }
        let start = 4 * self.rotations.len();
        for (place, &joint) in self.translations.iter().enumerate() {
            let change = change(joint).filter(|change| change.length.is_some());
            translations.extend(change.map(|change| (start + 3 * place, change)));
        }
        frames.rotations = rotations.iter().map(|(_, change)| change.to).collect();
        frames.translations = translations.iter().map(|(_, change)| change.to).collect();
        let width = self.width();
        for row in self.rows.chunks_exact(width.max(1)).take(self.count) {
            for (start, change) in &rotations {
                let rotation = change.rotation(Quat::from_slice(&row[*start..start + 4]));
                frames.rows.extend_from_slice(&rotation.to_array());
            }
            for (start, change) in &translations {
                let old = Vec3::from_slice(&row[*start..start + 3]);
                frames.rows.extend(change.translation(old, change.length.unwrap_or(1.0)).to_array());
            }
        }
        frames
    }
}
