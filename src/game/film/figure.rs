//! Films a model of `surefoot view` into one sheet: at rest, its skeleton and weights, each morph target, each clip, and its
//! walk over the course.

use std::path::{Path, PathBuf};

use bevy::{light::CascadeShadowConfigBuilder, math::ops, prelude::*};

use super::{
    FilmError, PATIENCE, frames, load,
    sheet::ContactSheet,
    shutter::{Canvas, ShutterPlugin, developed, expose},
    walk,
};
use crate::{
    anim::pose::Pose,
    game::{
        cli::Options,
        engine::{self, TICKS_PER_SECOND},
        level::{self, Cast, Hero, Loading, watch_loading},
        view::{
            playback::{self, Face, Playback, Show, posed},
            skeleton::{self, ShowSkeleton},
            subject::{Part, Subject},
            weights::{self, ShowWeights},
        },
    },
    rig::{Rig, loader::RigPlugin, tuning::motion::MotionConfig},
    skinning::SkinningPlugin,
};

/// Width and height of a picture, pixels.
const SIZE: UVec2 = UVec2::new(480, 360);
/// Pictures of each clip, and of the walk.
const OF_A_CLIP: usize = 4;
const OF_THE_WALK: usize = 12;
/// Most morph targets and expressions that are shown.
const MORPHS: usize = 8;
const EXPRESSIONS: usize = 20;
/// Number of pictures that only warm up: what is new is drawn some pictures later.
const UNSEEN: usize = usize::MAX;
const WARM_UP: usize = 3;
/// Upright angle of view, radians, and spare room around the model.
const FOV: f32 = 0.5;
const ROOM: f32 = 1.02;
/// From where the camera looks.
const AHEAD: Vec3 = Vec3::new(0.45, 0.18, -0.9);
const ASIDE: Vec3 = Vec3::new(-1.0, 0.1, 0.0);

/// One picture of the model on the spot.
#[derive(Clone)]
struct Shot {
    caption: String,
    playback: Playback,
    from: Vec3,
    skeleton: bool,
    weights: bool,
}

impl Shot {
    fn new(caption: &str, show: Show, time: f32) -> Self {
        let playback = Playback { show, time, face: None };
        Self { caption: caption.to_owned(), playback, from: AHEAD, skeleton: false, weights: false }
    }

    /// Middle and radius of the model in it, metres.
    fn ball(&self, rig: &Rig) -> (Vec3, f32) {
        let (low, high) = extent(rig, &posed(rig, self.playback.show, self.playback.time));
        (0.5 * (low + high), 0.5 * (high - low).length())
    }
}

/// Films `subject` into a sheet named like its file; returns where that lies.
///
/// # Errors
/// [`FilmError`]: the engine cannot load the model, or nothing could be written.
pub(in crate::game) fn run(subject: &Subject, options: &Options, assets: &Path) -> Result<PathBuf, FilmError> {
    std::fs::create_dir_all(&options.out).map_err(|error| FilmError::file(&options.out, error))?;
    let shots = shots(&subject.body());
    let walks = if subject.walks() { OF_THE_WALK } else { 0 };
    let mut roll = Roll { sheet: ContactSheet::new(shots.len() + walks), captions: Vec::new(), taken: 0 };
    let size = options.size.unwrap_or(SIZE);
    film_figure(subject, &shots, size, assets, &mut roll)?;
    if walks > 0 {
        film_walk(subject, options, size, assets, &mut roll)?;
    }
    let file = options.out.join(&subject.name).with_extension("png");
    let (taken, wanted) = (roll.taken, roll.captions.len());
    match roll.sheet.compose() {
        Some(sheet) if taken == wanted => frames::save(&file, &sheet)?,
        _ => return Err(FilmError::NoPicture(taken)),
    }
    Ok(file)
}

/// The sheet so far.
struct Roll {
    sheet: ContactSheet,
    /// Of all pictures exposed, by number.
    captions: Vec<String>,
    taken: usize,
}

impl Roll {
    fn expose(&mut self, app: &mut App, ticks: u32, caption: impl FnOnce(&mut World) -> String) {
        expose(app, self.captions.len(), ticks);
        self.captions.push(caption(app.world_mut()));
        self.keep(app);
    }

    fn keep(&mut self, app: &mut App) {
        for (picture, image) in developed(app).into_iter().filter(|(picture, _)| *picture != UNSEEN) {
            self.sheet.add(picture, image, self.captions[picture].clone());
            self.taken += 1;
        }
    }

    /// Waits for the pictures that are still on their way.
    fn finish(&mut self, app: &mut App) {
        for _ in 0..PATIENCE {
            if self.taken == self.captions.len() {
                return;
            }
            app.update();
            self.keep(app);
        }
    }
}

