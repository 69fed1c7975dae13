//! The path-tracing kernel: its specialisation for a scene, its push constants.

use std::sync::Arc;

use crate::bvh::{Accel, TreeStats};
use crate::error::Result;
use crate::film::{block_in_replicate, replicate_of_block};
use crate::gpu::{ComputePipeline, Context, DeviceKind, PipelineDesc, ShaderModule, shaders};
use crate::interface::*;
use crate::render::effects::Effects;
use crate::render::guard::Guard;
use crate::render::slice::{Place, Slice, WORKGROUP};
use crate::render::tiles::Tile;
use crate::render::tuning::Tuning;
use crate::settings::{AccelKind, Buffers, Hemisphere, Intersector, LightPick, Lights, Roulette, Sampler, Settings};

/// When lanes are left for the next pass by default: a CPU's dispatches are long, and at their ends most lanes of a vector wait for
/// the last (docs/performance.md). A GPU hides that behind other subgroups, and a dispatch more costs it a wait for the host.
pub fn leave_eighths(device: DeviceKind) -> u32 {
    match device {
        DeviceKind::Cpu => 5,
        _ => 0,
    }
}

pub use crate::interface::WRITTEN_BINDINGS;

/// Where lanes refill by default; measured in docs/performance.md.
const REFILL_EIGHTHS: u32 = 6;

/// Where a node visit brings fewer triangles than this, one test a visit keeps up with them; measured in docs/performance.md.
const FEW_TESTS_A_VISIT: f64 = 1.0;

/// Triangles that a lane tests between two node visits, 0 for all: a visit of the wide tree is dear enough to go on with.
fn tests_a_visit(tree: &TreeStats) -> u32 {
    match tree.kind {
        "wide" if tree.tests_a_visit < FEW_TESTS_A_VISIT => 1,
        "wide" => 2,
        _ => 0,
    }
}

/// The module for a device: with ballots and NaN kept where it offers them.
fn module(context: &Context, tuning: &Tuning) -> ShaderModule {
    let info = context.device_info();
    let keep_nan = info.shader_signed_zero_inf_nan_preserve_float32 && !tuning.nan_by_driver;
    match (info.subgroup_ballot, keep_nan) {
        (true, true) => shaders::PATH_TRACE_KEEP_NAN,
        (true, false) => shaders::PATH_TRACE,
        (false, true) => shaders::PATH_TRACE_PLAIN_KEEP_NAN,
        (false, false) => shaders::PATH_TRACE_PLAIN,
    }
}

/// How a kernel reads what has two bindings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadAs {
    /// The scene's records.
    pub records: Buffers,
    /// The path states.
    pub paths: Buffers,
}

/// Entries of the kernel's traversal stack: those that the tree needs, in whole texels.
pub fn padded_stack_entries(accel: &Accel) -> u32 {
    accel.stack_entries().next_multiple_of(STACK_ENTRIES_A_TEXEL)
}

/// A module and the values of its specialisation constants.
#[derive(Clone, Debug)]
pub struct Specialized {
    /// The module.
    pub module: ShaderModule,
    /// `(id, value)` of each constant.
    pub constants: Vec<(u32, u32)>,
}

/// The module, specialised for the scene's effects, its tree and the user's choices. `tree` has the figures of `accel`.
pub fn specialized(
    context: &Context,
    settings: &Settings,
    accel: &Accel,
    tree: &TreeStats,
    effects: &Effects,
    read_as: ReadAs,
    tuning: &Tuning,
) -> Specialized {
    let mut constants = vec![
        (SPEC_WORKGROUP_X, WORKGROUP[0]),
        (SPEC_WORKGROUP_Y, WORKGROUP[1]),
        (SPEC_STORAGE_RECORDS, u32::from(read_as.records == Buffers::Storage)),
        (SPEC_STORAGE_PATHS, u32::from(read_as.paths == Buffers::Storage)),
        (SPEC_ACCEL, accel_value(settings.accel)),
        (SPEC_STACK_ENTRIES, padded_stack_entries(accel)),
        (SPEC_INTERSECTOR, intersector_value(settings.intersector)),
        (SPEC_SAMPLER, sampler_value(settings.sampler)),
        (SPEC_LIGHTS, lights_value(settings.lights)),
        (SPEC_LIGHT_PICK, light_pick_value(settings)),
        (SPEC_HEMISPHERE, hemisphere_value(settings.hemisphere)),
        (SPEC_ROULETTE, roulette_value(settings.roulette).0),
        (SPEC_REFILL_EIGHTHS, tuning.refill_eighths.unwrap_or(REFILL_EIGHTHS)),
        (SPEC_TESTS_A_VISIT, tuning.tests_a_visit.unwrap_or_else(|| tests_a_visit(tree))),
        (SPEC_WITHOUT_GUARD, tuning.without_guard.map_or(GUARD_NONE, Guard::number)),
    ];
    constants.extend((0..EFFECTS).map(|effect| (SPEC_EFFECTS + effect, u32::from(effects.is_on(effect)))));
    Specialized { module: module(context, tuning), constants }
}

