//! How high the pelvis rides: over the mean of what carries both feet, sunk so far that planted legs reach.
//!
//! The capsule hops up and down steps; its height doesn't count here.
//!
//! World space, metres, +Y up.

use bevy::prelude::*;

use super::{ON, heave::Heave, ride::Ride};
use crate::{
    math::spring::Spring,
    rig::tuning::foot_ik::{FootIkConfig, TUNED_LEG},
};

/// Half-life in seconds in which the body follows a change of the slope that it rides over.
const FOLLOW: f32 = 0.3;
/// How much slower the pelvis rises than it sinks: on a slope it stays where each stride needs it.
const RISE_SLOWER: f32 = 3.0;
/// Metres of a rise from which on it is made faster, and from which on as fast as it sinks: nobody stays on his knees.
const KNEELS: (f32, f32) = (0.1, 0.25);

/// Share of a leg's length that a foot may be aside for the pelvis to sink after it; no sinking reaches one further off.
const ASIDE: f32 = 0.7;

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

/// The pelvis' height, carried from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct PelvisState {
    drop: Spring<f32>,
    /// World height of the ground that the body rides over; `None` before the first frame.
    ground: Option<Spring<f32>>,
    offset: f32,
    /// World height of the final hips joint in the last frame, and its speed.
    hips: Option<Spring<f32>>,
    fall: Fall,
    heave: Heave,
}

/// A fall that the legs stop.
#[derive(Clone, Copy, Debug, Default)]
enum Fall {
    #[default]
    Over,
    /// The body has come to the ground and slows: its speed, and the height of the hips without the fall in the last frame.
    Stops { speed: f32, own: Option<f32> },
    /// Metres below where the hips would be without the fall (negative), and speed.
    Recovers(Spring<f32>),
}

/// How fast legs stop a fall, m/s²; with gravity a force of some five to six body weights, as in landings from half a metre
/// (McNitt-Gray, "Kinetics of the lower extremities during drop landings", J. Biomech. 26, 1993).
const STOPS: f32 = 45.0;
/// Half-life in seconds in which the body rises again after a fall.
const RECOVERS: f32 = 0.2;
/// Height of the hips over the ground below which no fall presses them, as a share of the leg: a deep squat.
const SQUAT: f32 = 0.52;
/// Speed in m/s of falls, such as a jump's, that legs stop at the pace of clips.
const GENTLE: f32 = 4.0;
/// Radians a second that the joints of a leg of one metre turn for each m/s beyond.
const BENDS: f32 = 6.7;
/// Least metres in which a fall is stopped. Guards the division.
const LEAST_ROOM: f32 = 0.02;

impl PelvisState {
    /// Metres by which the pelvis stands above (below: negative) the clip's, as the root carries it.
    #[must_use]
    pub fn offset(&self) -> f32 {
        self.offset
    }

    /// Forgets everything; the pelvis starts from the clip.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Forgets how it moved; what it stands on holds.
    pub(super) fn forget_motion(&mut self) {
        *self = Self { drop: self.drop, ground: self.ground, offset: self.offset, ..Self::default() };
    }

    /// The body has come to the ground: legs bend to stop it.
    pub(super) fn land(&mut self) {
        self.fall = Fall::Stops { speed: self.hips.map_or(0.0, |hips| hips.velocity), own: None };
    }

    /// Angular speed in rad/s at which legs of `length` metres bend while they stop a fall; 0 for what clips are fit for.
    pub(super) fn bending(&self, length: f32) -> f32 {
        let sinks = self.hips.map_or(0.0, |hips| -hips.velocity);
        if matches!(self.fall, Fall::Over) { 0.0 } else { BENDS * (sinks - GENTLE).max(0.0) / length.max(1e-3) }
    }

    /// Whether a fall is being stopped.
    pub(super) fn falls(&self) -> bool {
        !matches!(self.fall, Fall::Over)
    }

