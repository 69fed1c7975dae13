//! Calls of the probes of sampling and scattering, and means of small renders.
//!
//! Comes in: a bench and arguments as floats. Goes out: what the renderer's own functions made of them.

use crate::Result;
use crate::gpu::shaders;
use crate::scene::Scene;
use crate::selftest::kit::TestBench;
use crate::selftest::kit::probe_calls::{ProbeCalls, nothing};
use crate::selftest::kit::test_bench::plain_settings;
use crate::settings::{Sampler, Settings};
use crate::texels::Texel;

// Functions of glsl/probe_sampling.comp.
/// `cosine_hemisphere`.
pub const COSINE_HEMISPHERE: u32 = 2;
/// `uniform_hemisphere`.
pub const UNIFORM_HEMISPHERE: u32 = 3;
/// `fresnel_dielectric`.
pub const FRESNEL: u32 = 6;
/// `make_basis`.
pub const MAKE_BASIS: u32 = 7;
/// `power_heuristic`.
pub const POWER_HEURISTIC: u32 = 8;
/// `pick_light` of four words.
pub const PICK_LIGHTS: u32 = 10;

// Functions of glsl/probe_scattering.comp.
/// `ggx_distribution`.
pub const GGX_DISTRIBUTION: u32 = 0;
/// `sample_ggx`.
pub const GGX_SAMPLE: u32 = 1;
/// Weights of `sample_ggx`, [`WEIGHTS`] a call.
pub const GGX_WEIGHTS: u32 = 2;
/// `solid_angle`.
pub const SOLID_ANGLE: u32 = 3;
/// `arc_tangent`.
pub const ARC_TANGENT: u32 = 4;
/// `refract_through`.
pub const REFRACTION: u32 = 5;
/// `sample_glass`.
pub const GLASS: u32 = 6;
/// `sample_light`.
pub const LIGHT_SAMPLE: u32 = 7;
/// `disc_point`.
pub const DISC_POINT: u32 = 8;
/// `ggx_value_cosine` both ways, and `ggx_pdf`.
pub const GGX_EVALUATE: u32 = 9;
/// `reflect_about`, many times.
pub const REFLECTIONS: u32 = 10;
/// Weights of a call of [`GGX_WEIGHTS`].
pub const WEIGHTS: usize = 64;

/// Three texels of arguments to a function of `probe_scattering`.
pub type Arguments = [[f32; 4]; 3];

/// Calls a function of `probe_sampling` on words, over the records of a scene.
pub fn call_words(bench: &TestBench, scene: &Scene, function: u32, input: &[Texel]) -> Result<Vec<Texel>> {
    ProbeCalls { scene: Some(scene), ..ProbeCalls::new(shaders::PROBE_SAMPLING, function, input) }.run(bench)
}

/// Calls a function of `probe_sampling` on floats.
pub fn call_sampling(bench: &TestBench, function: u32, input: &[[f32; 4]]) -> Result<Vec<[f32; 4]>> {
    let input: Vec<Texel> = input.iter().map(|call| call.map(f32::to_bits)).collect();
    let answers = call_words(bench, &nothing(), function, &input)?;
    Ok(answers.into_iter().map(|answer| answer.map(f32::from_bits)).collect())
}

/// Calls a function of `probe_scattering` over the records of a scene.
pub fn call_in(bench: &TestBench, scene: &Scene, function: u32, input: &[Arguments]) -> Result<Vec<[[f32; 4]; 2]>> {
    let input: Vec<Texel> = input.iter().flatten().map(|texel| texel.map(f32::to_bits)).collect();
    let calls = ProbeCalls {
        scene: Some(scene),
        calls: input.len() as u32 / 3,
        output_texels: 2,
        ..ProbeCalls::new(shaders::PROBE_SCATTERING, function, &input)
    };
    let answers = calls.run(bench)?;
    Ok(answers.as_chunks::<2>().0.iter().map(|answer| answer.map(|texel| texel.map(f32::from_bits))).collect())
}

/// Calls a function of `probe_scattering`.
pub fn call(bench: &TestBench, function: u32, input: &[Arguments]) -> Result<Vec<[[f32; 4]; 2]>> {
    call_in(bench, &nothing(), function, input)
}

/// The mean of a small picture, in the scene's own units of radiance.
#[derive(Clone, Copy, Debug)]
pub struct Measured {
    /// Mean of the red channel: scenes of the cases are grey.
    pub mean: f64,
    /// Its estimated variance, from replicates, over all pixels.
    pub variance: f64,
    /// Smallest and largest pixel.
    pub range: [f64; 2],
    /// Samples that were left out.
    pub invalid: u64,
}

impl Measured {
    /// Standard error over mean.
    pub fn relative_error(&self) -> f64 {
        self.variance.sqrt() / self.mean.abs()
    }
}

/// Renders and takes the mean of all pixels. Pixels are independent, each of at least two replicates.
pub fn measure(bench: &TestBench, scene: &Scene, settings: &Settings) -> Result<Measured> {
    let rendered = bench.render(scene, settings)?;
    let estimate = rendered.film.estimate();
    let count = estimate.mean.len() as f64;
    let values = || estimate.mean.iter().map(|pixel| f64::from(pixel[0]));
    Ok(Measured {
        mean: values().sum::<f64>() / count,
        variance: estimate.variance.iter().map(|pixel| pixel[0]).sum::<f64>() / (count * count),
        range: [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)],
        invalid: rendered.report.invalid_samples.values().sum(),
    })
}

/// Settings for [`measure`]: scrambled Sobol' points, of which each pixel has four sets of its own.
pub fn smooth_settings(scene: &Scene, side: u32, spp: u32) -> Settings {
    Settings { sampler: Sampler::Sobol, replicates: Some(4), ..plain_settings(scene, side, side, spp) }
}
