//! Stage 4: the scene on the device, and everything else that stands between a scene and its first dispatch.
//!
//! Comes in: a checked scene and settings. Goes out: a [`DeviceScene`]: tree built, records on the device, pipeline
//! made, buffers sized by the device's limits. It can take another camera, which is all that is copied then.

use std::sync::Arc;
use std::time::Instant;

use crate::bvh::{Accel, BinaryBvh, TreeStats, WideBvh};
use crate::error::Result;
use crate::gpu::{
    Barrier, BindGroup, Buffer, BufferUse, ComputePipeline, Context, InFlight, Ledger, Memory, Readback, Recorder,
    Resource,
};
use crate::interface::*;
use crate::render::counters::COUNTER_BYTES;
use crate::render::effects::Effects;
use crate::render::kernel::{self, Dispatch, ReadAs};
use crate::render::path_buffers::PathBuffers;
use crate::render::report::StageSeconds;
use crate::render::startup;
use crate::render::tile_sums::TileSums;
use crate::render::tiles::{self, Tile};
use crate::render::tuning::Tuning;
use crate::render::upload::{self, GpuScene};
use crate::scene::{Camera, Scene};
use crate::settings::{AccelKind, Buffers, Settings};
use crate::texels::TexelData;
use crate::texels::camera::camera_texels;
use crate::texels::random::splitmix64;

/// A scene on the device, ready to be traced.
pub(super) struct DeviceScene {
    context: Context,
    records: GpuScene,
    /// Replicates of the film.
    replicates: u32,
    pipeline: Arc<ComputePipeline>,
    bind_group: Arc<BindGroup>,
    counters: Arc<Buffer>,
    counter_readback: Readback,
    /// The tiles of the region.
    pub(super) tiles: Vec<Tile>,
    /// Sums of the tile that is on the device.
    pub(super) sums: TileSums,
    /// The effects that are on.
    pub(super) effects: Effects,
    /// Figures of the tree.
    pub(super) tree: TreeStats,
    /// How records and path states are read.
    pub(super) read_as: ReadAs,
}

impl DeviceScene {
    /// Builds the tree, packs and copies the records, and makes the pipeline, on a device that passes the start-up
    /// probe.
    pub(super) fn new(
        context: &Context,
        scene: &Scene,
        settings: &Settings,
        tuning: &Tuning,
        replicates: u32,
        seconds: &mut StageSeconds,
        ledger: &mut Ledger,
    ) -> Result<DeviceScene> {
        startup::check(context)?;
        let start = Instant::now();
        let accel = build_accel(scene, settings);
        let tree = accel.stats(scene.triangles.len());
        seconds.bvh = start.elapsed().as_secs_f64();

        let start = Instant::now();
        let data = TexelData::pack(scene, &accel, settings)?;
        let buffers = match upload::fits_texel_buffers(&data, context) {
            true => settings.buffers,
            false => Buffers::Storage,
        };
        let records = GpuScene::upload(context, &data, &constants(scene, settings, &data), buffers, ledger)?;
        seconds.upload = start.elapsed().as_secs_f64();

        let stack_entries = kernel::padded_stack_entries(&accel);
        let tile_size = match tuning.tile {
            Some(size) => size,
            None => tile_size(context, settings, stack_entries)?,
        };
        let tile_pixels = u64::from(tile_size[0]) * u64::from(tile_size[1]);
        let wanted = tuning.path_buffers.unwrap_or(settings.buffers);

        let start = Instant::now();
        let paths = PathBuffers::new(context, tile_pixels, stack_entries, wanted, records.null_texel())?;
        let touched = paths.touch(context)?;
        let effects = effects(scene, settings, tuning);
        let read_as = ReadAs { records: buffers, paths: paths.read_as };
        let kernel = kernel::specialized(context, settings, &accel, &tree, &effects, read_as, tuning);
        let pipeline = kernel::path_tracer(context, &kernel)?;
        if let Some(touched) = touched {
            touched.wait()?;
        }
        seconds.pipeline = start.elapsed().as_secs_f64();

        let sums = TileSums::new(context, tile_pixels)?;
        let storage = BufferUse { texel: false, storage: true };
        let counters = Buffer::new(context, "counters", COUNTER_BYTES, storage, Memory::Device)?;
        let mut resources = records.resources().to_vec();
        resources.extend_from_slice(paths.resources());
        resources.push((BINDING_SUMS, Resource::Storage(sums.buffer().clone())));
        resources.push((BINDING_COUNTERS, Resource::Storage(counters.clone())));
        let bind_group = BindGroup::new(&pipeline, &resources)?;
        Ok(DeviceScene {
            context: context.clone(),
            replicates,
            records,
            pipeline,
            bind_group,
            counters,
            counter_readback: Readback::new(context, "counters readback", COUNTER_BYTES)?,
            tiles: tiles::tiles(settings.region(), tile_size)?,
            sums,
            effects,
            tree,
            read_as,
        })
    }