    /// One frame just over the ground, at the height `floor`, hips that else were at the height `hips`, both world: metres by
    /// which they fall on, below (negative) or above the clip's.
    pub(super) fn fall_on(&mut self, hips: f32, floor: f32, length: f32, dt: f32) -> f32 {
        if !self.falls() {
            self.land();
        }
        let last = self.hips.unwrap_or(Spring::at(hips));
        let speed = (last.velocity + STOPS * dt).min(last.velocity.max(0.0));
        let squat = floor + SQUAT * length;
        self.offset = (last.value + 0.5 * (last.velocity + speed) * dt).max(squat) - hips;
        self.fall = Fall::Stops { speed, own: None };
        self.heave.let_go(hips + self.offset, dt);
        self.note(hips + self.offset, dt);
        self.offset
    }

    /// One frame in the air, without ground, the hips joint at the world height `hips`.
    pub(super) fn fly_free(&mut self, hips: f32, dt: f32) {
        *self = Self { hips: self.hips, heave: self.heave, ..Self::default() };
        self.heave.let_go(hips, dt);
        self.note(hips, dt);
    }

    /// Notes where the final hips joint is in this frame, world height.
    fn note(&mut self, hips: f32, dt: f32) {
        let velocity = self.hips.map_or(0.0, |last| (hips - last.value) / dt.max(1e-4));
        self.hips = Some(Spring { value: hips, velocity });
    }

    /// Metres by which what is left of a fall lowers hips that else were at the world height `hips`, never below `lowest`.
    ///
    /// The pelvis goes on as it did, then slows evenly, the harder the less room there is, then comes back.
    fn stop_fall(&mut self, hips: f32, lowest: f32, dt: f32) -> f32 {
        let Some(last) = self.hips else { return 0.0 };
        let most = (hips - lowest).max(0.0);
        match self.fall {
            Fall::Over => 0.0,
            Fall::Stops { speed: before, own } => {
                let room = (last.value - lowest).max(LEAST_ROOM);
                // As fast as comes to rest within the room there is, at least.
                let harder = before / (1.0 + 0.5 * before.abs() * dt / room);
                let speed = harder.max(before + STOPS * dt);
                let offset = (last.value + 0.5 * (before + speed) * dt - hips).max(-most);
                let own = own.map(|own| (hips - own) / dt.max(1e-4));
                self.fall = match own.filter(|own| speed >= *own) {
                    Some(own) => Fall::Recovers(Spring { value: offset, velocity: speed - own }),
                    None => Fall::Stops { speed, own: Some(hips) },
                };
                offset
            }
            Fall::Recovers(mut fall) => {
                fall.step(0.0, RECOVERS, dt);
                fall.value = fall.value.max(-most);
                let over = fall.value.abs() < 1e-4 && fall.velocity.abs() < 1e-3;
                self.fall = if over { Fall::Over } else { Fall::Recovers(fall) };
                fall.value
            }
        }
    }

    /// One frame: rides over `ground`.
    pub fn advance(&mut self, legs: &[LegReach; 2], ground: Ride, frame: &PelvisFrame<'_>) -> f32 {
        let PelvisFrame { floor, hips, weight, heave, config, dt } = *frame;
        let most = config.pelvis_drop;
        let ride = self.ground.get_or_insert(Spring { value: ground.height, velocity: ground.speed });
        // What is behind the ground, in place and speed, springs back: an even slope is followed without lag.
        let ahead = ride.value + ground.speed * dt;
        let mut behind = Spring { value: ahead - ground.height, velocity: ride.velocity - ground.speed };
        behind.step(0.0, FOLLOW, dt);
        ride.value = (ground.height + behind.value).clamp(floor - most, floor + most);
        ride.velocity = ground.speed + behind.velocity;
        let carried = (ride.value - floor) * weight;
        let raised = legs.map(|leg| LegReach { hip: leg.hip + Vec3::Y * carried, ..leg });
        let wanted = drop_for(&raised, config) * weight;
        self.drop.step(
            wanted,
            rise_slower((wanted - self.drop.value) * TUNED_LEG / legs[0].length) * config.pelvis_half_life,
            dt,
        );
        let placed = carried + self.drop.value * weight;
        let squat = floor + carried + SQUAT * legs[0].length;
        let lowest = squat.max(hips + placed - most);
        self.offset = placed + self.stop_fall(hips + placed, lowest, dt);
        let free = !matches!(self.fall, Fall::Over) || weight < ON;
        self.offset += self.heave.keep(hips + self.offset, heave, free, dt);
        self.note(hips + self.offset, dt);
        self.offset
    }
}

