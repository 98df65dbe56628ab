//! Cyclic clips: a stride for each foot and a trunk that moves over them.
//!
//! Model space of the file, in place; phase 0..1, 0 = left foot's initial contact.

use super::super::clip::Clip;
use super::body::{Arm, Figure, hip_joint};
use super::curves::{Fourier, ease};
use super::foot_path::Stride;
use super::leg::rest;
use super::record::{Moment, Timing, record};
use glam::{DQuat, DVec3};

/// Pelvis, thorax, head and arms at one phase.
#[derive(Clone, Copy, Debug)]
pub struct Trunk {
    pub hips: DVec3,
    pub pelvis: DQuat,
    pub thorax: DQuat,
    pub head: DQuat,
    pub arms: [Arm; 2],
}

/// A way of going.
pub struct Gait {
    pub name: &'static str,
    /// Left and right foot; the right one as its own mirror image.
    pub strides: [Stride; 2],
    /// Phase of the right foot when the left one lands.
    pub right_phase: f64,
    /// Keys per second.
    pub rate: f64,
    /// Knees outward, degrees.
    pub knees_out: f64,
    pub trunk: fn(f64) -> Trunk,
}

impl Gait {
    /// The body at `phase`.
    #[must_use]
    pub fn figure(&self, phase: f64) -> Figure {
        let trunk = (self.trunk)(phase);
        Figure {
            hips: trunk.hips,
            pelvis: trunk.pelvis,
            thorax: trunk.thorax,
            head: trunk.head,
            arms: trunk.arms,
            feet: [self.strides[0].foot(phase), self.strides[1].foot(phase + self.right_phase).mirrored()],
            knees_out: [self.knees_out; 2],
        }
    }

    /// The looping clip.
    #[must_use]
    pub fn clip(&self) -> Clip {
        self.recorded(self.name, |phase| self.figure(phase))
    }

    /// The looping clip of the mirror image, again from the left foot's contact on.
    #[must_use]
    pub fn mirrored_clip(&self, name: &'static str) -> Clip {
        self.recorded(name, |phase| self.figure(phase + 1.0 - self.right_phase).mirrored())
    }

    fn recorded(&self, name: &'static str, figure: impl Fn(f64) -> Figure) -> Clip {
        let stride = &self.strides[0];
        let seconds = stride.period;
        let timing = Timing { seconds, rate: self.rate, ground_speed: Some(stride.travel.length()) };
        record(name, timing, |time| Moment::from(figure(time / seconds)))
    }
}

/// A leg's swing by the sagittal angles of its segments.
#[derive(Clone, Copy, Debug)]
pub struct SwingAngles {
    /// Elevation of thigh and shank in degrees, foot forward +.
    pub thigh: Fourier,
    pub shank: Fourier,
    /// About the smallest bend of the knee, degrees.
    pub least_knee: f64,
    /// Phase of toe-off, of the clip and of the curves: swing runs from there to the end in both.
    pub toe_off: [f64; 2],
    /// Phase by which the curves run ahead at landing, so that the foot comes back toward the ground's own speed.
    pub early: f64,
    /// Ankle to the left of the midline, metres.
    pub x: f64,
}

impl SwingAngles {
    /// Ankle of the left leg below the moving hip, by phase.
    pub fn below(self, trunk: fn(f64) -> Trunk) -> impl Fn(f64) -> DVec3 {
        let thigh_length = (rest("leftLowerLeg") - rest("leftUpperLeg")).length();
        let shank_length = (rest("leftFoot") - rest("leftLowerLeg")).length();
        move |phase| {
            let body = trunk(phase);
            let hip = hip_joint(body.hips, body.pelvis, 0);
            let [own, theirs] = self.toe_off;
            let same = 1.0 - (1.0 - phase) * (1.0 - theirs) / (1.0 - own);
            let drawn = same + self.early * ease(0.65, 1.0, phase);
            let (thigh, shank) = (self.thigh.at(drawn), self.shank.at(drawn));
            let knee = thigh - shank;
            let excess = 0.5 * (knee - self.least_knee);
            let bent = self.least_knee + excess + (excess * excess + 16.0).sqrt();
            let more = 0.5 * (bent - knee);
            let (thigh, shank) = ((thigh + more).to_radians(), (shank - more).to_radians());
            let down = thigh.cos() * thigh_length + shank.cos() * shank_length;
            let ahead = thigh.sin() * thigh_length + shank.sin() * shank_length;
            DVec3::new(self.x, hip.y - down, hip.z + ahead)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{crouch, leg::Sole, run, sidle, sprint, walk};
    use super::*;

    /// Mean over 60 Hz frames of a foot's speed over the ground, counted by how low it is (up to 2.5 cm), cm/s.
    fn skate(stride: &Stride) -> f64 {
        let sole = Sole::left();
        let frames = 600;
        let sum: f64 = (0..frames)
            .map(|i| {
                let phase = f64::from(i) / f64::from(frames);
                let before = phase - 1.0 / 60.0 / stride.period;
                let (now, then) = (stride.foot(phase), stride.foot(before));
                let point = now.lowest_point(&sole);
                let (now, then) = (now.points(&sole)[point], then.points(&sole)[point]);
                // The seam: the foot before phase 0 is a whole stride behind.
                let moved = now - then + stride.travel / 60.0;
                let speed = 60.0 * DVec3::new(moved.x, 0.0, moved.z).length();
                100.0 * speed * (2.0 - (now.y / 0.025).clamp(0.0, 1.0).exp2())
            })
            .sum();
        sum / f64::from(frames)
    }

    #[test]
    fn feet_do_not_skate() {
        let gaits = [(walk::gait(), 0.7), (run::gait(), 0.7), (sprint::gait(), 2.5), (crouch::gait(), 0.7)];
        for (gait, bar) in gaits.into_iter().chain([(sidle::back(), 0.7), (sidle::left(), 0.7)]) {
            for stride in &gait.strides {
                let skate = skate(stride);
                assert!(skate < bar, "{} skates at {skate:.2} cm/s", gait.name);
            }
        }
    }
}
