//! The player's hands: keys, sticks and buttons → [`MoveIntent`] and actions. World space; steering is relative to the camera.

use bevy::prelude::*;
use bevy_enhanced_input::prelude::*;

use super::level::Hero;
use crate::{
    character::{animator, intent::MoveIntent, schedule::MotionSystems},
    rig::tuning::motion::MotionConfig,
};

/// Part of a stick's way that counts as rest.
const STICK_REST: f32 = 0.15;

/// The character that a person steers. Also the input context: it owns the bindings below.
#[derive(Component, Clone, Copy, Debug, Default)]
#[require(MoveIntent, Presses)]
pub(super) struct Player;

/// Where to, x to the right and y ahead as the camera sees it, length up to 1.
#[derive(InputAction)]
#[action_output(Vec2)]
struct Steer;

/// How far from a walk (0) to a run (1).
#[derive(InputAction)]
#[action_output(f32)]
struct Run;

/// Held to sprint.
#[derive(InputAction)]
#[action_output(bool)]
struct Sprint;

/// Pressed once to sprint until the stick rests, since nobody steers well with a stick held down.
#[derive(InputAction)]
#[action_output(bool)]
struct Dash;

#[derive(InputAction)]
#[action_output(bool)]
struct Jump;

#[derive(InputAction)]
#[action_output(bool)]
struct Crouch;

/// Held to face where the camera looks, and to point there.
#[derive(InputAction)]
#[action_output(bool)]
pub(super) struct Aim;

/// Pressed to greet.
#[derive(InputAction)]
#[action_output(bool)]
struct Wave;

/// What was pressed since the last fixed tick, so that a tap shorter than a tick counts.
#[derive(Component, Clone, Copy, Debug, Default)]
struct Presses {
    jump: bool,
    dash: bool,
}

pub(super) fn plugin(app: &mut App) {
    app.add_plugins(EnhancedInputPlugin)
        .add_input_context::<Player>()
        .add_observer(take_hero)
        .add_observer(bind)
        .add_observer(remember_jump)
        .add_observer(remember_dash)
        .add_observer(wave)
        .add_systems(FixedUpdate, decide.in_set(MotionSystems::Decide));
}

/// The person at the keyboard steers the hero.
fn take_hero(hero: On<Add, Hero>, mut commands: Commands) {
    commands.entity(hero.entity).insert(Player);
}

fn bind(added: On<Add, Player>, mut commands: Commands) {
    let rest = DeadZone { lower_threshold: STICK_REST, ..default() };
    commands.entity(added.entity).insert(actions!(Player[
        (Action::<Steer>::new(), rest, Bindings::spawn((Cardinal::wasd_keys(), Cardinal::arrows(), Axial::left_stick()))),
        (Action::<Run>::new(), bindings![KeyCode::ShiftLeft, KeyCode::ShiftRight, GamepadButton::RightTrigger2]),
        (Action::<Sprint>::new(), bindings![KeyCode::ControlLeft, KeyCode::ControlRight]),
        (Action::<Dash>::new(), bindings![GamepadButton::LeftThumb]),
        (Action::<Jump>::new(), bindings![KeyCode::Space, GamepadButton::South]),
        (Action::<Crouch>::new(), bindings![KeyCode::KeyC, GamepadButton::East]),
        (Action::<Aim>::new(), bindings![MouseButton::Right, GamepadButton::LeftTrigger2]),
        (Action::<Wave>::new(), bindings![KeyCode::KeyH, GamepadButton::DPadUp]),
    ]));
}

fn remember_jump(jump: On<Start<Jump>>, mut players: Query<&mut Presses>) {
    if let Ok(mut presses) = players.get_mut(jump.context) {
        presses.jump = true;
    }
}

fn remember_dash(dash: On<Start<Dash>>, mut players: Query<&mut Presses>) {
    if let Ok(mut presses) = players.get_mut(dash.context) {
        presses.dash = true;
    }
}

