//! Copies the arena to the GPU once a frame: two halves of matrices that take turns, and one table of records.
//!
//! Reads [`SkinArena`] of the main world while it is extracted, straight into wgpu's staging memory: the matrices of those who moved.
//! When nothing changed, nothing is written, and the last frame's half is this frame's: motion vectors are zero.

use core::{
    mem::size_of,
    sync::atomic::{AtomicU32, Ordering},
};

use bevy::{
    asset::AssetMut,
    prelude::*,
    render::{
        ExtractSchedule, GpuResourceAppExt, MainWorld, RenderApp,
        render_resource::{Buffer, BufferDescriptor, BufferUsages},
        renderer::{RenderDevice, RenderQueue},
    },
};

use super::{
    arena::{Capacity, SkinArena},
    halves::{Halves, Write},
    layout::{InstanceRecord, JointMatrix},
    material::SkinnedMaterial,
};

/// `current`, `previous` and padding in front of the records.
const HEADER_BYTES: u64 = 16;

/// The capacity that every material's bind group was last made for.
#[derive(Resource, Clone, Copy, Debug)]
pub(super) struct BoundCapacity(Capacity);

/// What the last frame cost. Resource of the render world.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub struct SkinUpload {
    /// Bytes written to the GPU for the last frame.
    pub bytes: u64,
    /// Writes that this took: one for those whose matrices lie together, one for what tells the halves apart.
    pub writes: u32,
    /// How often buffers were made: once at the start, once per growth.
    pub buffers_made: u32,
    /// How often a material's bind group was made: once a material, and once more per growth.
    pub bind_groups_made: u32,
}

/// What one frame wrote.
#[derive(Clone, Copy, Debug, Default)]
struct Written {
    bytes: u64,
    writes: u32,
}

/// The arena's buffers. Resource of the render world.
#[derive(Resource, Debug)]
pub struct SkinArenaGpu {
    pub(super) matrices: Buffer,
    pub(super) instances: Buffer,
    /// Materials that took these buffers since the last frame.
    pub(super) bind_groups_made: AtomicU32,
    capacity: Capacity,
    halves: Halves,
    /// Nothing was written yet.
    empty: bool,
}

pub(super) fn build(app: &mut App) {
    let capacity = BoundCapacity(app.world().resource::<SkinArena>().capacity());
    app.insert_resource(capacity);
    if let Some(render_app) = app.get_sub_app_mut(RenderApp) {
        render_app
            .insert_resource(capacity)
            .init_resource::<SkinUpload>()
            .init_gpu_resource::<SkinArenaGpu>()
            .add_systems(ExtractSchedule, upload);
    }
}

/// How many matrices one buffer of this device holds, in each of two halves.
pub(super) fn matrix_limit(device: &RenderDevice) -> u32 {
    let limits = device.limits();
    let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    u32::try_from(bytes / (2 * size_of::<JointMatrix>() as u64)).unwrap_or(u32::MAX)
}

/// When the arena grew, new buffers come with this frame: every material gets a new bind group.
pub(super) fn remake_bind_groups(
    arena: Res<SkinArena>,
    mut bound: ResMut<BoundCapacity>,
    mut materials: ResMut<Assets<SkinnedMaterial>>,
) {
    let capacity = arena.capacity();
    if bound.0 == capacity {
        return;
    }
    bound.0 = capacity;
    let ids: Vec<_> = materials.ids().collect();
    for material in ids {
        // Only a borrow taken out of its guard counts as a modification.
        let _ = materials.get_mut(material).map(AssetMut::into_inner);
    }
    debug!("skinning buffers grow to {} joints and {} instances", capacity.matrices, capacity.instances);
}

fn upload(
    mut main: ResMut<MainWorld>,
    mut gpu: ResMut<SkinArenaGpu>,
    mut report: ResMut<SkinUpload>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
) {
    let Some(BoundCapacity(capacity)) = main.get_resource().copied() else { return };
    let Some(mut arena) = main.get_resource_mut::<SkinArena>() else { return };
    report.bind_groups_made += gpu.bind_groups_made.swap(0, Ordering::Relaxed);
    if gpu.capacity != capacity {
        *gpu = SkinArenaGpu::new(&device, capacity);
    }
    report.buffers_made += u32::from(gpu.empty);
    Written { bytes: report.bytes, writes: report.writes } = gpu.write(&arena, &queue);
    arena.bypass_change_detection().forget_pending();
}

impl FromWorld for SkinArenaGpu {
    fn from_world(world: &mut World) -> Self {
        Self::new(world.resource::<RenderDevice>(), world.resource::<BoundCapacity>().0)
    }
}

impl SkinArenaGpu {
    fn new(device: &RenderDevice, capacity: Capacity) -> Self {
        let buffer = |label, size| {
            device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size,
                usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let matrices = 2 * u64::from(capacity.matrices) * size_of::<JointMatrix>() as u64;
        let instances = HEADER_BYTES + u64::from(capacity.instances) * size_of::<InstanceRecord>() as u64;
        Self {
            matrices: buffer("surefoot joint matrices", matrices),
            instances: buffer("surefoot skin instances", instances),
            bind_groups_made: AtomicU32::new(0),
            capacity,
            halves: Halves::default(),
            empty: true,
        }
    }

    /// Writes what changed.
    fn write(&mut self, arena: &SkinArena, queue: &RenderQueue) -> Written {
        let mut written = Written::default();
        let mut write = |buffer: &Buffer, offset: u64, bytes: &[u8]| {
            if !bytes.is_empty() {
                queue.write_buffer(buffer, offset, bytes);
                written.bytes += bytes.len() as u64;
                written.writes += 1;
            }
        };
        let at = |half: u32, joint: u32| {
            (u64::from(half) * u64::from(self.capacity.matrices) + u64::from(joint)) * size_of::<JointMatrix>() as u64
        };
        // What was allocated after bind groups were remade is drawn, and comes, with the next frame.
        let all = arena.all_matrices();
        let room = all.len().min(self.capacity.matrices as usize);
        let header = self.halves.turn(&arena.pending, room as u32);
        for Write { half, run } in self.halves.writes() {
            let matrices = &all[run.start as usize..run.end as usize];
            write(&self.matrices, at(*half, run.start), bytemuck::cast_slice(matrices));
        }
        if let Some(halves) = header {
            let [current, previous] = halves.map(|half| half * self.capacity.matrices);
            write(&self.instances, 0, bytemuck::cast_slice(&[current, previous, 0, 0]));
        }
        if arena.pending.instances || self.empty {
            let room = self.capacity.instances as usize;
            let all = &arena.all_instances()[..arena.all_instances().len().min(room)];
            write(&self.instances, HEADER_BYTES, bytemuck::cast_slice(all));
        }
        self.empty = false;
        written
    }
}
