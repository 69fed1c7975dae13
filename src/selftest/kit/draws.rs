//! The renderer's random numbers, drawn by its own functions, and tests of them.
//!
//! Comes in: which numbers. Goes out: their words, or findings about their means and correlations.

use crate::Result;
use crate::gpu::shaders;
use crate::selftest::kit::TestBench;
use crate::selftest::kit::probe_calls::{ProbeCalls, float_probe, pixel};
use crate::settings::Sampler;
use crate::statistics::Finding;
use crate::statistics::Moments;
use crate::texels::Texel;

/// Random-number function of `glsl/probe_sampling.comp`.
const RANDOM_PAIR: u32 = 0;

/// The number that a word stands for.
pub fn unit(word: u32) -> f64 {
    f64::from(word >> 8) / f64::from(1 << 24)
}

/// Words of `random_pair`: of pixel, index in the replicate, number of the pair.
pub fn pairs(bench: &TestBench, sampler: Sampler, questions: impl Iterator<Item = [u32; 3]>) -> Result<Vec<Texel>> {
    let input: Vec<Texel> = questions.map(|[pixel, index, pair]| [pixel, index, pair, 0]).collect();
    ProbeCalls { sampler, ..ProbeCalls::new(shaders::PROBE_SAMPLING, RANDOM_PAIR, &input) }.run(bench)
}

/// Correlation of numbers uniform in [0, 1): its standard error is 1 / root n.
pub fn correlation(what: String, pairs: impl Iterator<Item = (f64, f64)>) -> Finding {
    let products = Moments::of(pairs.map(|(a, b)| (a - 0.5) * (b - 0.5) * 12.0));
    Finding::z(what, 0.0, products.mean, 1.0 / products.count)
}

/// Variance across pixels of the means of 2^12, 2^16 and 2^20 numbers, in units of a number's own over how many they are.
pub fn scatter_of_means(bench: &TestBench) -> Result<Vec<Finding>> {
    const PART: u32 = 4096;
    const MOST: u32 = 1 << 20;
    let pixels = bench.count(64, 1024) as u32;
    let parts = (MOST / PART) as usize;
    let input: Vec<Texel> = (0..pixels)
        .flat_map(|index| (0..MOST / PART).map(move |part| [pixel(index, 32), part * PART, PART, 0]))
        .collect();
    let answers = ProbeCalls { output_texels: 2, ..ProbeCalls::new(float_probe(bench), 4, &input) }.run(bench)?;
    let mut findings = Vec::new();
    for bits in [12, 16, 20] {
        let taken = (1 << bits) / PART as usize;
        let samples = f64::from(1 << bits);
        let squares = answers.chunks_exact(2 * parts).map(|pixel| {
            let sum = pixel[..2 * taken].iter().step_by(2).map(|answer| f64::from(answer[0])).sum::<f64>();
            // Numbers of 16 bits: their mean is (2^16 - 1) / 2, their variance (2^32 - 1) / 12.
            let deviation = sum / samples - 65_535.0 / 2.0;
            deviation * deviation * samples * 12.0 / 4_294_967_295.0
        });
        let squares = Moments::of(squares);
        let what = format!("variance of means of 2^{bits} numbers over what it should be");
        // The square of a standard normal number has the variance 2.
        findings.push(Finding::z(what, 1.0, squares.mean, 2.0 / f64::from(pixels)));
    }
    Ok(findings)
}

/// Variance across pixels of the mean of 131,072 samples over that of the mean of their first 65,536.
pub fn falling_variance(bench: &TestBench) -> Result<Finding> {
    const PART: u32 = 4096;
    let pixels = bench.count(512, 4096) as u32;
    let parts = 131_072 / PART;
    let input: Vec<Texel> =
        (0..pixels).flat_map(|index| (0..parts).map(move |part| [pixel(index, 64), part * PART, PART, 0])).collect();
    let answers = ProbeCalls { output_texels: 2, ..ProbeCalls::new(float_probe(bench), 4, &input) }.run(bench)?;
    let (mut half, mut whole) = (Moments::default(), Moments::default());
    for pixel in answers.chunks_exact(2 * parts as usize) {
        let sum = |parts: &[Texel]| parts.iter().step_by(2).map(|answer| f64::from(answer[0])).sum::<f64>();
        half.add(sum(&pixel[..parts as usize]) / 65_536.0);
        whole.add(sum(pixel) / 131_072.0);
    }
    let ratio = whole.variance() / half.variance();
    // Each variance of P normal numbers has the relative variance 2 / P; the two are correlated by 1/2.
    let error = 0.5 * (2.0 / f64::from(pixels)).sqrt();
    Ok(Finding::z("variance of the mean of 131,072 samples over that of 65,536", 0.5, ratio, error * error))
}
