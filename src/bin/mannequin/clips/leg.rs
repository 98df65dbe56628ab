//! The leg: sole geometry of the left foot, and the two-bone solution from hip to ankle.
//!
//! Everything here is for the LEFT side in the file's model space (metres, +Y up, facing +Z); the right side is its
//! mirror image in X, see [`mirror_point`] and [`mirror_turn`].

use super::super::skeleton::{HEEL, JOINTS, TIP, index};
use glam::{DMat3, DQuat, DVec3};

/// Rest position of a joint, metres.
#[must_use]
pub fn rest(name: &str) -> DVec3 {
    JOINTS[index(name)].position.as_dvec3()
}

/// Points of the left foot at rest, metres. The ball is where the toe joint is: the sole under it stays put while the
/// heel lifts, so heel rocker turns about `heel`, ball rocker about `toe_joint`, toe-off about `tip`.
#[derive(Clone, Copy, Debug)]
pub struct Sole {
    pub ankle: DVec3,
    pub heel: DVec3,
    pub toe_joint: DVec3,
    pub tip: DVec3,
}

impl Sole {
    /// The left foot of the skeleton table.
    #[must_use]
    pub fn left() -> Self {
        Self { ankle: rest("leftFoot"), heel: HEEL.as_dvec3(), toe_joint: rest("leftToes"), tip: TIP.as_dvec3() }
    }
}

/// Where a foot is: ankle joint, turn of the foot and turn of the toes, all in model space.
#[derive(Clone, Copy, Debug)]
pub struct Foot {
    pub ankle: DVec3,
    pub turn: DQuat,
    pub toes: DQuat,
}

impl Foot {
    /// Under the heel, under the toe joint, under the toes' tip.
    #[must_use]
    pub fn points(&self, sole: &Sole) -> [DVec3; 3] {
        let toe_joint = self.ankle + self.turn * (sole.toe_joint - sole.ankle);
        let under = DVec3::new(0.0, -sole.toe_joint.y, 0.0);
        [
            self.ankle + self.turn * (sole.heel - sole.ankle),
            toe_joint + self.toes * under,
            toe_joint + self.toes * (sole.tip - sole.toe_joint),
        ]
    }

    /// Which of the sole's points is lowest.
    #[must_use]
    pub fn lowest_point(&self, sole: &Sole) -> usize {
        let points = self.points(sole);
        (1..3).fold(0, |lowest, point| if points[point].y < points[lowest].y { point } else { lowest })
    }

    /// The same foot on the other side.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { ankle: mirror_point(self.ankle), turn: mirror_turn(self.turn), toes: mirror_turn(self.toes) }
    }
}

/// A left foot on the ground: where it would stand flat, and how it is rolled from there. Angles in degrees.
#[derive(Clone, Copy, Debug)]
pub struct Footing {
    /// Ankle of the flat foot, metres; lifted feet have it higher.
    pub ankle: DVec3,
    /// Toes outward +.
    pub toe_out: f64,
    /// Toes up +; the foot turns about its heel, or about the toe joint when negative.
    pub pitch: f64,
    /// Toes against the foot, up +. Toes that would point into the ground stand on their tip instead.
    pub toes: f64,
}

impl Footing {
    /// Flat at `x` (outward) and `z`.
    #[must_use]
    pub fn flat(x: f64, z: f64, toe_out: f64) -> Self {
        Self { ankle: DVec3::new(x, rest("leftFoot").y, z), toe_out, pitch: 0.0, toes: 0.0 }
    }

    /// The foot so rolled.
    #[must_use]
    pub fn foot(&self, sole: &Sole) -> Foot {
        let heading = DQuat::from_rotation_y(self.toe_out.to_radians());
        let turn = heading * DQuat::from_rotation_x(-self.pitch.to_radians());
        let toe_pitch = self.pitch + self.toes;
        let toes = heading * DQuat::from_rotation_x(-toe_pitch.to_radians());
        let flat = |point: DVec3| self.ankle + heading * (point - sole.ankle);
        let ankle = if self.pitch > 0.0 {
            flat(sole.heel) + turn * (sole.ankle - sole.heel)
        } else if toe_pitch < 0.0 {
            flat(sole.tip) + toes * (sole.toe_joint - sole.tip) + turn * (sole.ankle - sole.toe_joint)
        } else {
            flat(sole.toe_joint) + turn * (sole.ankle - sole.toe_joint)
        };
        Foot { ankle, turn, toes }
    }
}

/// `p` seen in the plane x = 0.
#[must_use]
pub fn mirror_point(p: DVec3) -> DVec3 {
    DVec3::new(-p.x, p.y, p.z)
}

/// `q` seen in the plane x = 0.
#[must_use]
pub fn mirror_turn(q: DQuat) -> DQuat {
    DQuat::from_xyzw(q.x, -q.y, -q.z, q.w)
}

/// Model-space turns of thigh and shank.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    pub thigh: DQuat,
    pub shank: DQuat,
}

/// The leg from `hip` to `ankle`, its knee toward `forward` (need not be square to the leg).
///
/// A distance the bones cannot make gives the nearest they can.
#[must_use]
pub fn solve(hip: DVec3, ankle: DVec3, forward: DVec3) -> Leg {
    let thigh_rest = rest("leftLowerLeg") - rest("leftUpperLeg");
    let shank_rest = rest("leftFoot") - rest("leftLowerLeg");
    let (thigh, shank) = (thigh_rest.length(), shank_rest.length());
    let line = ankle - hip;
    let reach = line.length().clamp((thigh - shank).abs() + 1e-6, thigh + shank - 1e-9);
    let down = line.normalize();
    let hinge = down.cross(forward).normalize();
    let ahead = hinge.cross(down);
    let cos = (thigh * thigh + reach * reach - shank * shank) / (2.0 * thigh * reach);
    let along = thigh * cos;
    let knee = hip + down * along + ahead * (thigh * thigh - along * along).max(0.0).sqrt();
    let end = hip + down * reach;
    Leg { thigh: hinge_turn(thigh_rest, knee - hip, hinge), shank: hinge_turn(shank_rest, end - knee, hinge) }
}

/// The turn that brings the rest direction (in the plane x = 0) to `direction` and the rest hinge to `hinge`.
fn hinge_turn(rest: DVec3, direction: DVec3, hinge: DVec3) -> DQuat {
    let rest_hinge = DVec3::NEG_X;
    let basis = |y: DVec3, x: DVec3| DMat3::from_cols(x, y, x.cross(y));
    DQuat::from_mat3(&(basis(direction.normalize(), hinge) * basis(rest.normalize(), rest_hinge).transpose()))
        .normalize()
}
