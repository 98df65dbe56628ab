//! What a foot keeps of its motion when its way changes: it goes on as it was and eases into the new way.
//!
//! Inertialization of one point, world space, metres: the offset from the new way starts with the old place and speed and
//! ends with neither offset, speed nor acceleration.

use bevy::prelude::*;

use crate::math::fade::ebb;

/// Seconds of the longest and the shortest easing.
const LONGEST: f32 = 0.3;
const SHORTEST: f32 = 0.05;
/// Seconds in which a lift-off by a gait is eased: some seven frames at 60 Hz; and the frames that it takes at least.
const LIFT_OFF: f32 = 0.11;
const FRAMES: f32 = 4.5;

/// An offset that decays, and what it is made of.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Carry {
    phase: Phase,
    /// Whether a gait lifted it, and only its first moments are eased.
    brief: bool,
    ankle: Track,
    /// The toes' tip: what a gait lifts last.
    tip: Track,
}

/// Where a point was last, and its velocity then.
#[derive(Clone, Copy, Debug, Default)]
struct Track {
    place: Option<Vec3>,
    velocity: Vec3,
}

impl Track {
    fn note(&mut self, place: Vec3, dt: f32) {
        self.velocity = self.place.map_or(Vec3::ZERO, |last| (place - last) / dt.max(1e-4));
        self.place = Some(place);
    }
}

#[derive(Clone, Copy, Debug, Default)]
enum Phase {
    /// Nothing is left.
    #[default]
    Over,
    /// The way has just changed.
    Begun,
    /// The new way was seen once: the offset from it, and where it was.
    Seen { offset: Vec3, new: Vec3 },
    /// The offset decays.
    Eases { offset: Vec3, velocity: Vec3, elapsed: f32, seconds: f32 },
}

impl Carry {
    /// From now on the point goes another way.
    pub(super) fn begin(&mut self) {
        (self.phase, self.brief) = (Phase::Begun, false);
    }

    /// A gait lifts the point off its ground: over the ground it goes on as it was for a moment, since the body may have turned
    /// or braked meanwhile. Upward it goes with the gait.
    pub(super) fn lift_off(&mut self) {
        (self.phase, self.brief) = (Phase::Begun, true);
    }

    /// Whether a gait lifted it.
    pub(super) fn is_brief(&self) -> bool {
        self.brief
    }

    /// How fast the ankle was in the last frame, m/s.
    pub(super) fn velocity(&self) -> Vec3 {
        self.ankle.velocity
    }

    /// Nothing is known of how it moved.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// The point is where it belongs.
    pub(super) fn end(&mut self) {
        self.phase = Phase::Over;
    }

    /// The body that carries it has come to the ground, `fallen` metres lower than in the last frame: it fell with it.
    pub(super) fn land(&mut self, fallen: f32) {
        for track in [&mut self.ankle, &mut self.tip] {
            track.velocity.y = 0.0;
            if let Some(place) = &mut track.place {
                place.y -= fallen;
            }
        }
    }

    /// Notes where ankle and tip were put in this frame.
    pub(super) fn note(&mut self, ankle: Vec3, tip: Vec3, dt: f32) {
        self.ankle.note(ankle, dt);
        self.tip.note(tip, dt);
    }

    /// The offset from the new way, which has ankle and tip there now; it is over within `left` seconds.
    pub(super) fn offset(&mut self, ankle: Vec3, tip: Vec3, left: f32, dt: f32) -> Vec3 {
        // Whatever the foot turns, a tip that stood starts from rest.
        if self.brief { self.eased(tip, left, dt).with_y(0.0) } else { self.eased(ankle, left, dt) }
    }

    fn eased(&mut self, new: Vec3, left: f32, dt: f32) -> Vec3 {
        let Track { place, velocity: old } = if self.brief { self.tip } else { self.ankle };
        match self.phase {
            Phase::Over => Vec3::ZERO,
            Phase::Begun => {
                let offset = place.map_or(Vec3::ZERO, |place| place + old * dt - new);
                self.phase = Phase::Seen { offset, new };
                offset
            }
            Phase::Seen { offset, new: last } => {
                let velocity = old - (new - last) / dt.max(1e-4);
                let seconds = if self.brief { LIFT_OFF.max(FRAMES * dt) } else { left.clamp(SHORTEST, LONGEST) };
                self.phase = Phase::Eases { offset, velocity, elapsed: 0.0, seconds };
                self.eased(new, left, dt)
            }
            Phase::Eases { offset, velocity, elapsed, seconds } => {
                let elapsed = elapsed + dt;
                if elapsed >= seconds {
                    self.phase = Phase::Over;
                    return Vec3::ZERO;
                }
                self.phase = Phase::Eases { offset, velocity, elapsed, seconds };
                ebb(offset, velocity * seconds, elapsed / seconds)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f32 = 1.0 / 60.0;

    #[test]
    fn a_point_that_changes_its_way_neither_jumps_nor_kinks() {
        let (old, new) = (|t: f32| Vec3::new(2.0 * t, 0.1, 0.0), |t: f32| Vec3::new(0.3, 0.0, -t));
        let mut carry = Carry::default();
        let mut places = Vec::new();
        for frame in 0..40 {
            let time = frame as f32 * DT;
            let place = if frame < 10 {
                old(time)
            } else {
                if frame == 10 {
                    carry.begin();
                }
                new(time) + carry.offset(new(time), new(time), 0.3, DT)
            };
            carry.note(place, place, DT);
            places.push(place);
        }
        for (frame, three) in places.windows(3).enumerate() {
            let kink = (three[2] - 2.0 * three[1] + three[0]).length() / DT;
            // 2.2 m/s and 0.3 m go within 0.3 s; at once they would be a kink of 20 m/s.
            assert!(kink < 0.7, "its velocity changes by {kink} m/s in frame {frame}");
        }
        let off = places[30].distance(new(30.0 * DT));
        assert!(off < 1e-5, "{off} m off its new way after 0.33 s");
    }
}
