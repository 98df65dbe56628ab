//! What a viewer sees of a character in one frame: its pose, and what holds its feet.

use bevy::prelude::*;

use crate::{
    anim::{ik::two_bone::bend_angle, leg::Leg, pose::Pose},
    character::{
        animator::Actions,
        foot_ik::{FootIk, Pivot},
        locomotion::Locomotion,
        sole::sole_model,
    },
    rig::character::CharacterAsset,
};

/// What holds a foot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Hold {
    /// Nothing: it swings.
    #[default]
    Free,
    /// It stands, but its ball doesn't yet, or no longer.
    Stance,
    /// Its ball stands on this ground; `None` on whatever lies below it.
    Ball(Option<Entity>),
}

/// What a tick did with the feet.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ticked {
    pub(super) grounded: bool,
    pub(super) holds: [Hold; 2],
    pub(super) missed: [Option<f32>; 2],
}

impl Ticked {
    /// What holds between two ticks: a foot that comes down or lifts off in either isn't held.
    pub(super) fn between([last, now]: &[Self; 2]) -> Self {
        Self {
            grounded: last.grounded && now.grounded,
            holds: [0, 1].map(|side| last.holds[side].and(now.holds[side])),
            missed: [0, 1].map(|side| match (last.missed[side], now.missed[side]) {
                (Some(last), Some(now)) => Some(last.max(now)),
                (last, now) => last.or(now),
            }),
        }
    }
}

impl Hold {
    /// What holds between two moments.
    pub(super) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Free, _) | (_, Self::Free) => Self::Free,
            (before, after) if before == after => after,
            _ => Self::Stance,
        }
    }
}

/// What a viewer sees of a character in one frame.
#[derive(Clone, Copy)]
pub struct Seen<'a> {
    /// Whose legs these are.
    pub asset: &'a CharacterAsset,
    /// The final pose.
    pub pose: &'a Pose,
    /// The root, world.
    pub root: &'a Transform,
    /// Whether it stands on ground.
    pub grounded: bool,
    /// Velocity wanted, world, m/s.
    pub wanted: Vec3,
    /// Velocity over the ground, m/s.
    pub velocity: Vec3,
    /// What holds each foot.
    pub holds: [Hold; 2],
    /// Metres by which each ankle missed its target, if it has one within its reach.
    pub missed: [Option<f32>; 2],
    /// What plays.
    pub playing: &'a [Playing],
}

/// A clip that plays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playing {
    /// Index in [`CharacterAsset::clips`].
    pub clip: usize,
    /// Factor on its own speed.
    pub rate: f32,
}

/// Metres by which an ankle missed its target, if a leg can be as long as that.
pub(super) fn missed(asset: &CharacterAsset, pose: &Pose, side: usize, ik: &FootIk) -> Option<f32> {
    let (leg, missed) = (&asset.legs[side], ik.legs[side].missed);
    // A leg stretches straight toward what it misses: both together are how far the target was.
    let whole = extension(pose, leg) + missed / leg.length();
    (whole <= asset.file.foot_ik.extension.1).then_some(missed)
}

/// By the plants of foot IK; without foot IK by what the clips say.
pub(super) fn hold(ik: &FootIk, locomotion: &Locomotion, pose: &Pose, leg: &Leg, side: usize) -> Hold {
    if ik.weight < 0.01 {
        return hold_of_clip(pose, leg, locomotion.cues[side].contact);
    }
    match ik.feet[side].plant() {
        None => Hold::Free,
        Some(plant) if plant.pivot == Pivot::Ball => Hold::Ball(Some(plant.ground)),
        Some(_) => Hold::Stance,
    }
}

/// What a clip alone says of a foot whose contact weighs `contact`.
#[must_use]
pub fn hold_of_clip(pose: &Pose, leg: &Leg, contact: f32) -> Hold {
    let [heel, ball, _] = sole_model(pose, leg);
    match contact >= 0.5 {
        true if ball.y <= heel.y + 0.005 => Hold::Ball(None),
        true => Hold::Stance,
        false => Hold::Free,
    }
}

pub(super) fn playing(asset: &CharacterAsset, locomotion: &Locomotion, actions: &Actions) -> Vec<Playing> {
    let machine = &locomotion.machine;
    let laid_over = actions
        .clips(asset)
        .filter_map(|clip| Some(Playing { clip: asset.clip_index(&clip.name)?, rate: clip.clip.speed }));
    locomotion
        .playing(asset)
        .map(|playing| {
            let gait = machine.is_gait(playing.state);
            let rate = if gait { machine.phase_rate() * playing.clip.clip.duration } else { 1.0 };
            Playing { clip: playing.index, rate }
        })
        .chain(laid_over)
        .collect()
}

pub(super) fn extension(pose: &Pose, leg: &Leg) -> f32 {
    pose.position(leg.upper).distance(pose.position(leg.foot)) / leg.length()
}

/// Bend of the knee in radians; negative where the shin stands in front of the thigh's line.
pub(super) fn knee(pose: &Pose, leg: &Leg) -> f32 {
    let (hip, knee, ankle) = (pose.position(leg.upper), pose.position(leg.lower), pose.position(leg.foot));
    let angle = bend_angle(hip, knee, ankle);
    let hinge = pose.rotation(leg.upper) * leg.knee_axis;
    let turn = (knee - hip).cross(ankle - knee).dot(hinge);
    if turn < 0.0 { -angle } else { angle }
}
