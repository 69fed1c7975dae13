//! Russian roulette at its ends: probabilities near 0 and 1, dark walls, glass (hard case 65).
//!
//! Comes in: a bench. Goes out: findings on means that no roulette may change, and on noise that it must keep in bounds.

use crate::Result;
use crate::selftest::TestBench;
use crate::selftest::kit::furnaces::{furnace, mean, series};
use crate::selftest::kit::scenes::{SceneBuilder, camera, glass};
use crate::selftest::kit::test_bench::plain_settings;
use crate::settings::{Hemisphere, Lights, Roulette, Settings};
use crate::statistics::Finding;

/// Roulette changes noise and no mean, whatever the probability, and keeps noise in bounds.
pub fn check(bench: &TestBench) -> Result<Vec<Finding>> {
    let spp = bench.count(32, 512) as u32;
    let half = furnace(0.5, false);
    let mut findings = Vec::new();
    for (roulette, max_bounces) in [
        (Roulette::Off, 8),
        (Roulette::Throughput, 8),
        (Roulette::Fixed(0.95), 8),
        (Roulette::Fixed(0.5), 8),
        // At 1 in 20 the third bounce is reached by too few paths for a normal law.
        (Roulette::Fixed(0.05), 2),
    ] {
        let settings = Settings { roulette, max_bounces, ..plain_settings(&half, 32, 32, spp) };
        let what = format!("furnace 0.5, {max_bounces} bounces, {roulette:?}");
        findings.push(mean(bench, what, &half, &settings, series(0.5, max_bounces))?);
    }
    // Uniform directions weigh up to twice the albedo: the throughput goes above 1, and a probability must not.
    let bright = furnace(0.8, false);
    let settings = Settings {
        roulette: Roulette::Throughput,
        hemisphere: Hemisphere::Uniform,
        max_bounces: 8,
        ..plain_settings(&bright, 32, 32, spp)
    };
    findings.push(mean(bench, "furnace 0.8, uniform directions".into(), &bright, &settings, series(0.8, 8))?);
    let white = furnace(0.99, false);
    let settings = Settings { roulette: Roulette::Throughput, max_bounces: 64, ..plain_settings(&white, 32, 32, spp) };
    findings.push(mean(bench, "furnace 0.99, 64 bounces, Throughput".into(), &white, &settings, series(0.99, 64))?);
    let settings = Settings {
        roulette: Roulette::Off,
        lights: Lights::Bsdf,
        max_bounces: 2000,
        ..plain_settings(&white, 8, 8, 1)
    };
    let deep = bench.render(&white, &settings)?.film.mean()[0][0];
    let why = "2,000 roundings of 6e-8";
    findings.push(Finding::relative("furnace 0.99, 2,000 bounces", series(0.99, 2000), f64::from(deep), 1.2e-4, why));
    findings.push(roulette_of_dark_walls(bench)?);
    findings.push(roulette_in_glass(bench)?);
    Ok(findings)
}

/// Walls of 0.001: after the first bounce a path is worth a thousandth. A survivor is worth at most 20 times more, not a fifth of
/// the light, so the few there are make no fireflies.
fn roulette_of_dark_walls(bench: &TestBench) -> Result<Finding> {
    let scene = furnace(0.001, false);
    let settings = Settings {
        roulette: Roulette::Throughput,
        lights: Lights::Bsdf,
        max_bounces: 8,
        ..plain_settings(&scene, 128, 128, 4)
    };
    let picture = bench.render(&scene, &settings)?.film.mean();
    let largest = picture
        .iter()
        .fold(0.0f64, |largest, pixel| if f64::from(pixel[0]) <= largest { largest } else { f64::from(pixel[0]) });
    // Each decision raises a survivor 20 times: bounce k adds 0.02^k at most.
    let why = "1 / (1 - 0.02), whoever survives";
    Ok(Finding::at_most("largest pixel of a furnace 0.001", 1.0 / 0.98 * (1.0 + 1e-6), largest, why))
}

/// A glass ball behind a window in a white furnace: a path inside the ball has a throughput of 1 / 3^2, which it gets back on
/// its way out. Judged by that, roulette would end almost half of the paths that enter the ball.
fn roulette_in_glass(bench: &TestBench) -> Result<Finding> {
    let mut builder = SceneBuilder::new();
    let body = builder.material(glass(3.0));
    builder.sphere([0.0; 3], 1.0, 3, body, true);
    builder.cuboid([-2.0, -2.0, -4.2], [2.0, 2.0, -4.0], body, false);
    let scene = builder.finish(camera([0.0, 0.0, -8.0], [0.0; 3], 8.0), Some([1.0; 3]));
    let spp = bench.count(64, 256) as u32;
    let settings = Settings { roulette: Roulette::Throughput, max_bounces: 64, ..plain_settings(&scene, 24, 24, spp) };
    let estimate = bench.render(&scene, &settings)?.film.estimate();
    let pixels = estimate.variance.len() as f64;
    let variance = estimate.variance.iter().map(|variance| variance[0]).sum::<f64>() / pixels * f64::from(spp);
    // Every path that comes out brings 1. At 5 / 9 entering alone would add 0.8.
    let why = "0 but for the few paths that 64 bounces do not see out";
    Ok(Finding::at_most("variance of a sample through window and ball of glass in a furnace", 0.01, variance, why))
}
