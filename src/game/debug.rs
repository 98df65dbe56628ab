//! The view for debugging (F3): how the hero stands and places its feet, drawn over the picture. World space.

use bevy::prelude::*;

use bevy_enhanced_input::prelude::Start;

use super::{level::Hero, shell::ToggleFeet};
use crate::{
    character::motion::MotionState,
    debug::{ChainDebugPlugin, ChainGizmos, FootDebugPlugin, FootGizmos},
};

/// Whether the view is shown.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct DebugView(pub(super) bool);

pub(super) fn plugin(app: &mut App) {
    app.add_plugins((FootDebugPlugin, ChainDebugPlugin))
        .init_resource::<DebugView>()
        .add_observer(toggle)
        .add_systems(Update, draw_ground.run_if(resource_equals(DebugView(true))));
}

fn toggle(_: On<Start<ToggleFeet>>, mut view: ResMut<DebugView>, mut gizmos: ResMut<GizmoConfigStore>) {
    view.0 = !view.0;
    gizmos.config_mut::<FootGizmos>().0.enabled = view.0;
    gizmos.config_mut::<ChainGizmos>().0.enabled = view.0;
}

/// The ground under the root with its normal, and the velocity.
fn draw_ground(heroes: Query<(&Transform, &MotionState), With<Hero>>, mut gizmos: Gizmos) {
    for (root, motion) in &heroes {
        let feet = root.translation;
        if let Some(ground) = &motion.ground {
            let turn = Quat::from_rotation_arc(Vec3::Z, ground.normal);
            gizmos.circle(Isometry3d::new(feet + ground.normal * 0.01, turn), 0.3, Color::srgb(0.3, 0.9, 0.5));
            gizmos.arrow(feet, feet + ground.normal * 0.5, Color::srgb(0.3, 0.9, 0.5));
        }
        gizmos.arrow(feet, feet + motion.velocity * 0.4, Color::srgb(0.95, 0.75, 0.2));
    }
}
