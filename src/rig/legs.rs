//! Legs out of the rest pose and the vertices of the feet: lengths, the knee's axis, the sole.
//!
//! Model space, metres, +Y up, the character faces -Z.

use bevy::math::Vec3;

use super::{
    character_file::Soles,
    humanoid::{Humanoid, HumanoidError, HumanoidRole as Role},
};
use crate::{
    anim::{
        leg::{Leg, SolePoint},
        pose::Pose,
        skeleton::{JointIndex, Skeleton},
    },
    math::rotation::direction_or,
};

/// Vertices within this share of the leg's length over the lowest one belong to the sole: 2 cm on a leg of 0.875 m.
const SOLE: f32 = 0.023;
/// Share of the foot's length around a point in which the sole's lowest vertex counts for it.
const NEAR: f32 = 0.12;
/// Foot of a body without vertices, in shares of the leg's length (after GAIT figures of a 1.80 m body): ankle height,
/// heel behind the ankle, ball before it, tip before the ball.
const TYPICAL: [f32; 4] = [0.08, 0.063, 0.154, 0.086];
/// Height of the toe joint of such a body, as a share of the leg's length.
const TOE_HEIGHT: f32 = 0.025;
/// Ball's place between heel and tip, where there are no toes.
const BALL: f32 = 0.7;

/// The longer leg of a pair is less than so many times as long as the shorter one.
const UNEVEN: f32 = 1.6;

/// A skeleton whose `model_from_root` is set, and by joint the vertices that it moves most, in joint space.
#[derive(Clone, Copy)]
pub(super) struct Body<'a> {
    pub(super) skeleton: &'a Skeleton,
    pub(super) dominated: &'a [Vec<Vec3>],
}

/// Both legs, `[left, right]`.
pub(super) fn legs(body: Body, humanoid: &Humanoid) -> Result<[Leg; 2], HumanoidError> {
    let rest = Pose::rest(body.skeleton);
    let left = [Role::LeftUpperLeg, Role::LeftLowerLeg, Role::LeftFoot, Role::LeftToes];
    let right = [Role::RightUpperLeg, Role::RightLowerLeg, Role::RightFoot, Role::RightToes];
    let legs = [leg(body, humanoid, &rest, left)?, leg(body, humanoid, &rest, right)?];
    let [left_length, right_length] = legs.map(|leg| leg.length());
    if left_length.max(right_length) > UNEVEN * left_length.min(right_length) {
        let [left, right] =
            legs.map(|leg| leg.joints().map(|joint| format!("`{}`", body.skeleton.name(joint))).join(", "));
        return Err(HumanoidError::Uneven { left, left_length, right, right_length });
    }
    Ok(legs)
}

/// Puts the soles where the file says. Points are metres of the unscaled model; the skeleton's scale applies to them.
pub(super) fn place_soles(skeleton: &Skeleton, legs: &mut [Leg; 2], soles: &Soles, scale: f32) {
    let rest = Pose::rest(skeleton);
    for (leg, side) in legs.iter_mut().zip([-1.0, 1.0]) {
        let place = |(left, up, forward): (f32, f32, f32)| scale * Vec3::new(side * left, up, -forward);
        let front = leg.toes.unwrap_or(leg.foot);
        leg.heel = SolePoint::at(&rest, leg.foot, place(soles.heel));
        leg.ball = SolePoint::at(&rest, front, place(soles.ball));
        leg.tip = SolePoint::at(&rest, front, place(soles.tip));
    }
}

fn leg(body: Body, humanoid: &Humanoid, rest: &Pose, roles: [Role; 4]) -> Result<Leg, HumanoidError> {
    let joint = |role: Role| humanoid.get(role).unwrap_or_default();
    let [upper, lower, foot] = [joint(roles[0]), joint(roles[1]), joint(roles[2])];
    let toes = humanoid.get(roles[3]);
    let [hip, knee, ankle] = [upper, lower, foot].map(|joint| rest.position(joint));
    let (thigh, shin) = (hip.distance(knee), knee.distance(ankle));
    for (length, above, below) in [(thigh, 0, 1), (shin, 1, 2)] {
        if length.is_nan() || length < 1e-4 {
            return Err(HumanoidError::NoLength {
                role: roles[below].spelling(),
                joint: body.skeleton.name(joint(roles[below])).to_owned(),
                above_role: roles[above].spelling(),
                above: body.skeleton.name(joint(roles[above])).to_owned(),
            });
        }
    }
    let thigh_from_model = rest.rotation(upper).inverse();
    let knee_axis = (thigh_from_model * knee_axis(hip, knee, ankle)).normalize();
    let [heel, ball, tip] = sole(body, rest, thigh + shin, foot, toes);
    let front = toes.unwrap_or(foot);
    Ok(Leg {
        upper,
        lower,
        foot,
        toes,
        thigh,
        shin,
        knee_axis,
        heel: SolePoint::at(rest, foot, heel),
        ball: SolePoint::at(rest, front, ball),
        tip: SolePoint::at(rest, front, tip),
    })
}

