//! The lobe of rough surfaces: its distribution, its weights, its albedo, its samples (hard cases 47 to 49).
//!
//! Comes in: a bench. Goes out: findings on the functions of glsl/shading/microfacet.glsl against f64 (`microfacets`).

use std::f64::consts::TAU;

use crate::Result;
use crate::selftest::TestBench;
use crate::selftest::cases::microfacets;
use crate::selftest::kit::scattering::{
    Arguments, GGX_DISTRIBUTION, GGX_EVALUATE, GGX_SAMPLE, GGX_WEIGHTS, WEIGHTS, call,
};
use crate::statistics::Finding;
use crate::statistics::Worst;
use crate::statistics::random::Random;
use crate::statistics::{Moments, chi_square_test};

/// A direction at an angle from z, turned about it.
pub fn direction(theta: f64, phi: f64) -> [f32; 3] {
    let (sine, cosine) = theta.sin_cos();
    [(sine * phi.cos()) as f32, (sine * phi.sin()) as f32, cosine as f32]
}

/// Three numbers in f64.
pub fn wide(values: [f32; 3]) -> [f64; 3] {
    values.map(f64::from)
}

/// A vector with a fourth number.
pub fn with([x, y, z]: [f32; 3], w: f32) -> [f32; 4] {
    [x, y, z, w]
}

/// D(h) against f64 near its peak, where all of it is, and beyond.
pub fn distribution(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut random = Random::new(47, 0);
    let mut findings = Vec::new();
    for alpha in [1e-4f32, 1e-3, 1e-2, 0.1, 1.0] {
        let questions: Vec<Arguments> = (0..bench.count(1 << 13, 1 << 16))
            .map(|_| {
                let tangent = f64::from(alpha) * 10f64.powf(4.0 * random.next() - 2.0);
                [with(direction(tangent.atan(), TAU * random.next()), alpha), [0.0; 4], [0.0; 4]]
            })
            .collect();
        let mut worst = Worst::default();
        for ([[x, y, z, _], ..], [[found, ..], _]) in questions.iter().zip(call(bench, GGX_DISTRIBUTION, &questions)?) {
            let expected = microfacets::distribution(wide([*x, *y, *z]), f64::from(alpha));
            worst.add((f64::from(found) / expected - 1.0).abs());
        }
        let why = "twenty roundings of 2^-24 are 1.2e-6";
        findings.push(Finding::at_most(format!("D, relative error at alpha {alpha:e}"), 1e-5, worst.0, why));
    }
    Ok(findings)
}

/// Weights of visible normals are in [0, 1] whatever the angle.
pub fn grazing_weights(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut random = Random::new(48, 0);
    let calls = bench.count(1 << 14, 1 << 18);
    let questions: Vec<Arguments> = (0..calls)
        .map(|i| {
            // Cosines down to 1e-37, half of them above 1e-4; alpha 1e-3 to 1.
            let cosine = 10f64.powf(-random.next() * if i % 2 == 0 { 4.0 } else { 37.0 });
            let ([x, y, _], alpha) = (direction(cosine.acos(), TAU * random.next()), 10f64.powf(-3.0 * random.next()));
            [[x, y, cosine as f32, alpha as f32], [f32::from_bits(i as u32), 0.0, 0.0, 0.0], [0.0; 4]]
        })
        .collect();
    let (mut outside, mut largest) = (0.0, Worst::default());
    for [[_, _, most, bad], _] in call(bench, GGX_WEIGHTS, &questions)? {
        outside += f64::from(bad);
        largest.add(f64::from(most));
    }
    let trials = (calls * WEIGHTS) as u64;
    Ok(vec![
        Finding::never("weights outside [0, 1 + 1e-5], NaN among them", outside as u64, trials),
        Finding::at_most("largest weight", 1.00001, largest.0, "masking of two directions is at most that of one"),
    ])
}

/// Directional albedos, and samples against their density.
pub fn lossless_lobe(bench: &TestBench) -> Result<Vec<Finding>> {
    let calls = bench.count(1 << 9, 1 << 14);
    let lobes: Vec<(f64, f64)> = [0.001, 0.01, 0.1, 0.3, 1.0]
        .iter()
        .flat_map(|&alpha| [0.0, 45.0, 80.0, 89.0].map(|degrees: f64| (alpha, degrees.to_radians())))
        .collect();
    let question = |(alpha, theta): (f64, f64), salt: u32| -> Arguments {
        [with(direction(theta, 0.0), alpha as f32), [f32::from_bits(salt), 0.0, 0.0, 0.0], [0.0; 4]]
    };
    let questions: Vec<Arguments> =
        (0..lobes.len() * calls).map(|i| question(lobes[i / calls], 49 + (i / calls) as u32)).collect();
    let means: Vec<f64> =
        call(bench, GGX_WEIGHTS, &questions)?.iter().map(|[[mean, ..], _]| f64::from(*mean)).collect();
    let mut findings = Vec::new();
    for (&(alpha, theta), means) in lobes.iter().zip(means.chunks(calls)) {
        let what = format!("albedo at alpha {alpha}, {:.0} degrees", theta.to_degrees());
        let found = Moments::of(means.iter().copied());
        let expected = microfacets::albedo(theta, f64::from(alpha as f32), bench.count(300, 1000));
        findings.push(Finding::mean(&what, expected, &found));
        let limit = 1.0 + 3.0 * found.variance_of_mean().sqrt() + 1e-6;
        findings.push(Finding::at_most(what, limit, found.mean, "1 and three standard errors, 1e-6 for rounding"));
    }
    findings.extend(reciprocity(bench)?);
    let mut random = Random::new(49, 0);
    let tested: &[(f64, f64)] = if bench.count(0, 1) == 0 { &[(0.3, 45.0)] } else { &CHI_SQUARE };
    for &(alpha, degrees) in tested {
        findings.extend(chi_square(bench, &mut random, alpha, degrees)?);
    }
    Ok(findings)
}

