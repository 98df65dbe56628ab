//! The same body, clips and controller as Bevy's own `AnimationPlayer` animates them: what a game has without this crate.
//!
//! Reads `MotionState`; plays idle, walk and run by speed with cross-fades, their playback matched to the ground speed, and
//! no foot IK. Joints are entities, as Bevy wants them; what they do is measured like any other pose.

use core::time::Duration;

use avian3d::prelude::*;
use bevy::{
    animation::{ActiveAnimation, AnimatedBy, AnimationTargetId},
    app::AnimationSystems,
    asset::RenderAssetUsages,
    gltf::{GltfLoaderSettings, GltfPlugin},
    image::ImagePlugin,
    mesh::MeshPlugin,
    prelude::*,
    world_serialization::WorldSerializationPlugin,
};

use super::run::Runner;
use crate::{
    anim::{
        pose::Pose,
        skeleton::{JointIndex, JointTransform, Skeleton},
    },
    character::{
        foot_ik::{Frames, GroundFilter, NoGround, PhysicsProbe},
        intent::MoveIntent,
        motion::{CharacterMotion, MotionState},
        schedule::PoseSystems,
    },
    measure::{
        record::Recorder,
        seen::{Hold, Playing, Seen, hold_of_clip},
    },
    rig::character::CharacterAsset,
    testing::{
        stage::{Stage, StageError},
        world::World as Ground,
    },
};

/// Clips by the speed in m/s above which they play.
const GAITS: [(&str, f32); 3] = [("idle", 0.0), ("walk", 0.15), ("run", 2.4)];
/// Share of that speed below which the slower clip comes back.
const HYSTERESIS: f32 = 0.8;
/// Seconds of a cross-fade.
const FADE: Duration = Duration::from_millis(200);
/// Slowest and fastest playback.
const RATES: (f32, f32) = (0.5, 2.0);

/// A body animated by Bevy.
#[derive(Component)]
struct Puppet {
    character: CharacterAsset,
    /// One entity a joint, in the skeleton's order.
    joints: Vec<Entity>,
    /// Of each gait: its node in the graph, and its clip in the character.
    gaits: [(AnimationNodeIndex, usize); 3],
    playing: usize,
    pose: Pose,
}

/// A stage with puppets of the runner at `places`.
pub(super) fn stage(
    ground: &Ground,
    runner: &Runner,
    places: &[Transform],
) -> Result<(Stage, Vec<Entity>), StageError> {
    let mut stage = Stage::with(ground, &runner.assets, |app| {
        // Meshes and images only for the loader's sake.
        app.add_plugins((
            ImagePlugin::default(),
            MeshPlugin,
            WorldSerializationPlugin,
            AnimationPlugin,
            GltfPlugin::default(),
        ))
        .add_systems(
            PostUpdate,
            (choose.before(AnimationSystems), record.after(AnimationSystems).in_set(PoseSystems::Attach)),
        );
    });
    let model = runner.character.model.to_string();
    let settings = |settings: &mut GltfLoaderSettings| {
        settings.load_meshes = RenderAssetUsages::empty();
        settings.load_materials = RenderAssetUsages::empty();
    };
    let server = stage.app().world().resource::<AssetServer>();
    let gltf: Handle<Gltf> = server.load_builder().with_settings(settings).load(model.clone());
    stage.wait_for(&gltf, &model)?;
    let error = |name: &str| StageError::Load { path: model.clone(), reason: format!("it has no clip `{name}`") };
    let gltf = stage.app().world().resource::<Assets<Gltf>>().get(&gltf).ok_or_else(|| error("idle"))?;
    let mut graph = AnimationGraph::new();
    let mut gaits = [(graph.root, 0); 3];
    for (gait, (name, _)) in gaits.iter_mut().zip(GAITS) {
        let clip = gltf.named_animations.get(name).ok_or_else(|| error(name))?;
        let index = runner.character.clip_index(name).ok_or_else(|| error(name))?;
        *gait = (graph.add_clip(clip.clone(), 1.0, graph.root), index);
    }
    let world = stage.app().world_mut();
    let graph = world.resource_mut::<Assets<AnimationGraph>>().add(graph);
    let puppets = places.iter().map(|place| spawn(world, &runner.character, *place, &graph, gaits)).collect();
    Ok((stage, puppets))
}

