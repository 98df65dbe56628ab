//! How far the pelvis sinks so that planted legs reach, and how the capsule's hops are kept out of the body.
//!
//! World space, metres, +Y up.

use bevy::prelude::*;

use crate::{
    math::spring::{Spring, damp},
    rig::tuning::foot_ik::FootIkConfig,
};

/// Half-life in seconds of the root's hops in the body. The controller has rounded them off already.
const HOP_HALF_LIFE: f32 = 0.1;
/// Half-life in seconds over which the mean speed of hops is found.
const HOP_RATE_HALF_LIFE: f32 = 0.15;
/// How much slower the pelvis rises than it sinks: on a slope it stays where each stride needs it.
const RISE_SLOWER: f32 = 1.7;

/// One leg as the pelvis sees it.
#[derive(Clone, Copy, Debug)]
pub struct LegReach {
    /// Animated hip joint, world.
    pub hip: Vec3,
    /// Where the ankle shall be, world.
    pub ankle: Vec3,
    /// Thigh plus shin, metres.
    pub length: f32,
    /// Distance from hip to ankle in the clip, metres.
    pub animated: f32,
    /// Metres that lifting the heel can give.
    pub slack: f32,
    /// How much this leg counts: 1 planted, 0 in the air.
    pub weight: f32,
}

/// The pelvis' vertical offset from the clip, carried from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct PelvisState {
    drop: Spring<f32>,
    /// What is left of the root's hops, metres.
    hops: Spring<f32>,
    /// Mean speed of the hops, m/s.
    hop_rate: f32,
    /// `MotionState::stepped` of the last frame.
    stepped: Option<f32>,
}

impl PelvisState {
    /// Metres by which the pelvis stands above (below: negative) the clip's.
    #[must_use]
    pub fn offset(&self) -> f32 {
        self.drop.value + self.hops.value
    }

    /// Forgets everything; the pelvis starts from the clip.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// One frame. `stepped` is the sum of the root's hops; what it grew by is taken out of the body and springs back.
    pub fn advance(&mut self, legs: &[LegReach], stepped: f32, weight: f32, config: &FootIkConfig, dt: f32) -> f32 {
        let hop = stepped - self.stepped.unwrap_or(stepped);
        self.stepped = Some(stepped);
        self.hops.value = (self.hops.value - hop).clamp(-config.pelvis_drop, config.pelvis_drop);
        // On stairs hop follows hop: aiming ahead by the mean rate keeps the body from trailing.
        self.hop_rate = damp(self.hop_rate, hop / dt.max(1e-4), HOP_RATE_HALF_LIFE, dt);
        self.hops.step(self.hop_rate * HOP_HALF_LIFE / core::f32::consts::LN_2, HOP_HALF_LIFE, dt);
        let wanted = drop_for(legs, config) * weight;
        let half_life = if wanted < self.drop.value { 1.0 } else { RISE_SLOWER } * config.pelvis_half_life;
        self.drop.step(wanted, half_life, dt);
        self.offset()
    }
}

/// The least drop, ≤ 0, that lets every leg reach by its weight.
///
/// Law of cosines: over a horizontal distance `d`, a leg of `l` reaches `sqrt(l² - d²)` down.
#[must_use]
pub fn drop_for(legs: &[LegReach], config: &FootIkConfig) -> f32 {
    let mut lowest = 0.0f32;
    for leg in legs {
        // A clip that stretches its leg further than the reserve is taken at its word: it stands on flat ground.
        let longest = (config.pelvis_extension * leg.length).max(leg.animated.min(0.99 * leg.length));
        let away = leg.ankle - leg.hip;
        let across = Vec2::new(away.x, away.z).length_squared();
        let down = (longest * longest - across).max(0.0).sqrt();
        let drop = away.y + down + leg.slack;
        if drop < 0.0 {
            lowest = lowest.min(drop * leg.weight.clamp(0.0, 1.0));
        }
    }
    lowest.max(-config.pelvis_drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leg(ankle: f32) -> LegReach {
        LegReach { hip: Vec3::Y * 0.95, ankle: Vec3::Y * ankle, length: 0.875, animated: 0.86, slack: 0.0, weight: 1.0 }
    }

    #[test]
    fn level_feet_leave_the_pelvis_alone() {
        let drop = drop_for(&[leg(0.09), leg(0.09)], &FootIkConfig::default());
        assert!(drop.abs() < 1e-6, "{drop} m");
    }

    #[test]
    fn the_lower_foot_pulls_the_pelvis_down_by_what_it_lacks() {
        let drop = drop_for(&[leg(0.09), leg(-0.11)], &FootIkConfig::default());
        assert!((drop + 0.2).abs() < 1e-4, "{drop} m");
    }

    #[test]
    fn an_abyss_pulls_no_further_than_the_cap() {
        let config = FootIkConfig::default();
        let drop = drop_for(&[leg(0.09), leg(-3.0)], &config);
        assert!((drop + config.pelvis_drop).abs() < 1e-6, "{drop} m");
    }

    #[test]
    fn a_hop_of_the_root_does_not_move_the_body_at_once() {
        let (config, mut pelvis) = (FootIkConfig::default(), PelvisState::default());
        let legs = [leg(0.09), leg(0.09)];
        pelvis.advance(&legs, 0.0, 1.0, &config, 1.0 / 60.0);
        let after = pelvis.advance(&legs, 0.17, 1.0, &config, 1e-4);
        assert!((after + 0.17).abs() < 1e-3, "the body hopped by {} m", 0.17 + after);
    }
}
