//! What is recorded of a character in one frame. World space, metres, +Y up.

use bevy::prelude::*;

use super::Peak;

/// One foot in one frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct FootFrame {
    /// Heel, ball and toe tip of the final pose.
    pub sole: [Vec3; 3],
    /// Ground height below each of them; `None` over an abyss.
    pub ground: [Option<f32>; 3],
    /// How far the ground below each of them moved since the last frame.
    pub carried: [Vec3; 3],
    /// The ball in the frame of the ground that it is planted on, while it is planted on the ball.
    pub planted_ball: Option<Vec3>,
    /// Whether the foot is in stance.
    pub stance: bool,
    /// Metres by which the ankle missed its target; `None` without a target or when the leg can't reach it.
    pub missed: Option<f32>,
    /// Distance from hip to ankle over the leg's length.
    pub extension: f32,
    /// Bend of the knee in radians, negative when bent backward.
    pub knee: f32,
}

impl FootFrame {
    /// Heights of the sole's points over the ground below them, metres; points over an abyss are left out.
    pub fn heights(&self) -> impl Iterator<Item = f32> {
        self.sole.iter().zip(self.ground).filter_map(|(point, ground)| ground.map(|ground| point.y - ground))
    }

    /// Index in `sole` and height of the point that is lowest over its ground.
    #[must_use]
    pub fn lowest(&self) -> Option<(usize, f32)> {
        let heights = self.sole.iter().zip(self.ground).enumerate();
        heights
            .filter_map(|(index, (point, ground))| ground.map(|ground| (index, point.y - ground)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// One frame of one character.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Seconds since the recording began.
    pub time: f32,
    /// Left and right foot.
    pub feet: [FootFrame; 2],
    /// Height of the pelvis joint.
    pub pelvis: f32,
    /// Position of the root.
    pub root: Vec3,
    /// Whether the character stands on ground.
    pub grounded: bool,
    /// Horizontal velocity wanted, m/s.
    pub wanted: Vec3,
    /// Horizontal velocity over the ground, m/s.
    pub velocity: Vec3,
    /// Largest speed of any joint in model space, m/s.
    pub pose_speed: f32,
    /// Largest angular speed of any joint against its parent, rad/s.
    pub joint_speed: f32,
    /// Largest change, since the last frame, of any joint's velocity in model space, m/s.
    pub velocity_jump: f32,
    /// The most of the last two that the playing clips have by themselves.
    pub peak: Peak,
}
