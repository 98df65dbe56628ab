//! What a chain carries from frame to frame, and one frame of it.

use core::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use bevy::{
    math::{Affine3A, ops},
    prelude::*,
};

use super::{
    IkChain, IkTarget, Pole, Solver,
    bound::{Bound, ChainError},
    facing::PASSES,
};
use crate::{
    anim::{
        ik::{
            aim::{self, Aim},
            ccd,
            chain::{ChainJoint, Goal, end, into_chain},
            fabrik,
            limb::{self, Bend},
            swivel,
        },
        pose::Pose,
        skeleton::{JointIndex, JointTransform, Skeleton},
    },
    math::spring::Spring,
    rig::character::CharacterAsset,
};

/// Weights this near to where they go, at this speed per second, have arrived.
const ARRIVED: (f32, f32) = (1e-4, 1e-3);
/// Metres away at which a pole that is a direction stands.
const FAR: f32 = 10.0;

/// What became of an [`IkChain`] in this frame.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct IkResult {
    /// How much of the chain shows, 0..=1.
    pub weight: f32,
    /// Metres by which it misses its target when it shows in full; of an aim, by which its line of sight does. 0 while
    /// the chain is off.
    pub missed: f32,
    /// Whether that is within the tolerance.
    pub reached: bool,
}

/// What an [`IkChain`] carries from frame to frame.
#[derive(Component, Clone, Debug, Default)]
pub struct IkState {
    bound: Option<Bound>,
    /// What `bound` was made from, or failed to be made from.
    made_from: Option<(IkChain, Arc<Skeleton>)>,
    weight: Spring<f32>,
    kind: IkTarget,
    /// Where the target was shown last, model space.
    shown: Option<Vec3>,
    /// What is left of the way from the target before, model space.
    glide: Spring<Vec3>,
}

impl IkState {
    /// The joints from root to tip; none while the chain has no character or names joints that aren't there.
    #[must_use]
    pub fn path(&self) -> &[JointIndex] {
        self.bound.as_ref().map_or(&[], |bound| &bound.path)
    }

    /// The joints that turn, as they were solved in this frame, from the root on: their limits count from `rest`.
    #[must_use]
    pub fn joints(&self) -> &[ChainJoint] {
        self.bound.as_ref().map_or(&[], |bound| &bound.joints)
    }

    /// Where the target was in this frame, in model space.
    #[must_use]
    pub fn target(&self) -> Option<Vec3> {
        self.shown
    }

    /// Looks the chain's names up, if it or the character has changed.
    pub(super) fn bind(&mut self, chain: &Ref<IkChain>, asset: &CharacterAsset) -> Result<(), ChainError> {
        let same = self.made_from.as_ref().is_some_and(|(before, skeleton)| {
            Arc::ptr_eq(skeleton, &asset.skeleton) && (!chain.is_changed() || same_joints(before, chain))
        });
        if same {
            return Ok(());
        }
        self.made_from = Some((IkChain::clone(chain), Arc::clone(&asset.skeleton)));
        self.bound = None;
        self.bound = Some(Bound::new(chain, asset)?);
        Ok(())
    }

    /// One frame: `target` in the world, `world_from_model` places the character.
    pub(super) fn solve(
        &mut self,
        chain: &IkChain,
        world_from_model: Affine3A,
        target: Option<Vec3>,
        pose: &mut Pose,
        dt: f32,
    ) -> IkResult {
        let target = target.and_then(|target| into_chain(&world_from_model, target));
        let wanted = if target.is_some() && self.bound.is_some() { chain.weight.clamp(0.0, 1.0) } else { 0.0 };
        self.weight.step(wanted, chain.half_life, dt);
        if (self.weight.value - wanted).abs() < ARRIVED.0 && self.weight.velocity.abs() < ARRIVED.1 {
            self.weight = Spring::at(wanted);
        }
        let weight = self.weight.value.clamp(0.0, 1.0);
        if weight <= 0.0 {
            self.shown = None;
            self.glide = Spring::default();
            self.kind = chain.target;
            return IkResult::default();
        }
        let Some(target) = self.follow(chain, target, dt) else { return IkResult::default() };
        let Some(bound) = &mut self.bound else { return IkResult::default() };
        let missed = bound.reach(chain, &world_from_model, target, pose);
        bound.show(pose, weight);
        IkResult { weight, missed, reached: missed <= chain.tolerance }
    }

    /// The target to show: the one asked for, reached by gliding from the one before; else where it was last.
    fn follow(&mut self, chain: &IkChain, target: Option<Vec3>, dt: f32) -> Option<Vec3> {
        let Some(target) = target else { return self.shown };
        let other = match (self.kind, chain.target) {
            (IkTarget::Entity(before, _), IkTarget::Entity(now, _)) => before != now,
            (before, now) => core::mem::discriminant(&before) != core::mem::discriminant(&now),
        };
        self.kind = chain.target;
        self.glide.step(Vec3::ZERO, chain.half_life, dt);
        if let Some(shown) = self.shown.filter(|_| other) {
            self.glide = Spring::at(shown - target);
        }
        self.shown = Some(target + self.glide.value);
        self.shown
    }
}

