//! Buttons that are about the program and not about the hero.

use bevy::prelude::*;
use bevy_enhanced_input::prelude::*;

/// The input context that owns the bindings.
#[derive(Component, Clone, Copy, Debug, Default)]
struct Shell;

/// Hides or shows the line of controls.
#[derive(InputAction)]
#[action_output(bool)]
pub(super) struct ToggleHelp;

/// Hides or shows how the feet are placed.
#[derive(InputAction)]
#[action_output(bool)]
pub(super) struct ToggleFeet;

/// Takes the mouse to look around with.
#[derive(InputAction)]
#[action_output(bool)]
pub(super) struct TakeMouse;

/// Gives the mouse back.
#[derive(InputAction)]
#[action_output(bool)]
pub(super) struct FreeMouse;

pub(super) fn plugin(app: &mut App) {
    app.add_input_context::<Shell>().add_systems(Startup, bind);
}

fn bind(mut commands: Commands) {
    commands.spawn((
        Shell,
        actions!(Shell[
            (Action::<ToggleHelp>::new(), bindings![KeyCode::F1, GamepadButton::Select]),
            (Action::<ToggleFeet>::new(), bindings![KeyCode::F3, GamepadButton::Start]),
            (Action::<TakeMouse>::new(), bindings![MouseButton::Left]),
            (Action::<FreeMouse>::new(), bindings![KeyCode::Escape]),
        ]),
    ));
}
