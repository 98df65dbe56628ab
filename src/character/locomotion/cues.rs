//! What the playing clips say of each foot: is it on the ground, when will it land, and where.

use bevy::prelude::*;

use super::Locomotion;
use crate::{
    anim::{leg::Leg, pose::Pose},
    character::sole::sole_model,
    rig::character::{CharacterAsset, CharacterClip},
};

/// One foot as the playing clips have it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FootCue {
    /// How surely it is on the ground, 0..1.
    pub contact: f32,
    /// Seconds until it lands; 0 while it is on the ground.
    pub time_to_contact: f32,
    /// Seconds for which it stays on the ground; 0 in the air, without end where nothing plays that steps.
    pub stands_for: f32,
    /// Share of its swing that has passed, 0..1; 1 while it is on the ground.
    pub swing: f32,
    /// Where its ball lands, model space of the landing's own time; `None` when nothing plays that steps.
    pub landing_model: Option<Vec3>,
}

/// Per foot: where the ball is at the moment of contact, the sole laid flat; model space. `None` for a foot that never
/// lands.
pub(super) type Landing = [Option<Vec3>; 2];

/// Looks at a clip's moments of contact. `scratch` is a pose of the asset's skeleton.
pub(super) fn landing(asset: &CharacterAsset, clip: &CharacterClip, scratch: &mut Pose) -> Landing {
    [0, 1].map(|foot| {
        // A clip that doesn't loop begins with feet that never landed.
        let lands = |start: &f32| clip.gait.looping || *start > 0.0;
        let start = clip.gait.contact[foot].iter().map(|contact| contact.start).find(lands)?;
        let time = clip.gait.time_at(start, clip.clip.duration);
        clip.clip.sample(&asset.skeleton, time, scratch.locals_mut());
        scratch.update_model(&asset.skeleton);
        Some(flat_ball(scratch, &asset.legs[foot]))
    })
}

/// Where the ball comes to lie once the sole that touches with its heel is flat, model space.
fn flat_ball(pose: &Pose, leg: &Leg) -> Vec3 {
    let [heel, ball, _] = sole_model(pose, leg);
    if ball.y <= heel.y + 0.005 {
        return ball;
    }
    let along = (ball - heel).with_y(0.0).normalize_or_zero();
    heel + along * heel.distance(ball)
}

/// What all playing clips together say of `foot` (0 left, 1 right).
pub(super) fn cue(locomotion: &Locomotion, asset: &CharacterAsset, foot: usize) -> FootCue {
    let machine = &locomotion.machine;
    let mut cue = FootCue { swing: 1.0, stands_for: f32::INFINITY, ..FootCue::default() };
    let (mut heaviest, mut leading) = (0.0f32, 0.0f32);
    let (mut landing, mut landing_weight) = (Vec3::ZERO, 0.0f32);
    for playing in locomotion.playing(asset) {
        let (gait, weight, phase) = (&playing.clip.gait, playing.weight, playing.gait_phase);
        let contact = gait.contact_weight(foot, phase);
        cue.contact += weight * contact;
        if !machine.steps(playing.state) {
            continue;
        }
        if weight > leading {
            leading = weight;
            let stands = gait.phase_to_lift(foot, phase).unwrap_or(f32::INFINITY);
            cue.stands_for = stands / machine.cycle_rate(playing.state).max(0.2);
        }
        if let Some(ball) = playing.landing[foot] {
            landing += ball * weight;
            landing_weight += weight;
            if weight > heaviest && contact < 0.5 {
                heaviest = weight;
                let way = gait.phase_to_landing(foot, phase).unwrap_or(0.0);
                cue.time_to_contact = way / machine.cycle_rate(playing.state).max(0.2);
                cue.swing = gait.swing_share(foot, phase);
            }
        }
    }
    if landing_weight > 0.0 {
        cue.landing_model = Some(landing / landing_weight);
    }
    cue
}
