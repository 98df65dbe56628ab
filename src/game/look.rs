//! Looking around: mouse and right stick turn the camera, the wheel zooms, a click takes the mouse and Esc gives it back.
//!
//! Reads devices, writes [`CameraInput`] (radians, steps).

use bevy::{
    prelude::*,
    window::{CursorGrabMode, CursorOptions, PrimaryWindow, WindowFocused},
};
use bevy_enhanced_input::prelude::*;

use super::{
    level::Hero,
    shell::{FreeMouse, TakeMouse},
};
use crate::{
    camera::{CameraInput, CameraPlugin, OrbitCamera},
    terrain::SkyView,
};

/// Radians a pixel of mouse travel.
const MOUSE_TURN: f32 = 0.0028;
/// Radians a second with the stick at its end.
const STICK_TURN: f32 = 2.6;
/// Part of a stick's way that counts as rest.
const STICK_REST: f32 = 0.15;

/// The player's camera; owns the bindings below.
#[derive(Component, Clone, Copy, Debug, Default)]
struct View;

/// Radians to turn in this frame: x to the right, y up.
#[derive(InputAction)]
#[action_output(Vec2)]
struct Orbit;

/// Steps to come nearer in this frame.
#[derive(InputAction)]
#[action_output(f32)]
struct Zoom;

pub(super) fn plugin(app: &mut App) {
    app.add_plugins(CameraPlugin)
        .add_input_context::<View>()
        .add_observer(open_view)
        .add_observer(take_mouse)
        .add_observer(free_mouse)
        .add_systems(PreUpdate, heed_mouse.before(EnhancedInputSystems::Update))
        .add_systems(Update, (look, free_mouse_of_other_windows));
}

fn open_view(hero: On<Add, Hero>, roots: Query<&Transform>, mut commands: Commands) {
    let yaw = roots.get(hero.entity).map_or(0.0, |root| root.rotation.to_euler(EulerRot::YXZ).0);
    let rest = DeadZone { lower_threshold: STICK_REST, ..default() };
    let mouse = Scale::new(Vec3::new(MOUSE_TURN, -MOUSE_TURN, 0.0));
    let stick = (rest, Scale::splat(STICK_TURN), DeltaScale::REAL);
    commands.spawn((
        View,
        SkyView,
        OrbitCamera::around(hero.entity).facing(yaw),
        actions!(View[
            (
                Action::<Orbit>::new(),
                Bindings::spawn((Spawn((Binding::mouse_motion(), mouse)), Axial::right_stick().with(stick))),
            ),
            (Action::<Zoom>::new(), bindings![(Binding::mouse_wheel(), SwizzleAxis::YXZ)]),
        ]),
    ));
}

fn look(
    mut views: Query<(&Actions<View>, &mut CameraInput)>,
    orbits: Query<&Action<Orbit>>,
    zooms: Query<&Action<Zoom>>,
) {
    for (actions, mut input) in &mut views {
        input.orbit += orbits.iter_many(actions).next().map_or(Vec2::ZERO, |action| **action);
        input.zoom += zooms.iter_many(actions).next().map_or(0.0, |action| **action);
    }
}

fn take_mouse(_: On<Start<TakeMouse>>, mut cursors: Query<&mut CursorOptions, With<PrimaryWindow>>) {
    for mut cursor in &mut cursors {
        hold(&mut cursor, true);
    }
}

fn free_mouse(_: On<Start<FreeMouse>>, mut cursors: Query<&mut CursorOptions, With<PrimaryWindow>>) {
    for mut cursor in &mut cursors {
        hold(&mut cursor, false);
    }
}

/// A window in the background must not keep the mouse.
fn free_mouse_of_other_windows(mut changes: MessageReader<WindowFocused>, mut cursors: Query<&mut CursorOptions>) {
    for change in changes.read().filter(|change| !change.focused) {
        if let Ok(mut cursor) = cursors.get_mut(change.window) {
            hold(&mut cursor, false);
        }
    }
}

fn hold(cursor: &mut CursorOptions, held: bool) {
    cursor.visible = !held;
    cursor.grab_mode = if held { CursorGrabMode::Locked } else { CursorGrabMode::None };
}

/// A mouse that is free moves no camera.
fn heed_mouse(mut sources: ResMut<ActionSources>, cursors: Query<&CursorOptions, With<PrimaryWindow>>) {
    sources.mouse_motion = cursors.iter().any(|cursor| cursor.grab_mode != CursorGrabMode::None);
}