/// Unit axis about which the shin turns back and up; from the bend at rest, else to the character's left.
fn knee_axis(hip: Vec3, knee: Vec3, ankle: Vec3) -> Vec3 {
    let (thigh, shin) = (direction_or(knee - hip, Vec3::NEG_Y), direction_or(ankle - knee, Vec3::NEG_Y));
    let left = direction_or(Vec3::NEG_X - thigh * Vec3::NEG_X.dot(thigh), Vec3::NEG_X);
    let bend = thigh.cross(shin);
    // Below three degrees of bend the direction is noise; a bend to the front or far to the side is no knee's.
    if bend.length() < 0.05 {
        return left;
    }
    let bend = bend.normalize();
    if bend.dot(left) > 0.5 { bend } else { left }
}

/// Heel, ball and tip of a sole in model space.
fn sole(body: Body, rest: &Pose, leg: f32, foot: JointIndex, toes: Option<JointIndex>) -> [Vec3; 3] {
    let ankle = rest.position(foot);
    let vertices: Vec<Vec3> = vertices_below(body, rest, foot).collect();
    let lowest = vertices.iter().map(|vertex| vertex.y).fold(f32::INFINITY, f32::min);
    let ground: Vec<Vec3> = vertices.into_iter().filter(|vertex| vertex.y < lowest + SOLE * leg).collect();
    let [back, front] = [f32::max, f32::min].map(|pick| ground.iter().map(|v| v.z).reduce(pick));
    let (Some(back), Some(front)) = (back, front) else { return typical(rest, leg, ankle, toes) };
    let length = back - front;
    if length < 0.05 * leg {
        return typical(rest, leg, ankle, toes);
    }
    let point = |z: f32| {
        let near = ground.iter().filter(|vertex| (vertex.z - z).abs() <= NEAR * length);
        let (mut low, mut left, mut right) = (f32::INFINITY, f32::INFINITY, f32::NEG_INFINITY);
        for vertex in near {
            (low, left, right) = (low.min(vertex.y), left.min(vertex.x), right.max(vertex.x));
        }
        Vec3::new(0.5 * (left + right), if low.is_finite() { low } else { lowest }, z)
    };
    let ball = match toes.map(|toes| rest.position(toes).z) {
        Some(z) if z < back && z > front => z,
        _ => back - BALL * length,
    };
    let middle = |point: Vec3| if point.x.is_finite() { point } else { Vec3::new(ankle.x, point.y, point.z) };
    [middle(point(back)), middle(point(ball)), middle(point(front))]
}

/// Vertices that `joint` and what hangs below it move most, in the space of `rest`.
pub(super) fn vertices_below<'a>(body: Body<'a>, rest: &'a Pose, joint: JointIndex) -> impl Iterator<Item = Vec3> + 'a {
    let below = body.skeleton.joints().filter(move |&other| body.skeleton.is_below(other, joint));
    let flesh = below.filter_map(move |joint| Some((rest.model(joint), body.dominated.get(joint.index())?)));
    flesh.flat_map(|(model_from_joint, vertices)| vertices.iter().map(move |&v| model_from_joint.transform_point3(v)))
}

/// A sole without vertices: after the ankle, and the toes where there are any.
fn typical(rest: &Pose, leg: f32, ankle: Vec3, toes: Option<JointIndex>) -> [Vec3; 3] {
    let [height, heel, ball, tip] = TYPICAL.map(|share| share * leg);
    let toe_height = toes.map_or(f32::INFINITY, |toes| rest.position(toes).y);
    let ground = (ankle.y - height).min(toe_height - TOE_HEIGHT * leg);
    let toes = toes.map(|toes| rest.position(toes)).unwrap_or(ankle + Vec3::NEG_Z * ball);
    [
        Vec3::new(ankle.x, ground, ankle.z + heel),
        Vec3::new(toes.x, ground, toes.z),
        Vec3::new(toes.x, ground, toes.z - tip),
    ]
}
