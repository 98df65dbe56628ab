//! Finds the ground: downward rays, and footprints that have room for a whole sole.
//!
//! World space, metres. Reads colliders through [`Probe`]; writes nothing.

use bevy::prelude::*;

use super::board::{Profile, resting};

/// Where a probe met the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroundHit {
    /// World position.
    pub point: Vec3,
    /// World normal, up-facing.
    pub normal: Vec3,
    /// The collider's entity.
    pub entity: Entity,
}

/// Casts straight down.
pub trait Probe {
    /// The first ground below `start` within `length` metres.
    fn down(&self, start: Vec3, length: f32) -> Option<GroundHit>;

    /// World height of the first ground below `start` within `length` metres.
    fn height(&self, start: Vec3, length: f32) -> Option<f32> {
        self.down(start, length).map(|hit| hit.point.y)
    }

    /// The ground that `reach` reaches at a horizontal place; the height of `place` doesn't matter.
    fn at(&self, place: Vec3, reach: &Reach) -> Option<GroundHit> {
        let (start, length) = reach.ray(place);
        self.down(start, length)
    }

    /// World height of that.
    fn height_at(&self, place: Vec3, reach: &Reach) -> Option<f32> {
        let (start, length) = reach.ray(place);
        self.height(start, length)
    }
}

/// Heights between which ground is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// The root, world: at its own height the ground is expected, and further off it may be as much higher or lower as
    /// stairs rise.
    pub root: Vec3,
    /// Metres above the expected ground at which rays start.
    pub up: f32,
    /// Metres below it at which they end.
    pub down: f32,
    /// Least height of a unit normal of ground that a foot stands on: the cosine of the steepest.
    pub upright: f32,
}

/// Rise over run that ground may have on the way from the root to a place: steep stairs have 0.9.
const STEEPEST: f32 = 0.9;

impl Reach {
    /// Metres above and below the root between which rays run that start within `radius` metres of it on both axes.
    pub(super) fn tallest(self, radius: f32) -> f32 {
        self.up.max(self.down) + STEEPEST * core::f32::consts::SQRT_2 * radius + 0.01
    }

    /// The ground at a horizontal place; the height of `place` doesn't matter.
    pub fn at(self, probe: &impl Probe, place: Vec3) -> Option<GroundHit> {
        probe.at(place, &self)
    }

    /// World height of the ground at a horizontal place.
    pub fn height(self, probe: &impl Probe, place: Vec3) -> Option<f32> {
        probe.height_at(place, &self)
    }

    /// Whether ground at this height is within reach at every place.
    pub(super) fn reaches(&self, height: f32) -> bool {
        height < self.root.y + self.up && height > self.root.y - self.down
    }

    /// Where a ray straight down through a place starts, and its length.
    pub(super) fn ray(&self, place: Vec3) -> (Vec3, f32) {
        let away = place - self.root;
        let rise = STEEPEST * Vec2::new(away.x, away.z).length();
        let start = Vec3::new(place.x, self.root.y + self.up + rise, place.z);
        (start, self.up + self.down + 2.0 * rise)
    }
}

/// A plane under a foot: world height at a place, and its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point of it.
    pub point: Vec3,
    /// Unit normal with `y > 0`.
    pub normal: Vec3,
}

impl Plane {
    /// World height of the plane over a horizontal place.
    #[must_use]
    pub fn height(&self, place: Vec3) -> f32 {
        let away = place - self.point;
        self.point.y - (self.normal.x * away.x + self.normal.z * away.z) / self.normal.y.max(0.2)
    }
}

/// A sole's shape when it stands flat: offsets from the ball along the foot's direction, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SoleShape {
    /// From ball back to heel, positive.
    pub heel: f32,
    /// From ball forward to the toes' tip, positive.
    pub tip: f32,
    /// From ball back to the ankle joint above the sole, positive.
    pub ankle: f32,
    /// Height of the ankle joint over the sole.
    pub ankle_height: f32,
    /// Whether it bends at the toes, so that the heel lifts while they lie flat.
    pub bends: bool,
}

/// Length in metres of the sole that the lengths below are meant for: the mannequin's. They scale with it.
const TUNED_SOLE: f32 = 0.265;

impl SoleShape {
    /// Its length as a factor on the mannequin's.
    #[must_use]
    pub fn size(&self) -> f32 {
        (self.heel + self.tip) / TUNED_SOLE
    }
}

/// How well a sole would stand somewhere.
#[derive(Clone, Copy, Debug)]
pub struct Footprint {
    /// Ground under the ball; where heel and tip rest on what is higher, where they hold the ball over it.
    pub ball: GroundHit,
    /// Normal of the plane that carries the sole: the ball's, pitched so that heel and tip are carried too.
    pub normal: Vec3,
    /// Metres by which heel or tip would stick in the ground, were the sole laid on that plane.
    pub stuck: f32,
    /// Metres between the heel and the ground below it.
    pub heel_gap: f32,
}

