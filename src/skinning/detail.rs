//! Level of detail by size on the screen: writes [`Detail`] and [`MeshLevels`] of those that carry a [`ScreenDetail`].
//!
//! Reads where the cameras were in the last frame and where characters are now. World space; sizes are shares of the view's
//! height. Nobody has a [`ScreenDetail`] unless told: the player's own character is seen near and keeps every frame.

use bevy::{
    camera::primitives::{Frustum, Sphere},
    prelude::*,
};

use super::mesh_levels::MeshLevels;
use crate::character::{detail::Detail, levels::DetailLevels};

/// Goes on a character whose [`Detail`] shall follow its size on the screen, and what it is drawn with, too: [`MeshLevels`].
#[derive(Component, Reflect, Clone, Copy, Debug)]
#[reflect(Component)]
#[require(Detail)]
pub struct ScreenDetail {
    /// Its height in metres. Default 1.8.
    pub height: f32,
    /// Index of its level in [`DetailLevels`].
    pub level: usize,
}

impl Default for ScreenDetail {
    fn default() -> Self {
        Self { height: 1.8, level: 0 }
    }
}

/// Sets [`Detail`] by size on the screen.
pub(super) fn plugin(app: &mut App) {
    app.init_resource::<DetailLevels>()
        .register_type::<ScreenDetail>()
        .register_type::<DetailLevels>()
        .add_systems(PostUpdate, choose);
}

pub(super) fn choose(
    levels: Res<DetailLevels>,
    cameras: Query<(&Camera, &GlobalTransform, &Frustum)>,
    mut characters: Query<(&Transform, &mut ScreenDetail, &mut Detail, Option<&mut MeshLevels>)>,
) {
    if levels.levels.is_empty() || cameras.is_empty() {
        return;
    }
    characters.par_iter_mut().for_each(|(root, mut screen, mut detail, meshes)| {
        let middle = root.translation + Vec3::Y * (0.5 * screen.height);
        let sphere = Sphere { center: middle.into(), radius: screen.height + levels.margin };
        let views =
            cameras.iter().filter(|(camera, _, frustum)| camera.is_active && frustum.intersects_sphere(&sphere, true));
        let largest = views.map(|(camera, view, _)| size_in(camera, view, middle, screen.height)).reduce(f32::max);
        let wanted = match largest {
            None => levels.unseen(*detail),
            Some(size) => {
                let level = levels.level(size, screen.level);
                if level != screen.level {
                    screen.level = level;
                }
                if let Some(mut meshes) = meshes {
                    let level = meshes.wanted(size, levels.mesh_error, levels.hysteresis);
                    if level != meshes.level() {
                        meshes.set(level);
                    }
                }
                levels.levels[level].detail
            }
        };
        detail.set_if_neq(wanted);
    });
}

/// Share of the view's height of what is `height` metres tall; what the camera stands in is infinitely large.
fn size_in(camera: &Camera, view: &GlobalTransform, place: Vec3, height: f32) -> f32 {
    let clip_from_view = camera.clip_from_view();
    let in_view = view.affine().inverse().transform_point3(place);
    let w = (clip_from_view * in_view.extend(1.0)).w;
    if w <= 0.0 { f32::INFINITY } else { 0.5 * height * clip_from_view.y_axis.y / w }
}
