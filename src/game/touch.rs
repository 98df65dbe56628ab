//! Hands touch what is near: they glide along handrails and come to rest on masts.
//!
//! Reads [`Touchable`]s and the pose; sets the targets of two arms of whoever [`Touches`]. World space, metres.

use bevy::prelude::*;

use super::level::Hero;
use crate::{
    anim::{
        leg::{LEFT, RIGHT},
        skeleton::JointIndex,
    },
    character::{
        Character,
        animator::CharacterPose,
        bind::CharacterAssets,
        chains::{ChainOf, IkChain, IkTarget, TipFacing},
        motion::MotionState,
    },
    rig::{
        character::CharacterAsset,
        humanoid::HumanoidRole::{LeftHand, LeftLowerArm, LeftUpperArm, RightHand, RightLowerArm, RightUpperArm},
    },
    terrain::{Piece, shape::Shape},
};

/// Parts of an arm's length from the shoulder at which a hand takes hold, and at which it lets go.
const TAKES: f32 = 0.96;
const LETS_GO: f32 = 1.1;
/// Metres from shoulder to wrist of the arm that the lengths below are meant for; others' go with their arm.
const ARM: f32 = 0.57;
/// Metres ahead of the shoulder at which a hand likes to hold.
const AHEAD: f32 = 0.16;
/// Metres behind the shoulder beyond which a hand does not follow.
const BEHIND: f32 = 0.28;
/// Speed in m/s over which hands stay with the body.
const FASTEST: f32 = 2.3;
/// Seconds in which half of the way to a hold is made.
const HALF_LIFE: f32 = 0.14;
/// Middle of the palm from the wrist in metres: outward and down, as the arm is at rest.
const PALM: (f32, f32) = (0.085, 0.03);
/// Metres by which a palm may be elsewhere than its arm says: poses stretch arms by rounding.
const SAME: f32 = 0.001;
/// Most that a hand bends and twists to lie on what it touches, radians.
const WRIST: f32 = 1.3;
/// Metres below the shoulder at which a hand touches what is upright.
const BELOW_SHOULDER: f32 = 0.2;

/// A character whose hands touch [`Touchable`]s.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Touches;

/// What hands touch, in its own space.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub enum Touchable {
    /// A bar along X through `middle`, of this half length.
    Bar {
        /// The middle of its upper side.
        middle: Vec3,
        /// Half its length in metres.
        half: f32,
    },
    /// A square mast about Y.
    Mast {
        /// Half its width at the foot and at the top, metres.
        halves: [f32; 2],
        /// Its height in metres.
        height: f32,
    },
}

/// One of the arms of who [`Touches`].
#[derive(Component, Clone, Copy, Debug)]
struct TouchingArm {
    side: usize,
    /// Along X in model space, 1 or -1.
    outward: f32,
}

/// Has hands touch things.
pub struct TouchPlugin;

impl Plugin for TouchPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Update, (give_arms, touch).chain());
    }
}

pub(super) fn plugin(app: &mut App) {
    app.add_plugins(TouchPlugin).add_systems(PostStartup, mark_pieces).add_systems(Update, mark_hero);
}

fn mark_pieces(mut commands: Commands, pieces: Query<(Entity, &Piece)>) {
    for (entity, piece) in &pieces {
        if let Some(touchable) = Touchable::of(&piece.shape) {
            commands.entity(entity).insert(touchable);
        }
    }
}

fn mark_hero(mut commands: Commands, heroes: Query<Entity, Added<Hero>>) {
    for hero in &heroes {
        commands.entity(hero).insert(Touches);
    }
}

impl Touchable {
    /// What of a shape hands touch.
    #[must_use]
    pub fn of(shape: &Shape) -> Option<Self> {
        match *shape {
            Shape::Rail { length, height } => Some(Self::Bar { middle: Vec3::Y * height, half: 0.5 * length }),
            Shape::Mast { height, width } => Some(Self::Mast { halves: [0.5 * width, 0.25 * width], height }),
            _ => None,
        }
    }

