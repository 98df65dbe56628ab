//! Level of detail by size on the screen: writes [`Detail`] of those that carry a [`ScreenDetail`].
//!
//! Reads where the cameras were in the last frame and where characters are now. World space; sizes are shares of the view's
//! height. Nobody has a [`ScreenDetail`] unless told: the player's own character is seen near and keeps every frame.

use bevy::{
    camera::primitives::{Frustum, Sphere},
    prelude::*,
};

use crate::character::detail::Detail;

/// Goes on a character whose [`Detail`] shall follow its size on the screen.
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

/// What is done for characters of which size.
#[derive(Resource, Reflect, Clone, Debug)]
#[reflect(Resource)]
pub struct DetailLevels {
    /// From the largest on the screen to the smallest.
    ///
    /// Default: a fifth of the view's height or more has everything in every frame; down to a twelfth 30 poses a second; below as
    /// many without feet and look.
    pub levels: Vec<DetailLevel>,
    /// Share of a level's size by which a character must be smaller to leave it. Default 0.15.
    ///
    /// 0: who stands on the border changes in every frame.
    pub hysteresis: f32,
    /// Metres around a character that must be out of every view, too, before it isn't posed. Default 2.
    ///
    /// Small: shadows that fall into the view stand still. Large: more are posed that nobody sees.
    pub margin: f32,
}

/// One level.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub struct DetailLevel {
    /// Share of the view's height that a character of this level has at least.
    pub size: f32,
    /// What is done for it.
    pub detail: Detail,
}

impl Default for DetailLevels {
    fn default() -> Self {
        let level = |size: f32, step: f32, close: bool| DetailLevel {
            size,
            detail: Detail { step, feet: close, look: close, posed: true },
        };
        Self {
            levels: vec![level(0.2, 0.0, true), level(1.0 / 12.0, 1.0 / 30.0, true), level(0.0, 1.0 / 30.0, false)],
            hysteresis: 0.15,
            margin: 2.0,
        }
    }
}

impl DetailLevels {
    /// The level of a character of this size that has been on level `now`.
    #[must_use]
    pub fn level(&self, size: f32, now: usize) -> usize {
        let least = |level: &DetailLevel, index: usize| {
            if index == now { level.size * (1.0 - self.hysteresis) } else { level.size }
        };
        let found = self.levels.iter().enumerate().position(|(index, level)| size >= least(level, index));
        found.unwrap_or(self.levels.len().saturating_sub(1))
    }
}

/// Sets [`Detail`] by size on the screen.
pub(super) fn plugin(app: &mut App) {
    app.init_resource::<DetailLevels>()
        .register_type::<ScreenDetail>()
        .register_type::<DetailLevels>()
        .add_systems(PostUpdate, choose);
}

fn choose(
    levels: Res<DetailLevels>,
    cameras: Query<(&Camera, &GlobalTransform, &Frustum)>,
    mut characters: Query<(&Transform, &mut ScreenDetail, &mut Detail)>,
) {
    if levels.levels.is_empty() || cameras.is_empty() {
        return;
    }
    characters.par_iter_mut().for_each(|(root, mut screen, mut detail)| {
        let middle = root.translation + Vec3::Y * (0.5 * screen.height);
        let sphere = Sphere { center: middle.into(), radius: screen.height + levels.margin };
        let views =
            cameras.iter().filter(|(camera, _, frustum)| camera.is_active && frustum.intersects_sphere(&sphere, true));
        let largest = views.map(|(camera, view, _)| size_in(camera, view, middle, screen.height)).reduce(f32::max);
        let wanted = match largest {
            None => Detail { posed: false, ..*detail },
            Some(size) => {
                let level = levels.level(size, screen.level);
                if level != screen.level {
                    screen.level = level;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smaller_the_less_and_the_border_is_crossed_once() {
        let levels = DetailLevels::default();
        let sizes = [0.9, 0.19, 0.1, 0.05, 0.01];
        let got = sizes.map(|size| levels.level(size, usize::MAX));
        assert_eq!(got, [0, 1, 1, 2, 2], "levels of {sizes:?}");
        assert_eq!((levels.level(0.19, 0), levels.level(0.16, 0)), (0, 1), "down only once it is 15 % smaller");
        assert_eq!(levels.level(0.2, 1), 0, "up at once");
    }
}
