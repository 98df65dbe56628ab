//! Where up and forward are in a file, how long its unit is, and where its ground lies.

use bevy::math::{Affine3A, Mat3, Quat, Vec3};

use super::{
    humanoid::{Humanoid, HumanoidRole as Role},
    legs::{Body, vertices_below},
};
use crate::{
    anim::{leg::Leg, pose::Pose},
    math::rotation::direction_or,
};

/// Axes nearer than this (cosine) to one of the file's are taken to be that axis: bodies are never quite symmetric.
const NEAR_AXIS: f32 = 0.94;
/// Legs outside these lengths, in the file's metres, are in another unit: centimetres, or metres scaled down twice.
const LEG_LENGTHS: (f32, f32) = (0.02, 12.0);
/// Knees that are less than this share of the leg off the line from hip to ankle tell nothing.
const BENT: f32 = 0.008;
/// Feet reach at least so much farther to the front than to the back of the ankle.
const AHEAD: f32 = 1.3;
/// Shares of the leg's length by which ground and body may be off the file's origin without being moved.
const OFF_GROUND: f32 = 0.005;
const OFF_GROUND_GUESSED: f32 = 0.1;
const OFF_CENTRE: f32 = 0.05;

/// How a file lies in model space.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Frame {
    /// From the file's space to model space: +Y up, facing -Z, metres, the origin on the ground below the hips.
    pub(super) model_from_root: Affine3A,
    /// Up and forward in the file's space.
    pub(super) up: Vec3,
    pub(super) forward: Vec3,
    /// What told forward.
    pub(super) evidence: &'static str,
    /// Metres of one unit of the file.
    pub(super) unit: f32,
    /// Whether the joints called left are those on the right.
    pub(super) swapped: bool,
    /// Height of the soles over the file's origin, metres, before the frame was moved there.
    pub(super) ground: f32,
    /// What is odd about the file.
    pub(super) notes: Vec<String>,
}

/// From the file's space to model space for a file that says nothing: glTF faces +Z, model space -Z.
#[must_use]
pub fn gltf_default() -> Affine3A {
    Affine3A::from_quat(Quat::from_rotation_y(core::f32::consts::PI))
}

/// `direction`, or the axis of the file that it is near to.
pub(super) fn upward(direction: Vec3) -> Vec3 {
    on_axis(direction_or(direction, Vec3::Y))
}

/// Forward of two legs of which it isn't known which is the left one: where toes (`ahead` of the ankles) or knees point, else
/// glTF's own forward. `side` is a unit vector from one leg to the other.
pub(super) fn forward_of_legs(legs: [[Vec3; 3]; 2], ahead: [Vec3; 2], up: Vec3, side: Vec3) -> Vec3 {
    let forward = direction_or(side.cross(up), Vec3::Z);
    let length: f32 = legs.iter().map(|[hip, knee, ankle]| hip.distance(*knee) + knee.distance(*ankle)).sum();
    let toes = (ahead[0] + ahead[1]).dot(forward);
    let knees: f32 = legs.iter().map(|leg| knee_offset(*leg).dot(forward)).sum();
    let told = if toes.abs() > 0.04 * length {
        toes
    } else if knees.abs() > BENT * length {
        knees
    } else if forward.dot(Vec3::Z).abs() > 0.5 {
        forward.dot(Vec3::Z)
    } else {
        // Z-up tools have bodies face -Y.
        -forward.dot(Vec3::Y)
    };
    if told < 0.0 { -forward } else { forward }
}

