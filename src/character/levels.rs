//! Levels of detail: what is done for characters of which size.
//!
//! Sizes are shares of a view's height. Who follows them is told by [`Detail`].

use bevy::prelude::*;

use super::detail::Detail;

/// What is done for characters of which size.
#[derive(Resource, Reflect, Clone, Debug)]
#[reflect(Resource)]
pub struct DetailLevels {
    /// From the largest on the screen to the smallest.
    ///
    /// Default: a fifth of the view's height or more has everything in every tick; down to a twelfth 32 poses a second; below
    /// that clips alone, without fingers, the controller looking seven times a second; below a fortieth three times, shown 32
    /// times a second, and nothing is stopped by it.
    pub levels: Vec<DetailLevel>,
    /// Share of a level's size by which a character must be smaller to leave it. Default 0.15.
    ///
    /// 0: who stands on the border changes in every frame.
    pub hysteresis: f32,
    /// Metres around a character that must be out of every view, too, before it isn't posed. Default 2.
    ///
    /// Small: shadows that fall into the view stand still. Large: more are posed that nobody sees.
    pub margin: f32,
    /// [`Detail::glide`] in seconds of who is in no view. Default 0.5.
    ///
    /// 0: who isn't seen meets everything as exactly as who is.
    pub unseen_glide: f32,
    /// Most that is seen of a simplified mesh being off, as a share of the view's height. Default 0.001: a pixel of 1,080.
    ///
    /// Large: fewer triangles, and outlines that change from one mesh to the next. 0: everyone is drawn with all triangles.
    pub mesh_error: f32,
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
        let level = |size: f32, detail: Detail| DetailLevel { size, detail };
        let near = Detail { step: 1.0 / 32.0, ..default() };
        let far = Detail { clips_only: true, small_joints: false, glide: 0.15, ..default() };
        let farthest = Detail { step: 1.0 / 32.0, solid: false, glide: 0.3, ..far };
        Self {
            levels: vec![
                level(0.2, Detail::default()),
                level(1.0 / 12.0, near),
                level(1.0 / 40.0, far),
                level(0.0, farthest),
            ],
            hysteresis: 0.15,
            margin: 2.0,
            unseen_glide: 0.5,
            mesh_error: 1e-3,
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

    /// What is done for who is in no view and had `detail` before.
    #[must_use]
    pub fn unseen(&self, detail: Detail) -> Detail {
        Detail { posed: false, solid: false, glide: self.unseen_glide, ..detail }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smaller_the_less_and_the_border_is_crossed_once() {
        let levels = DetailLevels::default();
        let sizes = [0.9, 0.19, 0.1, 0.05, 0.01];
        let got = sizes.map(|size| levels.level(size, usize::MAX));
        assert_eq!(got, [0, 1, 1, 2, 3], "levels of {sizes:?}");
        assert_eq!((levels.level(0.19, 0), levels.level(0.16, 0)), (0, 1), "down only once it is 15 % smaller");
        assert_eq!(levels.level(0.2, 1), 0, "up at once");
    }
}