/// The value is the same with wo and wi exchanged, and where there is one, directions are drawn: over any two directions above
/// the surface.
fn reciprocity(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut random = Random::new(49, 1);
    let questions: Vec<Arguments> = (0..bench.count(1 << 15, 1 << 20))
        .map(|_| {
            let mut above = || {
                let d = random.direction();
                [d.x, d.y, d.z.abs().max(1e-6)]
            };
            let (wo, wi) = (above(), above());
            [with(wo, 10f32.powf(-3.0 * random.unit())), with(wi, 0.0), [0.0; 4]]
        })
        .collect();
    let (mut asymmetry, mut undrawn) = (Worst::default(), 0);
    for [[value, exchanged, pdf, _], _] in call(bench, GGX_EVALUATE, &questions)? {
        if value > 0.0 {
            asymmetry.add(f64::from((exchanged / value - 1.0).abs()));
        }
        undrawn += u64::from(value.is_nan() || value > 0.0 && (pdf.is_nan() || pdf <= 0.0));
    }
    Ok(vec![
        Finding::at_most("value with wo and wi exchanged, relative difference", 1e-4, asymmetry.0, "the catalogue's"),
        Finding::never("directions with a value that are never drawn", undrawn, questions.len() as u64),
    ])
}

/// Roughnesses and angles whose samples are counted.
const CHI_SQUARE: [(f64, f64); 12] = [
    (0.01, 0.0),
    (0.01, 45.0),
    (0.01, 85.0),
    (0.1, 0.0),
    (0.1, 60.0),
    (0.1, 85.0),
    (0.3, 30.0),
    (0.3, 80.0),
    (0.3, 89.0),
    (1.0, 0.0),
    (1.0, 60.0),
    (1.0, 89.0),
];

/// Samples' microfacet normals against the density of visible normals, and value over density against the weight.
fn chi_square(bench: &TestBench, random: &mut Random, alpha: f64, degrees: f64) -> Result<Vec<Finding>> {
    const CELLS: [usize; 2] = [21, 42];
    let theta = degrees.to_radians();
    let wo = direction(theta, 0.0);
    let questions: Vec<Arguments> = (0..bench.count(1 << 17, 1 << 19))
        .map(|_| [with(wo, alpha as f32), [random.unit(), random.unit(), 0.0, 0.0], [0.0; 4]])
        .collect();
    let (mut counts, mut worst) = (vec![0.0; CELLS[0] * CELLS[1]], Worst::default());
    for [[x, y, z, weight], [pdf, value, same, _]] in call(bench, GGX_SAMPLE, &questions)? {
        let (wo, wi) = (wide(wo), wide([x, y, z]));
        let half: [f64; 3] = std::array::from_fn(|axis| wo[axis] + wi[axis]);
        let [s, t] = microfacets::place(half, f64::from(alpha as f32));
        let [row, column] = [(s, CELLS[0]), (t, CELLS[1])].map(|(v, n)| ((v * n as f64) as usize).min(n - 1));
        counts[row * CELLS[1] + column] += 1.0;
        if weight > 0.0 {
            worst.add(f64::from((value / same / weight - 1.0).abs().max((pdf / same - 1.0).abs())));
        }
    }
    let expected: Vec<f64> = microfacets::visible_normals(theta, f64::from(alpha as f32), CELLS, 16)
        .into_iter()
        .map(|share| share * questions.len() as f64)
        .collect();
    let verdict = chi_square_test(&counts, &expected);
    // h is made of wo + wi again: 2^-22 of it, in units of alpha twice over in D.
    let limit = 1e-4 + 2.4e-7 * 16.0 / alpha;
    Ok(vec![
        Finding {
            what: format!("samples of alpha {alpha} at {degrees} degrees"),
            expected: "density of visible normals".into(),
            got: format!("chi-square {:.1}, p {:.2e}", verdict.statistic, verdict.p),
            tolerance: "p 1e-9: one false alarm in 1e6 suites of 1000 verdicts".into(),
            passes: verdict.p >= 1e-9,
        },
        Finding::at_most(
            format!("value over density against weight, alpha {alpha} at {degrees} degrees"),
            limit,
            worst.0,
            "1e-4, and the rounding of h over alpha",
        ),
    ])
}
