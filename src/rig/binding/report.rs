//! A binding in words: what was found and how, what is missing, and what to write about it.

use core::fmt::{self, Display, Formatter};

use bevy::math::Vec3;

use super::{Attempt, Means, attempt};
use crate::{
    anim::{leg::Leg, pose::Pose, skeleton::Skeleton},
    rig::{
        Rig,
        character_file::Roles,
        humanoid::{HumanoidError, HumanoidRole as Role},
    },
};

/// What was found of a body in a rig, and how. Shown as text of several lines.
#[derive(Clone, Debug, PartialEq)]
pub struct BindingReport {
    /// Every role, found or not, in order.
    pub roles: Vec<RoleReport>,
    /// What keeps the body from walking.
    pub problem: Option<HumanoidError>,
    /// Where it stands and how its legs are; `None` when it can't walk.
    pub body: Option<BodyReport>,
    /// What was mended or is odd, one sentence each.
    pub notes: Vec<String>,
}

/// A role and the joint that plays it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RoleReport {
    /// The role.
    pub role: Role,
    /// The joint's name and how it was found; `None` when it wasn't.
    pub joint: Option<(String, Means)>,
}

/// How a body stands.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyReport {
    /// Up in the file's space, unit vector.
    pub up: Vec3,
    /// Forward in the file's space, unit vector.
    pub forward: Vec3,
    /// What told forward: toes, soles, knees, or left and right.
    pub evidence: String,
    /// Metres of one unit of the file, scales of its nodes aside.
    pub unit: f32,
    /// Height of the soles over the file's origin, metres; the body is moved down by it.
    pub ground: f32,
    /// Thigh and shin, the mean of both legs, metres.
    pub leg_length: f32,
    /// Height of the highest joint or vertex at rest, metres.
    pub stature: f32,
    /// `[left, right]`.
    pub legs: [LegReport; 2],
}

/// How a leg is. Lengths in metres of model space (+Y up, facing -Z).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegReport {
    /// Hip to knee.
    pub thigh: f32,
    /// Knee to ankle.
    pub shin: f32,
    /// Unit axis of the knee's hinge in model space, at rest.
    pub hinge: Vec3,
    /// Heel, ball and tip of the sole, model space, at rest.
    pub sole: [Vec3; 3],
    /// Whether the foot hangs elsewhere than below its shin; then it is hung there.
    pub rehung: bool,
}

impl BindingReport {
    /// What is found of a body in `rig`, with parts spelt out as in a character's file.
    #[must_use]
    pub fn new(rig: &Rig, roles: &Roles) -> Self {
        let Attempt { parts, outcome } = attempt(rig, roles);
        let skeleton = &rig.skeleton;
        let role = |role: Role| {
            let joint = parts.joints.get(&role).map(|part| (skeleton.name(part.0).to_owned(), part.1));
            RoleReport { role, joint }
        };
        let mut notes = rig.notes.clone();
        let (problem, body) = match outcome {
            Err(error) => (Some(error), None),
            Ok(binding) => {
                let frame = &binding.frame;
                // The rig's own import says the same.
                notes.extend(frame.notes.iter().filter(|note| !rig.notes.contains(note)).cloned());
                let mut in_model = skeleton.clone();
                in_model.model_from_root = frame.model_from_root;
                let body = BodyReport {
                    up: frame.up,
                    forward: frame.forward,
                    evidence: frame.evidence.to_owned(),
                    unit: frame.unit,
                    ground: frame.ground,
                    leg_length: 0.5 * (binding.legs[0].length() + binding.legs[1].length()),
                    stature: stature(rig, &in_model),
                    legs: binding.legs.map(|leg| leg_report(&leg, &in_model)),
                };
                (None, Some(body))
            }
        };
        Self { roles: Role::ALL.into_iter().map(role).collect(), problem, body, notes }
    }

    /// Whether the body can walk.
    #[must_use]
    pub fn is_bound(&self) -> bool {
        self.problem.is_none()
    }

    /// The lines to write in a `.character.ron`: all parts found, and a gap for each that is needed and missing.
    #[must_use]
    pub fn ron(&self) -> String {
        let lines = self.roles.iter().filter_map(|RoleReport { role, joint }| match joint {
            Some((name, _)) => Some(format!("    {}: {name:?},\n", role.spelling())),
            None if role.is_needed() => Some(format!("    {}: \"…\",\n", role.spelling())),
            None => None,
        });
        format!("roles: Explicit({{\n{}}}),", lines.collect::<String>())
    }
}