fn spawn(
    world: &mut World,
    character: &CharacterAsset,
    place: Transform,
    graph: &Handle<AnimationGraph>,
    gaits: [(AnimationNodeIndex, usize); 3],
) -> Entity {
    let (mut player, mut transitions) = (AnimationPlayer::default(), AnimationTransitions::new());
    transitions.play(&mut player, gaits[0].0, Duration::ZERO).repeat();
    let root = world
        .spawn((
            CharacterMotion,
            place,
            character.file.motion.clone(),
            (player, transitions, AnimationGraphHandle(graph.clone())),
            Recorder::default(),
        ))
        .id();
    let skeleton = &character.skeleton;
    let joint = |joint: JointIndex| {
        let JointTransform { translation, rotation, scale } = skeleton.rest()[joint.index()];
        (Transform { translation, rotation, scale }, target(skeleton, joint), AnimatedBy(root))
    };
    let joints: Vec<_> = skeleton.joints().map(joint).collect();
    let joints = world.spawn_batch(joints).collect();
    world.entity_mut(root).insert((
        GroundFilter(SpatialQueryFilter::from_excluded_entities([root])),
        Puppet { pose: Pose::rest(skeleton), character: character.clone(), joints, gaits, playing: 0 },
    ));
    root
}

/// What Bevy's loader calls a joint: the names of all nodes down to it.
fn target(skeleton: &Skeleton, joint: JointIndex) -> AnimationTargetId {
    let mut names = Vec::new();
    let mut at = Some(joint);
    while let Some(joint) = at {
        names.push(Name::new(skeleton.name(joint).to_owned()));
        at = skeleton.parent(joint);
    }
    AnimationTargetId::from_names(names.iter().rev())
}

/// Plays the gait that fits the speed, as fast as the ground passes.
fn choose(mut puppets: Query<(&MotionState, &mut Puppet, &mut AnimationPlayer, &mut AnimationTransitions)>) {
    for (motion, mut puppet, mut player, mut transitions) in &mut puppets {
        let speed = motion.ground_velocity.with_y(0.0).length();
        let floor = |gait: usize| if gait > puppet.playing { GAITS[gait].1 } else { GAITS[gait].1 * HYSTERESIS };
        let wanted = (1..GAITS.len()).rev().find(|gait| speed > floor(*gait)).unwrap_or(0);
        if wanted != puppet.playing {
            puppet.playing = wanted;
            transitions.play(&mut player, puppet.gaits[wanted].0, FADE).repeat();
        }
        for (node, clip) in puppet.gaits {
            let natural = puppet.character.clips()[clip].gait.speed;
            if let Some(animation) = player.animation_mut(node).filter(|_| natural > 0.0) {
                animation.set_speed((speed / natural).clamp(RATES.0, RATES.1));
            }
        }
    }
}

fn record(
    time: Res<Time>,
    spatial: SpatialQuery,
    no_ground: Query<(), NoGround>,
    grounds: Frames,
    joints: Query<&Transform, (With<AnimationTargetId>, Without<Puppet>)>,
    mut puppets: Query<(
        &mut Puppet,
        &Transform,
        &AnimationPlayer,
        &MoveIntent,
        &MotionState,
        &GroundFilter,
        &mut Recorder,
    )>,
) {
    let dt = time.delta_secs();
    if dt <= 0.0 {
        return;
    }
    for (mut puppet, root, player, intent, motion, filter, mut recorder) in &mut puppets {
        let Puppet { character, joints: entities, gaits, pose, .. } = &mut *puppet;
        for (local, entity) in pose.locals_mut().iter_mut().zip(entities) {
            if let Ok(&Transform { translation, rotation, scale }) = joints.get(*entity) {
                *local = JointTransform { translation, rotation, scale };
            }
        }
        pose.update_model(&character.skeleton);
        let heard = || {
            gaits.iter().filter_map(|(node, clip)| {
                let animation = player.animation(*node).filter(|animation| animation.weight() > 0.0)?;
                Some((animation, *clip))
            })
        };
        let contact = |side: usize| -> f32 {
            let of = |(animation, clip): (&ActiveAnimation, usize)| {
                let clip = &character.clips()[clip];
                let phase = clip.gait.phase_at(animation.seek_time(), clip.clip.duration);
                animation.weight() * clip.gait.contact_weight(side, phase)
            };
            heard().map(of).sum()
        };
        let grounded = motion.ground.is_some();
        let seen = Seen {
            asset: character,
            pose,
            root,
            grounded,
            wanted: intent.velocity,
            velocity: motion.ground_velocity,
            holds: [0, 1].map(|side| {
                if grounded { hold_of_clip(pose, &character.legs[side], contact(side)) } else { Hold::Free }
            }),
            missed: [None; 2],
            playing: &heard().map(|(animation, clip)| Playing { clip, rate: animation.speed() }).collect::<Vec<_>>(),
        };
        recorder.record(&seen, &PhysicsProbe::new(&spatial, &no_ground, filter), &grounds, dt);
    }
}
