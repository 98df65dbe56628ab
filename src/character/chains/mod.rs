//! IK for any chain of joints: a hand that reaches, a tail that follows, a head that looks.
//!
//! Reads [`IkChain`]s, their targets and the pose as feet left it; turns the chain's joints in [`CharacterPose`]. Every
//! frame begins with the animated pose, so what stands still is solved alike and nothing swings.

mod arm;
mod bound;
mod facing;
mod limits;
mod state;

use bevy::prelude::*;

pub use facing::TipFacing;
pub use limits::{ChainJointSetup, RestLimit};
pub use state::{IkResult, IkState};

use super::{
    Character,
    animator::CharacterPose,
    bind::CharacterAssets,
    detail::{ClipsOnly, Mode, Pacing},
    schedule::PoseSystems,
    show::ShowLocals,
};
use crate::{anim::ik::two_bone::Extension, rig::joint_ref::JointRef};

/// Bends the joints from `root` to `tip` of the character that [`ChainOf`] names, so that the tip comes to a target.
///
/// Chains of one character are solved in the order they were added, each on the pose that those before it left.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(IkState, IkResult)]
pub struct IkChain {
    /// How it bends.
    pub solver: Solver,
    /// The first joint that turns.
    pub root: JointRef,
    /// The joint at its end, below `root`. Only [`Solver::Aim`] and `facing` turn it.
    pub tip: JointRef,
    /// What of the tip comes to the target: metres from its joint, in model space, when the character is in its rest
    /// pose. Default zero: the joint itself.
    pub effector: Vec3,
    /// Where to. Default [`IkTarget::None`].
    pub target: IkTarget,
    /// How much of it shows, 0..=1; what changes fades in or out. Default 1.
    pub weight: f32,
    /// Seconds after which half of a change of weight or of target has come. Default 0.1; 0 jumps.
    pub half_life: f32,
    /// Where its middle points. Default `None`: where it does anyway.
    pub pole: Option<Pole>,
    /// How its tip is turned. Default `None`: as it is animated.
    pub facing: Option<TipFacing>,
    /// Metres from the target that count as reached. Default 0.0005.
    pub tolerance: f32,
    /// Most steps from one start; more reach what is hard to reach. Default 32.
    pub iterations: u32,
    /// Other starts to try when limits bar the way from the animated pose. More find ways round limits, but the pose may
    /// jump where such a way begins. Default 0.
    pub retries: u32,
    /// How far and how readily joints turn. Those not listed turn freely.
    pub joints: Vec<ChainJointSetup>,
}

/// How a chain bends.
#[derive(Clone, Debug, PartialEq)]
pub enum Solver {
    /// In one joint, as arms and legs do.
    TwoBone {
        /// Which one; `None`: the one nearest to half-way.
        middle: Option<JointRef>,
        /// How far it stretches.
        extension: Extension,
    },
    /// In all joints, by cyclic coordinate descent: the animated pose changes little; best with hinges.
    Ccd,
    /// In all joints, by forward and backward reaching: round bends, best for chains of many balls. With hinges the way it
    /// bends may jump as a target moves; [`Solver::Ccd`] follows smoothly there.
    Fabrik,
    /// Not to the target, but at it: all joints turn until the tip's line of sight meets it.
    Aim {
        /// Where that line goes from the effector, in model space, when the character is in its rest pose.
        forward: Vec3,
    },
}

/// Where a chain's end goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum IkTarget {
    /// Nowhere: the chain fades out.
    #[default]
    None,
    /// A place in the world. Its motion is followed exactly.
    Point(Vec3),
    /// Another entity, as it is placed in this frame, or a place in its space. If it is gone the chain fades out.
    Entity(Entity, Vec3),
}

/// Where a chain's middle points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pole {
    /// Toward a place in the world.
    Point(Vec3),
    /// This way, in model space: the character's right is +X, up +Y, back +Z.
    Direction(Vec3),
}

/// Whose chain this is. Despawned with the character.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[relationship(relationship_target = Chains)]
pub struct ChainOf(pub Entity);

