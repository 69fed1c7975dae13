//! Runs a probe kernel (`glsl/probe_*.comp`) over the records of a scene and gives back what it wrote.

use crate::Result;
use crate::bvh::Accel;
use crate::gpu::{
    Barrier, BindGroup, Buffer, BufferUse, ComputePipeline, Context, Ledger, Memory, PipelineDesc, Readback, Recorder,
    Resource, ShaderModule, Uploader,
};
use crate::interface::*;
use crate::render::guard::Guard;
use crate::render::kernel::{self, Dispatch};
use crate::render::slice::{Place, Slice};
use crate::render::tiles::Tile;
use crate::render::upload::{GpuScene, fits_texel_buffers};
use crate::render::work_size::max_step_budget;
use crate::settings::Buffers;
use crate::texels::{Texel, TexelData};

/// A probe: which kernel, on what, with what answers.
pub struct Probe<'a> {
    /// The kernel.
    pub module: ShaderModule,
    /// Records to bind.
    pub data: &'a TexelData,
    /// The tree that the records hold.
    pub accel: &'a Accel,
    /// How the records are bound.
    pub buffers: Buffers,
    /// Specialisation constants beside those of tree and buffers, or in their place.
    pub specialization: Vec<(u32, u32)>,
    /// `push.flags`.
    pub function: u32,
    /// First sample of the run: its block decides the replicate.
    pub first_sample: u32,
    /// Invocations.
    pub calls: u32,
    /// Texels of input.
    pub input: &'a [Texel],
    /// Texels of output of a call.
    pub output_texels: u32,
    /// A guard to leave out.
    pub without_guard: Option<Guard>,
}

impl Probe<'_> {
    /// Runs it, and gives `output_texels` a call.
    pub fn run(&self, context: &Context) -> Result<Vec<Texel>> {
        self.run_repeated(context, 1)
    }

    /// Runs it `dispatches` times over the same output, which is zero at first.
    pub fn run_repeated(&self, context: &Context, dispatches: u32) -> Result<Vec<Texel>> {
        let mut ledger = Ledger::default();
        // As a render chooses.
        let buffers = if fits_texel_buffers(self.data, context) { self.buffers } else { Buffers::Storage };
        let scene = GpuScene::upload(context, self.data, &self.constants(), buffers, &mut ledger)?;
        let accel_value = match self.accel {
            Accel::Brute => ACCEL_BRUTE,
            Accel::Binary(_) => ACCEL_BINARY,
            Accel::Wide(_) => ACCEL_WIDE,
        };
        let mut specialization = vec![
            (SPEC_STORAGE_RECORDS, u32::from(buffers == Buffers::Storage)),
            (SPEC_ACCEL, accel_value),
            (SPEC_STACK_ENTRIES, self.accel.stack_entries()),
            (SPEC_WITHOUT_GUARD, self.without_guard.map_or(GUARD_NONE, Guard::number)),
        ];
        specialization.retain(|(id, _)| self.specialization.iter().all(|(given, _)| given != id));
        specialization.extend_from_slice(&self.specialization);
        let pipeline = ComputePipeline::shared(
            context,
            &PipelineDesc { name: "probe", module: self.module, specialization: &specialization },
        )?;
        let bytes = 16 * u64::from(self.calls) * u64::from(self.output_texels);
        let storage = |name: &str, bytes| {
            Buffer::new(context, name, bytes, BufferUse { storage: true, texel: false }, Memory::Device)
        };
        let (output, scratch) = (storage("probe output", bytes)?, storage("scratch", 256)?);
        let input = storage("probe input", 16 * self.input.len().max(1) as u64)?;
        let mut uploader = Uploader::new(context)?;
        if !self.input.is_empty() {
            let input_bytes = bytemuck::cast_slice(self.input);
            uploader.upload(&mut ledger, &input, 0, input_bytes, "questions")?;
        }
        uploader.finish()?;
        let mut resources = scene.resources().to_vec();
        resources.push((BINDING_PATHS, Resource::Texel(scene.null_texel().clone())));
        resources.extend(kernel::WRITTEN_BINDINGS.map(|number| (number, Resource::Storage(scratch.clone()))));
        resources.push((BINDING_PROBE_INPUT, Resource::Storage(input)));
        resources.push((BINDING_PROBE_OUTPUT, Resource::Storage(output.clone())));
        // A kernel uses a part of them.
        resources.retain(|(number, _)| pipeline.bindings().iter().any(|slot| slot.number == *number));
        let group = BindGroup::new(&pipeline, &resources)?;

        let dispatch = Dispatch {
            tile: Tile { x: 0, y: 0, width: 1, height: 1 },
            slice: Slice::Rows { first: 0, count: 1 },
            fills: Place { list: 0, at: 0 },
            samples: [self.first_sample, self.calls],
            budget: max_step_budget(context.device_info()),
            leave_eighths: 0,
        };
        let push = Push { flags: self.function, ..kernel::push(&dispatch, 4) }.bytes();

        let mut recorder = Recorder::new(context, "probe")?;
        recorder.fill(&scratch, 0, 256, 0)?;
        recorder.fill(&output, 0, bytes, 0)?;
        recorder.barrier(Barrier::TransferToCompute)?;
        for dispatch in 0..dispatches {
            if dispatch > 0 {
                recorder.barrier(Barrier::ComputeToCompute)?;
            }
            recorder.dispatch(&pipeline, &group, &push, [self.calls.div_ceil(PROBE_WORKGROUP), 1, 1])?;
        }
        let mut readback = Readback::new(context, "answers", bytes)?;
        readback.copy_from(&mut recorder, &mut ledger, &output, 0, 0, bytes, "answers")?;
        recorder.submit()?.wait()?;
        Ok(bytemuck::pod_collect_to_vec(&readback.bytes()?[..bytes as usize]))
    }
    /// What stands for a render's constants; no two of them are alike.
    pub fn constants(&self) -> RenderConstants {
        RenderConstants {
            sky_r: 0.25,
            sky_g: 0.5,
            sky_b: 0.75,
            triangle_count: self.data.triangle_count,
            light_count: self.data.light_count,
            max_bounces: 8,
            seed_low: 0x1234_5678,
            seed_high: 0x9abc_def0,
            roulette_p: 1.0,
        }
    }
}
