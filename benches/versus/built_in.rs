//! The engine's own way: an entity a joint, `animate_targets`, transform propagation, `extract_skins`.
//!
//! The systems are the engine's; each group runs in a schedule of its own, so that it can be timed.

use core::mem;

use bevy::{
    animation::{
        AnimatedBy, AnimationPlugin, AnimationTargetId, advance_animations, animate_targets, animated_field, prelude::*,
    },
    asset::AssetPlugin,
    camera::visibility::{SetViewVisibility, ViewVisibility},
    ecs::schedule::{ScheduleLabel, SingleThreadedExecutor},
    math::curve::UnevenSampleAutoCurve,
    mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes},
    pbr::{SkinUniforms, extract_skins},
    prelude::*,
    render::{MainWorld, RenderApp, RenderPlugin, pipelined_rendering::PipelinedRenderingPlugin},
    time::TimeUpdateStrategy,
    transform::systems::{mark_dirty_trees, propagate_parent_transforms, sync_simple_transforms},
    window::ExitCondition,
};
use surefoot::anim::skeleton::JointIndex;

use crate::body::{Body, Keys};

/// What a frame is made of.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Part {
    /// Clips sampled and blended.
    Animate,
    /// Global transforms of all joints.
    Propagate,
    /// Skinning matrices into the staging buffer.
    Extract,
}

/// A crowd of the engine's characters, and a render world that takes their palettes.
pub(crate) struct BuiltIn {
    app: App,
    render: World,
}

impl BuiltIn {
    /// `count` characters that play `clips` clips each. `None` without a GPU driver, which the staging buffer wants.
    pub(crate) fn new(body: &Body, count: usize, clips: usize) -> Option<Self> {
        let mut render = World::new();
        render.insert_resource(skin_uniforms()?);
        render.init_resource::<MainWorld>();
        let mut app = App::new();
        app.add_plugins((
            MinimalPlugins.set(TaskPoolPlugin { task_pool_options: TaskPoolOptions::with_num_threads(1) }),
            AssetPlugin::default(),
            TransformPlugin,
            AnimationPlugin,
        ))
        .init_asset::<SkinnedMeshInverseBindposes>()
        .insert_resource(TimeUpdateStrategy::ManualDuration(core::time::Duration::from_secs_f64(1.0 / 60.0)));
        let one_thread = |schedule: &mut Schedule| {
            schedule.set_executor(SingleThreadedExecutor::new());
        };
        app.add_systems(Part::Animate, (advance_animations, animate_targets).chain())
            .add_systems(
                Part::Propagate,
                (mark_dirty_trees, propagate_parent_transforms, sync_simple_transforms).chain(),
            )
            .edit_schedule(Part::Animate, one_thread)
            .edit_schedule(Part::Propagate, one_thread);
        let mut extract = Schedule::new(Part::Extract);
        extract.add_systems(extract_skins).set_executor(SingleThreadedExecutor::new());
        render.add_schedule(extract);
        spawn(app.world_mut(), body, count, clips);
        app.finish();
        app.cleanup();
        let mut built_in = Self { app, render };
        // Graphs are prepared and skins find their places in the first frames.
        for _ in 0..3 {
            built_in.app.update();
            built_in.run(Part::Extract);
        }
        Some(built_in)
    }

    /// A whole frame of the engine, and its palettes.
    pub(crate) fn frame(&mut self) {
        self.app.update();
        self.run(Part::Extract);
    }

    /// One part of a frame.
    pub(crate) fn run(&mut self, part: Part) {
        let world = self.app.world_mut();
        if part == Part::Extract {
            mem::swap(&mut **self.render.resource_mut::<MainWorld>(), world);
            self.render.run_schedule(part);
            mem::swap(&mut **self.render.resource_mut::<MainWorld>(), world);
        } else {
            world.run_schedule(part);
        }
        world.increment_change_tick();
    }
}