/// How a file lies after where the joints of `humanoid` are at rest. Its ground is found by [`Frame::stand`].
pub(super) fn find(body: Body, humanoid: &Humanoid) -> Frame {
    let mut in_file = body.skeleton.clone();
    in_file.model_from_root = Affine3A::IDENTITY;
    let rest = Pose::rest(&in_file);
    let at = |role: Role| humanoid.get(role).map(|joint| rest.position(joint)).unwrap_or_default();
    let left = [Role::LeftUpperLeg, Role::LeftLowerLeg, Role::LeftFoot].map(at);
    let right = [Role::RightUpperLeg, Role::RightLowerLeg, Role::RightFoot].map(at);
    let hips = 0.5 * (left[0] + right[0]);
    let feet = 0.5 * (left[2] + right[2]);
    let head = humanoid.get(Role::Head).map_or(hips, |head| rest.position(head));
    let up = upward(head - feet);
    let aside = on_axis(direction_or(right[0] - left[0] - up * (right[0] - left[0]).dot(up), Vec3::NEG_X));
    let aside = direction_or(aside - up * aside.dot(up), Vec3::NEG_X);
    let leg = left[0].distance(left[1]) + left[1].distance(left[2]);

    // What joints called left and right say; what toes, feet and knees say weighs more.
    let named = up.cross(aside);
    let toes: Vec3 = [(Role::LeftFoot, Role::LeftToes), (Role::RightFoot, Role::RightToes)]
        .into_iter()
        .filter(|&(_, toes)| humanoid.get(toes).is_some())
        .map(|(foot, toes)| at(toes) - at(foot))
        .sum();
    let soles = [Role::LeftFoot, Role::RightFoot].map(|role| {
        let foot = humanoid.get(role).unwrap_or_default();
        let along = vertices_below(body, &rest, foot).map(|vertex| (vertex - rest.position(foot)).dot(named));
        let (back, front) = along.fold((0.0f32, 0.0f32), |(back, front), at| (back.max(-at), front.max(at)));
        if front > AHEAD * back || back > AHEAD * front { front - back } else { 0.0 }
    });
    let knees = knee_offset(left).dot(named) + knee_offset(right).dot(named);
    let (told, evidence) = if toes.dot(named).abs() > 0.3 * toes.length() && toes != Vec3::ZERO {
        (toes.dot(named), "toes")
    } else if (soles[0] + soles[1]).abs() > 0.02 * leg {
        (soles[0] + soles[1], "soles")
    } else if knees.abs() > BENT * leg {
        (knees, "knees")
    } else {
        (1.0, "left and right")
    };
    let mut frame = Frame { up, evidence, swapped: told < 0.0, unit: 1.0, ..Frame::default() };
    frame.forward = if frame.swapped { -named } else { named };
    if leg > LEG_LENGTHS.1 {
        frame.unit = 0.01;
    } else if leg > 0.0 && leg < LEG_LENGTHS.0 {
        frame.unit = 100.0;
    }
    if frame.unit.to_bits() != 1f32.to_bits() {
        frame.notes.push(format!("legs of {leg} m: lengths are taken times {}", frame.unit));
    }
    let model_from_file = Mat3::from_cols(frame.forward.cross(up), up, -frame.forward).transpose();
    frame.model_from_root = Affine3A::from_mat3(model_from_file * frame.unit);
    frame
}

impl Frame {
    /// Moves the body over the origin and its soles onto the ground, where they are off. `legs` are those of `body`, which lies
    /// as this frame says.
    pub(super) fn stand(&mut self, body: Body, legs: &[Leg; 2]) {
        let rest = Pose::rest(body.skeleton);
        let seen = legs.iter().all(|leg| vertices_below(body, &rest, leg.foot).next().is_some());
        let length = 0.5 * (legs[0].length() + legs[1].length());
        let lowest =
            |leg: &Leg| leg.sole().map(|point| point.position(&rest).y).into_iter().fold(f32::INFINITY, f32::min);
        let hips = 0.5 * (rest.position(legs[0].upper) + rest.position(legs[1].upper));
        self.ground = 0.5 * (lowest(&legs[0]) + lowest(&legs[1]));
        let mut by = Vec3::ZERO;
        // Soles without vertices are a guess.
        if self.ground.abs() > if seen { OFF_GROUND } else { OFF_GROUND_GUESSED } * length {
            by.y = -self.ground;
        }
        if Vec3::new(hips.x, 0.0, hips.z).length() > OFF_CENTRE * length {
            (by.x, by.z) = (-hips.x, -hips.z);
        }
        if by.is_finite() {
            self.model_from_root = Affine3A::from_translation(by) * self.model_from_root;
        }
    }
}

/// From the line between hip and ankle to the knee.
fn knee_offset([hip, knee, ankle]: [Vec3; 3]) -> Vec3 {
    let line = direction_or(ankle - hip, Vec3::ZERO);
    (knee - hip) - line * (knee - hip).dot(line)
}

/// The axis of the file nearest to `direction` if it is near.
fn on_axis(direction: Vec3) -> Vec3 {
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    axes.into_iter().find(|axis| axis.dot(direction) > NEAR_AXIS).unwrap_or(direction)
}
