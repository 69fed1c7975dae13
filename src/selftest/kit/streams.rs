//! Streams of numbers whose sums are known: what `glsl/probe_sums.comp` sums, again on the host.
//!
//! Comes in: a stream and how many of its numbers. Goes out: their sum in f64, and what the device makes of them.

use crate::Result;
use crate::gpu::{ShaderModule, shaders};
use crate::selftest::kit::TestBench;
use crate::selftest::kit::probe_calls::ProbeCalls;
use crate::texels::Texel;

/// Number of streams.
pub const COUNT: u32 = 3;
/// The streams by name.
pub const NAMES: [&str; COUNT as usize] = ["0.1 each", "uniform", "10,000 once in 10,000"];
/// Numbers that a dispatch of the compensated sum takes.
pub const STEPS: u32 = 62_500;

/// The renderer's hash (`glsl/sampling/random.glsl`), first lane.
fn pcg4d_first(v: [u32; 4]) -> u32 {
    let round = |[x, y, z, w]: [u32; 4]| {
        let x = x.wrapping_add(y.wrapping_mul(w));
        let y = y.wrapping_add(z.wrapping_mul(x));
        let z = z.wrapping_add(x.wrapping_mul(y));
        let w = w.wrapping_add(y.wrapping_mul(z));
        [x, y, z, w]
    };
    let v = v.map(|lane| lane.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let v = round(round(v).map(|lane| lane ^ (lane >> 16)));
    v[0] ^ (v[0] >> 16)
}

/// Number `index` of a stream.
pub fn number(stream: u32, index: u32) -> f32 {
    if stream == 0 {
        return 0.1;
    }
    let u = (pcg4d_first([stream, index, 0, 0]) >> 8) as f32 / 16_777_216.0;
    match stream {
        1 => u,
        _ if u < 1e-4 => 1e4,
        _ => 0.0,
    }
}

/// Sum of a stream's first `count` numbers; f64 is off by at most 2^-53 of it a number, 1e-9 at 10^7.
pub fn sum(stream: u32, count: u32) -> f64 {
    (0..count).map(|index| f64::from(number(stream, index))).sum()
}

/// The streams' sums with compensation by the kernel `module`, `dispatches` times [`STEPS`] numbers each.
pub fn compensated(bench: &TestBench, module: ShaderModule, dispatches: u32) -> Result<Vec<f32>> {
    let calls = ProbeCalls { calls: COUNT, dispatches, ..ProbeCalls::new(module, 0, &[]) };
    Ok(calls.run(bench)?.into_iter().map(|state| f32::from_bits(state[0])).collect())
}

/// Sums of `blocks` blocks of 16 samples whose channels are the streams, as a render makes them.
pub fn blocks(bench: &TestBench, blocks: u32) -> Result<Vec<Texel>> {
    ProbeCalls { calls: blocks, ..ProbeCalls::new(shaders::PROBE_SUMS, 1, &[]) }.run(bench)
}
