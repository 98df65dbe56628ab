//! Sockets: entities that ride on a joint, in the frame of the pose itself.
//!
//! Reads the final pose; writes the [`Transform`] of what is attached, in the space of the character that it is a child of,
//! before transforms propagate. So it moves, hides and vanishes with the character, and never lags behind.

use std::sync::Arc;

use bevy::{math::Affine3A, prelude::*};

use super::{Character, animator::CharacterPose, bind::CharacterAssets, crowd::PoseRead, schedule::PoseSystems};
use crate::{
    anim::{
        pose::Pose,
        skeleton::{JointIndex, Skeleton},
    },
    rig::joint_ref::JointRef,
};

/// Makes a child of a [`Character`] ride on one of its joints.
///
/// Give a character that carries what is drawn a `Visibility` from the start: it gets one of its own only with its model.
/// To let it go, take its `ChildOf` away (`remove_parent_in_place` leaves it where it is).
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[require(Transform, Socket)]
pub struct Attach {
    /// The joint.
    pub joint: JointRef,
    /// Where it sits on the joint: metres along the joint's axes, whatever the model's unit. A joint that is scaled by
    /// animation scales what it carries.
    pub offset: Transform,
}

impl Attach {
    /// Rides on the joint itself.
    #[must_use]
    pub fn to(joint: impl Into<JointRef>) -> Self {
        Self { joint: joint.into(), offset: Transform::IDENTITY }
    }

    /// The same, off the joint.
    #[must_use]
    pub fn at(self, offset: Transform) -> Self {
        Self { offset, ..self }
    }
}

/// The joint that an [`Attach`] names, looked up.
#[derive(Component, Clone, Debug, Default)]
pub struct Socket {
    joint: Option<Seat>,
    /// The skeleton that was searched.
    skeleton: Option<Arc<Skeleton>>,
}

#[derive(Clone, Copy, Debug)]
struct Seat {
    joint: JointIndex,
    /// Takes the scale out that the model has at rest.
    metres: Vec3,
}

/// Carries what is attached.
pub struct AttachPlugin;

impl Plugin for AttachPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, carry.in_set(PoseSystems::Attach));
    }
}

fn carry(
    assets: CharacterAssets,
    mut riders: Query<(Entity, Ref<Attach>, &ChildOf, &mut Socket, &mut Transform)>,
    characters: Query<(&Character, &CharacterPose, Has<PoseRead>)>,
    mut commands: Commands,
) {
    for (entity, attach, parent, mut socket, mut transform) in &mut riders {
        let Ok((character, pose, read)) = characters.get(parent.parent()) else { continue };
        if !read {
            commands.entity(parent.parent()).try_insert(PoseRead);
        }
        let Some(asset) = assets.get(character) else { continue };
        let known = socket.skeleton.as_ref().is_some_and(|skeleton| Arc::ptr_eq(skeleton, &asset.skeleton));
        if !known || attach.is_changed() {
            socket.skeleton = Some(Arc::clone(&asset.skeleton));
            socket.joint = match attach.joint.find(asset) {
                Ok(joint) => Some(Seat::new(&asset.skeleton, joint)),
                Err(error) => {
                    error!("{entity} can't be attached to {}: {error}", asset.file.model);
                    None
                }
            };
        }
        if let Some(seat) = socket.joint {
            transform.set_if_neq(seat.place(&pose.pose, &attach.offset));
        }
    }
}

impl Seat {
    fn new(skeleton: &Skeleton, joint: JointIndex) -> Self {
        let scale = Pose::rest(skeleton).model(joint).to_scale_rotation_translation().0;
        let metres = 1.0 / scale;
        Self { joint, metres: if metres.is_finite() { metres } else { Vec3::ONE } }
    }

    /// Where the rider is in model space.
    fn place(&self, pose: &Pose, offset: &Transform) -> Transform {
        let seat = pose.model(self.joint) * Affine3A::from_scale(self.metres);
        let (scale, rotation, translation) = (seat * offset.compute_affine()).to_scale_rotation_translation();
        Transform { translation, rotation, scale }
    }
}
