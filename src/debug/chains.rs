//! Draws IK chains that show: their bones, where they shall go, whether they get there, and how far their joints may turn.
//!
//! Reads [`IkState`] and the pose; draws lines in world space, metres, over everything else.

use bevy::{
    math::{Affine3A, ops},
    prelude::*,
};

use crate::{
    anim::ik::{chain::ChainJoint, limits::Limit},
    character::{
        Character,
        animator::CharacterPose,
        bind::CharacterAssets,
        chains::{ChainOf, IkChain, IkResult, IkState, Pole},
        schedule::PoseSystems,
    },
    math::rotation::{any_perpendicular, direction_or, from_scaled_axis},
};

const BONE: Color = Color::srgb(1.0, 1.0, 1.0);
const REACHED: Color = Color::srgb(0.2, 0.95, 0.35);
const MISSED: Color = Color::srgb(1.0, 0.3, 0.25);
const CONE: Color = Color::srgb(0.3, 0.65, 1.0);
const HINGE: Color = Color::srgb(1.0, 0.75, 0.15);
const POLE: Color = Color::srgb(0.85, 0.5, 1.0);

/// Length in metres of the sides of cones, and radius of hinges' arcs.
const SIDE: f32 = 0.12;
/// Lines along a cone's side, and pieces of an arc.
const SIDES: u8 = 8;
const PIECES: u8 = 16;
/// Width of lines, pixels.
const LINES: f32 = 2.0;
/// Length in metres of the line toward a pole.
const POLE_LINE: f32 = 0.3;

/// The lines of IK chains. Off at first; [`GizmoConfigStore`] holds what to change:
/// `store.config_mut::<ChainGizmos>().0.enabled = true`.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct ChainGizmos;

/// Draws [`ChainGizmos`] for every IK chain of a character.
pub struct ChainDebugPlugin;

impl Plugin for ChainDebugPlugin {
    fn build(&self, app: &mut App) {
        let line = GizmoLineConfig { width: LINES, ..default() };
        app.insert_gizmo_config(ChainGizmos, GizmoConfig { enabled: false, line, depth_bias: -1.0, ..default() })
            .add_systems(PostUpdate, draw.after(PoseSystems::Reach).before(PoseSystems::Palette).run_if(enabled));
    }
}

fn enabled(store: Res<GizmoConfigStore>) -> bool {
    store.config::<ChainGizmos>().0.enabled
}

fn draw(
    chains: Query<(&IkChain, &IkState, &IkResult, &ChainOf)>,
    characters: Query<(&Character, &Transform, &CharacterPose)>,
    assets: CharacterAssets,
    mut gizmos: Gizmos<ChainGizmos>,
) {
    for (chain, state, result, of) in &chains {
        let Ok((character, root, pose)) = characters.get(of.0) else { continue };
        let Some(asset) = assets.get(character).filter(|_| result.weight > 0.0) else { continue };
        let world_from_model = root.compute_affine();
        let place = |index: usize| world_from_model.transform_point3(pose.pose.position(state.path()[index]));
        for (index, joint) in state.joints().iter().enumerate() {
            let bone = match state.path().get(index + 1) {
                Some(next) => {
                    gizmos.line(place(index), place(index + 1), BONE);
                    joint.local.scale * pose.pose.local(*next).translation
                }
                None => Vec3::ZERO,
            };
            let above = asset.skeleton.parent(state.path()[index]);
            let model_from_parent = above.map_or(asset.skeleton.model_from_root, |above| pose.pose.model(above));
            let frame = world_from_model * model_from_parent;
            draw_limit(&mut gizmos, &frame, joint, place(index), bone);
        }
        if let Some(target) = state.target() {
            let target = world_from_model.transform_point3(target);
            let color = if result.reached { REACHED } else { MISSED };
            gizmos.sphere(target, 0.045, color);
            if !result.reached
                && let Some(tip) = state.path().len().checked_sub(1)
            {
                gizmos.line(place(tip), target, color);
            }
        }
        if let (Some(pole), false) = (chain.pole, state.joints().is_empty()) {
            let start = place(state.joints().len() / 2);
            let way = match pole {
                Pole::Point(point) => point - start,
                Pole::Direction(way) => world_from_model.transform_vector3(way),
            };
            gizmos.arrow(start, start + direction_or(way, Vec3::ZERO) * POLE_LINE, POLE);
        }
    }
}

/// `world_from_parent` places the space that the joint's limit is fixed in; `bone` is its bone in its own space.
fn draw_limit(
    gizmos: &mut Gizmos<ChainGizmos>,
    world_from_parent: &Affine3A,
    joint: &ChainJoint,
    place: Vec3,
    bone: Vec3,
) {
    let world = |turned: Vec3| {
        place + direction_or(world_from_parent.transform_vector3(joint.rest * turned), Vec3::ZERO) * SIDE
    };
    let share = |piece: u8, of: u8| f32::from(piece) / f32::from(of);
    match joint.limit {
        Limit::Free | Limit::Fixed => {}
        Limit::Hinge { axis, min, max } => {
            let bone = direction_or(bone.reject_from_normalized(axis), any_perpendicular(axis));
            let at = |piece: u8| world(from_scaled_axis(axis * min.lerp(max, share(piece, PIECES))) * bone);
            gizmos.linestrip((0..=PIECES).map(at), HINGE);
            gizmos.linestrip([at(0), place, at(PIECES)], HINGE);
        }
        Limit::Cone { axis, swing, .. } => {
            let across = any_perpendicular(axis);
            let side = |turn: f32| {
                let (sin, cos) = ops::sin_cos(swing);
                world(axis * cos + from_scaled_axis(axis * turn) * across * sin)
            };
            let turn = |piece: u8, of: u8| core::f32::consts::TAU * share(piece, of);
            gizmos.linestrip((0..=2 * PIECES).map(|piece| side(turn(piece, 2 * PIECES))), CONE);
            for piece in 0..SIDES {
                gizmos.line(place, side(turn(piece, SIDES)), CONE.with_alpha(0.5));
            }
        }
    }
}