/// The staging buffer of an engine that draws nothing.
fn skin_uniforms() -> Option<SkinUniforms> {
    let mut app = App::new();
    let window = WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() };
    let render = RenderPlugin { synchronous_pipeline_compilation: true, ..default() };
    let one_thread = TaskPoolPlugin { task_pool_options: TaskPoolOptions::with_num_threads(1) };
    // Pipelined, the render world would be out of reach.
    let plugins = DefaultPlugins
        .set(window)
        .set(render)
        .set(one_thread)
        .disable::<PipelinedRenderingPlugin>()
        .disable::<bevy::log::LogPlugin>();
    #[cfg(feature = "game")]
    let plugins = plugins.disable::<bevy::winit::WinitPlugin>();
    app.add_plugins(plugins);
    while app.plugins_state() == bevy::app::PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    app.update();
    app.get_sub_app_mut(RenderApp)?.world_mut().remove_resource::<SkinUniforms>()
}

fn spawn(world: &mut World, body: &Body, count: usize, clips: usize) {
    let poses = body.skin.inverse_bind.iter().map(|inverse| Mat4::from(inverse.to_affine())).collect::<Vec<_>>();
    let inverse_bindposes = world.resource_mut::<Assets<SkinnedMeshInverseBindposes>>().add(poses);
    let mut graph = AnimationGraph::new();
    let root = graph.root;
    let nodes: Vec<_> = [(&body.walk, 0.6), (&body.run, 0.4)][..clips]
        .iter()
        .map(|(keys, weight)| {
            let clip = world.resource_mut::<Assets<AnimationClip>>().add(clip(body, keys));
            (graph.add_clip(clip, *weight, root), keys.duration())
        })
        .collect();
    let graph = world.resource_mut::<Assets<AnimationGraph>>().add(graph);
    for index in 0..count {
        let phase = (index as f32 * 0.618_034).fract();
        let mut player = AnimationPlayer::default();
        for (node, duration) in &nodes {
            player.play(*node).repeat().seek_to(phase * duration);
        }
        let place = Transform::from_xyz((index % 100) as f32, 0.0, (index / 100) as f32);
        let character = world.spawn((place, player, AnimationGraphHandle(graph.clone()))).id();
        let mut joints: Vec<Entity> = Vec::with_capacity(body.skeleton.len());
        for joint in body.skeleton.joints() {
            let parent = body.skeleton.parent(joint).map_or(character, |parent| joints[parent.index()]);
            let rest = body.skeleton.rest()[joint.index()];
            let transform = Transform { translation: rest.translation, rotation: rest.rotation, scale: rest.scale };
            joints.push(world.spawn((transform, target(body, joint), AnimatedBy(character), ChildOf(parent))).id());
        }
        let skin = SkinnedMesh { inverse_bindposes: inverse_bindposes.clone(), joints };
        let mut entity = world.entity_mut(character);
        entity.insert((skin, ViewVisibility::default()));
        if let Some(mut visibility) = entity.get_mut::<ViewVisibility>() {
            visibility.set_visible();
        }
    }
}

/// A clip as the engine's glTF loader makes it.
fn clip(body: &Body, keys: &Keys) -> AnimationClip {
    let mut clip = AnimationClip::default();
    for (joint, rotations) in body.skeleton.joints().zip(&keys.rotations) {
        let samples = keys.times.iter().copied().zip(rotations.iter().copied());
        if let Ok(curve) = UnevenSampleAutoCurve::new(samples) {
            let curve = AnimatableCurve::new(animated_field!(Transform::rotation), curve);
            clip.add_curve_to_target(target(body, joint), curve);
        }
    }
    for (joint, translations) in &keys.translations {
        let samples = keys.times.iter().copied().zip(translations.iter().copied());
        if let Ok(curve) = UnevenSampleAutoCurve::new(samples) {
            let curve = AnimatableCurve::new(animated_field!(Transform::translation), curve);
            clip.add_curve_to_target(target(body, *joint), curve);
        }
    }
    clip
}

fn target(body: &Body, joint: JointIndex) -> AnimationTargetId {
    AnimationTargetId::from_name(&Name::new(body.skeleton.name(joint).to_owned()))
}
