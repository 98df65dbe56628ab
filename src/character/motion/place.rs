//! Writes moved bodies back into the world: transforms, avian's own copies of them, and pushes.

use avian3d::prelude::{Collider, Forces, LinearVelocity, Position, Rotation, WriteRigidBodyForces};
use bevy::prelude::*;
use bevy_transform_interpolation::{RotationEasingState, TranslationEasingState};

use super::{
    MotionState,
    body::MotionBody,
    capsule::{KnownShapes, MotionShapes},
};
use crate::{math::rotation::from_scaled_axis, rig::tuning::motion::MotionConfig};

/// Rebuilds the shapes of characters whose tuning changed.
pub(super) fn build_shapes(
    mut known: Local<KnownShapes>,
    mut characters: Query<(Entity, &MotionConfig, &mut MotionShapes, &mut MotionBody), Changed<MotionConfig>>,
) {
    for (entity, config, mut shapes, mut body) in &mut characters {
        if let Some(problem) = config.problem() {
            warn!("MotionConfig of character {entity}: {problem}; the nearest that works is used");
        }
        *shapes = known.of(config);
        body.reshaped = true;
        body.checks = body.checks.max(2);
    }
}

/// Stops the easing of roots that someone moved since the last frame, before the easing puts them back.
pub(super) fn heed_moved_roots(
    mut characters: Query<
        (&MotionBody, &Transform, &mut TranslationEasingState, &mut RotationEasingState),
        Changed<Transform>,
    >,
) {
    characters.par_iter_mut().for_each(|(body, transform, mut translation, mut rotation)| {
        // What is not finite is left to the easing, which puts the last place back.
        if transform.is_finite() && body.shown.is_some_and(|shown| shown != *transform) {
            *translation = TranslationEasingState::default();
            *rotation = RotationEasingState::default();
        }
    });
}

/// Remembers what the frame shows.
pub(super) fn remember_shown_roots(mut characters: Query<(&mut MotionBody, &Transform), Changed<Transform>>) {
    characters.par_iter_mut().for_each(|(mut body, transform)| body.shown = Some(*transform));
}

/// Roots go where the bodies are.
pub(super) fn place_roots(
    mut characters: Query<(
        &mut MotionBody,
        &MotionState,
        &MotionShapes,
        &mut Transform,
        &mut Position,
        &mut Rotation,
        &mut LinearVelocity,
        &mut Collider,
        &mut TranslationEasingState,
    )>,
) {
    characters.par_iter_mut().for_each(|parts| {
        let (
            mut body,
            state,
            shapes,
            mut transform,
            mut position,
            mut rotation,
            mut velocity,
            mut collider,
            mut easing,
        ) = parts;
        if !core::mem::take(&mut body.moved) && !body.reshaped {
            return;
        }
        if body.jumped_place {
            // Shown where it is now, not on a way there.
            easing.start = None;
        }
        let (root, facing) = (body.root(), from_scaled_axis(Vec3::Y * body.yaw.value));
        let moved = transform.translation != root || transform.rotation != facing || position.0 != root;
        if moved {
            transform.translation = root;
            transform.rotation = facing;
            // Written as well, since avian takes over a turned transform only from a tenth of a degree on.
            position.0 = root;
            rotation.0 = facing;
        }
        if velocity.0 != state.velocity {
            velocity.0 = state.velocity;
        }
        if body.reshaped {
            body.reshaped = false;
            *collider = shapes.posture(body.crouched).whole.clone();
        }
    });
}

/// Dynamic bodies get the impulses of this tick, in the order of the characters.
pub(super) fn push_bodies(characters: Query<&MotionBody>, mut bodies: Query<Forces, Without<MotionBody>>) {
    for push in characters.iter().flat_map(|body| &body.pushes) {
        if let Ok(mut forces) = bodies.get_mut(push.body) {
            forces.apply_linear_impulse_at_point(push.impulse, push.point);
        }
    }
}