/// What is shown of a model besides its walk.
fn shots(rig: &Rig) -> Vec<Shot> {
    let rest = Shot::new("at rest", Show::Rest, 0.0);
    let mut shots = vec![
        rest.clone(),
        Shot { caption: "from its left".to_owned(), from: ASIDE, ..rest.clone() },
        Shot { caption: "skeleton".to_owned(), skeleton: true, ..rest.clone() },
        Shot { caption: "weights".to_owned(), weights: true, ..rest.clone() },
    ];
    let targets = rig.meshes.iter().map(|mesh| mesh.morph_weights.len()).max().unwrap_or(0);
    for morph in 0..targets.min(MORPHS) {
        let playback = Playback { face: Some(Face::Target(morph)), ..rest.playback };
        shots.push(Shot { caption: format!("morph target {}", morph + 1), playback, ..rest.clone() });
    }
    let expressions = rig.expressions.iter().enumerate().filter(|(_, expression)| !expression.binds.is_empty());
    for (index, expression) in expressions.take(EXPRESSIONS) {
        let playback = Playback { face: Some(Face::Expression(index)), ..rest.playback };
        shots.push(Shot { caption: format!("expression {}", expression.name), playback, ..rest.clone() });
    }
    // Each clip begins a row of four.
    while shots.len() % OF_A_CLIP != 0 {
        let (place, playback) = (shots.len() % OF_A_CLIP, rest.playback);
        let turned = Quat::from_rotation_y(place as f32) * AHEAD;
        shots.push(Shot { caption: "turned".to_owned(), playback, from: turned, ..rest.clone() });
    }
    for (index, clip) in rig.clips.iter().enumerate() {
        for moment in 0..OF_A_CLIP {
            let last = if clip.looping { OF_A_CLIP } else { OF_A_CLIP - 1 };
            let time = clip.duration * moment as f32 / last as f32;
            shots.push(Shot::new(&format!("{} {time:.2} s", clip.name), Show::Clip(index), time));
        }
    }
    // Without meshes there is nothing else to see.
    shots.iter_mut().for_each(|shot| shot.skeleton |= rig.meshes.is_empty());
    shots
}

fn film_figure(
    subject: &Subject,
    shots: &[Shot],
    size: UVec2,
    assets: &Path,
    roll: &mut Roll,
) -> Result<(), FilmError> {
    let rig = subject.body();
    let mut app = engine::headless_from(subject.app(), assets);
    app.init_resource::<Loading>()
        .insert_resource(ClearColor(Color::srgb(0.62, 0.70, 0.78)))
        .add_plugins((
            ShutterPlugin { size },
            RigPlugin,
            SkinningPlugin::default(),
            playback::plugin,
            skeleton::plugin,
            weights::plugin,
        ))
        .add_systems(Startup, furnish)
        .add_systems(Update, watch_loading.run_if(resource_equals(Loading::Waiting)));
    subject.enter(&mut app, Part::Figure);
    engine::finish(&mut app);
    app.update();
    let floor = extent(&rig, &Pose::rest(&rig.skeleton)).0.y;
    let world = app.world_mut();
    for mut ground in world.query_filtered::<&mut Transform, With<Ground>>().iter_mut(world) {
        ground.translation.y = floor;
    }
    load(&mut app)?;
    let balls: Vec<(Vec3, f32)> = shots.iter().map(|shot| shot.ball(&rig)).collect();
    for (shot, (middle, _)) in shots.iter().zip(&balls) {
        // One distance for all pictures of a clip, so that they can be compared.
        let alike = shots.iter().zip(&balls).filter(|(other, _)| other.playback.show == shot.playback.show);
        let radius = alike.map(|(_, (_, radius))| *radius).fold(0.05, f32::max);
        stage(&mut app, shot, *middle, ROOM * radius / ops::sin(0.5 * FOV));
        // What a shot turns on or off is new to the engine; a picture without it goes first.
        for _ in 0..WARM_UP {
            expose(&mut app, UNSEEN, 1);
        }
        roll.expose(&mut app, 1, |_| shot.caption.clone());
    }
    roll.finish(&mut app);
    Ok(())
}

/// Poses the model and puts the camera `distance` metres from its `middle`.
fn stage(app: &mut App, shot: &Shot, middle: Vec3, distance: f32) {
    let world = app.world_mut();
    world.insert_resource(shot.playback);
    world.insert_resource(ShowSkeleton(shot.skeleton));
    world.insert_resource(ShowWeights(shot.weights));
    let eye = middle + shot.from.normalize() * distance;
    for mut camera in world.query_filtered::<&mut Transform, With<Camera3d>>().iter_mut(world) {
        *camera = Transform::from_translation(eye).looking_at(middle, Vec3::Y);
    }
}

