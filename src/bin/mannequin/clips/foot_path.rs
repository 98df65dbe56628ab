//! The path of one foot through a stride: planted on exact contact points, then swung to where it lands next.
//!
//! Written for the LEFT foot; the right one is the mirror image half a stride later. Model space of the file, in place:
//! the ground runs under the body at `−travel` m/s. Phase 0..1 from initial contact; angles in degrees.

use super::curves::{Spline, ease};
use super::leg::{Foot, Footing, Sole};
use glam::DVec3;

/// Share of the acceleration of stance that swing takes over; with all of it the foot would linger where it left.
const FIRMNESS: f64 = 0.3;
/// Metres that a sole flies clear of the ground at least; 3 to 4 cm read well in games, people show 1 to 2 cm.
const CLEARANCE: f64 = 0.034;

/// How a foot stands, rolls and swings.
///
/// In stance a positive pitch turns the foot about its heel, a negative one about the toe joint while the toes lie flat,
/// and from `tip_off` on the toes lift too, about their tip. All three points lie still on the ground in their time.
pub struct Stride {
    /// Seconds from one contact to the next.
    pub period: f64,
    /// Velocity of the body over the ground, m/s.
    pub travel: DVec3,
    /// Phase at which the foot leaves the ground.
    pub toe_off: f64,
    /// Phase from which only the tip of the toes stays.
    pub tip_off: f64,
    /// Ankle of the flat foot at phase 0, metres; its height is that of the skeleton.
    pub placement: DVec3,
    /// Toes outward +.
    pub toe_out: f64,
    /// Pitch of the foot, toes up +.
    pub pitch: Spline,
    /// Bend of the toes against the foot from `tip_off` to the next flat stance, up +.
    pub toes: Spline,
    /// Ankle in swing that the path is drawn after, at any phase; it need not meet the stance. `None`: straight ahead.
    pub swing: Option<Box<dyn Fn(f64) -> DVec3>>,
    /// Widths of phase over which the drawn path is bent to the stance, after leaving and before landing.
    pub bends: [f64; 2],
    /// Seconds after leaving, and before landing, in which the foot is eased to the place where it stands.
    pub hold: [f64; 2],
    /// Seconds from leaving to [`CLEARANCE`], and from there to landing.
    pub rise: [f64; 2],
    /// Bumps of the drawn path.
    pub bumps: Vec<Bump>,
    /// Points of the sole at rest.
    pub sole: Sole,
}

/// A smooth bump of a path: `by` metres at phase `peak`, nothing from `width` away on.
#[derive(Clone, Copy, Debug)]
pub struct Bump {
    pub peak: f64,
    pub width: f64,
    pub by: DVec3,
}

impl Bump {
    /// `up` and `ahead` in metres.
    #[must_use]
    pub const fn new(peak: f64, width: f64, up: f64, ahead: f64) -> Self {
        Self { peak, width, by: DVec3::new(0.0, up, ahead) }
    }

    fn at(&self, phase: f64) -> DVec3 {
        let t = (phase - self.peak) / self.width;
        self.by * (1.0 - t * t).max(0.0).powi(3)
    }
}

impl Stride {
    /// The foot at `phase`.
    #[must_use]
    pub fn foot(&self, phase: f64) -> Foot {
        let phase = phase.rem_euclid(1.0);
        let mut foot = self.planted(phase);
        if phase > self.toe_off {
            foot.ankle = self.swung(phase);
            foot.ankle += self.clearing(phase, &foot);
        }
        foot
    }

    /// What keeps a foot near the ground from skating: it leaves the ground upward and comes down on its place.
    ///
    /// The point that leaves last holds its place until it is off the ground, the point that lands first is over its place
    /// before it touches; between, the sole flies no lower than [`CLEARANCE`].
    fn clearing(&self, phase: f64, foot: &Foot) -> DVec3 {
        let (since, left) = ((phase - self.toe_off) * self.period, (1.0 - phase) * self.period);
        let on_ground = |foot: &Foot, point: usize, phase: f64| {
            foot.points(&self.sole)[point] + self.travel * (phase * self.period)
        };
        let held = |at: f64, meets: f64, still: f64| {
            let there = self.planted(at);
            let point = there.lowest_point(&self.sole);
            let away = on_ground(foot, point, phase) - on_ground(&there, point, meets);
            DVec3::new(away.x, 0.0, away.z) * still
        };
        let leaving = held(self.toe_off, self.toe_off, 1.0 - ease(0.0, self.hold[0], since));
        let landing = held(0.0, 1.0, 1.0 - ease(0.0, self.hold[1], left));
        let points = foot.points(&self.sole);
        let height = points[foot.lowest_point(&self.sole)].y;
        let wanted = CLEARANCE * ease(0.0, self.rise[0], since) * ease(0.0, self.rise[1], left);
        // The greater of both, rounded off where they meet.
        let round = 0.3 * wanted;
        let raised = 0.5 * (height + wanted + ((height - wanted).powi(2) + round * round).sqrt());
        DVec3::Y * (raised - height) - leaving - landing
    }