fn leg_report(leg: &Leg, skeleton: &Skeleton) -> LegReport {
    let rest = Pose::rest(skeleton);
    LegReport {
        thigh: leg.thigh,
        shin: leg.shin,
        hinge: rest.rotation(leg.upper) * leg.knee_axis,
        sole: leg.sole().map(|point| point.position(&rest)),
        rehung: !skeleton.is_below(leg.foot, leg.lower),
    }
}

/// Height of the highest vertex or joint at rest over the ground, metres, by a skeleton of `rig` in model space.
pub(in super::super) fn stature(rig: &Rig, skeleton: &Skeleton) -> f32 {
    let rest = Pose::rest(skeleton);
    let top = |(joint, vertices): (usize, &Vec<Vec3>)| {
        let model_from_joint = rest.models()[joint];
        vertices.iter().map(|&vertex| model_from_joint.transform_point3(vertex).y).reduce(f32::max)
    };
    let vertices = rig.dominated.iter().enumerate().filter_map(top);
    let joints = rest.positions().map(|joint| joint.y);
    vertices.chain(joints).fold(0.0, f32::max)
}

impl Display for BindingReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.problem {
            None => writeln!(f, "A body on two legs.")?,
            Some(problem) => writeln!(f, "No body that walks: {problem}.")?,
        }
        for RoleReport { role, joint } in &self.roles {
            let role_name = role.spelling();
            match joint {
                Some((name, means)) => writeln!(f, "  {role_name:14} `{name}`, {means}")?,
                None if role.is_needed() => writeln!(f, "  {role_name:14} missing, and needed")?,
                None => {}
            }
        }
        let missing = self.roles.iter().filter(|role| role.joint.is_none() && !role.role.is_needed());
        let missing: Vec<String> = missing.map(|missing| missing.role.spelling()).collect();
        if !missing.is_empty() {
            writeln!(f, "Not found, and not needed: {}.", missing.join(", "))?;
        }
        if let Some(body) = &self.body {
            write!(f, "{body}")?;
        }
        for note in &self.notes {
            writeln!(f, "Note: {note}.")?;
        }
        let why = if self.is_bound() { "To change a part" } else { "Name the parts" };
        writeln!(f, "{why}, in its .character.ron:\n{}", self.ron())
    }
}

impl Display for BodyReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { evidence, unit, ground, leg_length, stature, .. } = self;
        writeln!(f, "Up is {} of the file, forward is {}, told by {evidence}.", axis(self.up), axis(self.forward))?;
        let unit = if unit.to_bits() == 1f32.to_bits() { "1 m".to_owned() } else { format!("{unit} m") };
        writeln!(f, "Legs of {leg_length:.3} m, {stature:.2} m tall; one unit of the file is {unit}.")?;
        writeln!(f, "Soles lie {:.1} mm over the file's origin.", 1000.0 * ground)?;
        for (side, leg) in ["Left", "Right"].into_iter().zip(&self.legs) {
            write!(f, "{side} leg: {leg}")?;
        }
        Ok(())
    }
}

impl Display for LegReport {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { thigh, shin, hinge, sole: [heel, ball, tip], rehung } = self;
        let point = |point: &Vec3| format!("({:.3}, {:.3}, {:.3})", -point.x, point.y, -point.z);
        writeln!(
            f,
            "thigh {thigh:.3} m, shin {shin:.3} m, knee turns about {}; sole (left, up, forward): heel {}, ball {}, tip {}.",
            axis(*hinge),
            point(heel),
            point(ball),
            point(tip)
        )?;
        if *rehung { writeln!(f, "  Its foot hangs elsewhere in the file and is hung on the shin.") } else { Ok(()) }
    }
}

impl Display for Means {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::File => "as the character's file says",
            Self::Vrm => "as the model's VRM map says",
            Self::Name => "by name",
            Self::Hierarchy => "from what hangs where",
            Self::Geometry => "from the shape at rest",
        })
    }
}

/// `+Y` for an axis, else the vector.
fn axis(direction: Vec3) -> String {
    let axes = [
        ("+X", Vec3::X),
        ("-X", Vec3::NEG_X),
        ("+Y", Vec3::Y),
        ("-Y", Vec3::NEG_Y),
        ("+Z", Vec3::Z),
        ("-Z", Vec3::NEG_Z),
    ];
    let near = axes.into_iter().find(|(_, axis)| axis.distance(direction) < 0.01);
    near.map_or_else(
        || format!("({:.2}, {:.2}, {:.2})", direction.x, direction.y, direction.z),
        |(name, _)| name.to_owned(),
    )
}