/// Whether both name the same joints and set them up alike.
fn same_joints(a: &IkChain, b: &IkChain) -> bool {
    let side = |chain: &IkChain| chain.facing.map(|facing| facing.side);
    (&a.root, &a.tip, a.effector, &a.joints, &a.solver, side(a))
        == (&b.root, &b.tip, b.effector, &b.joints, &b.solver, side(b))
}

impl Bound {
    /// [`solve`](Self::solve), with the tip turned as the chain says.
    fn reach(&mut self, chain: &IkChain, world_from_model: &Affine3A, target: Vec3, pose: &Pose) -> f32 {
        self.tip = None;
        let mut missed = self.solve(chain, world_from_model, target, pose);
        let (Some(facing), Some(&tip)) = (chain.facing, self.path.get(self.joints.len())) else { return missed };
        let root = self.path[0];
        let above = self.skeleton.parent(root);
        let model_from_chain = above.map_or(self.skeleton.model_from_root, |above| pose.model(above));
        let chain_from_world = (*world_from_model * model_from_chain).inverse();
        for _ in 0..PASSES {
            self.tip = Some(self.faced(&facing, &chain_from_world, pose.local(tip).rotation));
            missed = self.solve(chain, world_from_model, target, pose);
        }
        missed
    }

    /// Turns its own copy of the joints; returns by how many metres they miss. Infinite in a space that is squashed flat.
    fn solve(&mut self, chain: &IkChain, world_from_model: &Affine3A, target: Vec3, pose: &Pose) -> f32 {
        let skeleton = &self.skeleton;
        for (joint, index) in self.joints.iter_mut().zip(&self.path) {
            joint.local = pose.local(*index);
        }
        let root = self.path[0];
        let model_from_chain = skeleton.parent(root).map_or(skeleton.model_from_root, |above| pose.model(above));
        let world_from_chain = *world_from_model * model_from_chain;
        let Some(place) = into_chain(&model_from_chain, target) else { return f32::INFINITY };
        let scale = world_from_chain.matrix3.x_axis.length().max(world_from_chain.matrix3.y_axis.length());
        let scale = scale.max(world_from_chain.matrix3.z_axis.length());
        let goal = Goal {
            target: place,
            effector: match self.path.get(self.joints.len()) {
                Some(tip) => {
                    let local = pose.local(*tip);
                    let turned = JointTransform { rotation: self.tip.unwrap_or(local.rotation), ..local };
                    turned.to_affine().transform_point3(self.effector)
                }
                None => self.effector,
            },
            tolerance: 0.5 * chain.tolerance / scale,
            iterations: chain.iterations,
            retries: chain.retries,
        };
        let pole = chain.pole.and_then(|pole| match pole {
            Pole::Point(place) => into_chain(&world_from_chain, place),
            Pole::Direction(way) => into_chain(&model_from_chain, pose.position(root) + way * FAR),
        });
        let swivel = |joints: &mut [ChainJoint]| {
            if let Some(pole) = pole {
                swivel::toward(joints, goal.effector, self.middle, pole);
            }
        };
        match chain.solver {
            Solver::TwoBone { extension, .. } => {
                limb::solve(&mut self.joints, &goal, Bend { middle: self.middle, pole, extension });
            }
            Solver::Ccd => {
                swivel(&mut self.joints);
                ccd::solve(&mut self.joints, &goal, &mut self.room);
                swivel(&mut self.joints);
            }
            Solver::Fabrik => {
                swivel(&mut self.joints);
                fabrik::solve(&mut self.joints, &goal, &mut self.room);
                swivel(&mut self.joints);
            }
            Solver::Aim { .. } => return self.aim(chain, &goal, &world_from_chain),
        }
        let world = |place: Vec3| world_from_chain.transform_point3(place);
        world(end(&self.joints, goal.effector)).distance(world(place))
    }

    fn aim(&mut self, chain: &IkChain, goal: &Goal, world_from_chain: &Affine3A) -> f32 {
        let eye = end(&self.joints, goal.effector);
        let away = world_from_chain.transform_vector3(goal.target - eye).length();
        let tolerance = ops::atan2(chain.tolerance, away);
        let aim = Aim { target: goal.target, eye: self.effector, forward: self.forward, tolerance };
        let aimed = aim::solve(&mut self.joints, &self.shares, &aim);
        if aimed.missed < FRAC_PI_2 { ops::sin(aimed.missed) * away } else { away }
    }

    /// Puts the joints' turns into the pose, as far as they show.
    fn show(&self, pose: &mut Pose, weight: f32) {
        let rotations = self.joints.iter().map(|joint| joint.local.rotation).chain(self.tip);
        for (rotation, index) in rotations.zip(&self.path) {
            let mut local = pose.local(*index);
            local.rotation = if weight < 1.0 { local.rotation.slerp(rotation, weight) } else { rotation };
            if local.rotation.is_finite() {
                pose.set_local(*index, local);
            }
        }
        pose.update_model_below(&self.skeleton, self.path[0]);
    }
}