/// Lowest and highest corner of what the joints move, and of the joints themselves.
fn extent(rig: &Rig, pose: &Pose) -> (Vec3, Vec3) {
    let joints = pose.positions();
    let moved = pose.models().iter().zip(&rig.dominated);
    let vertices = moved.flat_map(|(joint, vertices)| vertices.iter().map(|vertex| joint.transform_point3(*vertex)));
    let any = vertices.chain(joints).filter(|at| at.is_finite());
    let (low, high) = any.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
    if low.is_finite() { (low, high) } else { (Vec3::NEG_ONE, Vec3::ONE) }
}

#[derive(Component)]
struct Ground;

fn furnish(
    cast: Res<Cast>,
    canvas: Res<Canvas>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut commands: Commands,
) {
    if let Cast::Model(model) = &*cast {
        commands.spawn((Hero, model.clone(), Transform::default()));
    }
    commands.spawn((
        Camera3d::default(),
        AmbientLight { brightness: 900.0, ..default() },
        Msaa::Off,
        canvas.target(),
        Projection::from(PerspectiveProjection { fov: FOV, near: 0.01, ..default() }),
    ));
    commands.spawn((
        DirectionalLight { illuminance: 9_000.0, shadow_maps_enabled: true, ..default() },
        CascadeShadowConfigBuilder { num_cascades: 2, maximum_distance: 40.0, ..default() }.build(),
        Transform::default().looking_to(Vec3::new(-0.35, -0.9, 0.6), Vec3::Y),
    ));
    let grey = StandardMaterial { perceptual_roughness: 1.0, ..Color::srgb(0.42, 0.42, 0.42).into() };
    let plane = Plane3d::default().mesh().size(200.0, 200.0);
    commands.spawn((Ground, Mesh3d(meshes.add(plane)), MeshMaterial3d(materials.add(grey)), Transform::default()));
}

/// The walk of `surefoot film`, by the model.
fn film_walk(
    subject: &Subject,
    options: &Options,
    size: UVec2,
    assets: &Path,
    roll: &mut Roll,
) -> Result<(), FilmError> {
    let mut app = engine::headless_from(subject.app(), assets);
    let plugins = (ShutterPlugin { size }, level::plugin, walk::plugin, skeleton::plugin);
    app.insert_resource(level::Seed(options.seed)).add_plugins(plugins);
    // A file of clips alone has nothing else to show.
    app.insert_resource(ShowSkeleton(subject.body().meshes.is_empty()));
    subject.enter(&mut app, Part::Walker);
    engine::finish(&mut app);
    load(&mut app)?;
    let pace = subject.walker.as_ref().map_or(1.0, |walker| {
        // Who goes slower than the walk is meant for gets longer for it.
        MotionConfig::default().walk_speed / walker.file.motion.walk_speed
    });
    let ticks = (options.seconds * pace * TICKS_PER_SECOND as f32 / OF_THE_WALK as f32).round().max(1.0) as u32;
    for picture in 1..=OF_THE_WALK {
        let seconds = picture as f32 * ticks as f32 / TICKS_PER_SECOND as f32;
        roll.expose(&mut app, ticks, |world| walk::caption(world, seconds));
    }
    roll.finish(&mut app);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::anim::{
        bake::ClipCurves,
        curve::{Curve, Interpolation},
        keys::JointCurves,
        skeleton::{JointIndex, JointTransform, Skeleton},
    };
    use bevy::math::Affine3A;

    #[test]
    fn every_clip_has_a_row_of_its_own() {
        let root = [("root".to_owned(), None, JointTransform::IDENTITY)];
        let skeleton = Skeleton::new(root, Affine3A::IDENTITY).unwrap();
        let clip = |name: &str| {
            let way = Curve::new(vec![0.0, 2.0], vec![Vec3::ZERO, Vec3::X], Interpolation::Linear).unwrap();
            let root = JointCurves { translation: Some(way), ..JointCurves::new(JointIndex(0)) };
            ClipCurves { name: name.to_owned(), joints: vec![root], ..ClipCurves::default() }.bake(&skeleton).into()
        };
        let clips = vec![clip("walk"), clip("wave")];
        let shots = shots(&Rig { clips, ..Rig::default() });
        let captions: Vec<_> = shots.iter().map(|shot| shot.caption.as_str()).collect();
        assert_eq!(captions[4..8], ["walk 0.00 s", "walk 0.67 s", "walk 1.33 s", "walk 2.00 s"]);
        assert_eq!(shots.len(), 12);
    }
}
