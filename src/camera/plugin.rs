//! Runs the camera: takes its input, follows the target, keeps out of walls, writes the camera's [`Transform`].

use bevy::{camera::CameraUpdateSystems, prelude::*, transform::TransformSystems};

use super::{
    collision::{Obstacles, shortened},
    config::OrbitCameraConfig,
    orbit::{CameraInput, OrbitCamera, OrbitCameraState},
};

/// Sets of the camera's systems.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CameraSystems {
    /// Every [`OrbitCamera`] moves, in `PostUpdate` before transforms propagate, by its target's transform of this frame.
    Follow,
}

/// Moves every [`OrbitCamera`].
pub struct CameraPlugin;

impl Plugin for CameraPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<OrbitCamera>()
            .register_type::<OrbitCameraConfig>()
            .register_type::<CameraInput>()
            .configure_sets(
                PostUpdate,
                CameraSystems::Follow.before(TransformSystems::Propagate).before(CameraUpdateSystems),
            )
            .add_systems(PostUpdate, follow.in_set(CameraSystems::Follow));
    }
}

fn follow(
    time: Res<Time>,
    obstacles: Obstacles,
    targets: Query<(&Transform, Option<&ChildOf>), Without<OrbitCamera>>,
    mut cameras: Query<(
        &mut OrbitCamera,
        &OrbitCameraConfig,
        &mut OrbitCameraState,
        &mut CameraInput,
        &mut Transform,
        Option<&mut Projection>,
    )>,
) {
    let dt = time.delta_secs();
    for (mut camera, config, mut state, mut input, mut place, projection) in &mut cameras {
        camera.steer(core::mem::take(&mut *input), config);
        let Some(target) = position(camera.target, &targets) else { continue };
        let arm = state.advance(&camera, config, target, dt);
        let room = obstacles.room(&arm, camera.target, config);
        state.shortened = shortened(state.shortened, arm.length, room.free, config.ease_out_half_life, dt);
        let eye = room.root + arm.rotation * Vec3::Z * (arm.length - state.shortened);
        let lift = obstacles.lift(eye, camera.target, config);
        *place = Transform::from_translation(eye + Vec3::Y * lift).with_rotation(arm.rotation);
        if let Some(Projection::Perspective(lens)) = projection.map(Mut::into_inner) {
            lens.fov = state.field_of_view;
        }
    }
}

/// World position by this frame's transforms, which `GlobalTransform` does not hold yet; `None` where it is not a finite place.
fn position(entity: Entity, targets: &Query<(&Transform, Option<&ChildOf>), Without<OrbitCamera>>) -> Option<Vec3> {
    let (place, mut parent) = targets.get(entity).ok()?;
    let mut at = place.translation;
    while let Some(child_of) = parent {
        let (place, above) = targets.get(child_of.parent()).ok()?;
        at = place.transform_point(at);
        parent = above;
    }
    at.is_finite().then_some(at)
}
