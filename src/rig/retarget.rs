//! Which joints of one body follow which of another's, and how their rest postures differ.

use bevy::math::{Quat, Vec3};

use super::{
    Rig,
    binding::Binding,
    character_file::Roles,
    humanoid::{Humanoid, HumanoidRole as Role},
    tuning::retarget::RetargetConfig,
};
use crate::{
    anim::{
        clip::Clip,
        gait::Gait,
        leg::Leg,
        pose::Pose,
        retarget::{Part, Pelvis, Retarget},
        skeleton::{JointIndex, Skeleton},
    },
    math::rotation::{angle_between, from_scaled_axis, shortest_arc},
};

/// Rest places that differ by less than this share of the bone, and rest turns by less than so many radians, are the same.
const SAME: (f32, f32) = (0.02, 0.02);

/// However long they are, feet turn by at least this share of what the source's do.
const LEAST_FOOT_SHARE: f32 = 0.25;

/// A body that clips are made for.
#[derive(Clone, Copy)]
pub(super) struct Target<'a> {
    pub(super) rig: &'a Rig,
    pub(super) skeleton: &'a Skeleton,
    pub(super) humanoid: &'a Humanoid,
    pub(super) legs: &'a [Leg; 2],
    pub(super) config: &'a RetargetConfig,
}

/// Another body, ready to be followed.
pub(super) struct Source {
    skeleton: Skeleton,
    /// Joints of both by equal names.
    by_name: Vec<(JointIndex, JointIndex)>,
    parts: Vec<Part>,
    pelvis: Option<Pelvis>,
    length: f32,
    /// Legs of the source, where feet are held as theirs.
    legs: Option<[Leg; 2]>,
    /// Whether it is the same skeleton as far as the body's parts go.
    same: bool,
}

impl Source {
    /// `rig` for the body `target`.
    pub(super) fn new(rig: &Rig, target: Target) -> Self {
        let by_name = by_name(rig, target);
        // Who asks for another share of a motion gets it.
        let same = *target.config == RetargetConfig::default()
            && target.humanoid.iter().all(|(_, own)| {
                let partner = by_name.iter().find(|pair| pair.1 == own);
                partner.is_some_and(|&(other, _)| is_same(&rig.skeleton, other, target.skeleton, own))
            });
        let mut source = Self {
            skeleton: rig.skeleton.clone(),
            by_name,
            parts: Vec::new(),
            pelvis: None,
            length: 1.0,
            legs: None,
            same,
        };
        match rig.bind(&Roles::Auto) {
            Ok(binding) if !same => source.follow_body(&binding, target),
            _ => source.follow_names(target),
        }
        source
    }

    /// Metres here for a metre of the source.
    pub(super) fn length(&self) -> f32 {
        self.length
    }

    /// What feet do in `clip`, during which the root turns by `angle` radians, where they are held so; speeds in metres here.
    pub(super) fn gait(&self, clip: &Clip, angle: f32) -> Option<Gait> {
        let clip = if clip.looping { clip.without_lead() } else { clip.clone() };
        let mut gait = Gait::analyze_turning(&clip, &self.skeleton, &self.legs?, angle);
        gait.velocity *= self.length;
        Some(gait)
    }

    /// `clip` for the target; `None` when no joint that it moves has a partner.
    pub(super) fn clip(&self, clip: &Clip, target: Target) -> Option<Clip> {
        let has_partner = |joint: JointIndex| {
            let named = self.by_name.iter().any(|pair| pair.0 == joint);
            named || self.parts.iter().any(|part| part.from.contains(&joint))
        };
        let mut moving = clip.moving_joints().peekable();
        if moving.peek().is_some() && !moving.any(has_partner) {
            return None;
        }
        if self.same {
            return Some(clip.renumbered(&self.skeleton, target.skeleton, &self.by_name));
        }
        let retarget = Retarget {
            from: &self.skeleton,
            to: target.skeleton,
            parts: self.parts.clone(),
            pelvis: self.pelvis,
            length: self.length,
            sway: target.config.pelvis,
        };
        Some(retarget.clip(clip))
    }

