//! Directions made of sines and cosines: hard case 7, and what a driver whose sines are poor would make of them.
//!
//! Comes in: a bench. Goes out: findings on lengths, and on the first moments of the cosines.

use std::f64::consts::TAU;

use crate::Result;
use crate::selftest::TestBench;
use crate::selftest::kit::scattering::{COSINE_HEMISPHERE, DISC_POINT, UNIFORM_HEMISPHERE, call, call_sampling};
use crate::statistics::Finding;
use crate::statistics::Moments;
use crate::statistics::Worst;
use crate::statistics::random::Random;

/// What Vulkan allows sine and cosine to be off by, absolutely.
const SINE_ERROR: f64 = 1.0 / 2048.0;

/// Hard case 7.
pub fn check(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut random = Random::new(7, 0);
    let count = bench.count(1 << 17, 1 << 20);
    let numbers: Vec<[f32; 4]> = (0..count).map(|_| [random.unit(), random.unit(), 0.0, 0.0]).collect();
    let mut findings = Vec::new();
    for (name, function, [mean, square, fourth]) in [
        ("cosine", COSINE_HEMISPHERE, [2.0 / 3.0, 0.5, 1.0 / 3.0]),
        ("uniform", UNIFORM_HEMISPHERE, [0.5, 1.0 / 3.0, 0.2]),
    ] {
        let (mut cosines, mut squares, mut worst) = (Moments::default(), Moments::default(), Worst::default());
        for [x, y, z, _] in call_sampling(bench, function, &numbers)?.into_iter().map(|d| d.map(f64::from)) {
            worst.add((x * x + y * y + z * z - 1.0).abs());
            cosines.add(z);
            squares.add(z * z);
        }
        let samples = count as f64;
        let why = "1e-6: ten roundings of 2^-24, and 2 units of the inverse root";
        findings.push(Finding::at_most(format!("{name} directions, | |d|^2 - 1 |"), 1e-6, worst.0, why));
        let variance = (square - mean * mean) / samples;
        findings.push(Finding::z(format!("{name} directions, mean cosine"), mean, cosines.mean, variance));
        let variance = (fourth - square * square) / samples;
        findings.push(Finding::z(format!("{name} directions, mean squared cosine"), square, squares.mean, variance));
    }
    // Points of the disc on a driver whose sine and cosine are as poor as they may be.
    let questions: Vec<_> = (0..bench.count(1 << 12, 1 << 16))
        .map(|_| {
            let (angle, radius) = (TAU * random.next(), random.unit());
            let mut poor = |exact: f64| (exact + SINE_ERROR * (2.0 * random.next() - 1.0)) as f32;
            [[radius, poor(angle.cos()), poor(angle.sin()), 0.0], [0.0; 4], [0.0; 4]]
        })
        .collect();
    let mut worst = Worst::default();
    for ([[radius, ..], ..], [[x, y, ..], _]) in questions.iter().zip(call(bench, DISC_POINT, &questions)?) {
        worst.add((f64::from(x).hypot(f64::from(y)) - f64::from(*radius)).abs());
    }
    let why = "1e-6, though sine and cosine are off by up to 2^-11: six roundings of 2^-24 and 2 units of the root";
    findings.push(Finding::at_most("distance of disc points from their circle", 1e-6, worst.0, why));
    Ok(findings)
}
