//! A chain's names looked up in a skeleton.

use std::sync::Arc;

use bevy::{math::Affine3A, prelude::*};

use super::{ChainJointSetup, IkChain, RestLimit, Solver};
use crate::{
    anim::{
        ik::chain::{ChainJoint, Workspace},
        pose::Pose,
        skeleton::{JointIndex, Skeleton},
    },
    math::rotation::direction_or,
    rig::{
        character::CharacterAsset,
        joint_ref::{JointError, JointRef},
    },
};

/// Why a chain can't be solved.
#[derive(thiserror::Error, Clone, Debug, PartialEq)]
pub(super) enum ChainError {
    #[error(transparent)]
    Joint(#[from] JointError),
    #[error("`{tip}` does not hang below `{root}`; a chain leads from a joint down to one below it")]
    NotBelow { root: String, tip: String },
    #[error("`{joint}` has a limit but is not on the way from `{root}` to `{tip}`, which is: {path}")]
    Beside { joint: String, root: String, tip: String, path: String },
    #[error("two bones need a joint between `{root}` and `{tip}`, at which the limb bends")]
    NoMiddle { root: String, tip: String },
}

/// A chain in one skeleton.
#[derive(Clone, Debug)]
pub(super) struct Bound {
    /// From the first joint that turns to the tip.
    pub path: Vec<JointIndex>,
    /// Those that turn, as a solver takes them: the path, without the tip unless that is aimed.
    pub joints: Vec<ChainJoint>,
    /// How much each takes on, for aiming.
    pub shares: Vec<f32>,
    /// What comes to the target, in the tip's space.
    pub effector: Vec3,
    /// Where the tip looks, in its space.
    pub forward: Vec3,
    /// What of the tip faces, in its space.
    pub side: Vec3,
    /// Rotation of the tip against its parent, where it is turned.
    pub tip: Option<Quat>,
    /// The joint that a limb bends at, as an index of `joints`.
    pub middle: usize,
    pub room: Workspace,
    pub skeleton: Arc<Skeleton>,
}

impl Bound {
    pub(super) fn new(chain: &IkChain, asset: &CharacterAsset) -> Result<Self, ChainError> {
        let skeleton = &asset.skeleton;
        let (root, tip) = (chain.root.find(asset)?, chain.tip.find(asset)?);
        let name = |joint: JointIndex| skeleton.name(joint).to_owned();
        let ends = || (name(root), name(tip));
        let mut path = vec![tip];
        let mut walk = tip;
        while walk != root {
            let Some(above) = skeleton.parent(walk) else {
                let (root, tip) = ends();
                return Err(ChainError::NotBelow { root, tip });
            };
            path.insert(0, above);
            walk = above;
        }
        let aims = matches!(chain.solver, Solver::Aim { .. });
        let turning = if aims { path.len() } else { path.len() - 1 };
        if turning == 0 {
            let (root, tip) = ends();
            return Err(ChainError::NotBelow { root, tip });
        }
        let rest = Pose::rest(skeleton);
        let mut joints: Vec<ChainJoint> = path[..turning]
            .iter()
            .map(|joint| ChainJoint { rest: skeleton.rest()[joint.index()].rotation, ..default() })
            .collect();
        for setup in &chain.joints {
            let joint = setup.joint.find(asset)?;
            let Some(at) = path[..turning].iter().position(|on_path| *on_path == joint) else {
                let (root, tip) = ends();
                let path: Vec<_> = path[..turning].iter().map(|joint| name(*joint)).collect();
                return Err(ChainError::Beside { joint: name(joint), root, tip, path: path.join(", ") });
            };
            set_up(&mut joints[at], setup, skeleton, &rest, &path, at);
        }
        let middle = match &chain.solver {
            Solver::TwoBone { middle, .. } => middle_of(middle.as_ref(), asset, &rest, &path)?,
            _ => turning / 2,
        };
        let tip_from_model = rest.model(tip).inverse();
        let side = chain.facing.map_or(Vec3::ZERO, |facing| facing.side);
        let forward = if let Solver::Aim { forward } = chain.solver { forward } else { Vec3::NEG_Z };
        Ok(Self {
            shares: joints.iter().map(|joint| joint.give).collect(),
            effector: tip_from_model.transform_vector3(chain.effector),
            forward: direction_or(tip_from_model.transform_vector3(forward), Vec3::NEG_Z),
            side: direction_or(tip_from_model.transform_vector3(side), Vec3::ZERO),
            tip: None,
            middle,
            room: Workspace::for_joints(joints.len()),
            skeleton: Arc::clone(skeleton),
            joints,
            path,
        })
    }
}

fn set_up(
    joint: &mut ChainJoint,
    setup: &ChainJointSetup,
    skeleton: &Skeleton,
    rest: &Pose,
    path: &[JointIndex],
    at: usize,
) {
    let index = path[at];
    let own = skeleton.rest()[index.index()];
    let above = skeleton.parent(index).map_or(skeleton.model_from_root, |parent| rest.model(parent));
    let model_from_joint = above * Affine3A::from_rotation_translation(own.rotation, own.translation);
    let bone = match path.get(at + 1) {
        Some(next) => own.scale * skeleton.rest()[next.index()].translation,
        // The last joint goes on where the bone before it led.
        None => model_from_joint.inverse().transform_vector3(rest.position(index) - rest.position(path[at.max(1) - 1])),
    };
    joint.limit = setup.limit.in_joint(&model_from_joint, bone);
    joint.give = setup.give.clamp(0.0, 1.0);
}

/// The joint that a limb bends at: the one named, or the one nearest to half-way.
fn middle_of(
    named: Option<&JointRef>,
    asset: &CharacterAsset,
    rest: &Pose,
    path: &[JointIndex],
) -> Result<usize, ChainError> {
    let (root, tip) = (path[0], path[path.len() - 1]);
    let between = 1..path.len() - 1;
    let away = |at: usize| {
        let place = rest.position(path[at]);
        (place.distance(rest.position(root)) - place.distance(rest.position(tip))).abs()
    };
    let middle = match named {
        Some(named) => {
            let joint = named.find(asset)?;
            between.clone().find(|at| path[*at] == joint)
        }
        None => between.min_by(|a, b| away(*a).total_cmp(&away(*b))),
    };
    let name = |joint: JointIndex| asset.skeleton.name(joint).to_owned();
    middle.ok_or_else(|| ChainError::NoMiddle { root: name(root), tip: name(tip) })
}

impl RestLimit {
    /// A ball that swings by this angle and twists by half of it.
    #[must_use]
    pub fn cone(swing: f32) -> Self {
        Self::Cone { swing, twist: [-0.5 * swing, 0.5 * swing] }
    }
}
