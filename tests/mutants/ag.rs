//! Guards of groups A and G, each with the case that must fail without it.

use texray::gpu::shaders;
use texray::render::Guard;
use texray::selftest::{Bench, streams};

/// Guard and case.
pub const MUTANTS: &[(Guard, u8)] = &[
    (Guard::InvalidSamples, 1),
    (Guard::CompensatedSum, 6),
    (Guard::IntegerClamp, 9),
    (Guard::CompensatedSum, 58),
    (Guard::UnitFloat, 61),
    (Guard::HashShift, 62),
    (Guard::BounceDimensions, 64),
    (Guard::RouletteRange, 65),
    (Guard::RouletteWeight, 65),
    (Guard::RouletteScale, 65),
];

/// Without `precise` a driver may fold the compensation away; lavapipe does, and the sum of case 6 drifts as a naive one. A
/// driver that does not is none the worse.
pub fn loose_sums(bench: &Bench) {
    let dispatches = 16;
    let expected = streams::sum(0, dispatches * streams::STEPS);
    let sum = |spirv| streams::compensated(bench, spirv, dispatches).expect("the probe runs")[0];
    let error = |sum: f32| (f64::from(sum) / expected - 1.0).abs();
    let (precise, loose) = (sum(shaders::PROBE_SUMS), sum(shaders::PROBE_SUMS_LOOSE));
    println!("10^6 x 0.1: {:.1e} with precise, {:.1e} without", error(precise), error(loose));
    assert!(error(precise) < 1e-6);
    if bench.context().device_info().name.contains("llvmpipe") {
        assert!(error(loose) > 1e-4, "precise is no guard here: {loose} for {expected}");
    }
}