impl Footprint {
    /// Whether `sole` lies on the plane without sticking in the ground.
    #[must_use]
    pub fn has_room(&self, sole: &SoleShape) -> bool {
        self.stuck <= TOLERATED * sole.size()
    }
}

/// Metres that a sole may sink at heel or tip without counting as stuck; rough ground is never a plane.
pub(super) const TOLERATED: f32 = 0.004;
/// Metres between the places that a landing tries.
const SHIFT_STEP: f32 = 0.02;
/// Metres of unevenness under a sole that a pitch of the foot takes up; more is an edge.
const PITCHED: f32 = 0.06;
/// Metres by which a foot that finds no room is propped up at one end rather than sunk in.
pub(super) const PROPPED: f32 = 0.16;
/// Metres before and behind the ball that must still carry it: toes and heel may hang over an edge, the ball not.
const FOOTING: f32 = 0.03;
/// Metres that toes keep from a riser ahead, so that they clear it when they lift; and a heel from one behind, so that it
/// clears that when it lands.
const TOE_ROOM: f32 = 0.05;
const HEEL_ROOM: f32 = 0.025;

/// How the sole would stand with its ball over `ball`, pointing along `forward` (horizontal unit vector).
pub fn footprint(probe: &impl Probe, reach: Reach, ball: Vec3, forward: Vec3, sole: SoleShape) -> Option<Footprint> {
    let under_ball = reach.at(probe, ball)?;
    let size = sole.size();
    let ground = |along: f32| reach.height(probe, ball + forward * along).unwrap_or(f32::NEG_INFINITY);
    let profile = Profile::of(sole, 1.0, |along| ground(along) - under_ball.point.y);
    let rise_of = |normal: Vec3| -normal.dot(forward) / normal.y.max(0.2);
    let over = |slope: f32| profile.over(slope);
    let mut slope = rise_of(under_ball.normal);
    let worst = over(slope).fold((0.0, 0.0f32), |worst, point| if point.1 > worst.1 { point } else { worst });
    let level = slope;
    if worst.1 > 0.0 && worst.1 < PROPPED * size {
        slope += worst.1 / worst.0;
    }
    // What takes more than a bit of pitch is no room, but the best that a foot makes of it.
    let judged = if worst.1 < PITCHED * size { slope } else { level };
    let toes = sole.tip + TOE_ROOM * size;
    let riser = ground(toes) - under_ball.point.y - slope * toes;
    let drop = |along: f32| under_ball.point.y + slope * along - ground(along);
    let edge = drop(FOOTING * size).max(drop(-FOOTING * size));
    let stuck = over(judged).map(|point| point.1).fold(0.0, f32::max);
    let heel = sole.heel + HEEL_ROOM * size;
    let behind = ground(-heel) - under_ball.point.y + slope * heel;
    // On the brink or on what is too steep is bad, in a riser worse.
    let steep = under_ball.normal.y < reach.upright;
    let stuck = if steep || edge.max(behind) > PITCHED * size { stuck.max(2.0 * TOLERATED * size) } else { stuck };
    let rest = resting(&profile, slope, sole, |along| ground(along) - under_ball.point.y);
    let heel = over(rest.slope).next().map_or(0.0, |(_, height)| height);
    Some(Footprint {
        ball: GroundHit { point: under_ball.point + Vec3::Y * rest.lift, ..under_ball },
        normal: pitched(under_ball.normal, forward, rest.slope),
        stuck: if riser > PITCHED * size { stuck.max(riser) } else { stuck },
        heel_gap: (rest.lift - heel).max(0.0),
    })
}

/// `normal` turned about the foot's side axis so that the plane rises by `slope` along `forward`.
fn pitched(normal: Vec3, forward: Vec3, slope: f32) -> Vec3 {
    let side = forward.cross(Vec3::Y);
    let across = -normal.dot(side) / normal.y.max(0.2);
    (Vec3::Y - forward * slope - side * across).normalize_or(Vec3::Y)
}

