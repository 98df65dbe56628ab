//! What a clip's feet do: when each stands, how fast the ground passes, how long a stride is.
//!
//! Model space, metres, +Y up, the character faces -Z. Phases 0..1 of the clip; 0 is where the left foot lands.

mod track;

use bevy::math::Vec3;

use self::track::Track;
use super::{clip::Clip, leg::Leg, skeleton::Skeleton};
use crate::math::rotation::direction_or;

/// Phase over which a contact's weight grows and fades, centred on its edge.
const EDGE: f32 = 0.03;

/// A stance: from landing to lift-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// Phase of landing, 0..1.
    pub start: f32,
    /// Phase of lift-off, above `start` by at most 1: beyond 1 it wraps.
    pub end: f32,
}

/// What a clip's feet do. Pairs are `[left, right]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gait {
    /// Speed over ground, in m/s at normal playback, at which the feet don't slide; 0 when standing.
    pub speed: f32,
    /// The same with its direction in model space: -Z forward.
    pub velocity: Vec3,
    /// Metres over ground from one landing of the left foot to its next; 0 when standing.
    pub stride: f32,
    /// Strides in one run of the clip: usually 1.
    pub strides: u16,
    /// Stances of each foot, by start.
    pub contact: [Vec<Contact>; 2],
    /// Share of the clip's duration, 0..1, at which the phase is 0.
    pub phase_offset: f32,
    /// Whether the clip loops; only then does phase 0 move to a landing.
    pub looping: bool,
    /// Height of each sole while it stands, metres over the model's ground plane.
    pub sole_height: [f32; 2],
    /// Largest angular speed of a hip, knee or ankle against its parent, rad/s at normal playback.
    pub leg_speed: f32,
    /// Largest vertical acceleration of the hips, m/s² at normal playback.
    pub heave: f32,
}

impl Gait {
    /// Looks at the feet of `clip`.
    #[must_use]
    pub fn analyze(clip: &Clip, skeleton: &Skeleton, legs: &[Leg; 2]) -> Self {
        Self::analyze_turning(clip, skeleton, legs, 0.0)
    }

    /// Looks at the feet of a `clip` during which the game turns the root by `angle` radians about +Y: a foot that turns
    /// back under the root stands.
    #[must_use]
    pub fn analyze_turning(clip: &Clip, skeleton: &Skeleton, legs: &[Leg; 2], angle: f32) -> Self {
        Track::new(clip, skeleton, legs, angle).gait()
    }

    /// Takes `contact` for the stances, as shares of the clip's duration, and moves phase 0 to the left foot's landing.
    pub fn set_contacts(&mut self, contact: [Vec<Contact>; 2]) {
        let landing = contact[0].iter().find(|contact| contact.end - contact.start < 1.0);
        self.phase_offset = landing.filter(|_| self.looping).map_or(0.0, |contact| contact.start);
        self.contact = contact.map(|mut contacts| {
            for contact in &mut contacts {
                let length = contact.end - contact.start;
                contact.start = if length < 1.0 { wrapped(contact.start - self.phase_offset) } else { 0.0 };
                contact.end = contact.start + length;
            }
            contacts.sort_by(|a, b| a.start.total_cmp(&b.start));
            contacts
        });
        let strides = self.contact[0].len().max(self.contact[1].len()).max(1);
        self.strides = u16::try_from(strides).unwrap_or(u16::MAX);
    }

    /// Stances as shares of the clip's duration, as [`Gait::set_contacts`] takes them.
    #[must_use]
    pub fn contacts_in_clip(&self) -> [Vec<Contact>; 2] {
        self.contact.clone().map(|contacts| {
            let moved = |contact: &Contact| {
                let length = contact.end - contact.start;
                let start = if length < 1.0 { wrapped(contact.start + self.phase_offset) } else { 0.0 };
                Contact { start, end: start + length }
            };
            contacts.iter().map(moved).collect()
        })
    }

    /// Takes `speed` (m/s) for the speed over ground of a clip of `duration` seconds; forward if it had none.
    pub fn set_speed(&mut self, speed: f32, duration: f32) {
        self.velocity = direction_or(self.velocity, Vec3::NEG_Z) * speed;
        self.speed = speed;
        self.stride = speed * duration / f32::from(self.strides.max(1));
    }

    /// Phase 0..1 at `time` seconds of a clip of `duration` seconds.
    #[must_use]
    pub fn phase_at(&self, time: f32, duration: f32) -> f32 {
        if duration > 0.0 { wrapped(time / duration - self.phase_offset) } else { 0.0 }
    }

    /// Seconds into a clip of `duration` seconds at `phase`.
    #[must_use]
    pub fn time_at(&self, phase: f32, duration: f32) -> f32 {
        wrapped(phase + self.phase_offset) * duration
    }

    /// How firmly foot 0 (left) or 1 stands at `phase`: 0 in swing, 1 in stance, half on the edge.
    #[must_use]
    pub fn contact_weight(&self, foot: usize, phase: f32) -> f32 {
        let phase = wrapped(phase);
        let weight = |contact: &Contact| {
            let length = contact.end - contact.start;
            if length >= 1.0 {
                return 1.0;
            }
            let edge = EDGE.min(0.5 * length).min(0.5 * (1.0 - length));
            // Phase after landing, as the nearest of its repeats to the stance's middle.
            let since = wrapped(phase - contact.start - 0.5 * length + 0.5) + 0.5 * length - 0.5;
            let inside = since.min(length - since);
            smooth(0.5 + inside / edge.max(f32::MIN_POSITIVE))
        };
        self.contact[foot].iter().map(weight).fold(0.0, f32::max)
    }

    /// Phase from `phase` until the foot lands: 0 while it stands, `None` when it never does.
    #[must_use]
    pub fn phase_to_landing(&self, foot: usize, phase: f32) -> Option<f32> {
        let until = |contact: &Contact| {
            let since = wrapped(phase - contact.start);
            if since < contact.end - contact.start { 0.0 } else { 1.0 - since }
        };
        self.contact[foot].iter().map(until).reduce(f32::min)
    }

    /// Share of its swing, 0..1, that a foot has made at `phase`; 1 while it stands, and if it never lands.
    #[must_use]
    pub fn swing_share(&self, foot: usize, phase: f32) -> f32 {
        let left = self.phase_to_landing(foot, phase).unwrap_or(0.0);
        let before = |contact: &Contact| wrapped(phase - contact.end);
        let passed = self.contact[foot].iter().map(before).reduce(f32::min).unwrap_or(0.0);
        if left > 0.0 { passed / (passed + left) } else { 1.0 }
    }

    /// Phase from `phase` until the foot lifts: 0 in swing, `None` when it never does.
    #[must_use]
    pub fn phase_to_lift(&self, foot: usize, phase: f32) -> Option<f32> {
        let stands = |contact: &&Contact| wrapped(phase - contact.start) < contact.end - contact.start;
        match self.contact[foot].iter().find(stands) {
            Some(contact) if contact.end - contact.start >= 1.0 => None,
            Some(contact) => Some(contact.end - contact.start - wrapped(phase - contact.start)),
            None => Some(0.0),
        }
    }
}

/// Phase brought into 0..1; NaN gives 0.
fn wrapped(phase: f32) -> f32 {
    let wrapped = match phase {
        0.0..1.0 => return phase,
        -1.0..0.0 => phase + 1.0,
        1.0..2.0 => return phase - 1.0,
        _ => phase.rem_euclid(1.0),
    };
    if (0.0..1.0).contains(&wrapped) { wrapped } else { 0.0 }
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "these values are exact by construction")]
mod tests;