    fn pitch_at(&self, phase: f64) -> f64 {
        self.pitch.at(self.pitch.wrapped(phase))
    }

    fn toe_bend(&self, phase: f64, pitch: f64) -> f64 {
        if phase >= self.tip_off {
            self.toes.at(phase)
        } else if pitch <= 0.0 {
            -pitch
        } else {
            self.toes.at(self.toes.wrapped(phase))
        }
    }

    /// The foot as the ground contact of stance holds it, also a little beyond.
    fn planted(&self, phase: f64) -> Foot {
        let pitch = self.pitch_at(phase);
        let ankle = self.placement - self.travel * (phase * self.period);
        Footing { ankle, toe_out: self.toe_out, pitch, toes: self.toe_bend(phase, pitch) }.foot(&self.sole)
    }

    /// The ankle that swing is drawn after: as given, or straight from where it leaves to where it lands.
    fn drawn(&self, phase: f64) -> DVec3 {
        let path = self.swing.as_ref().map_or_else(
            || {
                let (from, to) = (self.planted(self.toe_off).ankle, self.planted(0.0).ankle);
                from.lerp(to, ease(self.toe_off, 1.0, phase))
            },
            |swing| swing(phase),
        );
        self.bumps.iter().fold(path, |path, bump| path + bump.at(phase))
    }

    /// The ankle in swing: the drawn path, bent at both ends so that place and velocity (and some of the acceleration)
    /// meet the stance.
    fn swung(&self, phase: f64) -> DVec3 {
        let [leave, land] = self.bends;
        let left = Miss::between(|p| self.planted(p).ankle, |p| self.drawn(p), self.toe_off);
        let landed = Miss::between(|p| self.planted(p - 1.0).ankle, |p| self.drawn(p), 1.0);
        let after = left.fading(leave, (phase - self.toe_off) / leave);
        let before = landed.backward().fading(land, (1.0 - phase) / land);
        self.drawn(phase) + after + before
    }
}

/// Bend of the toes from `tip_off` on, through `knots`.
///
/// It goes on from toes lying flat under a foot of this `pitch`; a foot that lands on its ball gets flat toes at landing,
/// one that lands on its heel must have a last knot where it comes to lie flat.
#[must_use]
pub fn toe_curve(pitch: &Spline, tip_off: f64, knots: &[(f64, f64)]) -> Spline {
    let step = 1e-4;
    let flat = |phase: f64| {
        let value = (-pitch.at(phase)).max(0.0);
        let slope = (pitch.at(phase - step) - pitch.at(phase + step)) / (2.0 * step);
        (value, if value > 0.0 { slope } else { 0.0 })
    };
    let (first, first_slope) = flat(tip_off);
    let (last, last_slope) = flat(1.0);
    let mut all = vec![(tip_off, first)];
    all.extend(knots);
    if last > 0.0 {
        all.push((1.0, last));
    }
    Spline::clamped(&all, first_slope, last_slope)
}

/// How far the stance is from the drawn swing at one phase: place, velocity and acceleration per phase.
struct Miss {
    place: DVec3,
    velocity: DVec3,
    acceleration: DVec3,
}

impl Miss {
    fn between(stance: impl Fn(f64) -> DVec3, swing: impl Fn(f64) -> DVec3, phase: f64) -> Self {
        let step = 1e-4;
        let miss = |p: f64| stance(p) - swing(p);
        let (before, here, after) = (miss(phase - step), miss(phase), miss(phase + step));
        Self {
            place: here,
            velocity: (after - before) / (2.0 * step),
            acceleration: FIRMNESS * (after - 2.0 * here + before) / (step * step),
        }
    }

    /// The same, with phase running backward.
    fn backward(self) -> Self {
        Self { velocity: -self.velocity, ..self }
    }

    /// The quintic from this miss to none over `width` of phase, at `t`; none from t = 1 on.
    fn fading(&self, width: f64, t: f64) -> DVec3 {
        let u = (1.0 - t).max(0.0);
        let velocity = self.velocity * width;
        let acceleration = self.acceleration * width * width;
        let (place, rise) = (self.place, velocity + 3.0 * self.place);
        u * u * u * (place + t * (rise + t * (3.0 * rise - 3.0 * place + 0.5 * acceleration)))
    }
}