    /// The place on it that a hand takes whose shoulder is at `shoulder`, and whose arm is `size` times a person's; both places
    /// in its own space.
    #[must_use]
    pub fn hold(&self, shoulder: Vec3, size: f32) -> Vec3 {
        match *self {
            Self::Bar { middle, half } => middle + Vec3::X * (shoulder.x - middle.x).clamp(-half, half),
            Self::Mast { halves, height } => {
                let y = (shoulder.y - BELOW_SHOULDER * size).clamp(0.0, height);
                let half = halves[0].lerp(halves[1], y / height.max(0.01));
                let flat = Vec2::new(shoulder.x, shoulder.z);
                let onto = flat.clamp(Vec2::splat(-half), Vec2::splat(half));
                Vec3::new(onto.x, y, onto.y)
            }
        }
    }
}

impl Touchable {
    /// Where a palm looks that lies on it at `hold`; both in its own space.
    #[must_use]
    pub fn inward(&self, hold: Vec3) -> Vec3 {
        match self {
            Self::Bar { .. } => Vec3::NEG_Y,
            Self::Mast { .. } => -hold.with_y(0.0).normalize_or(Vec3::X),
        }
    }
}

fn give_arms(mut commands: Commands, fresh: Query<Entity, Added<Touches>>) {
    for entity in &fresh {
        for (side, outward) in [(LEFT, -1.0), (RIGHT, 1.0)] {
            let facing = Some(TipFacing { side: Vec3::NEG_Y, toward: Vec3::NEG_Y, most: WRIST });
            let chain = IkChain { half_life: HALF_LIFE, facing, ..IkChain::arm(side) };
            commands.spawn((TouchingArm { side, outward }, chain, ChainOf(entity)));
        }
    }
}

fn touch(
    things: Query<(Entity, &Touchable, &Transform)>,
    bodies: Query<(&Character, &Transform, &MotionState, &CharacterPose)>,
    mut arms: Query<(&TouchingArm, &ChainOf, &mut IkChain)>,
    assets: CharacterAssets,
) {
    for (arm, of, mut chain) in &mut arms {
        let Ok((character, root, motion, pose)) = bodies.get(of.0) else { continue };
        let Some(asset) = assets.get(character) else { continue };
        let Some([shoulder, elbow, wrist]) = arm.joints(asset).map(|joints| joints.map(|at| pose.pose.position(at)))
        else {
            continue;
        };
        let holds = chain.target != IkTarget::None;
        let to_wrist = shoulder.distance(elbow) + elbow.distance(wrist);
        let size = to_wrist / ARM;
        let palm = size * Vec3::new(arm.outward * PALM.0, -PALM.1, 0.0);
        if chain.effector.distance(palm) > SAME * size {
            chain.effector = palm;
        }
        let reach = (to_wrist + PALM.0 * size) * if holds { LETS_GO } else { TAKES };
        let hand = Hand { shoulder, outward: arm.outward, reach, size };
        let walks = motion.ground.is_some() && motion.ground_velocity.length() < FASTEST && !motion.facing_locked;
        let near = things.iter().filter(|_| walks).filter_map(|(entity, thing, place)| {
            let world_from_thing = place.to_isometry();
            let (place, away) = hand.take(thing, &world_from_thing, &root.to_isometry())?;
            Some((IkTarget::Entity(entity, place), away, world_from_thing.rotation * thing.inward(place)))
        });
        let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1));
        let target = nearest.map_or(IkTarget::None, |(target, ..)| target);
        if chain.target != target {
            chain.target = target;
        }
        if let (Some((.., inward)), Some(mut facing)) = (nearest, chain.facing)
            && facing.toward != inward
        {
            facing.toward = inward;
            chain.facing = Some(facing);
        }
    }
}

