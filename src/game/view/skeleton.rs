//! Draws the model's skeleton over it: a line from each joint to the one it hangs on, a cross at each joint. World space.

use bevy::prelude::*;

use super::subject::Viewed;
use crate::{
    anim::skeleton::JointIndex,
    character::{animator::CharacterPose, schedule::PoseSystems},
    game::level::Hero,
    skinning::SkinPose,
};

const BONE: Color = Color::srgb(0.98, 0.9, 0.35);
const JOINT: Color = Color::srgb(1.0, 0.35, 0.2);
/// Half the size of a joint's cross, as a share of the line to it, and metres at most.
const CROSS: f32 = 0.12;
const LARGEST_CROSS: f32 = 0.015;

/// Whether it is drawn.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(in crate::game) struct ShowSkeleton(pub(in crate::game) bool);

/// The lines.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct SkeletonGizmos;

pub(in crate::game) fn plugin(app: &mut App) {
    let line = GizmoLineConfig { width: 2.0, ..default() };
    app.init_resource::<ShowSkeleton>()
        .insert_gizmo_config(SkeletonGizmos, GizmoConfig { line, depth_bias: -1.0, ..default() })
        .add_systems(
            PostUpdate,
            draw.after(PoseSystems::Plant).after(PoseSystems::Palette).run_if(resource_equals(ShowSkeleton(true))),
        );
}

fn draw(
    viewed: Res<Viewed>,
    heroes: Query<(&Transform, Option<&SkinPose>, Option<&CharacterPose>), With<Hero>>,
    mut gizmos: Gizmos<SkeletonGizmos>,
) {
    for (root, posed, walking) in &heroes {
        let pose = posed.map(|pose| &pose.0).or(walking.map(|pose| &pose.pose));
        let skeleton = &viewed.rig.skeleton;
        let Some(pose) = pose.filter(|pose| pose.len() == skeleton.len()) else { continue };
        let at = |joint: JointIndex| root.transform_point(pose.position(joint));
        for joint in skeleton.joints() {
            let Some(parent) = skeleton.parent(joint) else { continue };
            let (from, to) = (at(parent), at(joint));
            gizmos.line(from, to, BONE);
            let arm = (CROSS * from.distance(to)).min(LARGEST_CROSS);
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                gizmos.line(to - axis * arm, to + axis * arm, JOINT);
            }
        }
    }
}
