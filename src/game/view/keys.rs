//! Keys of the viewer and the panel that tells what is shown.

use bevy::prelude::*;

use super::{
    playback::{Face, Playback, Show},
    skeleton::ShowSkeleton,
    subject::Viewed,
    weights::ShowWeights,
};
use crate::{game::level::Hero, skinning::Morphs};

/// What can be pressed besides what the game knows.
const KEYS: &str = "N next clip   B clip before   V walk   K skeleton   G weights   M morphs";
/// Text size in pixels.
const TEXT_SIZE: f32 = 14.0;
/// Distance of the panel from the edges of the window, pixels.
const MARGIN: f32 = 12.0;
/// Seconds that the last pose of a clip holds that does not loop.
const HOLD: f32 = 0.5;
const INK: Color = Color::srgb(0.95, 0.96, 0.98);
const SHADE: Color = Color::srgba(0.0, 0.0, 0.0, 0.6);

/// What is shown, in words.
#[derive(Component)]
struct Panel;

pub(super) fn plugin(app: &mut App) {
    app.add_systems(Startup, write).add_systems(Update, (press, advance, tell).chain());
}

fn press(
    keys: Res<ButtonInput<KeyCode>>,
    viewed: Res<Viewed>,
    mut playback: ResMut<Playback>,
    mut skeleton: ResMut<ShowSkeleton>,
    mut weights: ResMut<ShowWeights>,
    heroes: Query<&Morphs, With<Hero>>,
) {
    let (targets, expressions) =
        heroes.iter().next().map_or((0, 0), |morphs| (morphs.names().len(), morphs.expressions().count()));
    for key in keys.get_just_pressed() {
        match key {
            KeyCode::KeyN => show(&mut playback, |shown| shown.stepped(viewed.rig.clips.len(), 1)),
            KeyCode::KeyB => show(&mut playback, |shown| shown.stepped(viewed.rig.clips.len(), -1)),
            KeyCode::KeyV => show(&mut playback, |_| Show::Own),
            KeyCode::KeyK => skeleton.0 = !skeleton.0,
            KeyCode::KeyG => weights.0 = !weights.0,
            KeyCode::KeyM => {
                playback.face = Face::after(playback.face, targets, expressions);
                // A character that walks has its own expression.
                if playback.show == Show::Own {
                    playback.show = Show::Rest;
                }
            }
            _ => {}
        }
    }
}

fn show(playback: &mut Playback, next: impl Fn(Show) -> Show) {
    *playback = Playback { show: next(playback.show), time: 0.0, ..*playback };
}

/// Clips begin again at their end.
fn advance(time: Res<Time>, viewed: Res<Viewed>, mut playback: ResMut<Playback>) {
    let Show::Clip(clip) = playback.show else { return };
    let Some(clip) = viewed.rig.clips.get(clip) else { return };
    playback.time += time.delta_secs();
    if !clip.looping && playback.time > clip.duration + HOLD {
        playback.time = 0.0;
    }
}

fn write(mut commands: Commands) {
    commands.spawn((
        Panel,
        Text::default(),
        TextFont { font_size: FontSize::Px(TEXT_SIZE), ..default() },
        TextColor(INK),
        BackgroundColor(SHADE),
        Node {
            position_type: PositionType::Absolute,
            right: px(MARGIN),
            top: px(MARGIN),
            padding: px(6).all(),
            ..default()
        },
    ));
}

fn tell(
    viewed: Res<Viewed>,
    playback: Res<Playback>,
    heroes: Query<Option<&Morphs>, With<Hero>>,
    mut panels: Query<&mut Text, With<Panel>>,
) {
    let Ok(mut text) = panels.single_mut() else { return };
    let shown = match playback.show {
        Show::Own if viewed.walks => "walks".to_owned(),
        Show::Own => "rests, for it cannot walk".to_owned(),
        Show::Rest => "rests".to_owned(),
        Show::Clip(clip) => {
            let name = viewed.rig.clips.get(clip).map_or("", |clip| &clip.name);
            format!("clip {} of {}: {name}, {:.2} s", clip + 1, viewed.rig.clips.len(), playback.time)
        }
    };
    let morphs = heroes.iter().flatten().next();
    let face = match playback.face {
        Some(Face::Target(target)) => {
            morphs.and_then(|morphs| morphs.names().get(target)).map(|name| format!("\nmorph target {name}"))
        }
        Some(Face::Expression(expression)) => {
            morphs.and_then(|morphs| morphs.expressions().nth(expression)).map(|name| format!("\nexpression {name}"))
        }
        None => None,
    };
    let told = format!("{}\n{shown}{}\n{KEYS}", viewed.name, face.unwrap_or_default());
    if text.0 != told {
        text.0 = told;
    }
}