/// A place near `ball` where the whole sole has room: the shift along `forward` in metres, and the footprint there.
///
/// `preferred` is tried first, so that a decision stays from frame to frame. Where nothing near has room, the least stuck
/// place wins. `None` where there is no ground at all.
pub fn find_room(
    probe: &impl Probe,
    reach: Reach,
    ball: Vec3,
    forward: Vec3,
    sole: SoleShape,
    preferred: f32,
    most: f32,
) -> Option<(f32, Footprint)> {
    let mut best: Option<(f32, Footprint)> = None;
    let step = SHIFT_STEP * sole.size();
    let steps = (most / step).ceil().max(0.0) as i32;
    let others = core::iter::once(0.0)
        .chain((1..=steps).flat_map(|i| [i as f32 * step, -(i as f32) * step]))
        .filter(|shift| (shift - preferred).abs() > 0.0);
    for shift in core::iter::once(preferred).chain(others).filter(|shift| shift.abs() <= most) {
        let Some(print) = footprint(probe, reach, ball + forward * shift, forward, sole) else { continue };
        if print.has_room(&sole) {
            return Some((shift, print));
        }
        if best.is_none_or(|(_, least)| print.stuck < least.stuck) {
            best = Some((shift, print));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stairs along -Z: treads 0.29 deep, risers 0.17, the first edge at z = 0.
    struct Stairs;

    impl Probe for Stairs {
        fn down(&self, start: Vec3, length: f32) -> Option<GroundHit> {
            let y = (-start.z / 0.29).floor().max(-1.0) * 0.17 + 0.17;
            (start.y - y <= length).then_some(GroundHit {
                point: Vec3::new(start.x, y, start.z),
                normal: Vec3::Y,
                entity: Entity::PLACEHOLDER,
            })
        }
    }

    const SOLE: SoleShape = SoleShape { heel: 0.19, tip: 0.075, ankle: 0.135, ankle_height: 0.07, bends: true };
    const REACH: Reach = Reach { root: Vec3::ZERO, up: 3.0, down: 3.0, upright: 0.6 };

    #[test]
    fn toes_never_land_inside_the_next_riser() {
        for i in 0..29 {
            let ball = Vec3::new(0.0, 0.0, -0.6 - 0.01 * i as f32);
            let (shift, print) =
                find_room(&Stairs, REACH, ball, Vec3::NEG_Z, SOLE, 0.0, 0.2).expect("stairs everywhere");
            assert!(print.stuck <= 0.004, "{:.3} m stuck after a shift of {shift:.2} m", print.stuck);
        }
    }

    #[test]
    fn going_down_the_heel_finds_room_too() {
        for i in 0..29 {
            let ball = Vec3::new(0.0, 0.0, -1.5 + 0.01 * i as f32);
            let (shift, print) = find_room(&Stairs, REACH, ball, Vec3::Z, SOLE, 0.0, 0.2).expect("stairs everywhere");
            assert!(print.stuck <= 0.004, "{:.3} m stuck after a shift of {shift:.2} m", print.stuck);
        }
    }

    #[test]
    fn a_sole_longer_than_the_treads_rests_on_their_edges() {
        // As long as a tread and a half.
        let sole = SoleShape { heel: 0.28, tip: 0.16, ..SOLE };
        for i in 0..29 {
            let ball = Vec3::new(0.0, 0.0, -0.9 - 0.01 * i as f32);
            let print = footprint(&Stairs, REACH, ball, Vec3::NEG_Z, sole).expect("stairs everywhere");
            let plane = Plane { point: print.ball.point, normal: print.normal };
            for along in [-0.28, 0.0, 0.16] {
                let place = ball + Vec3::NEG_Z * along;
                let ground = REACH.height(&Stairs, place).expect("stairs everywhere");
                let deep = ground - plane.height(place);
                assert!(deep < 0.01, "{deep:.3} m deep {along} m from the ball, {i} cm on");
            }
        }
    }

    /// A wall of 60° rises along -Z from z = 0 on; level ground before it.
    struct Bank;

    impl Probe for Bank {
        fn down(&self, start: Vec3, length: f32) -> Option<GroundHit> {
            let (rise, normal) = if start.z < 0.0 { (1.732, Vec3::new(0.0, 0.5, 0.866)) } else { (0.0, Vec3::Y) };
            let y = -start.z * rise;
            let point = Vec3::new(start.x, y, start.z);
            (start.y - y <= length).then_some(GroundHit { point, normal, entity: Entity::PLACEHOLDER })
        }
    }

    #[test]
    fn what_is_too_steep_is_no_room() {
        let ball = Vec3::new(0.0, 0.0, -0.02);
        let reach = |upright: f32| Reach { upright, ..REACH };
        let find = |upright: f32| find_room(&Bank, reach(upright), ball, Vec3::X, SOLE, 0.0, 0.2);
        let (_, print) = find(0.64).expect("ground everywhere");
        assert!(print.stuck > TOLERATED, "stands on 60°");
        let (_, print) = find(0.4).expect("ground everywhere");
        assert!(print.stuck <= TOLERATED, "{} m stuck on a slope that it may stand on", print.stuck);
    }

    #[test]
    fn a_plane_gives_heights_along_its_slope() {
        let plane = Plane { point: Vec3::ZERO, normal: Vec3::new(0.0, 1.0, 1.0).normalize() };
        let y = plane.height(Vec3::new(3.0, 0.0, -2.0));
        assert!((y - 2.0).abs() < 1e-5, "{y}");
    }
}
