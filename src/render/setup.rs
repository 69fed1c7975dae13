//! Stage 4 and what stage 5 needs: everything that stands between a scene and its first dispatch.
//!
//! Comes in: a checked scene and settings. Goes out: a [`Renderer`]: tree built, records on the device, pipeline made,
//! buffers sized by the device's limits, an empty film.

use std::time::Instant;

use crate::bvh::TreeStats;
use crate::error::Result;
use crate::film::Film;
use crate::gpu::{BindGroup, Buffer, BufferUse, Context, Ledger, Memory, Readback, Resource};
use crate::interface::*;
use crate::memory::filled;
use crate::render::effects::Effects;
use crate::render::ending::EstimateClock;
use crate::render::frames::{COUNTER_BYTES, Renderer};
use crate::render::kernel::{self, ReadAs};
use crate::render::pace::{self, Pace, RunLength};
use crate::render::path_buffers::PathBuffers;
use crate::render::report::{Bytes, RenderReport, StageSeconds, StopReason};
use crate::render::stop::{Looks, StopRules};
use crate::render::tiles::{self, SUM_BYTES};
use crate::render::upload::{self, GpuScene};
use crate::render::{Tuning, build_accel};
use crate::scene::Scene;
use crate::settings::{Buffers, Settings};
use crate::texels::TexelData;
use crate::texels::random::splitmix64;

impl Renderer {
    /// Builds the tree, packs and copies the records, and makes the pipeline.
    pub fn new(context: &Context, scene: &Scene, settings: &Settings, tuning: &Tuning) -> Result<Renderer> {
        settings.check()?;
        let [_, _, width, height] = settings.region();
        tuning.check([width, height])?;
        if !settings.allow_black {
            scene.check_emits()?;
        }
        let mut seconds = StageSeconds::default();
        let mut ledger = Ledger::default();
        let pixels = u64::from(settings.width) * u64::from(settings.height);
        let replicates = settings.replicates.unwrap_or_else(|| Film::replicates(pixels));
        let region_pixels = width as usize * height as usize;
        let sums_of_run = || filled("memory for the sums of a run", [0; 4], region_pixels);
        let (run_sums, open_sums) = (sums_of_run()?, sums_of_run()?);
        let film = Film::new(width, height, replicates, scene.scaling.radiance_exponent)?;

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
        let gpu_scene = GpuScene::upload(context, &data, &constants(scene, settings, &data), buffers, &mut ledger)?;
        seconds.upload = start.elapsed().as_secs_f64();

        let stack_entries = kernel::padded_stack_entries(&accel);
        let tile_size = match tuning.tile {
            Some(size) => size,
            None => tile_size(context, settings, stack_entries)?,
        };
        let tile_pixels = u64::from(tile_size[0]) * u64::from(tile_size[1]);
        let wanted = tuning.path_buffers.unwrap_or(settings.buffers);

        let start = Instant::now();
        let paths = PathBuffers::new(context, tile_pixels, stack_entries, wanted, gpu_scene.null_texel())?;
        let touched = paths.touch(context)?;
        let mut effects = Effects::of(scene, settings);
        if let Some(effect) = tuning.without_effect {
            effects = effects.without(effect);
        }
        if let Some(effect) = tuning.with_effect {
            effects = effects.with(effect);
        }
        let read_as = ReadAs { records: buffers, paths: paths.read_as };
        let kernel = kernel::specialized(context, settings, &accel, &tree, &effects, read_as, tuning);
        let pipeline = kernel::path_tracer(context, &kernel)?;
        if let Some(touched) = touched {
            touched.wait()?;
        }
        seconds.pipeline = start.elapsed().as_secs_f64();

        let device =
            |name, bytes| Buffer::new(context, name, bytes, BufferUse { texel: false, storage: true }, Memory::Device);
        let sums = device("open sums", tile_pixels * SUM_BYTES)?;
        let counters = device("counters", COUNTER_BYTES)?;
        let mut resources = gpu_scene.resources().to_vec();
        resources.extend_from_slice(paths.resources());
        resources.push((BINDING_SUMS, Resource::Storage(sums.clone())));
        resources.push((BINDING_COUNTERS, Resource::Storage(counters.clone())));
        let bind_group = BindGroup::new(&pipeline, &resources)?;
        let readback = |name| Readback::new(context, name, tile_pixels * SUM_BYTES);
        Ok(Renderer {
            replicates,
            report: empty_report(&effects, seconds, read_as, tree),
            context: context.clone(),
            settings: settings.clone(),
            effects,
            pipeline,
            bind_group,
            tiles: tiles::tiles(settings.region(), tile_size)?,
            readbacks: [readback("sums readback 0")?, readback("sums readback 1")?],
            counter_readback: Readback::new(context, "counters readback", COUNTER_BYTES)?,
            sums,
            counters,
            pace: Pace::new(pace::cpu_lanes(context.device_info()), tuning.budget),
            leave_eighths: tuning.leave_eighths.unwrap_or(kernel::leave_eighths(context.device_info().kind)),
            slice_pixels: tuning.slice_pixels,
            run_length: RunLength::new(tuning.run_samples),
            film,
            run_sums,
            open_sums,
            run_counts: [0; COUNTERS as usize],
            ledger,
            estimate: EstimateClock::default(),
            rules: StopRules::default(),
            looks: Looks::new(),
            forecasts: None,
        })
    }
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

fn empty_report(effects: &Effects, seconds: StageSeconds, read_as: ReadAs, tree: TreeStats) -> RenderReport {
    RenderReport {
        spp: 0,
        stop_reason: StopReason::Spp,
        seconds,
        paths: 0,
        rays: 0,
        node_visits: 0,
        triangle_tests: 0,
        buffers: read_as.records,
        path_buffers: read_as.paths,
        relative_rmse: None,
        error: None,
        seconds_per_sample: 0.0,
        tree,
        effects: effects.names(),
        invalid_samples: CAUSE_NAMES.into_iter().map(|cause| (cause, 0)).collect(),
        invalid_kinds: INVALID_KIND_NAMES.into_iter().map(|kind| (kind, 0)).collect(),
        table_wraps: 0,
        bytes: Bytes::default(),
    }
}