/// How much slower than sinking the pelvis rises by `rise` metres, told for a leg of [`TUNED_LEG`]; 1 where it sinks.
fn rise_slower(rise: f32) -> f32 {
    let (from, to) = KNEELS;
    let kneels = ((rise - from) / (to - from)).clamp(0.0, 1.0);
    if rise > 0.0 { RISE_SLOWER + (1.0 - RISE_SLOWER) * kneels * kneels * (3.0 - 2.0 * kneels) } else { 1.0 }
}

/// What a frame is for the pelvis.
#[derive(Clone, Copy, Debug)]
pub struct PelvisFrame<'a> {
    /// World height of the root.
    pub floor: f32,
    /// World height of the animated hips joint.
    pub hips: f32,
    /// How much of foot placement is on, 0..1.
    pub weight: f32,
    /// Largest vertical acceleration of the hips in the clips, m/s².
    pub heave: f32,
    /// Tuning, scaled to the leg.
    pub config: &'a FootIkConfig,
    /// Seconds since the last frame.
    pub dt: f32,
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
        let across = Vec2::new(away.x, away.z).length_squared().min((ASIDE * longest).powi(2));
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

    fn level(height: f32) -> Ride {
        Ride { height, speed: 0.0 }
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
    fn a_hop_of_the_root_does_not_move_the_body() {
        let (config, mut pelvis) = (FootIkConfig::default(), PelvisState::default());
        let legs = [leg(0.09), leg(0.09)];
        let frame = PelvisFrame { floor: 0.0, hips: 0.95, weight: 1.0, heave: 0.0, config: &config, dt: 1.0 / 60.0 };
        pelvis.advance(&legs, level(0.0), &frame);
        let after = 0.17
            + pelvis.advance(
                &legs.map(|leg| LegReach { hip: leg.hip + Vec3::Y * 0.17, ..leg }),
                level(0.0),
                &PelvisFrame { floor: 0.17, hips: 1.12, ..frame },
            );
        assert!(after.abs() < 1e-3, "the body hopped by {after} m");
    }

    #[test]
    fn a_fall_is_stopped_within_what_legs_bend() {
        let (config, mut pelvis) = (FootIkConfig::default(), PelvisState::default());
        let dt = 1.0 / 60.0;
        let frame = PelvisFrame { floor: 0.0, hips: 0.95, weight: 1.0, heave: 0.0, config: &config, dt };
        // From the air at 4 m/s; hips stand still in the clip.
        let mut heights = vec![0.95 + 2.0 * 4.0 * dt, 0.95 + 4.0 * dt];
        heights.iter().for_each(|height| pelvis.note(*height, dt));
        pelvis.land();
        for _ in 0..90 {
            heights.push(0.95 + pelvis.advance(&[leg(0.09), leg(0.09)], level(0.0), &frame));
        }
        let stops = heights.windows(3).map(|h| (h[2] - 2.0 * h[1] + h[0]) / (dt * dt)).fold(0.0, f32::max);
        let lowest = heights.iter().copied().fold(f32::MAX, f32::min);
        assert!(stops < 60.0, "stopped by {stops} m/s²");
        assert!((0.6..0.9).contains(&lowest), "sinks to {lowest} m of 0.95");
        assert!((heights[91] - 0.95).abs() < 0.01, "stands at {} m after 1.5 s", heights[91]);
    }

    #[test]
    fn a_body_whose_feet_have_climbed_climbs_after_them() {
        let (config, mut pelvis) = (FootIkConfig::default(), PelvisState::default());
        let legs = [leg(0.26), leg(0.26)];
        let frame = PelvisFrame { floor: 0.0, hips: 0.95, weight: 1.0, heave: 0.0, config: &config, dt: 1.0 / 60.0 };
        pelvis.advance(&legs, level(0.0), &frame);
        let risen = (0..180).map(|_| pelvis.advance(&legs, level(0.17), &frame)).fold(0.0, f32::max);
        assert!((risen - 0.17).abs() < 1e-3, "risen by {risen} m of 0.17");
    }
}
