//! What cases read off a small render.
//!
//! Comes in: a scene and settings. Goes out: moments over pixels of one expectation, bits to compare, or tiles with their
//! variances. A render in which a sample was left out is an error here, as no such case expects one.

use crate::render::Rendered;
use crate::scene::Scene;
use crate::selftest::kit::TestBench;
use crate::settings::Settings;
use crate::statistics::Finding;
use crate::statistics::Worst;
use crate::statistics::finding::VERDICTS;
use crate::statistics::{Moments, critical_z};
use crate::{Error, Result};

fn rendered(bench: &TestBench, scene: &Scene, settings: &Settings) -> Result<Rendered> {
    let rendered = bench.render(scene, settings)?;
    match rendered.report.invalid_samples.values().sum() {
        0u64 => Ok(rendered),
        count => Err(Error::Internal(format!("{count} samples were left out"))),
    }
}

/// Moments of the red channel over the pixels, for scenes in which all of them have one expectation.
pub fn pixel_moments(bench: &TestBench, scene: &Scene, settings: &Settings) -> Result<Moments> {
    let film = rendered(bench, scene, settings)?.film;
    Ok(Moments::of(film.mean().into_iter().map(|pixel| f64::from(pixel[0]))))
}

/// The bits of the picture.
pub fn bits(bench: &TestBench, scene: &Scene, settings: &Settings) -> Result<Vec<[u32; 3]>> {
    Ok(rendered(bench, scene, settings)?.film.mean().into_iter().map(|pixel| pixel.map(f32::to_bits)).collect())
}

/// Pixels that are not black.
pub fn lit_pixels(bench: &TestBench, scene: &Scene, settings: &Settings) -> Result<u64> {
    let film = rendered(bench, scene, settings)?.film;
    Ok(film.mean().iter().filter(|rgb| rgb.iter().any(|&channel| channel != 0.0)).count() as u64)
}

/// Largest relative distance of any pixel's channel from `expected`.
pub fn worst_error(bench: &TestBench, scene: &Scene, settings: &Settings, expected: f64) -> Result<f64> {
    let film = rendered(bench, scene, settings)?.film;
    let mut worst = Worst::default();
    film.mean().into_iter().flatten().for_each(|value| worst.add((f64::from(value) / expected - 1.0).abs()));
    Ok(worst.0)
}

/// Pixels in which two pictures differ.
pub fn differing(what: impl Into<String>, a: &[[u32; 3]], b: &[[u32; 3]]) -> Finding {
    let events = if a.len() == b.len() { a.iter().zip(b).filter(|(a, b)| a != b).count() } else { a.len().max(1) };
    Finding::never(what, events as u64, a.len() as u64)
}

/// Side of the tiles of [`compare_tiles`], in pixels.
const TILE: usize = 8;

/// Two pictures of one expectation, from seeds of their own: the worst z over tiles of 8x8 pixels and three channels.
pub fn compare_tiles(
    bench: &TestBench,
    what: impl Into<String>,
    [first, second]: [(&Scene, &Settings); 2],
) -> Result<Finding> {
    let (a, b) = (tiles(bench, first)?, tiles(bench, second)?);
    let mut worst = Worst::default();
    let mut compared = 0;
    for (a, b) in a.iter().zip(&b) {
        let variance = a.1 + b.1;
        if variance > 0.0 || a.0 != b.0 {
            worst.add((a.0 - b.0).abs() / variance.sqrt());
            compared += 1;
        }
    }
    let limit = critical_z(compared.max(1) * VERDICTS);
    let why = format!("largest z of {compared} tiles (false alarms: 1e-6 over {VERDICTS} such cases)");
    Ok(Finding::at_most(what, limit, worst.0, &why))
}

/// Mean and its variance for each tile and channel, from the film's replicates.
fn tiles(bench: &TestBench, (scene, settings): (&Scene, &Settings)) -> Result<Vec<(f64, f64)>> {
    let film = rendered(bench, scene, settings)?.film;
    let estimate = film.estimate();
    let (width, height) = (settings.width as usize, settings.height as usize);
    let mut tiles = Vec::new();
    for y in (0..height).step_by(TILE) {
        for x in (0..width).step_by(TILE) {
            for channel in 0..3 {
                let (mut mean, mut variance) = (0.0, 0.0);
                for row in y..(y + TILE).min(height) {
                    for column in x..(x + TILE).min(width) {
                        let pixel = row * width + column;
                        mean += f64::from(estimate.mean[pixel][channel]);
                        variance += estimate.variance[pixel][channel];
                    }
                }
                tiles.push((mean, variance));
            }
        }
    }
    Ok(tiles)
}
