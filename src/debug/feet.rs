//! Draws how feet are placed: probes and hits, plants, landings, soles, ankles, the pelvis, and why a foot let go.
//!
//! Reads [`FootIk`], between ticks as the frame shows it, the pose and the ground; draws lines in world space, metres, over everything else.

use avian3d::prelude::SpatialQuery;
use bevy::prelude::*;

use super::{
    shown::{ShownFeet, note},
    words::{describe, reason},
};
use crate::{
    character::{
        Character,
        animator::CharacterPose,
        bind::CharacterAssets,
        foot_ik::{
            FootIk, Frames, GroundFilter, GroundFrames, Mode, NoGround, PhysicsProbe, Pivot, PlacedFoot, Plant, Probe,
        },
        schedule::{PoseClock, PoseSystems},
    },
    rig::character::CharacterAsset,
};

const PROBE: Color = Color::srgba(1.0, 1.0, 1.0, 0.45);
const HIT: Color = Color::srgb(1.0, 1.0, 1.0);
const BALL: Color = Color::srgb(0.2, 0.95, 0.35);
const HEEL: Color = Color::srgb(1.0, 0.55, 0.1);
const AIR: Color = Color::srgb(0.3, 0.65, 1.0);
const STEP: Color = Color::srgb(0.75, 0.5, 1.0);
const LANDING: Color = Color::srgb(1.0, 0.3, 0.75);
const ANKLE: Color = Color::srgb(1.0, 0.9, 0.15);
const MISSED: Color = Color::srgb(1.0, 0.3, 0.25);
const PELVIS: Color = Color::srgb(0.1, 0.9, 0.9);
const SHADE: Color = Color::srgba(0.0, 0.0, 0.0, 0.7);

/// What each colour means.
pub const LEGEND: [(&str, Color); 9] = [
    ("probe and hit", HIT),
    ("held by ball", BALL),
    ("held by heel", HEEL),
    ("sole in the air", AIR),
    ("correcting step", STEP),
    ("landing foreseen", LANDING),
    ("ankle wanted", ANKLE),
    ("ankle missed", MISSED),
    ("pelvis moved", PELVIS),
];

/// Half the width of a sole at heel, ball and tip, metres.
const HALF_WIDTHS: [f32; 3] = [0.032, 0.048, 0.03];
/// Metres by which an ankle may miss its place without being marked.
const NEAR: f32 = 0.002;
/// Height of letters, as a part of their distance from the camera.
const LETTERS: f32 = 0.026;
/// Width of lines and of letters' strokes, pixels.
const LINES: f32 = 2.5;
const STROKES: f32 = 2.0;

/// The lines of the feet. Off at first; [`GizmoConfigStore`] holds what to change:
/// `store.config_mut::<FootGizmos>().0.enabled = true`.
#[derive(Default, Reflect, GizmoConfigGroup)]
pub struct FootGizmos;

/// Their words, on when they are.
#[derive(Default, Reflect, GizmoConfigGroup)]
struct FootWords;

/// Draws [`FootGizmos`] for every character whose feet are placed.
pub struct FootDebugPlugin;

impl Plugin for FootDebugPlugin {
    fn build(&self, app: &mut App) {
        // Over everything else, since much of it lies in the ground.
        let config = |width| {
            let line = GizmoLineConfig { width, ..default() };
            GizmoConfig { line, depth_bias: -1.0, ..default() }
        };
        app.insert_gizmo_config(FootGizmos, GizmoConfig { enabled: false, ..config(LINES) })
            .insert_gizmo_config(FootWords, config(STROKES))
            .register_required_components::<FootIk, ShownFeet>()
            .add_systems(FixedPostUpdate, note.after(PoseSystems::Plant).run_if(enabled))
            .add_systems(PostUpdate, draw.after(PoseSystems::Show).run_if(enabled));
    }
}

fn enabled(store: Res<GizmoConfigStore>) -> bool {
    store.config::<FootGizmos>().0.enabled
}

fn draw(
    fixed: Res<Time<Fixed>>,
    clock: Res<PoseClock>,
    characters: Query<(&Character, &Transform, &GroundFilter, &CharacterPose, &FootIk, &ShownFeet)>,
    assets: CharacterAssets,
    frames: Frames,
    spatial: SpatialQuery,
    no_ground: Query<(), NoGround>,
    cameras: Query<(&Camera, &GlobalTransform), With<Camera3d>>,
    gizmos: Gizmos<FootGizmos>,
    words: Gizmos<FootWords>,
) {
    let mut pen = Pen { gizmos, words, eye: Transform::IDENTITY };
    let share = clock.share(fixed.overstep_fraction());
    for (character, root, filter, pose, ik, shown) in &characters {
        let feet = shown.at(share);
        let Some(asset) = assets.get(character).filter(|_| feet[0].is_some()) else { continue };
        pen.eye = nearest_eye(&cameras, root.translation);
        let probe = PhysicsProbe::new(&spatial, &no_ground, filter);
        for (side, placed) in feet.into_iter().enumerate() {
            let Some(placed) = placed else { continue };
            let foot = &ik.feet[side];
            pen.probes(&placed, &probe, root, asset);
            pen.sole(&placed, color_of(&foot.mode));
            if let Some(plant) = foot.plant() {
                pen.plant(plant, &frames);
            }
            if let Some((landing, _)) = placed.landing {
                pen.landing(landing, &placed);
            }
            pen.ankle(root.transform_point(pose.pose.position(asset.legs[side].foot)), &placed, ik.legs[side].missed);
            let words = format!("{}\n{}", describe(foot, &placed), reason(foot.released));
            pen.write_beside(placed.ankle, root.translation, &words, color_of(&foot.mode));
        }
        pen.pelvis(root.transform_point(pose.pose.position(asset.hips)), root.rotation, ik.pelvis.offset());
    }
}