    fn follow_body(&mut self, binding: &Binding, target: Target) {
        self.skeleton.model_from_root = binding.frame.model_from_root;
        let leg = |legs: &[Leg; 2]| legs[0].length() + legs[1].length();
        self.length = leg(target.legs) / leg(&binding.legs);
        let rests = [Pose::rest(&self.skeleton), Pose::rest(target.skeleton)];
        let lever = lever(&binding.legs, &rests[0]) / lever(target.legs, &rests[1]);
        let bodies = Bodies {
            source: &binding.humanoid,
            own: target.humanoid,
            foot_share: if lever.is_finite() { lever.clamp(LEAST_FOOT_SHARE, 1.0) } else { 1.0 },
        };
        self.parts = bodies.parts(&self.skeleton, target, &rests);
        if let Some((from, to)) = bodies.pair(Role::Hips) {
            self.legs = target.config.hold_feet.then_some(binding.legs);
            self.pelvis = Some(Pelvis { from, to, legs: self.legs.map(|legs| [legs, *target.legs]) });
        }
        // Fingers and the like, whose names are the same.
        for &(from, to) in &self.by_name {
            let taken = |part: &Part| part.to == to || part.from.contains(&from);
            if self.parts.iter().any(taken)
                || target.humanoid.get(Role::Hips).is_some_and(|hips| {
                    // What carries the whole body is told by the pelvis.
                    target.skeleton.is_below(hips, to)
                })
            {
                continue;
            }
            let mut above = target.skeleton.parent(to);
            while let Some(joint) = above.filter(|&joint| !self.parts.iter().any(|part| part.to == joint)) {
                above = target.skeleton.parent(joint);
            }
            let offset =
                self.parts.iter().find(|part| Some(part.to) == above).map_or(Quat::IDENTITY, |part| part.offset);
            self.parts.push(whole(from, to, offset));
        }
    }

    fn follow_names(&mut self, target: Target) {
        self.parts = self.by_name.iter().map(|&(from, to)| whole(from, to, Quat::IDENTITY)).collect();
        let Some(hips) = target.humanoid.get(Role::Hips) else { return };
        let Some(&(from, to)) = self.by_name.iter().find(|pair| pair.1 == hips) else { return };
        let height = |skeleton: &Skeleton, joint: JointIndex| Pose::rest(skeleton).position(joint).y;
        let length = height(target.skeleton, to) / height(&self.skeleton, from);
        self.length = if length.is_finite() && length > 0.0 { length } else { 1.0 };
        self.pelvis = Some(Pelvis { from, to, legs: None });
    }
}

/// Joints of the same name, skinned ones first.
fn by_name(rig: &Rig, target: Target) -> Vec<(JointIndex, JointIndex)> {
    let skinned = target.rig.skin_joints();
    let pair = |joint: JointIndex| {
        let name = rig.skeleton.name(joint);
        let own = skinned.iter().copied().find(|&own| target.skeleton.name(own) == name);
        own.or_else(|| target.skeleton.find(name)).map(|own| (joint, own))
    };
    rig.skeleton.joints().filter_map(pair).collect()
}

fn is_same(from: &Skeleton, a: JointIndex, to: &Skeleton, b: JointIndex) -> bool {
    let name = |skeleton: &Skeleton, joint| skeleton.parent(joint).map(|parent| skeleton.name(parent).to_owned());
    let (one, other) = (from.rest()[a.index()], to.rest()[b.index()]);
    let length = one.translation.length().max(other.translation.length());
    one.translation.distance(other.translation) <= SAME.0 * length + 1e-4
        && angle_between(one.rotation, other.rotation) < SAME.1
        && one.scale.distance(other.scale) < SAME.0
        && name(from, a) == name(to, b)
}

fn whole(from: JointIndex, to: JointIndex, offset: Quat) -> Part {
    Part { to, from: [from; 2], between: 0.0, carrier: Some(from), amount: 1.0, offset }
}

/// From the heel to where a foot bends, or to its tip where it doesn't, against the leg's length: mean of both legs.
fn lever(legs: &[Leg; 2], rest: &Pose) -> f32 {
    let of_leg = |leg: &Leg| {
        let front = if leg.toes.is_some() { leg.ball } else { leg.tip };
        leg.heel.position(rest).distance(front.position(rest)) / leg.length()
    };
    0.5 * (of_leg(&legs[0]) + of_leg(&legs[1]))
}

struct Bodies<'a> {
    source: &'a Humanoid,
    own: &'a Humanoid,
    /// Share of the feet's turns that is taken: long feet would lift their heels to the knees.
    foot_share: f32,
}

