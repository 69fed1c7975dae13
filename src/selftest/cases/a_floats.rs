//! Group A: floats and shader language.

use crate::Result;
use crate::gpu::shaders;
use crate::interface::FILTER_ENTRIES;
use crate::render::startup;
use crate::render::{Guard, Rendered, Tuning};
use crate::scene::{Filter, Scene};
use crate::selftest::cases::directions;
use crate::selftest::kit::draws::falling_variance;
use crate::selftest::kit::faults::{SIDE, causes, emitter, spot_pixel, spotted_wall};
use crate::selftest::kit::furnaces::furnaces;
use crate::selftest::kit::probe_calls::{ProbeCalls, float_probe, pixel};
use crate::selftest::kit::scenes::{SceneBuilder, camera, glass, lambert, mirror};
use crate::selftest::kit::streams;
use crate::selftest::kit::test_bench::plain_settings;
use crate::selftest::{Case, Check, TestBench};
use crate::settings::{Lights, Sampler, Settings};
use crate::statistics::Finding;
use crate::statistics::random::Random;
use crate::texels::Texel;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        number: 1,
        title: "samples that are not numbers",
        meaning: "black or white dots that filters spread",
        check: Check::Run(invalid_samples),
    },
    Case {
        number: 2,
        title: "NaN tests that the driver folds away",
        meaning: "as 1, unnoticed and uncounted",
        check: Check::Run(nan_tests),
    },
    Case {
        number: 3,
        title: "masking hides faults",
        meaning: "energy is lost and nobody sees it",
        check: Check::Run(nothing_to_mask),
    },
    Case {
        number: 4,
        title: "min, max and clamp of NaN",
        meaning: "dots, or darkness that looks right",
        check: Check::Run(lesser_and_greater),
    },
    Case {
        number: 5,
        title: "fma that is not fused",
        meaning: "cancellation errors where none are expected",
        check: Check::Run(fused_or_not),
    },
    Case {
        number: 6,
        title: "compensated sums optimised away",
        meaning: "long renders drift in brightness",
        check: Check::Run(compensated_sum),
    },
    Case {
        number: 7,
        title: "sine and cosine of 11 bits",
        meaning: "directions of wrong length, noise that does not go away",
        check: Check::Run(directions::check),
    },
    Case {
        number: 8,
        title: "loops that the driver ends early",
        meaning: "parts of the picture too dark, without a word",
        check: Check::Run(long_loops),
    },
    Case {
        number: 9,
        title: "floats that become indices",
        meaning: "wild reads, lost devices",
        check: Check::Run(indices),
    },
    Case {
        number: 10,
        title: "sample numbers beyond 2^24",
        meaning: "samples repeat, noise stops falling",
        check: Check::Run(late_samples),
    },
    Case {
        number: 11,
        title: "denormals flushed to zero",
        meaning: "faint light sources go out",
        check: Check::Run(extreme_emission),
    },
];