fn wave(wave: On<Start<Wave>>, mut players: Query<&mut animator::Actions>) {
    if let Ok(mut actions) = players.get_mut(wave.context) {
        actions.play("wave");
    }
}

fn decide(
    mut players: Query<(&Actions<Player>, &MotionConfig, &mut Presses, &mut MoveIntent), With<Player>>,
    steers: Query<&Action<Steer>>,
    runs: Query<&Action<Run>>,
    sprints: Query<&Action<Sprint>>,
    jumps: Query<&Action<Jump>>,
    crouches: Query<&Action<Crouch>>,
    aims: Query<&Action<Aim>>,
    cameras: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
) {
    let view = cameras.iter().find(|(camera, _)| camera.is_active).map_or(Vec3::NEG_Z, |(_, view)| *view.forward());
    for (actions, config, mut presses, mut intent) in &mut players {
        let steer = steers.iter_many(actions).next().map_or(Vec2::ZERO, |action| **action);
        let run = runs.iter_many(actions).next().map_or(0.0, |action| **action).clamp(0.0, 1.0);
        let held_jump = jumps.iter_many(actions).next().is_some_and(|action| **action);
        let aim = aims.iter_many(actions).next().is_some_and(|action| **action);
        presses.dash &= steer != Vec2::ZERO;
        // Nobody aims at a sprint.
        let sprint = !aim && (presses.dash || sprints.iter_many(actions).next().is_some_and(|action| **action));
        let speed = if sprint { config.sprint_speed } else { config.walk_speed.lerp(config.run_speed, run) };
        intent.velocity = wanted_velocity(steer, view, speed);
        intent.facing = aim.then(|| level_forward(view));
        intent.aim = aim.then_some(view);
        intent.jump = held_jump || presses.jump;
        intent.crouch = crouches.iter_many(actions).next().is_some_and(|action| **action);
        presses.jump = false;
    }
}

/// World velocity for a stick at `steer` while the camera looks along `view`; a full stick wants `speed` m/s.
///
/// A stick pushed into its corner wants no more than `speed`.
#[must_use]
fn wanted_velocity(steer: Vec2, view: Vec3, speed: f32) -> Vec3 {
    let forward = level_forward(view);
    let right = forward.cross(Vec3::Y);
    let steer = steer.clamp_length_max(1.0);
    (right * steer.x + forward * steer.y) * speed
}

