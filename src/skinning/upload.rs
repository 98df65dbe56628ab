//! Copies the arena to the GPU once a frame: two halves of matrices that take turns, and one table of records.
//!
//! Reads [`SkinArena`] of the main world while it is extracted, straight into wgpu's staging memory.
//! When nothing changed, nothing is written, and the last frame's half is this frame's: motion vectors are zero.

use core::mem::size_of;

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
    /// How often buffers were made: once at the start, once per growth.
    pub buffers_made: u32,
}

/// The arena's buffers. Resource of the render world.
#[derive(Resource, Debug)]
pub struct SkinArenaGpu {
    pub(super) matrices: Buffer,
    pub(super) instances: Buffer,
    capacity: Capacity,
    /// Which half holds this frame: 0 or 1.
    half: u32,
    /// Nothing was written yet.
    empty: bool,
    /// The last frame's half counts as this frame's.
    settled: bool,
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
    if gpu.capacity != capacity {
        *gpu = SkinArenaGpu::new(&device, capacity);
    }
    report.buffers_made += u32::from(gpu.empty);
    report.bytes = gpu.write(&arena, &queue);
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
            capacity,
            half: 0,
            empty: true,
            settled: false,
        }
    }

    /// Writes what changed; returns how many bytes that was.
    fn write(&mut self, arena: &SkinArena, queue: &RenderQueue) -> u64 {
        let mut written = 0;
        let mut write = |buffer: &Buffer, offset: u64, bytes: &[u8]| {
            if !bytes.is_empty() {
                queue.write_buffer(buffer, offset, bytes);
                written += bytes.len() as u64;
            }
        };
        let at = |half: u32, joint: u32| {
            (u64::from(half) * u64::from(self.capacity.matrices) + u64::from(joint)) * size_of::<JointMatrix>() as u64
        };
        let moved = arena.pending.matrices || self.empty;
        if moved {
            let (last, now) = (self.half, 1 - self.half);
            // What was allocated after bind groups were remade is drawn, and comes, with the next frame.
            let room = self.capacity.matrices as usize;
            let all = &arena.all_matrices()[..arena.all_matrices().len().min(room)];
            write(&self.matrices, at(now, 0), bytemuck::cast_slice(all));
            if self.empty {
                write(&self.matrices, at(last, 0), bytemuck::cast_slice(all));
            } else {
                for fresh in &arena.pending.fresh {
                    let matrices = all.get(fresh.start as usize..fresh.end as usize).unwrap_or_default();
                    write(&self.matrices, at(last, fresh.start), bytemuck::cast_slice(matrices));
                }
            }
            self.half = now;
        }
        if moved || !self.settled {
            let first = |half: u32| half * self.capacity.matrices;
            let previous = if moved { 1 - self.half } else { self.half };
            write(&self.instances, 0, bytemuck::cast_slice(&[first(self.half), first(previous), 0, 0]));
            self.settled = !moved;
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