/// The camera that sees a character best.
fn nearest_eye(cameras: &Query<(&Camera, &GlobalTransform), With<Camera3d>>, place: Vec3) -> Transform {
    let away = |eye: &GlobalTransform| eye.translation().distance_squared(place);
    let eyes = cameras.iter().filter(|(camera, _)| camera.is_active).map(|(_, eye)| eye);
    eyes.min_by(|a, b| away(a).total_cmp(&away(b))).map_or(Transform::IDENTITY, GlobalTransform::compute_transform)
}

fn color_of(mode: &Mode) -> Color {
    match mode {
        Mode::Planted(plant) if plant.pivot == Pivot::Heel => HEEL,
        Mode::Planted(_) => BALL,
        Mode::Swing => AIR,
        Mode::Stepping { .. } => STEP,
    }
}

struct Pen<'w, 's> {
    gizmos: Gizmos<'w, 's, FootGizmos>,
    words: Gizmos<'w, 's, FootWords>,
    /// The camera, which letters face.
    eye: Transform,
}

impl Pen<'_, '_> {
    /// Rays down through the sole and the foreseen landing, and where they met the ground.
    fn probes(&mut self, placed: &PlacedFoot, probe: &impl Probe, root: &Transform, asset: &CharacterAsset) {
        let config = &asset.file.foot_ik;
        let top = root.translation.y + config.probe_up;
        let length = config.probe_up + config.probe_down;
        for place in placed.sole.into_iter().chain(placed.landing.map(|(landing, _)| landing)) {
            let start = place.with_y(top);
            match probe.down(start, length) {
                Some(hit) => {
                    self.gizmos.line(start, hit.point, PROBE);
                    self.gizmos.cross(hit.point, 0.02, HIT);
                    self.gizmos.ray(hit.point, hit.normal * 0.06, HIT);
                }
                None => self.gizmos.ray(start, Vec3::NEG_Y * length, MISSED),
            }
        }
    }

    fn sole(&mut self, placed: &PlacedFoot, color: Color) {
        let [heel, ball, tip] = placed.sole;
        let aside = (tip - heel).cross(Vec3::Y).normalize_or_zero();
        let edge = |side: f32| {
            let [at_heel, at_ball, at_tip] = HALF_WIDTHS.map(|width| aside * width * side);
            [heel + at_heel, ball + at_ball, tip + at_tip]
        };
        let ([a, b, c], [d, e, f]) = (edge(1.0), edge(-1.0));
        self.gizmos.linestrip([a, b, c, f, e, d, a], color);
        self.gizmos.linestrip([heel, ball, tip], color);
    }

    /// The point of the ground that is held.
    fn plant(&mut self, plant: &Plant, frames: &impl GroundFrames) {
        let Some(frame) = frames.frame(plant.ground) else { return };
        let anchor = frame * plant.anchor_ground;
        let flat = Quat::from_rotation_arc(Vec3::Z, frame.rotation * plant.normal_ground);
        let color = if plant.pivot == Pivot::Heel { HEEL } else { BALL };
        for radius in [0.02, 0.035, 0.05] {
            self.gizmos.circle(Isometry3d::new(anchor, flat), radius, color);
        }
    }

    fn landing(&mut self, landing: Vec3, placed: &PlacedFoot) {
        let flat = Quat::from_rotation_arc(Vec3::Z, placed.plane.normal);
        self.gizmos.circle(Isometry3d::new(landing, flat), 0.06, LANDING);
        self.gizmos.line(placed.sole[1], landing, LANDING);
    }

    /// Where the ankle shall be, and how far `ankle` is from there.
    fn ankle(&mut self, ankle: Vec3, placed: &PlacedFoot, missed: f32) {
        self.gizmos.sphere(placed.ankle, 0.025, ANKLE);
        if missed > NEAR {
            self.gizmos.line(ankle, placed.ankle, MISSED);
            self.write(ankle, &format!("missed by {:.0} mm", missed * 1000.0), 0.0, MISSED);
        }
    }

    /// The pelvis as the clip has it, and where it was moved to.
    fn pelvis(&mut self, hips: Vec3, facing: Quat, offset: f32) {
        let (clip, aside) = (hips - Vec3::Y * offset, facing * Vec3::X * 0.16);
        self.gizmos.line(clip - aside, clip + aside, PROBE);
        self.gizmos.line(hips - aside, hips + aside, PELVIS);
        self.gizmos.line(clip, hips, PELVIS);
        let words = format!("pelvis {:+.1} cm", offset * 100.0);
        self.write(hips + aside * 1.6, &words, -0.5, PELVIS);
    }

    /// Writes beside `place`, on the side away from `middle` as the camera sees it.
    fn write_beside(&mut self, place: Vec3, middle: Vec3, words: &str, color: Color) {
        let side = (place - middle).dot(*self.eye.right()).signum();
        self.write(place + self.eye.right() * (side * 0.15), words, -0.5 * side, color);
    }

    /// Writes toward the camera; `anchor` -0.5 begins at the place, 0.5 ends there.
    fn write(&mut self, place: Vec3, words: &str, anchor: f32, color: Color) {
        let height = LETTERS * (place - self.eye.translation).dot(*self.eye.forward());
        // A dark copy below, for light ground.
        for (color, off) in [(SHADE, 0.08), (color, 0.0)] {
            let place = place + self.eye.rotation * Vec3::new(off, -off, 0.0) * height;
            self.words.text(Isometry3d::new(place, self.eye.rotation), words, height, Vec2::new(anchor, 0.0), color);
        }
    }
}