impl TouchingArm {
    fn joints(self, asset: &CharacterAsset) -> Option<[JointIndex; 3]> {
        let roles = if self.side == LEFT {
            [LeftUpperArm, LeftLowerArm, LeftHand]
        } else {
            [RightUpperArm, RightLowerArm, RightHand]
        };
        let [upper, lower, hand] = roles.map(|role| asset.humanoid.get(role));
        Some([upper?, lower?, hand?])
    }
}

/// A hand in search of something to touch.
#[derive(Clone, Copy, Debug)]
struct Hand {
    /// Model space.
    shoulder: Vec3,
    /// Along X in model space, 1 or -1.
    outward: f32,
    /// Metres from the shoulder.
    reach: f32,
    /// Its arm over a person's.
    size: f32,
}

impl Hand {
    /// The place on a thing, in its space, that the hand takes, and how far it is from the shoulder.
    fn take(
        &self,
        thing: &Touchable,
        world_from_thing: &Isometry3d,
        world_from_model: &Isometry3d,
    ) -> Option<(Vec3, f32)> {
        let thing_from_model = world_from_thing.inverse() * *world_from_model;
        let hold = thing.hold(thing_from_model * (self.shoulder + Vec3::NEG_Z * (AHEAD * self.size)), self.size);
        let hold_model = thing_from_model.inverse() * hold;
        let from_shoulder = hold_model - self.shoulder;
        let beside = hold_model.x * self.outward > 0.0 && from_shoulder.z < BEHIND * self.size;
        let away = from_shoulder.length();
        (beside && away < self.reach).then_some((hold, away))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RAIL: Touchable = Touchable::Bar { middle: Vec3::Y, half: 1.0 };

    /// A right hand of a body that stands `aside` metres left of the rail and faces along it.
    fn take(aside: f32, along: f32) -> Option<(Vec3, f32)> {
        let hand = Hand { shoulder: Vec3::new(0.185, 1.4, 0.0), outward: 1.0, reach: 0.65, size: 1.0 };
        // The rail's X is the body's -Z.
        let turned = Quat::from_rotation_y(core::f32::consts::FRAC_PI_2);
        let rail = Isometry3d::new(Vec3::new(aside, 0.0, along), turned);
        hand.take(&RAIL, &rail, &Isometry3d::IDENTITY)
    }

    #[test]
    fn a_hand_takes_the_rail_a_little_ahead_of_its_shoulder() {
        let (hold, away) = take(0.45, 0.0).expect("within reach");
        assert!((hold - Vec3::new(AHEAD, 1.0, 0.0)).length() < 1e-5, "it takes {hold}");
        assert!(away < 0.65, "{away} m away");
    }

    #[test]
    fn a_hand_lets_alone_what_is_far_across_or_behind() {
        assert!(take(1.2, 0.0).is_none(), "a rail 1.2 m aside");
        assert!(take(-0.2, 0.0).is_none(), "a rail on the other side");
        assert!(take(0.45, 1.4).is_none(), "a rail that ended 0.4 m behind");
        assert!(take(0.45, 1.2).is_some(), "the end of a rail 0.2 m behind");
    }

    #[test]
    fn a_giant_takes_hold_further_ahead() {
        let hand = Hand { shoulder: Vec3::new(0.46, 3.5, 0.0), outward: 1.0, reach: 3.0, size: 2.5 };
        let turned = Quat::from_rotation_y(core::f32::consts::FRAC_PI_2);
        let (hold, _) =
            hand.take(&RAIL, &Isometry3d::new(Vec3::X, turned), &Isometry3d::IDENTITY).expect("within reach");
        assert!((hold.x - 2.5 * AHEAD).abs() < 1e-5, "it takes {hold}");
    }

    #[test]
    fn a_mast_is_touched_on_the_near_side() {
        let mast = Touchable::of(&Shape::Mast { height: 8.0, width: 0.8 }).expect("masts are touched");
        let hold = mast.hold(Vec3::new(0.1, 1.4, 2.0), 1.0);
        assert!((hold.y - 1.2).abs() < 1e-5 && (hold.z - 0.37).abs() < 1e-3 && (hold.x - 0.1).abs() < 1e-5, "{hold}");
    }
}
