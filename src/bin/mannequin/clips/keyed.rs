//! Bodies drawn by a few key poses with smooth curves between: for what is done once, not in cycles.

use super::body::{Arm, Figure, turn};
use super::curves::Spline;
use super::leg::{Footing, Sole, rest};
use glam::DVec3;

/// One foot of a [`Still`], as its left image.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Ankle of the flat foot, metres outward and forward.
    pub x: f64,
    pub z: f64,
    /// Metres the foot is lifted.
    pub up: f64,
    /// Degrees as in [`Footing`].
    pub pitch: f64,
    pub toes: f64,
    pub out: f64,
}

/// One arm of a [`Still`], degrees as in [`Arm`].
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    pub flex: f64,
    pub abduct: f64,
    pub elbow: f64,
    pub inward: f64,
    pub curl: f64,
}

/// A key pose.
#[derive(Clone, Copy, Debug)]
pub struct Still {
    /// Metres the hips are below their rest height, and forward.
    pub drop: f64,
    pub ahead: f64,
    /// Forward lean of pelvis, thorax and head in model space, degrees.
    pub pelvis: f64,
    pub thorax: f64,
    pub head: f64,
    pub shrug: f64,
    /// Left, right.
    pub steps: [Step; 2],
    pub arms: [Reach; 2],
}

const CHANNELS: usize = 28;

impl Still {
    /// Standing at ease on the feet of `idle`.
    pub const STANDING: Self = Self {
        drop: 0.017,
        ahead: 0.016,
        pelvis: 2.5,
        thorax: 0.5,
        head: 1.0,
        shrug: -3.0,
        steps: [
            Step { x: 0.100, z: 0.006, up: 0.0, pitch: 0.0, toes: 0.0, out: 9.0 },
            Step { x: 0.104, z: -0.030, up: 0.0, pitch: 0.0, toes: 0.0, out: 12.0 },
        ],
        arms: [
            Reach { flex: -5.0, abduct: 9.0, elbow: 17.0, inward: 14.0, curl: 0.34 },
            Reach { flex: -2.0, abduct: 9.0, elbow: 21.0, inward: 11.0, curl: 0.37 },
        ],
    };

    fn channels(&self) -> [f64; CHANNELS] {
        let [a, b] = self.steps.map(|s| [s.x, s.z, s.up, s.pitch, s.toes, s.out]);
        let [c, d] = self.arms.map(|r| [r.flex, r.abduct, r.elbow, r.inward, r.curl]);
        let body = [self.drop, self.ahead, self.pelvis, self.thorax, self.head, self.shrug];
        let mut all = [0.0; CHANNELS];
        for (slot, value) in all.iter_mut().zip(body.into_iter().chain(a).chain(b).chain(c).chain(d)) {
            *slot = value;
        }
        all
    }

    fn from_channels(v: [f64; CHANNELS]) -> Self {
        let step =
            |i: usize| Step { x: v[i], z: v[i + 1], up: v[i + 2], pitch: v[i + 3], toes: v[i + 4], out: v[i + 5] };
        let reach =
            |i: usize| Reach { flex: v[i], abduct: v[i + 1], elbow: v[i + 2], inward: v[i + 3], curl: v[i + 4] };
        Self {
            drop: v[0],
            ahead: v[1],
            pelvis: v[2],
            thorax: v[3],
            head: v[4],
            shrug: v[5],
            steps: [step(6), step(12)],
            arms: [reach(18), reach(23)],
        }
    }

    /// The body in this pose.
    #[must_use]
    pub fn figure(&self) -> Figure {
        let sole = Sole::left();
        let [left, right] = self.steps.map(|step| {
            let mut footing = Footing::flat(step.x, step.z, step.out);
            footing.ankle.y += step.up;
            Footing { pitch: step.pitch, toes: step.toes, ..footing }.foot(&sole)
        });
        let arms = self.arms.map(|reach| Arm {
            flex: reach.flex,
            abduct: reach.abduct,
            inward: reach.inward,
            elbow: reach.elbow,
            pronate: 22.0,
            wrist: 5.0,
            curl: reach.curl,
            shrug: self.shrug + 0.12 * (reach.abduct - 9.0).max(0.0),
            protract: 0.12 * reach.flex,
        });
        Figure {
            hips: DVec3::new(0.0, rest("hips").y - self.drop, self.ahead),
            pelvis: turn(0.0, self.pelvis, 0.0),
            thorax: turn(0.0, self.thorax, 0.0),
            head: turn(0.0, self.head, 0.0),
            arms,
            feet: [left, right.mirrored()],
            knees_out: [8.0, 9.0],
        }
    }
}

/// Key poses over time.
#[derive(Clone, Debug)]
pub struct Keyed {
    channels: Vec<Spline>,
}

impl Keyed {
    /// Through `keys` (seconds, pose), at rest at both ends.
    #[must_use]
    pub fn new(keys: &[(f64, Still)]) -> Self {
        let rows: Vec<(f64, [f64; CHANNELS])> = keys.iter().map(|(time, still)| (*time, still.channels())).collect();
        let spline = |i: usize| {
            let knots: Vec<(f64, f64)> = rows.iter().map(|(time, row)| (*time, row[i])).collect();
            Spline::level(&knots)
        };
        Self { channels: (0..CHANNELS).map(spline).collect() }
    }

    /// The pose at `time`.
    #[must_use]
    pub fn at(&self, time: f64) -> Still {
        let mut values = [0.0; CHANNELS];
        for (value, channel) in values.iter_mut().zip(&self.channels) {
            *value = channel.at(time);
        }
        Still::from_channels(values)
    }
}
