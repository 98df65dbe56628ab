//! What the player reads: a line of controls (F1), and with F3 how the hero moves.

use bevy::{
    diagnostic::{DiagnosticsStore, FrameTimeDiagnosticsPlugin},
    prelude::*,
};

use bevy_enhanced_input::prelude::Start;

use super::{debug::DebugView, level::Hero, shell::ToggleHelp};
use crate::{
    character::{locomotion::Locomotion, motion::MotionState},
    debug::LEGEND,
};

/// The line of controls.
const CONTROLS: &str = "WASD walk   Shift run   Ctrl sprint   Space jump   C crouch   H wave   mouse look   wheel zoom   \
    right button aim   Esc free the mouse   F1 hide this   F3 feet";
/// Text size in pixels.
const TEXT_SIZE: f32 = 13.0;
/// Distance of texts from the edges of the window, pixels.
const MARGIN: f32 = 12.0;
/// Most of the window's width that the line of controls takes, percent.
const WIDEST: f32 = 96.0;
/// Ink, and the shade below it that keeps it readable over snow and shadow alike.
const INK: Color = Color::srgb(0.95, 0.96, 0.98);
const SHADE: Color = Color::srgba(0.0, 0.0, 0.0, 0.6);

/// The line of controls at the lower edge.
#[derive(Component)]
pub(super) struct Help;

/// What F3 shows.
#[derive(Component)]
struct Details;

/// The readout at the upper left.
#[derive(Component)]
struct Readout;

pub(super) fn plugin(app: &mut App) {
    app.add_plugins(FrameTimeDiagnosticsPlugin::default())
        .add_systems(Startup, write)
        .add_observer(toggle_help)
        .add_systems(Update, (show_details, read_out.run_if(resource_equals(DebugView(true)))));
}

fn write(mut commands: Commands) {
    let font = TextFont { font_size: FontSize::Px(TEXT_SIZE), ..default() };
    let panel = Node { position_type: PositionType::Absolute, padding: px(6).all(), ..default() };
    commands.spawn((
        Help,
        Text::new(CONTROLS),
        font.clone(),
        TextColor(INK),
        BackgroundColor(SHADE),
        Node { left: px(MARGIN), bottom: px(MARGIN), max_width: percent(WIDEST), ..panel.clone() },
    ));
    let details = |place| (Details, TextColor(INK), BackgroundColor(SHADE), Visibility::Hidden, place);
    commands.spawn((
        Readout,
        Text::default(),
        font.clone(),
        details(Node { left: px(MARGIN), top: px(MARGIN), ..panel.clone() }),
    ));
    let entries =
        LEGEND.map(|(meaning, color)| (TextSpan::new(format!("{meaning}\n")), font.clone(), TextColor(color)));
    commands
        .spawn((Text::default(), font.clone(), details(Node { right: px(MARGIN), top: px(MARGIN), ..panel })))
        .with_children(|legend| {
            for entry in entries {
                legend.spawn(entry);
            }
        });
}

fn toggle_help(_: On<Start<ToggleHelp>>, mut help: Query<&mut Visibility, With<Help>>) {
    for mut visibility in &mut help {
        *visibility = if *visibility == Visibility::Hidden { Visibility::Inherited } else { Visibility::Hidden };
    }
}

fn show_details(debug: Res<DebugView>, mut details: Query<&mut Visibility, With<Details>>) {
    if debug.is_changed() {
        for mut visibility in &mut details {
            *visibility = if debug.0 { Visibility::Inherited } else { Visibility::Hidden };
        }
    }
}

fn read_out(
    heroes: Query<(&Transform, &MotionState, Option<&Locomotion>), With<Hero>>,
    diagnostics: Res<DiagnosticsStore>,
    mut readouts: Query<&mut Text, With<Readout>>,
) {
    let (Ok((root, motion, locomotion)), Ok(mut text)) = (heroes.single(), readouts.single_mut()) else { return };
    let rate = diagnostics.get(&FrameTimeDiagnosticsPlugin::FPS).and_then(bevy::diagnostic::Diagnostic::smoothed);
    let slope = motion.ground.as_ref().map(|ground| ground.normal.angle_between(Vec3::Y).to_degrees());
    let ground =
        slope.map_or_else(|| format!("in the air {:.2} s", motion.air_time), |slope| format!("slope {slope:.0} deg"));
    let place = root.translation;
    text.0 = format!(
        "{} at {:.2} m/s\n{ground}\nat {:.1} {:.1} {:.1}\n{:.0} frames a second",
        locomotion.map_or("", Locomotion::state),
        motion.ground_velocity.with_y(0.0).length(),
        place.x,
        place.y,
        place.z,
        rate.unwrap_or(0.0),
    );
}
