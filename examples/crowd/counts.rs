//! Counts what the renderer does in a frame: draws, triangles, bytes of matrices, and what it makes anew.

use std::sync::{Arc, Mutex, PoisonError};

use bevy::{
    camera::visibility::ViewVisibility,
    core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Transparent3d},
    mesh::{Indices, skinning::SkinnedMesh},
    pbr::{Shadow, SkinUniforms},
    prelude::*,
    render::{
        Render, RenderApp, RenderSystems,
        render_phase::{BinnedPhaseItem, PhaseItem, ViewBinnedRenderPhases, ViewSortedRenderPhases},
        render_resource::PipelineCache,
    },
};
use surefoot::skinning::{SkinUpload, SkinnedBy};

/// What the renderer did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Draw calls of the pass that lights.
    pub(crate) draws: usize,
    /// Draw calls of each shadow pass.
    pub(crate) shadow_draws: Vec<usize>,
    /// Bytes of joint matrices written in the last frame.
    pub(crate) bytes: u64,
    /// Pipelines since the start.
    pub(crate) pipelines: usize,
    /// Bind groups of skinned materials since the start; `None` for the engine, which doesn't say.
    pub(crate) bind_groups: Option<u32>,
    /// Buffers of joint matrices since the start.
    pub(crate) buffers: Option<u32>,
}

/// The counts of the last frame, shared by main and render world.
#[derive(Resource, Clone, Default)]
pub(crate) struct Counter(Arc<Mutex<Counts>>);

impl Counter {
    pub(crate) fn read(&self) -> Counts {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

pub(crate) fn plugin(app: &mut App) {
    let counter = Counter::default();
    app.insert_resource(counter.clone());
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        let count = count.after(RenderSystems::Render).before(RenderSystems::Cleanup);
        render_app.insert_resource(counter).add_systems(Render, count);
    }
}

fn count(
    counter: Res<Counter>,
    opaque: Res<ViewBinnedRenderPhases<Opaque3d>>,
    masked: Res<ViewBinnedRenderPhases<AlphaMask3d>>,
    clear: Res<ViewSortedRenderPhases<Transparent3d>>,
    shadows: Res<ViewBinnedRenderPhases<Shadow>>,
    pipelines: Res<PipelineCache>,
    ours: Option<Res<SkinUpload>>,
    engine: Option<Res<SkinUniforms>>,
) {
    let clear = clear.values().flat_map(|phase| phase.items.values()).filter(|item| !item.batch_range().is_empty());
    let engine = engine.map_or(0, |skins| size_of_val(skins.current_staging_buffer.as_slice()) as u64);
    let counts = Counts {
        draws: draws(&opaque).sum::<usize>() + draws(&masked).sum::<usize>() + clear.count(),
        shadow_draws: draws(&shadows).collect(),
        bytes: ours.as_ref().map_or(engine, |upload| upload.bytes),
        pipelines: pipelines.pipelines().count(),
        bind_groups: ours.as_ref().map(|upload| upload.bind_groups_made),
        buffers: ours.as_ref().map(|upload| upload.buffers_made),
    };
    *counter.0.lock().unwrap_or_else(PoisonError::into_inner) = counts;
}

/// Triangles of all characters in view.
pub(crate) fn triangles(world: &mut World) -> usize {
    let mut drawn = world.query_filtered::<(&Mesh3d, &ViewVisibility), Or<(With<SkinnedBy>, With<SkinnedMesh>)>>();
    let meshes = world.resource::<Assets<Mesh>>();
    let corners = |mesh: &Mesh| mesh.try_indices_option().ok().flatten().map_or(0, Indices::len);
    let drawn = drawn.iter(world).filter(|(_, visible)| visible.get()).filter_map(|(mesh, _)| meshes.get(&mesh.0));
    drawn.map(corners).sum::<usize>() / 3
}

/// Draw calls by view: a set of meshes that are drawn together is one, and so is each batch of one mesh.
fn draws<Item: BinnedPhaseItem>(phases: &ViewBinnedRenderPhases<Item>) -> impl Iterator<Item = usize> {
    phases.values().map(|phase| {
        let alone: usize = phase.unbatchable_meshes.values().map(|bin| bin.entities.len()).sum();
        phase.multidrawable_meshes.len() + phase.batchable_meshes.len() + alone
    })
}
