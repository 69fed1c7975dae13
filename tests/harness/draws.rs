//! Calls of the sampling probe (`glsl/probe_sampling.comp`): the renderer's own random numbers and warps, one texel a call.

use texray::gpu::shaders;
use texray::interface::BLOCK_SAMPLES;
use texray::scene::{Filter, Scene};
#[allow(unused_imports)]
pub use texray::selftest::kit::draws::unit;
use texray::selftest::kit::probe_calls::ProbeCalls;
#[allow(unused_imports)]
pub use texray::selftest::kit::probe_calls::nothing;
#[allow(unused_imports)]
pub use texray::selftest::kit::scattering::{
    COSINE_HEMISPHERE, FRESNEL, MAKE_BASIS, POWER_HEURISTIC, UNIFORM_HEMISPHERE,
};
use texray::selftest::{TestBench, Tier};
use texray::settings::Sampler;
use texray::texels::Texel;

use super::device::{assert_valid, context};
use super::statistics::{Verdict, chi_square_test};
use texray::statistics::distributions::normal_two_sided;

/// Functions of the probe that no hard case calls.
pub const RANDOM_PAIR: u32 = 0;
pub const UNIT_FLOAT: u32 = 1;
pub const SQUARE_TO_TRIANGLE: u32 = 4;
pub const FILTER_OFFSET: u32 = 5;
pub const PICK_LIGHT: u32 = 9;

/// Replicates of the probe's draws, as `selftest/kit/probe.rs` sets them.
pub const REPLICATES: u32 = 4;

/// Calls a function over the records of `scene`.
pub fn call(scene: &Scene, sampler: Sampler, filter: Filter, function: u32, input: &[Texel]) -> Vec<Texel> {
    call_in_run(scene, sampler, filter, function, 0, input)
}

fn call_in_run(
    scene: &Scene,
    sampler: Sampler,
    filter: Filter,
    function: u32,
    first_sample: u32,
    input: &[Texel],
) -> Vec<Texel> {
    let calls = ProbeCalls {
        scene: Some(scene),
        sampler,
        filter,
        first_sample,
        ..ProbeCalls::new(shaders::PROBE_SAMPLING, function, input)
    };
    let answers = calls.run(&TestBench::new(context(), Tier::Full)).expect("the probe runs");
    assert_valid(context());
    answers
}

/// Calls a function of floats.
pub fn call_floats(function: u32, input: &[[f32; 4]]) -> Vec<[f32; 4]> {
    let input: Vec<Texel> = input.iter().map(|call| call.map(f32::to_bits)).collect();
    let answers = call(&nothing(), Sampler::Independent, Filter::Box, function, &input);
    answers.into_iter().map(|answer| answer.map(f32::from_bits)).collect()
}

/// The words of pairs of random numbers of a replicate: of pixel (x, y), index in the replicate, number of the pair.
pub fn pairs(
    sampler: Sampler,
    replicate: u32,
    questions: impl IntoIterator<Item = ([u32; 2], u32, u32)>,
) -> Vec<[u32; 2]> {
    assert!(replicate < REPLICATES);
    let question = |([x, y], index, pair): ([u32; 2], u32, u32)| [x | y << 16, index, pair, 0];
    let input: Vec<Texel> = questions.into_iter().map(question).collect();
    // Block `replicate` is the first of that replicate.
    let first = replicate * BLOCK_SAMPLES;
    let answers = call_in_run(&nothing(), sampler, Filter::Box, RANDOM_PAIR, first, &input);
    answers.into_iter().map(|[a, b, _, _]| [a, b]).collect()
}

/// Correlation of pairs of numbers uniform in [0, 1), as a z: r √n is standard normal where they are independent.
pub fn correlation(pairs: impl IntoIterator<Item = (f64, f64)>) -> Verdict {
    let (mut sum, mut count) = (0.0, 0.0);
    for (a, b) in pairs {
        sum += (a - 0.5) * (b - 0.5) * 12.0;
        count += 1.0;
    }
    let z = sum / f64::sqrt(count);
    Verdict { statistic: z, p: normal_two_sided(z) }
}

/// Chi-square of pairs in [0, 1)² over `side` x `side` equal cells.
pub fn uniform_square(pairs: impl IntoIterator<Item = (f64, f64)>, side: usize) -> Verdict {
    let mut counts = vec![0.0; side * side];
    let cell = |value: f64| ((value * side as f64) as usize).min(side - 1);
    pairs.into_iter().for_each(|(a, b)| counts[cell(a) * side + cell(b)] += 1.0);
    let expected = counts.iter().sum::<f64>() / counts.len() as f64;
    chi_square_test(&counts, &vec![expected; side * side])
}