/// The chains of a character, in the order they are solved.
#[derive(Component, Debug, Default)]
#[require(ShowLocals)]
#[relationship_target(relationship = ChainOf, linked_spawn)]
pub struct Chains(Vec<Entity>);

impl IkChain {
    /// A chain without target yet.
    #[must_use]
    pub fn new(solver: Solver, root: impl Into<JointRef>, tip: impl Into<JointRef>) -> Self {
        Self {
            solver,
            root: root.into(),
            tip: tip.into(),
            effector: Vec3::ZERO,
            target: IkTarget::None,
            weight: 1.0,
            half_life: 0.1,
            pole: None,
            facing: None,
            tolerance: 5e-4,
            iterations: 32,
            retries: 0,
            joints: Vec::new(),
        }
    }

    /// A chain solved by cyclic coordinate descent.
    #[must_use]
    pub fn ccd(root: impl Into<JointRef>, tip: impl Into<JointRef>) -> Self {
        Self::new(Solver::Ccd, root, tip)
    }

    /// A chain solved by forward and backward reaching.
    #[must_use]
    pub fn fabrik(root: impl Into<JointRef>, tip: impl Into<JointRef>) -> Self {
        Self::new(Solver::Fabrik, root, tip)
    }

    /// A limb that bends in one joint.
    #[must_use]
    pub fn two_bone(root: impl Into<JointRef>, tip: impl Into<JointRef>) -> Self {
        Self::new(Solver::TwoBone { middle: None, extension: Extension::default() }, root, tip)
    }

    /// A chain whose tip looks along `forward` (model space, at rest).
    #[must_use]
    pub fn aim(root: impl Into<JointRef>, tip: impl Into<JointRef>, forward: Vec3) -> Self {
        Self::new(Solver::Aim { forward }, root, tip)
    }

    /// The same chain with this target.
    #[must_use]
    pub fn toward(self, target: IkTarget) -> Self {
        Self { target, ..self }
    }

    /// The same chain with this point of its tip brought to the target; see [`IkChain::effector`].
    #[must_use]
    pub fn with_effector(self, effector: Vec3) -> Self {
        Self { effector, ..self }
    }

    /// The same chain with its middle pointing there.
    #[must_use]
    pub fn with_pole(self, pole: Pole) -> Self {
        Self { pole: Some(pole), ..self }
    }

    /// The same chain with one more joint set up.
    #[must_use]
    pub fn with_joint(mut self, setup: ChainJointSetup) -> Self {
        self.joints.push(setup);
        self
    }
}

/// Solves [`IkChain`]s.
pub struct ChainsPlugin;

impl Plugin for ChainsPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(PostUpdate, reach.in_set(PoseSystems::Reach));
    }
}

fn reach(
    time: Res<Time>,
    assets: CharacterAssets,
    transforms: TransformHelper,
    mut characters: Query<(Entity, &Character, &Chains, Option<&Pacing>, &mut CharacterPose)>,
    mut chains: Query<(Ref<IkChain>, &mut IkState, &mut IkResult)>,
) {
    let dt = time.delta_secs();
    for (entity, character, of, pacing, mut pose) in &mut characters {
        let hidden =
            pacing.is_some_and(|pacing| matches!(pacing.mode, Mode::Hidden | Mode::ClipsOnly(ClipsOnly::Alone)));
        let Some(asset) = assets.get(character).filter(|_| !hidden) else { continue };
        let Ok(root) = transforms.compute_global_transform(entity) else { continue };
        for chain_entity in of.iter() {
            let Ok((chain, mut state, mut result)) = chains.get_mut(chain_entity) else { continue };
            if let Err(error) = state.bind(&chain, asset) {
                error!("IK chain {chain_entity} of {}: {error}", asset.file.model);
            }
            let target = match chain.target {
                IkTarget::None => None,
                IkTarget::Point(place) => Some(place),
                IkTarget::Entity(target, place) => {
                    transforms.compute_global_transform(target).ok().map(|world| world.transform_point(place))
                }
            };
            let reached = state.solve(&chain, root.affine(), target, &mut pose.pose, dt);
            result.set_if_neq(reached);
        }
    }
}