fn bits(rendered: &Rendered) -> Vec<[u32; 3]> {
    rendered.film.mean().into_iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

fn total(counts: &std::collections::BTreeMap<&'static str, u64>) -> u64 {
    counts.values().sum()
}

/// Three pixels of NaN, +inf and -inf: counted, left out, and nowhere else to be seen. Then each stage in turn is given a
/// NaN, and must be the one that is named.
fn invalid_samples(bench: &TestBench) -> Result<Vec<Finding>> {
    let spots = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(emitter);
    let settings =
        |scene: &Scene| Settings { lights: Lights::Bsdf, max_bounces: 1, ..plain_settings(scene, SIDE, SIDE, 1) };
    let clean = spotted_wall(&[], None);
    let expected = bits(&bench.render(&clean, &settings(&clean))?);
    let scene = spotted_wall(&spots, None);
    let mut findings = Vec::new();
    let rendered = match bench.render(&scene, &settings(&scene)) {
        Ok(rendered) => rendered,
        Err(error) => {
            return Ok(vec![Finding::holds("a picture of NaN, +inf and -inf", "a picture", error.to_string(), false)]);
        }
    };
    let count = |name: &str| rendered.report.invalid_kinds.get(name).copied().unwrap_or(0);
    findings.push(Finding::exact("samples left out as NaN", 1, count("nan")));
    findings.push(Finding::exact("samples left out as infinite", 2, count("infinite")));
    findings.push(Finding::exact("samples left out in all", 3, total(&rendered.report.invalid_kinds)));
    findings.push(Finding::exact("pixels without a sample", 3, rendered.film.empty_pixels()));
    let spot = |index: usize| (0..3).any(|i| spot_pixel(i) == [index as u32 % SIDE, index as u32 / SIDE]);
    let others =
        bits(&rendered).iter().zip(&expected).enumerate().filter(|(index, (a, b))| !spot(*index) && a != b).count();
    findings.push(Finding::never("other pixels changed", others as u64, u64::from(SIDE * SIDE - 3)));
    let ordinary = spotted_wall(&[lambert(0.5, 0.0), mirror(0.5, 0.0), glass(1.5)], None);
    let rendered = bench.render(&ordinary, &plain_settings(&ordinary, SIDE, SIDE, 16))?;
    findings.push(Finding::never(
        "samples left out of an ordinary picture",
        total(&rendered.report.invalid_samples),
        rendered.report.paths,
    ));
    for (cause, scene) in causes() {
        let rendered = bench.render(&scene, &Settings { max_bounces: 2, ..plain_settings(&scene, SIDE, SIDE, 4) })?;
        let named = rendered.report.invalid_samples.get(cause).copied().unwrap_or(0);
        let all = total(&rendered.report.invalid_samples);
        findings.push(Finding::holds(
            format!("samples left out for `{cause}`"),
            "all that are left out",
            format!("{named} of {all}"),
            named == all && all > 0,
        ));
    }
    Ok(findings)
}

fn nan_tests(bench: &TestBench) -> Result<Vec<Finding>> {
    Ok(startup::probe(bench.context())?.iter().filter(|finding| finding.what == "nan").cloned().collect())
}

/// With the check of samples off, a NaN anywhere would reach the film, which refuses it.
fn nothing_to_mask(bench: &TestBench) -> Result<Vec<Finding>> {
    let unmasked = bench.without(Guard::InvalidSamples);
    let mut findings = Vec::new();
    for (name, scene) in furnaces().into_iter().take(bench.count(1, 3)) {
        let settings = Settings { max_bounces: 16, ..plain_settings(&scene, 32, 32, bench.count(16, 256) as u32) };
        let with = bench.render(&scene, &settings)?;
        let pixels = with.film.pixels() as u64;
        findings.push(Finding::never(
            format!("{name}: samples left out"),
            total(&with.report.invalid_samples),
            with.report.paths,
        ));
        findings.push(match unmasked.render(&scene, &settings) {
            Ok(without) => {
                let differ = bits(&with).iter().zip(bits(&without)).filter(|(a, b)| **a != *b).count();
                Finding::never(format!("{name}: pixels that masking changes"), differ as u64, pixels)
            }
            Err(error) => Finding::holds(format!("{name}: unmasked"), "a picture", error.to_string(), false),
        });
    }
    Ok(findings)
}

/// `lesser` and `greater` are comparisons, which are defined for NaN; min, max and clamp are used where no NaN can come.
fn lesser_and_greater(bench: &TestBench) -> Result<Vec<Finding>> {
    let denormal = f32::from_bits(1);
    let values = [f32::NAN, 0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, denormal, 1.0, -2.5, f32::MAX, f32::MIN];
    let pairs: Vec<[f32; 2]> = values.iter().flat_map(|&a| values.map(|b| [a, b])).collect();
    let input: Vec<Texel> = pairs.iter().map(|[a, b]| [a.to_bits(), b.to_bits(), 0, 0]).collect();
    let answers = ProbeCalls { output_texels: 2, ..ProbeCalls::new(float_probe(bench), 0, &input) }.run(bench)?;
    let (mut own, mut plain, mut strange) = (0, 0, 0);
    // A device may take a denormal for 0, as an operand and as a result.
    let flushed = |value: f32| if value == denormal { 0.0 } else { value };
    let same = |bits: u32, value: f32| {
        let got = f32::from_bits(bits);
        flushed(got) == flushed(value) || got.is_nan() && value.is_nan()
    };
    for (&[a, b], answer) in pairs.iter().zip(answers.as_chunks::<2>().0) {
        own +=
            u64::from(!same(answer[1][0], if b < a { b } else { a }) || !same(answer[1][1], if b > a { b } else { a }));
        match a.is_nan() || b.is_nan() {
            false => {
                let right = same(answer[0][0], a.min(b)) && same(answer[0][1], a.max(b));
                plain += u64::from(!right || !same(answer[0][2], a.clamp(0.0, 1.0)));
            }
            true => strange += u64::from((0..2).any(|i| !same(answer[0][i], a) && !same(answer[0][i], b))),
        }
    }
    let clamped = f32::from_bits(answers[0][2]);
    Ok(vec![
        Finding::never("wrong answers of lesser and greater, NaN included", own, pairs.len() as u64),
        Finding::never("wrong answers of min, max and clamp without NaN", plain, pairs.len() as u64),
        Finding::never("min or max with a NaN that is neither operand", strange, pairs.len() as u64),
        Finding::holds("clamp(NaN, 0, 1), recorded", "anything", clamped.to_string(), true),
    ])
}

/// Vulkan's fma may be a product and a sum. The renderer uses none; where the error of a product is needed, Dekker's split
/// gives it.
fn fused_or_not(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut random = Random::new(5, 0);
    let mut factor = || (random.unit() + 1.0) * 2f32.powi(random.below(16) as i32 - 8);
    let pairs: Vec<[f32; 2]> = (0..65_536).map(|_| [factor(), factor()]).collect();
    let input: Vec<Texel> = pairs.iter().map(|[a, b]| [a.to_bits(), b.to_bits(), 0, 0]).collect();
    let answers = ProbeCalls { output_texels: 2, ..ProbeCalls::new(float_probe(bench), 1, &input) }.run(bench)?;
    let (mut fused, mut split, mut neither, mut dekker) = (0, 0, 0, 0);
    for (&[a, b], answer) in pairs.iter().zip(answers.as_chunks::<2>().0) {
        let product = a * b;
        let error = (f64::from(a) * f64::from(b) - f64::from(product)) as f32;
        let got = f32::from_bits(answer[0][1]);
        fused += u64::from(got == error);
        split += u64::from(got == 0.0 && error != 0.0);
        neither += u64::from(got != error && got != 0.0);
        dekker += u64::from(f32::from_bits(answer[0][0]) != product || f32::from_bits(answer[0][2]) != error);
    }
    let count = pairs.len() as u64;
    let kind = if split == 0 { "fused" } else { "a product and a sum" };
    Ok(vec![
        Finding::never("products whose error Dekker's split misses", dekker, count),
        Finding::never("fma that is neither fused nor a product and a sum", neither, count),
        Finding::holds("fma on this device, recorded", "either", format!("{kind} ({fused} of {count} exact)"), true),
    ])
}

/// 10^7 numbers in one f32 with compensation. Kahan's bound is 2u + n u^2 of the sum of magnitudes: 1.2e-7 + 3.6e-8 for
/// n = 10^7.
fn compensated_sum(bench: &TestBench) -> Result<Vec<Finding>> {
    let dispatches = bench.count(16, 160) as u32;
    let count = dispatches * streams::STEPS;
    let sums = streams::compensated(bench, shaders::PROBE_SUMS, dispatches)?;
    let findings = sums.iter().enumerate().map(|(stream, &sum)| {
        let exact = streams::sum(stream as u32, count);
        let what = format!("compensated sum of {count} numbers, {}", streams::NAMES[stream]);
        Finding::relative(what, exact, f64::from(sum), 1.6e-7, "Kahan's bound")
    });
    Ok(findings.collect())
}

/// The driver's limit is measured; a path of forty bounces between mirrors past ten thousand triangles does not see it.
fn long_loops(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings: Vec<_> =
        startup::probe(bench.context())?.iter().filter(|finding| finding.what == "loops").cloned().collect();
    let mut builder = SceneBuilder::new();
    let [mirrors, walls, body, light] = [mirror(0.95, 0.0), lambert(0.5, 0.0), lambert(0.7, 0.0), lambert(0.0, 5.0)]
        .map(|material| builder.material(material));
    builder.cuboid([-0.5, -1.0, -5.0], [0.5, 1.0, 5.0], walls, true);
    builder.quad([-0.45, -0.9, -4.9], [0.0, 0.0, 9.8], [0.0, 1.8, 0.0], mirrors);
    builder.quad([0.45, -0.9, -4.9], [0.0, 0.0, 9.8], [0.0, 1.8, 0.0], mirrors);
    builder.quad([-0.3, 0.95, -2.0], [0.6, 0.0, 0.0], [0.0, 0.0, 4.0], light);
    builder.sphere([0.0, -0.2, 0.0], 0.3, 5, body, false);
    builder.sphere([0.0, -0.2, 2.0], 0.3, 4, body, false);
    let scene = builder.finish(camera([-0.3, 0.1, -4.0], [0.4, 0.0, -3.0], 60.0), None);
    let size = bench.count(16, 32) as u32;
    let settings = Settings { max_bounces: 40, ..plain_settings(&scene, size, size, 8) };
    let mut reference: Option<Vec<[u32; 3]>> = None;
    for (run, budget) in [(8, None), (1, None), (2, Some(64)), (4, Some(8191)), (8, Some(1000))] {
        let tuning = Tuning { run_samples: Some(run), budget, ..Tuning::default() };
        let picture = bits(&bench.render_tuned(&scene, &settings, &tuning)?);
        let reference = reference.get_or_insert_with(|| picture.clone());
        let differ = picture.iter().zip(reference.iter()).filter(|(a, b)| a != b).count() as u64;
        let budget = budget.map_or("the clock's".to_owned(), |budget| budget.to_string());
        let what = format!("pixels that differ at {run} samples a run, budget {budget}");
        findings.push(Finding::never(what, differ, u64::from(size * size)));
    }
    Ok(findings)
}

/// What a float becomes as an index: within the table for 0, the largest number below 1, 1 itself, NaN and numbers far
/// beyond.
fn indices(bench: &TestBench) -> Result<Vec<Finding>> {
    let ends = [0.0, 1.0 - 2f32.powi(-24), 1.0, f32::NAN, f32::INFINITY, -1.0, 1e20, f32::NEG_INFINITY];
    let input: Vec<Texel> = ends.iter().map(|u| [(u * (FILTER_ENTRIES - 1) as f32).to_bits(), 0, 0, 0]).collect();
    let calls =
        ProbeCalls { output_texels: 2, filter: Filter::Gaussian, ..ProbeCalls::new(float_probe(bench), 2, &input) };
    let answers = calls.run(bench)?;
    let entries: Vec<u32> = answers.as_chunks::<2>().0.iter().map(|answer| answer[0][0]).collect();
    let outside = entries.iter().filter(|&&entry| entry > FILTER_ENTRIES - 2).count();
    let mut findings = vec![Finding::never("indices outside the table", outside as u64, entries.len() as u64)];
    for (u, entry) in [(0, 0), (2, FILTER_ENTRIES - 2)] {
        findings.push(Finding::exact(format!("entry of {}", ends[u]), entry, entries[u]));
    }
    Ok(findings)
}

/// Sample numbers around 2^16, 2^24 and 2^31 draw numbers of their own, and noise falls on where 16 bits would wrap.
fn late_samples(bench: &TestBench) -> Result<Vec<Finding>> {
    const INDICES: [u32; 8] = [65_535, 65_536, (1 << 24) - 1, 1 << 24, (1 << 24) + 1, (1 << 31) - 1, 1 << 31, u32::MAX];
    const PIXELS: u32 = 256;
    let mut findings = Vec::new();
    for sampler in [Sampler::Sobol, Sampler::Independent] {
        let input: Vec<Texel> =
            INDICES.iter().flat_map(|&index| (0..PIXELS).map(move |i| [pixel(i, 16), index, 0, 0])).collect();
        let answers = ProbeCalls { sampler, ..ProbeCalls::new(shaders::PROBE_SAMPLING, 0, &input) }.run(bench)?;
        let pictures: Vec<_> = answers.chunks_exact(PIXELS as usize).collect();
        let mut equal = 0;
        for (i, a) in pictures.iter().enumerate() {
            for b in &pictures[..i] {
                // By the 24 bits that a float keeps, of both numbers.
                equal += a.iter().zip(b.iter()).filter(|(a, b)| (0..2).all(|d| a[d] >> 8 == b[d] >> 8)).count() as u64;
            }
        }
        let pairs = (INDICES.len() * (INDICES.len() - 1) / 2) as u64 * u64::from(PIXELS);
        findings.push(Finding::never(format!("{sampler:?}: equal points of two late samples"), equal, pairs));
    }
    findings.push(falling_variance(bench)?);
    Ok(findings)
}

/// A furnace of 1/2 that emits 1e-30, 1 or 1e30: emission is scaled by a power of two on the host, so nothing is near a
/// denormal. 8 bounces: 2 - 2^-8.
fn extreme_emission(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for emission in [1e-30f32, 1.0, 1e30] {
        let mut builder = SceneBuilder::new();
        let walls = builder.material(lambert(0.5, emission));
        builder.cuboid([-1.0; 3], [1.0; 3], walls, true);
        let scene = builder.finish(camera([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 70.0), None);
        let settings = Settings { lights: Lights::Bsdf, max_bounces: 8, ..plain_settings(&scene, 16, 16, 4) };
        let rendered = bench.render(&scene, &settings)?;
        let expected = 2.0 - 2f64.powi(-8);
        let values = rendered.film.mean().into_iter().flatten().map(|value| f64::from(value) / f64::from(emission));
        // The farthest from what is expected; a NaN is the farthest of all.
        let farther = |a: f64, b: f64| if (b - expected).abs() <= (a - expected).abs() { a } else { b };
        let value = values.fold(expected, farther);
        let what = format!("farthest pixel of a furnace that emits {emission:e}, over its emission");
        findings.push(Finding::relative(what, expected, value, 1e-5, "roundings of 9 terms, each below 1e-6"));
        findings.push(Finding::never(
            "samples left out",
            total(&rendered.report.invalid_samples),
            rendered.report.paths,
        ));
    }
    Ok(findings)
}
