//! Calls of the renderer's own functions through probe kernels.
//!
//! Comes in: a kernel, a function's number, arguments, and a scene where one matters. Goes out: its answers.

use crate::Result;
use crate::bvh::Accel;
use crate::gpu::{ShaderModule, shaders};
use crate::interface::{SAMPLER_INDEPENDENT, SAMPLER_SOBOL, SAMPLER_TABLE, SPEC_SAMPLER};
use crate::scene::{Filter, Scene};
use crate::selftest::kit::TestBench;
use crate::selftest::kit::probe::Probe;
use crate::selftest::kit::scenes::{SceneBuilder, camera};
use crate::settings::{Buffers, LightPick, Sampler, Settings};
use crate::texels::{Texel, TexelData};

/// Number `index` of the pixels of a picture `side` wide, as the samplers take a pixel: x | y << 16.
pub fn pixel(index: u32, side: u32) -> u32 {
    (index % side) | ((index / side) << 16)
}

/// A scene of nothing.
pub fn nothing() -> Scene {
    SceneBuilder::new().finish(camera([0.0; 3], [0.0, 0.0, 1.0], 40.0), Some([1.0; 3]))
}

/// The kernel of the float functions, in the mode of `bench`'s renders: with NaN kept where the device offers that.
pub fn float_probe(bench: &TestBench) -> ShaderModule {
    if bench.context().device_info().shader_signed_zero_inf_nan_preserve_float32 {
        shaders::PROBE_FLOATS_KEEP_NAN
    } else {
        shaders::PROBE_FLOATS
    }
}

/// A call of many: function `function` of the kernel `module`.
pub struct ProbeCalls<'a> {
    /// The kernel.
    pub module: ShaderModule,
    /// Number of the function.
    pub function: u32,
    /// The scene whose records are bound; none: one of nothing.
    pub scene: Option<&'a Scene>,
    /// Random-number scheme.
    pub sampler: Sampler,
    /// How lights are chosen; none: as for a render of the scene.
    pub light_pick: Option<LightPick>,
    /// Pixel filter whose table is bound.
    pub filter: Filter,
    /// First sample of the run: its block decides the replicate.
    pub first_sample: u32,
    /// ProbeCalls; the kernel says how many texels of `input` each takes.
    pub calls: u32,
    /// Arguments.
    pub input: &'a [Texel],
    /// Texels that a call answers with.
    pub output_texels: u32,
    /// Dispatches, one after the other, over the same answers.
    pub dispatches: u32,
}

impl<'a> ProbeCalls<'a> {
    /// One call a texel of input, one texel of answer, independent samples.
    pub fn new(module: ShaderModule, function: u32, input: &'a [Texel]) -> ProbeCalls<'a> {
        ProbeCalls {
            module,
            function,
            scene: None,
            sampler: Sampler::Independent,
            light_pick: None,
            filter: Filter::Box,
            first_sample: 0,
            calls: input.len() as u32,
            input,
            output_texels: 1,
            dispatches: 1,
        }
    }

    /// Makes the calls.
    pub fn run(&self, bench: &TestBench) -> Result<Vec<Texel>> {
        let empty = nothing();
        let scene = self.scene.unwrap_or(&empty);
        let accel = Accel::brute();
        let defaults = Settings::for_scene(scene);
        let light_pick = self.light_pick.unwrap_or(defaults.light_pick);
        let settings = Settings { sampler: self.sampler, filter: self.filter, light_pick, ..defaults };
        let data = TexelData::pack(scene, &accel, &settings)?;
        let sampler = match self.sampler {
            Sampler::Sobol => SAMPLER_SOBOL,
            Sampler::Independent => SAMPLER_INDEPENDENT,
            Sampler::Table => SAMPLER_TABLE,
        };
        let probe = Probe {
            module: self.module,
            data: &data,
            accel: &accel,
            buffers: Buffers::Texel,
            specialization: vec![(SPEC_SAMPLER, sampler)],
            function: self.function,
            first_sample: self.first_sample,
            calls: self.calls,
            input: self.input,
            output_texels: self.output_texels,
            without_guard: None,
        };
        bench.probe_repeated(probe, self.dispatches)
    }
}
