//! A rig made fit for legs that are turned joint by joint: feet hang below their shins, no joint's space is a mirror image.
//!
//! Nothing seen changes: every vertex is where it was in every pose.

use std::sync::Arc;

use bevy::math::{Affine3A, Vec3, Vec3A, bounding::Aabb3d};

use super::{
    Rig,
    humanoid::{Humanoid, HumanoidRole as Role},
};
use crate::anim::{
    pose::Pose,
    skeleton::{JointIndex, JointTransform, Skeleton},
};

/// Turns the mirror image of a joint's space right side out, and back.
const MIRROR: Affine3A =
    Affine3A { matrix3: bevy::math::Mat3A::from_cols(Vec3A::NEG_X, Vec3A::Y, Vec3A::Z), translation: Vec3A::ZERO };

/// How the new skeleton comes out of the old one.
struct Change {
    /// New number of each old joint.
    new: Vec<JointIndex>,
    /// By old joint: its parent from now on, as an old joint.
    parents: Vec<Option<JointIndex>>,
    /// By old joint: whether its space is turned right side out.
    mirrored: Vec<bool>,
    /// By old joint: whether its local transform is another than before.
    changed: Vec<bool>,
}

impl Rig {
    /// The rig with feet below their shins and without mirrored spaces; `None` when it is like that already.
    pub(super) fn straightened(&self, humanoid: &Humanoid) -> Option<Self> {
        let change = Change::of(self, humanoid)?;
        let skeleton = change.skeleton(&self.skeleton);
        let new = |joint: JointIndex| change.new[joint.index()];
        let mut rig = self.clone();
        for skin in &mut rig.skins {
            for (joint, inverse_bind) in skin.joints.iter_mut().zip(&mut skin.inverse_bind) {
                if change.mirrored[joint.index()] {
                    *inverse_bind = (MIRROR * inverse_bind.to_affine()).into();
                }
                *joint = new(*joint);
            }
        }
        for mesh in &mut rig.meshes {
            mesh.joint = new(mesh.joint);
        }
        for joint in rig.node_joints.iter_mut().flatten() {
            *joint = new(*joint);
        }
        for (_, joint) in &mut rig.told_roles {
            *joint = new(*joint);
        }
        for joint in self.skeleton.joints() {
            let (old, place) = (joint.index(), new(joint).index());
            let mirrored = change.mirrored[old];
            let flip = |v: &Vec3| if mirrored { Vec3::new(-v.x, v.y, v.z) } else { *v };
            rig.joint_bounds[place] = self.joint_bounds[old].map(|bounds| mirror_box(bounds, mirrored));
            rig.dominated[place] = self.dominated[old].iter().map(flip).collect();
        }
        let mut whole = vec![Affine3A::IDENTITY; self.skeleton.len()];
        rig.clips = self
            .clips
            .iter()
            .map(|clip| {
                let moved = clip.rebuilt(
                    &self.skeleton,
                    &skeleton,
                    |node| Some(new(node)),
                    |pose, out| {
                        change.write(&self.skeleton, pose, &mut whole, |joint, local| out[joint.index()] = local);
                    },
                );
                Arc::new(moved)
            })
            .collect();
        rig.skeleton = skeleton;
        Some(rig)
    }
}

impl Change {
    fn of(rig: &Rig, humanoid: &Humanoid) -> Option<Self> {
        let skeleton = &rig.skeleton;
        let rest = Pose::rest(skeleton);
        // A mesh without a skin is drawn by its joint's matrix, mirror and all.
        let rigid = |joint: JointIndex| rig.meshes.iter().any(|mesh| mesh.skin.is_none() && mesh.joint == joint);
        let inside_out = |joint: &JointIndex| rest.model(*joint).matrix3.determinant() < 0.0 && !rigid(*joint);
        let mirrored: Vec<bool> = skeleton.joints().map(|joint| inside_out(&joint)).collect();
        let mut parents = skeleton.parents().to_vec();
        for (lower, foot) in [(Role::LeftLowerLeg, Role::LeftFoot), (Role::RightLowerLeg, Role::RightFoot)] {
            if let (Some(lower), Some(foot)) = (humanoid.get(lower), humanoid.get(foot))
                && !skeleton.is_below(foot, lower)
                && !skeleton.is_below(lower, foot)
            {
                parents[foot.index()] = Some(lower);
            }
        }
        let changed: Vec<bool> = skeleton
            .joints()
            .map(|joint| {
                let parent = parents[joint.index()];
                let mirrors = mirrored[joint.index()] || parent.is_some_and(|parent| mirrored[parent.index()]);
                mirrors || parent != skeleton.parent(joint)
            })
            .collect();
        if !changed.contains(&true) {
            return None;
        }
        let mut new = vec![JointIndex::default(); skeleton.len()];
        let mut open: Vec<JointIndex> = skeleton.joints().filter(|joint| parents[joint.index()].is_none()).collect();
        open.reverse();
        let mut next = 0u16;
        while let Some(joint) = open.pop() {
            new[joint.index()] = JointIndex(next);
            next += 1;
            let children: Vec<_> = skeleton.joints().filter(|child| parents[child.index()] == Some(joint)).collect();
            open.extend(children.into_iter().rev());
        }
        Some(Self { new, parents, mirrored, changed })
    }

    fn skeleton(&self, old: &Skeleton) -> Skeleton {
        let mut joints = vec![(String::new(), None, JointTransform::IDENTITY); old.len()];
        for joint in old.joints() {
            let parent = self.parents[joint.index()].map(|parent| self.new[parent.index()]);
            joints[self.new[joint.index()].index()] = (old.name(joint).to_owned(), parent, JointTransform::IDENTITY);
        }
        let mut whole = vec![Affine3A::IDENTITY; old.len()];
        self.write(old, &Pose::rest(old), &mut whole, |joint, local| joints[joint.index()].2 = local);
        Skeleton::new(joints, old.model_from_root).unwrap_or_else(|_| old.clone())
    }

    /// Gives each new joint its local transform in `pose` of the old skeleton; `whole` is space for one matrix a joint.
    fn write(
        &self,
        old: &Skeleton,
        pose: &Pose,
        whole: &mut [Affine3A],
        mut give: impl FnMut(JointIndex, JointTransform),
    ) {
        for joint in old.joints() {
            let matrix = pose.model(joint);
            whole[joint.index()] = if self.mirrored[joint.index()] { matrix * MIRROR } else { matrix };
        }
        for joint in old.joints() {
            let mut local = pose.local(joint);
            if self.changed[joint.index()] {
                let above = self.parents[joint.index()].map_or(old.model_from_root, |parent| whole[parent.index()]);
                let matrix = above.inverse() * whole[joint.index()];
                let (scale, rotation, translation) = matrix.to_scale_rotation_translation();
                if rotation.is_finite() && translation.is_finite() {
                    local = JointTransform { translation, rotation, scale };
                }
            }
            give(self.new[joint.index()], local);
        }
    }
}

fn mirror_box(bounds: Aabb3d, mirrored: bool) -> Aabb3d {
    if !mirrored {
        return bounds;
    }
    let (mut min, mut max) = (bounds.min, bounds.max);
    (min.x, max.x) = (-max.x, -min.x);
    Aabb3d { min, max }
}