impl Bodies<'_> {
    fn pair(&self, role: Role) -> Option<(JointIndex, JointIndex)> {
        Some((self.source.get(role)?, self.own.get(role)?))
    }

    fn parts(&self, from: &Skeleton, target: Target, rests: &[Pose; 2]) -> Vec<Part> {
        let config = target.config;
        let Some((hips, own_hips)) = self.pair(Role::Hips) else { return Vec::new() };
        let mut parts = vec![whole(hips, own_hips, Quat::IDENTITY)];
        let trunk = self.source.spine(from);
        let own_trunk = self.own.spine(target.skeleton);
        let top = trunk.last().copied().unwrap_or(hips);
        // The spines may have different numbers of joints: each follows what is at its share of the way up.
        for (place, &to) in own_trunk.iter().enumerate() {
            let share = (place + 1) as f32 / own_trunk.len() as f32 * trunk.len() as f32;
            let at = |place: usize| if place == 0 { hips } else { trunk[(place - 1).min(trunk.len() - 1)] };
            let below = share.floor() as usize;
            let pair = if trunk.is_empty() { [hips; 2] } else { [at(below), at(below + 1)] };
            let part = Part {
                from: pair,
                between: share.fract(),
                carrier: Some(hips),
                amount: config.spine,
                ..whole(hips, to, Quat::IDENTITY)
            };
            parts.push(part);
        }
        let mut add = |role: Role, carrier: Option<JointIndex>, amount: f32, offset: Quat| {
            if let Some((from, to)) = self.pair(role) {
                parts.push(Part { carrier, amount, ..whole(from, to, offset) });
            }
        };
        let (hips, top) = (Some(hips), Some(top));
        add(Role::Neck, top, config.head, Quat::IDENTITY);
        add(Role::Head, top, config.head, Quat::IDENTITY);
        for (arm, way) in [
            ([Role::LeftShoulder, Role::LeftUpperArm, Role::LeftLowerArm, Role::LeftHand], -1.0),
            ([Role::RightShoulder, Role::RightUpperArm, Role::RightLowerArm, Role::RightHand], 1.0),
        ] {
            let spread = from_scaled_axis(Vec3::Z * (way * config.arm_spread));
            let [upper, lower] = self.offsets([arm[1], arm[2], arm[3]], rests, config.align_arms, spread);
            add(arm[0], top, config.arms, Quat::IDENTITY);
            add(arm[1], top, config.arms, upper);
            add(arm[2], top, config.arms, lower);
            let forearm = self.source.get(arm[2]).or(top);
            add(arm[3], forearm, config.hands, lower);
        }
        for [upper, lower, foot, toes] in [
            [Role::LeftUpperLeg, Role::LeftLowerLeg, Role::LeftFoot, Role::LeftToes],
            [Role::RightUpperLeg, Role::RightLowerLeg, Role::RightFoot, Role::RightToes],
        ] {
            let offsets = self.offsets([upper, lower, foot], rests, config.align_legs, Quat::IDENTITY);
            add(upper, hips, config.legs, offsets[0]);
            add(lower, hips, config.legs, offsets[1]);
            // A foot that is flat at rest stays flat.
            add(foot, None, config.legs * self.foot_share, Quat::IDENTITY);
            add(toes, None, config.legs * self.foot_share, Quat::IDENTITY);
        }
        parts
    }

    /// Turns that bring the two bones of this body's limb, at rest, to where the source's are, `spread` on top.
    fn offsets(&self, limb: [Role; 3], rests: &[Pose; 2], align: bool, spread: Quat) -> [Quat; 2] {
        let at = |role: Role| self.pair(role).map(|(a, b)| [rests[0].position(a), rests[1].position(b)]);
        let [Some(top), Some(middle), Some(end)] = limb.map(at) else { return [spread; 2] };
        if !align {
            return [spread; 2];
        }
        let bone = |from: [Vec3; 2], to: [Vec3; 2]| [spread * (to[0] - from[0]), to[1] - from[1]];
        let [wanted, own] = bone(top, middle);
        let upper = shortest_arc(own, wanted);
        let [wanted, own] = bone(middle, end);
        [upper, shortest_arc(upper * own, wanted) * upper]
    }
}