/// Makes the pipeline of a [`specialized`] module.
pub fn path_tracer(context: &Context, kernel: &Specialized) -> Result<Arc<ComputePipeline>> {
    ComputePipeline::shared(
        context,
        &PipelineDesc { name: "path tracer", module: kernel.module, specialization: &kernel.constants },
    )
}

/// What differs from one dispatch to the next.
#[derive(Clone, Copy, Debug)]
pub struct Dispatch {
    /// The tile on the device.
    pub tile: Tile,
    /// The pixels that the dispatch works on.
    pub slice: Slice,
    /// Where unfinished pixels are listed; a dispatch that goes on takes its own from the other list.
    pub fills: Place,
    /// First sample index of the run, and how many.
    pub samples: [u32; 2],
    /// Step budget.
    pub budget: u32,
    /// Paths are left unfinished when fewer eighths of a subgroup's lanes than this have samples left; 0: never.
    pub leave_eighths: u32,
}

impl Dispatch {
    /// Workgroups that cover the pixels.
    pub fn groups(&self) -> [u32; 3] {
        match self.slice {
            Slice::Rows { count, .. } => [self.tile.width.div_ceil(WORKGROUP[0]), count.div_ceil(WORKGROUP[1]), 1],
            Slice::Listed { count, .. } => [LIST_ROW / WORKGROUP[0], count.div_ceil(LIST_ROW * WORKGROUP[1]), 1],
        }
    }

    fn flags(&self) -> u32 {
        let begins = match self.slice {
            Slice::Rows { .. } => DISPATCH_BEGINS_RUN,
            Slice::Listed { .. } => 0,
        };
        begins | if self.fills.list == 0 { DISPATCH_FILLS_FIRST_LIST } else { 0 }
    }
}

/// The push constants of a dispatch of a render into so many replicates.
pub fn push(dispatch: &Dispatch, replicates: u32) -> Push {
    let tile = dispatch.tile;
    let (rows, listed) = match dispatch.slice {
        Slice::Rows { first, count } => ([first, count], [0, 0]),
        Slice::Listed { first, count } => ([0, 0], [first, count]),
    };
    // A run never crosses a block's end, so all of it belongs to one replicate.
    let [first, samples] = dispatch.samples;
    let block = first / BLOCK_SAMPLES;
    Push {
        tile_x: tile.x,
        tile_y: tile.y,
        tile_width: tile.width,
        tile_height: tile.height,
        slice_row: rows[0],
        slice_rows: rows[1],
        first_sample: first,
        samples,
        budget: dispatch.budget,
        flags: dispatch.flags(),
        replicate: replicate_of_block(block, replicates),
        first_index: block_in_replicate(block, replicates) * BLOCK_SAMPLES + first % BLOCK_SAMPLES,
        listed_first: listed[0],
        listed: listed[1],
        filled: dispatch.fills.at,
        leave_eighths: dispatch.leave_eighths,
    }
}

/// Probability of the fixed roulette, 1 for the others.
pub fn roulette_value(roulette: Roulette) -> (u32, f32) {
    match roulette {
        Roulette::Off => (ROULETTE_OFF, 1.0),
        Roulette::Throughput => (ROULETTE_THROUGHPUT, 1.0),
        Roulette::Fixed(p) => (ROULETTE_FIXED, p),
    }
}

fn accel_value(accel: AccelKind) -> u32 {
    match accel {
        AccelKind::Brute => ACCEL_BRUTE,
        AccelKind::Binary => ACCEL_BINARY,
        AccelKind::Wide => ACCEL_WIDE,
    }
}

fn intersector_value(intersector: Intersector) -> u32 {
    match intersector {
        Intersector::Watertight => INTERSECTOR_WATERTIGHT,
        Intersector::MollerTrumbore => INTERSECTOR_MOLLER_TRUMBORE,
    }
}

fn sampler_value(sampler: Sampler) -> u32 {
    match sampler {
        Sampler::Sobol => SAMPLER_SOBOL,
        Sampler::Independent => SAMPLER_INDEPENDENT,
        Sampler::Table => SAMPLER_TABLE,
    }
}

fn lights_value(lights: Lights) -> u32 {
    match lights {
        Lights::Mis => LIGHTS_MIS,
        Lights::Area => LIGHTS_AREA,
        Lights::Bsdf => LIGHTS_BSDF,
    }
}

fn light_pick_value(settings: &Settings) -> u32 {
    match settings.effective_light_pick() {
        LightPick::Power | LightPick::Area => LIGHT_PICK_LIST,
        LightPick::Tree => LIGHT_PICK_TREE,
    }
}

fn hemisphere_value(hemisphere: Hemisphere) -> u32 {
    match hemisphere {
        Hemisphere::Cosine => HEMISPHERE_COSINE,
        Hemisphere::Uniform => HEMISPHERE_UNIFORM,
    }
}