    /// Puts another camera in the place of the one that is there, for a picture of the same settings.
    pub(super) fn set_camera(&self, camera: &Camera, settings: &Settings, ledger: &mut Ledger) -> Result<()> {
        let texels = camera_texels(camera, settings.width, settings.height, settings.filter);
        self.records.replace_camera(&self.context, &texels, ledger)
    }

    /// Records and submits one dispatch, its counters cleared before and copied after.
    pub(super) fn submit(&mut self, ledger: &mut Ledger, dispatch: &Dispatch) -> Result<InFlight> {
        let mut recorder = Recorder::new(&self.context, "frame")?;
        // The last frame's shader and copy have used the counters before they are cleared.
        recorder.barrier(Barrier::ComputeToTransfer)?;
        recorder.barrier(Barrier::TransferToTransfer)?;
        recorder.fill(&self.counters, 0, COUNTER_BYTES, 0)?;
        // The counters are cleared, the path states are touched (path_buffers.rs), and the copy of the last tile's sums
        // has read them, before this frame's shader writes.
        recorder.barrier(Barrier::TransferToCompute)?;
        // The last frame's shader has written the path states, lists and sums that this one reads.
        recorder.barrier(Barrier::ComputeToCompute)?;
        let push = kernel::push(dispatch, self.replicates);
        recorder.dispatch(&self.pipeline, &self.bind_group, &push.bytes(), dispatch.groups())?;
        let why = "unfinished paths and counts of a frame";
        self.counter_readback.copy_from(&mut recorder, ledger, &self.counters, 0, 0, COUNTER_BYTES, why)?;
        recorder.submit()
    }

    /// Waits for a frame; its counters.
    pub(super) fn counters(&self, frame: InFlight) -> Result<[u32; COUNTERS as usize]> {
        frame.wait()?;
        let mut counters = [0u32; COUNTERS as usize];
        bytemuck::cast_slice_mut(&mut counters).copy_from_slice(self.counter_readback.bytes()?);
        Ok(counters)
    }
}

/// The tree, or its absence, that the settings ask for.
pub fn build_accel(scene: &Scene, settings: &Settings) -> Accel {
    match settings.accel {
        AccelKind::Brute => Accel::Brute,
        AccelKind::Binary => Accel::Binary(BinaryBvh::build(&scene.triangles, settings.builder)),
        AccelKind::Wide => Accel::Wide(WideBvh::build(&scene.triangles, settings.builder)),
    }
}

/// The effects that the scene calls for, but for what a test or a study wants otherwise.
fn effects(scene: &Scene, settings: &Settings, tuning: &Tuning) -> Effects {
    let mut effects = Effects::of(scene, settings);
    if let Some(effect) = tuning.without_effect {
        effects = effects.without(effect);
    }
    if let Some(effect) = tuning.with_effect {
        effects = effects.with(effect);
    }
    effects
}

/// Half of the heap that the scene has left is for the paths.
fn tile_size(context: &Context, settings: &Settings, stack_entries: u32) -> Result<[u32; 2]> {
    let limits = context.device_info();
    let [_, _, width, height] = settings.region();
    let in_one_buffer = limits.max_storage_buffer_range.min(limits.max_memory_allocation_size);
    let memory = limits.device_heap_bytes().saturating_sub(context.device_bytes()) / 2;
    tiles::largest_tile(width, height, stack_entries, in_one_buffer, memory)
}

fn constants(scene: &Scene, settings: &Settings, data: &TexelData) -> RenderConstants {
    let mut state = settings.seed;
    let mixed = splitmix64(&mut state);
    let [sky_r, sky_g, sky_b] = scene.sky.unwrap_or_default();
    RenderConstants {
        sky_r,
        sky_g,
        sky_b,
        roulette_p: kernel::roulette_value(settings.roulette).1,
        triangle_count: data.triangle_count,
        light_count: data.light_count,
        max_bounces: settings.max_bounces,
        seed_low: mixed as u32,
        seed_high: (mixed >> 32) as u32,
    }
}