/// The level direction that `view` points to. Straight up or down gives -Z.
#[must_use]
fn level_forward(view: Vec3) -> Vec3 {
    view.with_y(0.0).try_normalize().unwrap_or(Vec3::NEG_Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::character::schedule::SchedulePlugin;
    use bevy::{
        input::{
            InputPlugin,
            gamepad::{
                GamepadConnection, GamepadConnectionEvent, RawGamepadAxisChangedEvent, RawGamepadButtonChangedEvent,
                RawGamepadEvent,
            },
        },
        time::TimeUpdateStrategy,
    };

    /// An app with a player and a camera that looks to +X and 45° down.
    fn app() -> (App, Entity) {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, InputPlugin, SchedulePlugin, plugin))
            .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
        let look = GlobalTransform::from(Transform::default().looking_to(Vec3::new(1.0, -1.0, 0.0), Vec3::Y));
        app.world_mut().spawn((Camera3d::default(), look));
        app.finish();
        app.cleanup();
        let player = app.world_mut().spawn((Player, MotionConfig::default())).id();
        app.update();
        (app, player)
    }

    fn intent_with(keys: &[KeyCode]) -> MoveIntent {
        let (mut app, player) = app();
        for key in keys {
            app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(*key);
        }
        app.update();
        app.update();
        app.world().get::<MoveIntent>(player).unwrap().clone()
    }

    #[test]
    fn ahead_is_where_the_camera_looks() {
        let config = MotionConfig::default();
        let velocity = intent_with(&[KeyCode::KeyW]).velocity;
        assert!(velocity.distance(Vec3::X * config.walk_speed) < 1e-4, "wanted {velocity}");
    }

    #[test]
    fn shift_runs_and_two_keys_are_no_faster_than_one() {
        let config = MotionConfig::default();
        let velocity = intent_with(&[KeyCode::KeyW, KeyCode::KeyD, KeyCode::ShiftLeft]).velocity;
        assert!((velocity.length() - config.run_speed).abs() < 1e-3, "ran at {} m/s", velocity.length());
        assert!(velocity.x > 1.0 && velocity.z > 1.0, "ahead and right of +X is +X+Z, wanted {velocity}");
    }

    #[test]
    fn control_sprints_and_shift_beside_it_changes_nothing() {
        let config = MotionConfig::default();
        for keys in
            [&[KeyCode::KeyW, KeyCode::ControlLeft][..], &[KeyCode::KeyW, KeyCode::ControlLeft, KeyCode::ShiftLeft]]
        {
            let speed = intent_with(keys).velocity.length();
            assert!((speed - config.sprint_speed).abs() < 1e-3, "sprints at {speed} m/s with {keys:?}");
        }
    }

    #[test]
    fn a_dash_lasts_until_the_stick_rests() {
        let (mut app, player) = app();
        let speed = |app: &mut App| {
            app.update();
            app.update();
            app.world().get::<MoveIntent>(player).unwrap().velocity.length()
        };
        let config = MotionConfig::default();
        app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(KeyCode::KeyW);
        app.update();
        app.world_mut().get_mut::<Presses>(player).unwrap().dash = true;
        assert!((speed(&mut app) - config.sprint_speed).abs() < 1e-3, "the dash does not sprint");
        app.world_mut().resource_mut::<ButtonInput<KeyCode>>().release(KeyCode::KeyW);
        assert!(speed(&mut app) < 1e-6, "it goes on without a way");
        app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(KeyCode::KeyW);
        assert!((speed(&mut app) - config.walk_speed).abs() < 1e-3, "the dash outlives its stop");
    }

    #[test]
    fn the_right_button_faces_and_points_where_the_camera_looks() {
        let (mut app, player) = app();
        app.world_mut().resource_mut::<ButtonInput<MouseButton>>().press(MouseButton::Right);
        app.update();
        app.update();
        let MoveIntent { facing, aim, .. } = app.world().get::<MoveIntent>(player).unwrap().clone();
        assert!(facing.unwrap().distance(Vec3::X) < 1e-4, "it faces {facing:?}");
        assert!(aim.unwrap().distance(Vec3::new(1.0, -1.0, 0.0).normalize()) < 1e-4, "it aims along {aim:?}");
        app.world_mut().resource_mut::<ButtonInput<MouseButton>>().release(MouseButton::Right);
        app.update();
        app.update();
        assert_eq!(app.world().get::<MoveIntent>(player).unwrap().aim, None, "the button is up");
    }

    #[test]
    fn a_tap_of_its_key_waves() {
        let (mut app, player) = app();
        app.world_mut().entity_mut(player).insert(animator::Actions::default());
        app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(KeyCode::KeyH);
        app.update();
        app.update();
        assert!(app.world().get::<animator::Actions>(player).unwrap().is_playing("wave"), "no wave is asked for");
    }

    /// What a pad's driver reports, from the plug on.
    struct Pad(Entity);

    impl Pad {
        fn plug(app: &mut App) -> Self {
            let pad = app.world_mut().spawn_empty().id();
            let (name, vendor_id, product_id) = ("Pad".into(), None, None);
            let connection = GamepadConnection::Connected { name, vendor_id, product_id };
            app.world_mut().write_message(GamepadConnectionEvent::new(pad, connection));
            app.update();
            Self(pad)
        }

        fn tilt(&self, app: &mut App, axis: GamepadAxis, value: f32) {
            let event = RawGamepadAxisChangedEvent::new(self.0, axis, value);
            app.world_mut().write_message(RawGamepadEvent::Axis(event));
        }

        fn press(&self, app: &mut App, button: GamepadButton, value: f32) {
            let event = RawGamepadButtonChangedEvent::new(self.0, button, value);
            app.world_mut().write_message(RawGamepadEvent::Button(event));
        }
    }

    #[test]
    fn a_gamepad_walks_runs_dashes_and_presses_everything() {
        let (mut app, player) = app();
        app.world_mut().entity_mut(player).insert(animator::Actions::default());
        let pad = Pad::plug(&mut app);
        let intent = |app: &mut App| {
            app.update();
            app.update();
            app.world().get::<MoveIntent>(player).unwrap().clone()
        };
        let config = MotionConfig::default();

        pad.tilt(&mut app, GamepadAxis::LeftStickX, 1.0);
        let wanted = intent(&mut app).velocity;
        assert!(wanted.distance(Vec3::Z * config.walk_speed) < 1e-3, "the stick to its right wants {wanted}");
        pad.press(&mut app, GamepadButton::RightTrigger2, 1.0);
        let speed = intent(&mut app).velocity.length();
        assert!((speed - config.run_speed).abs() < 1e-3, "the right trigger runs at {speed} m/s");
        pad.press(&mut app, GamepadButton::RightTrigger2, 0.0);
        pad.press(&mut app, GamepadButton::LeftThumb, 1.0);
        let speed = intent(&mut app).velocity.length();
        assert!((speed - config.sprint_speed).abs() < 1e-3, "a press of the stick sprints at {speed} m/s");
        pad.press(&mut app, GamepadButton::LeftThumb, 0.0);
        pad.tilt(&mut app, GamepadAxis::LeftStickX, 0.0);
        assert_eq!(intent(&mut app), MoveIntent::default(), "the stick rests");

        for button in [GamepadButton::South, GamepadButton::East, GamepadButton::LeftTrigger2, GamepadButton::DPadUp] {
            pad.press(&mut app, button, 1.0);
        }
        let MoveIntent { jump, crouch, aim, .. } = intent(&mut app);
        assert!(jump && crouch && aim.is_some(), "jump {jump}, crouch {crouch}, aim {aim:?}");
        assert!(app.world().get::<animator::Actions>(player).unwrap().is_playing("wave"), "no wave is asked for");
    }

    #[test]
    fn nothing_pressed_wants_nothing() {
        assert_eq!(intent_with(&[]), MoveIntent::default());
    }

    #[test]
    fn a_tap_shorter_than_a_tick_still_jumps_once() {
        let (mut app, player) = app();
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(0));
        app.world_mut().resource_mut::<ButtonInput<KeyCode>>().press(KeyCode::Space);
        app.update();
        app.world_mut().resource_mut::<ButtonInput<KeyCode>>().release(KeyCode::Space);
        app.update();
        app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
        let mut jumps = Vec::new();
        for _ in 0..3 {
            app.update();
            jumps.push(app.world().get::<MoveIntent>(player).unwrap().jump);
        }
        assert_eq!(jumps, [true, false, false], "jump at the ticks after the tap");
    }

    #[test]
    fn a_half_pushed_stick_walks_at_half_speed() {
        let velocity = wanted_velocity(Vec2::new(0.0, 0.5), Vec3::NEG_Z, 1.4);
        assert!(velocity.distance(Vec3::NEG_Z * 0.7) < 1e-6, "wanted {velocity}");
    }

    #[test]
    fn a_camera_that_looks_straight_down_still_steers() {
        let velocity = wanted_velocity(Vec2::Y, Vec3::NEG_Y, 1.0);
        assert!((velocity.length() - 1.0).abs() < 1e-6, "wanted {velocity}");
    }
}
