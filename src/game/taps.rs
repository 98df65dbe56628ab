//! Taps shorter than a frame: keys and buttons stay down for one frame at least, since bindings ask what is down, not what was.

use core::hash::Hash;

use bevy::{input::InputSystems, prelude::*};
use bevy_enhanced_input::prelude::EnhancedInputSystems;

/// Held down for this frame although the finger is up already.
#[derive(Resource)]
struct Lengthened<T>(Vec<T>);

pub(super) fn plugin(app: &mut App) {
    lengthen_taps_of::<KeyCode>(app);
    lengthen_taps_of::<MouseButton>(app);
}

fn lengthen_taps_of<T: Copy + Eq + Hash + Send + Sync + 'static>(app: &mut App) {
    app.insert_resource(Lengthened::<T>(Vec::new())).add_systems(
        PreUpdate,
        (let_go::<T>.before(InputSystems), lengthen::<T>.after(InputSystems).before(EnhancedInputSystems::Update)),
    );
}

fn let_go<T: Copy + Eq + Hash + Send + Sync + 'static>(
    mut input: ResMut<ButtonInput<T>>,
    mut lengthened: ResMut<Lengthened<T>>,
) {
    for button in lengthened.0.drain(..) {
        input.release(button);
    }
}

fn lengthen<T: Copy + Eq + Hash + Send + Sync + 'static>(
    mut input: ResMut<ButtonInput<T>>,
    mut lengthened: ResMut<Lengthened<T>>,
) {
    lengthened.0.extend(input.get_just_pressed().filter(|button| !input.pressed(**button)));
    for button in &lengthened.0 {
        input.press(*button);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::input::{
        ButtonState, InputPlugin,
        mouse::{MouseButton, MouseButtonInput},
    };

    #[test]
    fn a_tap_between_two_frames_is_down_for_one() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, InputPlugin, plugin));
        for state in [ButtonState::Pressed, ButtonState::Released] {
            app.world_mut().write_message(MouseButtonInput {
                button: MouseButton::Left,
                state,
                window: Entity::PLACEHOLDER,
            });
        }
        let down = [0, 1, 2].map(|_| {
            app.update();
            app.world().resource::<ButtonInput<MouseButton>>().pressed(MouseButton::Left)
        });
        assert_eq!(down, [true, false, false], "down in the frames after the tap");
    }
}
