//! Group G: sums, random numbers, transport.

use std::collections::HashSet;

use crate::Result;
use crate::film::{Film, PixelSum, replicate_of_block};
use crate::gpu::shaders;
use crate::interface::BLOCK_SAMPLES;
use crate::output::{Display, Tonemap};
use crate::render::Guard;
use crate::render::bounce_cap::cap_bias;
use crate::selftest::cases::{light_trees, roulette};
use crate::selftest::kit::draws::{correlation, pairs, scatter_of_means, unit};
use crate::selftest::kit::furnaces::{furnace, mean, series};
use crate::selftest::kit::probe_calls::{ProbeCalls, float_probe, pixel};
use crate::selftest::kit::scenes::{SceneBuilder, camera, lambert};
use crate::selftest::kit::streams;
use crate::selftest::kit::test_bench::{Silent, plain_settings};
use crate::selftest::{Case, Check, TestBench, Tier};
use crate::settings::{Lights, Roulette, Sampler, Settings};
use crate::statistics::Finding;
use crate::statistics::finding::VERDICTS;
use crate::statistics::random::Random;
use crate::statistics::{Moments, chi_square_test};
use crate::texels::Texel;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        number: 58,
        title: "sums of many samples",
        meaning: "long renders drift in brightness",
        check: Check::Run(long_sums),
    },
    Case {
        number: 59,
        title: "variances from sums of squares",
        meaning: "error estimates of zero or below",
        check: Check::Run(variances),
    },
    Case {
        number: 60,
        title: "merging partial films",
        meaning: "merged pictures of the wrong brightness",
        check: Check::Run(partial_films),
    },
    Case {
        number: 61,
        title: "random numbers of exactly 1 or 0",
        meaning: "rare NaN, infinite directions",
        check: Check::Run(ends_of_the_unit_interval),
    },
    Case {
        number: 62,
        title: "random streams that collide",
        meaning: "noise that does not go away, patterns",
        check: Check::Run(colliding_streams),
    },
    Case {
        number: 63,
        title: "more dimensions, or samples, than the sequence has",
        meaning: "patterns after many bounces",
        check: Check::Run(late_dimensions),
    },
    Case {
        number: 64,
        title: "the same numbers at every bounce",
        meaning: "wrong brightness between mirrors",
        check: Check::Run(dimensions_of_a_bounce),
    },
    Case {
        number: 65,
        title: "Russian roulette at its ends",
        meaning: "fireflies or a dark bias",
        check: Check::Run(roulette::check),
    },
    Case {
        number: 66,
        title: "the bias of the bounce cap",
        meaning: "dark pictures without a warning",
        check: Check::Run(bounce_cap),
    },
    Case {
        number: 67,
        title: "fireflies",
        meaning: "clamped pictures that are too dark",
        check: Check::Run(fireflies),
    },
    Case {
        number: 68,
        title: "very bright and very faint emission together",
        meaning: "faint parts lost",
        check: Check::Run(bright_and_faint),
    },
    Case {
        number: 69,
        title: "tone mapping of 0, infinity and negative numbers",
        meaning: "broken pixels in PNG files",
        check: Check::Run(tone_maps),
    },
];

/// 10^7 samples a pixel through what a render does: blocks of 16 in f32 on the device, closed blocks in the film.
fn long_sums(bench: &TestBench) -> Result<Vec<Finding>> {
    let blocks = bench.count(62_500, 625_000) as u32;
    let sums = streams::blocks(bench, blocks)?;
    let mut film = Film::new(1, 1, 4, 0)?;
    let mut naive = [0f32; 3];
    for (block, sum) in sums.iter().enumerate() {
        film.add_block(replicate_of_block(block as u32, 4), [0, 0, 1, 1], &[*sum])?;
        for (naive, bits) in naive.iter_mut().zip(sum) {
            *naive += f32::from_bits(*bits);
        }
    }
    let count = blocks * BLOCK_SAMPLES;
    // Without the guard the film is what a sum in f32 would be.
    let mean = match bench.has(Guard::CompensatedSum) {
        true => film.mean()[0],
        false => naive.map(|sum| sum / count as f32),
    };
    let mut findings = Vec::new();
    for (stream, mean) in mean.into_iter().enumerate() {
        let exact = streams::sum(stream as u32, count) / f64::from(count);
        let what = format!("mean of {count} samples, {}", streams::NAMES[stream]);
        let why = "required; a block's sum in f32 is off by at most 15 roundings of 6e-8";
        findings.push(Finding::relative(what, exact, f64::from(mean), 1e-6, why));
    }
    Ok(findings)
}

/// Replicate means in f64: exactly 0 for a constant, unbiased for uniform numbers.
fn variances(_bench: &TestBench) -> Result<Vec<Finding>> {
    const REPLICATES: u32 = 64;
    let (width, height) = (96, 64);
    let pixels = width * height;
    let all = [0, 0, width, height];
    let mut constant = Film::new(width, height, 4, 0)?;
    let mut uniform = Film::new(width, height, REPLICATES, 0)?;
    let mut random = Random::new(59, 0);
    let sum_of = |mut sample: Box<dyn FnMut() -> f32 + '_>| -> PixelSum {
        let bits = (0..BLOCK_SAMPLES).fold(0.0f32, |sum, _| sum + sample()).to_bits();
        [bits, bits, bits, BLOCK_SAMPLES]
    };
    for block in 0..REPLICATES {
        let sums: Vec<_> = (0..pixels).map(|pixel| sum_of(Box::new(move || 0.1 * (pixel + 1) as f32))).collect();
        constant.add_block(replicate_of_block(block, 4), all, &sums)?;
        let sums: Vec<_> = (0..pixels).map(|_| sum_of(Box::new(|| random.unit()))).collect();
        uniform.add_block(block, all, &sums)?;
    }
    let constant = constant.estimate();
    let nonzero = constant.variance.iter().flatten().filter(|&&variance| variance != 0.0).count();
    let uniform = uniform.estimate();
    let negative = uniform.variance.iter().flatten().filter(|&&variance| variance < 0.0).count();
    let samples = f64::from(REPLICATES * BLOCK_SAMPLES);
    let variance = uniform.variance.iter().map(|variance| variance[0]).sum::<f64>() / f64::from(pixels) * samples;
    Ok(vec![
        Finding::never("variances of constants that are not 0", nonzero as u64, u64::from(3 * pixels)),
        Finding::never("negative variances", negative as u64, u64::from(3 * pixels)),
        Finding::relative(
            "variance of a uniform number",
            1.0 / 12.0,
            variance,
            0.01,
            "required; the standard error of 6,144 estimates of 63 degrees of freedom is 0.0023",
        ),
    ])
}

/// A film gets its blocks in any order and in any number of parts; integers do not mind.
fn partial_films(_bench: &TestBench) -> Result<Vec<Finding>> {
    const BLOCKS: usize = 1001;
    let mut random = Random::new(60, 0);
    let mut value = || (random.unit() * 2f32.powi(random.below(40) as i32 - 20)).to_bits();
    let blocks: Vec<Vec<PixelSum>> =
        (0..BLOCKS).map(|_| (0..6).map(|_| [value(), value(), value(), BLOCK_SAMPLES]).collect()).collect();
    let mut pictures = Vec::new();
    for parts in [1, 7, BLOCKS] {
        let mut film = Film::new(3, 2, 4, 0)?;
        for part in (0..parts).rev() {
            for block in (part..BLOCKS).step_by(parts) {
                let replicate = replicate_of_block(block as u32, 4);
                // Every other part comes in two halves.
                match part % 2 {
                    0 => film.add_block(replicate, [0, 0, 3, 2], &blocks[block])?,
                    _ => {
                        film.add_block(replicate, [0, 1, 3, 1], &blocks[block][3..])?;
                        film.add_block(replicate, [0, 0, 3, 1], &blocks[block][..3])?;
                    }
                }
            }
        }
        pictures.push(film.estimate());
    }
    let differ = pictures.iter().filter(|&picture| *picture != pictures[0]).count();
    Ok(vec![Finding::never("films of 7 and 1001 parts that differ from the whole", differ as u64, 2)])
}

/// Every float that a word can become is below 1, and warps of the ends of the unit interval are directions.
fn ends_of_the_unit_interval(bench: &TestBench) -> Result<Vec<Finding>> {
    const PART: u32 = 4096;
    let input: Vec<Texel> = (0..(1 << 24) / PART).map(|part| [part * PART, PART, 0, 0]).collect();
    let answers = ProbeCalls { output_texels: 2, ..ProbeCalls::new(float_probe(bench), 3, &input) }.run(bench)?;
    let answers = || answers.iter().step_by(2);
    let largest = answers().map(|answer| f32::from_bits(answer[0])).fold(0.0, f32::max);
    let reach = answers().map(|answer| u64::from(answer[1])).sum::<u64>();
    let wrong = answers().map(|answer| u64::from(answer[2])).sum::<u64>();
    let mut findings = vec![
        Finding::exact("largest of all random floats", 1.0 - 2f64.powi(-24), f64::from(largest)),
        Finding::never("random floats that reach 1", reach, 1 << 24),
        Finding::never("random floats other than the word's 24 bits", wrong, 1 << 24),
    ];
    findings.push(places_in_shares(bench)?);
    findings.push(light_trees::places_in_words(bench)?);
    let ends = [0.0, 2f32.powi(-24), 0.25, 0.5, 0.5 + 2f32.powi(-24), 1.0 - 2f32.powi(-24)];
    let input: Vec<Texel> = ends.iter().flat_map(|&u| ends.map(|v: f32| [u.to_bits(), v.to_bits(), 0, 0])).collect();
    for (function, name) in [(2, "cosine hemisphere"), (3, "uniform hemisphere"), (4, "triangle")] {
        let answers = ProbeCalls::new(shaders::PROBE_SAMPLING, function, &input).run(bench)?;
        let wrong = answers.iter().filter(|answer| {
            let [x, y, z, _] = answer.map(|bits| f64::from(f32::from_bits(bits)));
            let sound = match function {
                4 => x >= 0.0 && y >= 0.0 && x + y <= 1.0 + 1e-6,
                // At the horizon, a chance of 2^-23, the density is 0: sample_lambert leaves it out.
                _ => (x * x + y * y + z * z - 1.0).abs() <= 1e-6 && z >= 0.0,
            };
            !sound
        });
        findings.push(Finding::never(format!("{name}: unsound at the ends"), wrong.count() as u64, input.len() as u64));
    }
    Ok(findings)
}

/// A number that chose a light has a place below 1 in the light's share: the ends of shares of every size, at either end of all
/// numbers.
fn places_in_shares(bench: &TestBench) -> Result<Finding> {
    let sizes = (0..=32).flat_map(|exponent| [1u64 << exponent, (1 << exponent) - 1]).filter(|&size| size > 0);
    let input: Vec<Texel> = sizes
        .flat_map(|size| {
            let scale = (1.0 / size as f32).to_bits();
            let last_share = ((1 << 32) - size) as u32;
            [0, last_share].into_iter().flat_map(move |first| {
                [0, size / 2, size - 1].map(|offset| [first.wrapping_add(offset as u32), first, scale, 0])
            })
        })
        .collect();
    let answers = ProbeCalls::new(shaders::PROBE_SAMPLING, 11, &input).run(bench)?;
    let outside = answers.iter().filter(|answer| !(0.0..1.0).contains(&f32::from_bits(answer[0]))).count();
    Ok(Finding::never("places in a light's share outside [0, 1)", outside as u64, input.len() as u64))
}

/// Numbers of neighbouring pixels, samples and dimensions are independent, down to the lowest bits; means of up to 2^20 of
/// them scatter as they should.
fn colliding_streams(bench: &TestBench) -> Result<Vec<Finding>> {
    const SIDE: usize = 256;
    let count = SIDE * SIDE;
    let mut findings = Vec::new();
    for sampler in [Sampler::Sobol, Sampler::Independent] {
        let draw = |index, pair| pairs(bench, sampler, (0..count).map(|i| [pixel(i as u32, SIDE as u32), index, pair]));
        let (first, second) = (draw(0, 0)?, draw(0, 1)?);
        let at = |i: usize| unit(first[i][0]);
        let name = |what: &str| format!("{sampler:?}: correlation {what}");
        let right = (0..count).filter(|i| (i + 1) % SIDE != 0).map(|i| (at(i), at(i + 1)));
        findings.push(correlation(name("with the pixel to the right"), right));
        findings.push(correlation(name("with the pixel below"), (SIDE..count).map(|i| (at(i), at(i - SIDE)))));
        findings.push(correlation(name("within a pair"), first.iter().map(|[a, b, ..]| (unit(*a), unit(*b)))));
        findings.push(correlation(name("with the next pair"), (0..count).map(|i| (at(i), unit(second[i][0])))));
        if sampler == Sampler::Independent {
            let next = draw(1, 0)?;
            findings.push(correlation(name("with the next sample"), (0..count).map(|i| (at(i), unit(next[i][0])))));
            for dimension in 0..2 {
                let mut counts = [0.0; 256];
                first.iter().for_each(|words| counts[(words[dimension] & 255) as usize] += 1.0);
                let verdict = chi_square_test(&counts, &[count as f64 / 256.0; 256]);
                findings.push(Finding::holds(
                    format!("lowest byte of word {dimension}, chi-square of 255"),
                    "p above 1e-9",
                    format!("{:.1}, p {:.1e}", verdict.statistic, verdict.p),
                    verdict.passes(VERDICTS),
                ));
            }
        }
    }
    findings.extend(scatter_of_means(bench)?);
    Ok(findings)
}

/// Any bounce up to 65,535 and any sample up to 2^32 - 1 has numbers of its own: hashes, not a table that ends.
fn late_dimensions(bench: &TestBench) -> Result<Vec<Finding>> {
    const PIXELS: u32 = 4096;
    let mut findings = Vec::new();
    for sampler in [Sampler::Sobol, Sampler::Independent] {
        let mut seen = HashSet::new();
        let streams: [(u32, u32); 5] =
            [(0, 0), (u32::MAX, 0), (0, 4 * 65_535 + 3), (u32::MAX, 4 * 65_535 + 3), (0, 4 * 1024)];
        for (index, pair) in streams {
            let draws = pairs(bench, sampler, (0..PIXELS).map(|i| [pixel(i, 64), index, pair]))?;
            let numbers = Moments::of(draws.iter().map(|words| unit(words[0])));
            let what = format!("{sampler:?}: mean of sample {index}, pair {pair}");
            findings.push(Finding::z(what, 0.5, numbers.mean, 1.0 / 12.0 / f64::from(PIXELS)));
            seen.extend(draws.iter().map(|words| [words[0] >> 8, words[1] >> 8]));
        }
        let all = streams.len() as u64 * u64::from(PIXELS);
        // 20,480 points of 2^48: a chance of 7e-7 that two are equal.
        findings.push(Finding::never(format!("{sampler:?}: equal points"), all - seen.len() as u64, all));
    }
    Ok(findings)
}

/// Each bounce draws numbers of its own: a box of diffuse walls and two mirrors has the brightness of its geometric series,
/// also where roulette must be decided anew at every bounce.
fn dimensions_of_a_bounce(bench: &TestBench) -> Result<Vec<Finding>> {
    let scene = furnace(0.5, true);
    let mut findings = Vec::new();
    let spp = bench.count(16, 128) as u32;
    let depths: Vec<u32> = if bench.tier() == Tier::Fast { vec![1, 4, 16] } else { (1..=16).collect() };
    for max_bounces in depths {
        // Roulette of depth k keeps 0.8^k of the paths; where numbers came again it would keep 0.8 of them.
        for (roulette, name) in [(Roulette::Off, "no roulette"), (Roulette::Fixed(0.8), "roulette 0.8")] {
            let settings = Settings { max_bounces, roulette, ..plain_settings(&scene, 32, 32, spp) };
            let what = format!("diffuse box with two mirrors, {max_bounces} bounces, {name}");
            findings.push(mean(bench, what, &scene, &settings, series(0.5, max_bounces))?);
        }
    }
    Ok(findings)
}

/// Energy beyond the cap is missing, as much as the series says, and the report of the bias says so.
fn bounce_cap(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for (albedo, expected) in [(0.5f32, 1.996_093_75), (0.8, 4.328_911_36)] {
        let scene = furnace(albedo, false);
        let exact = Settings { lights: Lights::Bsdf, max_bounces: 8, ..plain_settings(&scene, 8, 8, 1) };
        let pixel = f64::from(bench.render(&scene, &exact)?.film.mean()[0][0]);
        let what = format!("furnace {albedo} capped at 8 bounces, BSDF samples alone");
        findings.push(Finding::relative(what, expected, pixel, 2e-6, "9 products and sums, each rounded by 6e-8"));
        let settings = Settings { max_bounces: 8, ..plain_settings(&scene, 32, 32, bench.count(32, 512) as u32) };
        let what = format!("furnace {albedo} capped at 8 bounces, light samples");
        findings.push(mean(bench, what, &scene, &settings, expected)?);
        if let Some(bias) = cap_bias(bench.context(), &scene, &settings, None, &mut Silent)? {
            let what = format!("furnace {albedo} capped at 8 bounces, share cut off as reported");
            let whole = 1.0 / (1.0 - f64::from(albedo));
            findings.push(Finding::z(what, 1.0 - expected / whole, bias.bounce_cap, bias.standard_error.powi(2)));
        }
    }
    Ok(findings)
}

/// A small light of radiance 10^4, found by chance: every sample is 0 or all of it, none is clamped, and the mean is right.
fn fireflies(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut builder = SceneBuilder::new();
    let [floor, lamp] = [lambert(0.5, 0.0), lambert(0.0, 1e4)].map(|material| builder.material(material));
    builder.quad([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], floor);
    builder.quad([-0.1, 1.0, -0.1], [0.2, 0.0, 0.0], [0.0, 0.0, 0.2], lamp);
    let scene = builder.finish(camera([0.9, 0.5, 0.0], [0.0; 3], 0.01), None);
    let settings = Settings { lights: Lights::Bsdf, max_bounces: 1, ..plain_settings(&scene, 64, 64, 1) };
    let picture = bench.render(&scene, &settings)?.film.mean();
    let other = picture.iter().flatten().filter(|&&value| value != 0.0 && value != 5000.0).count();
    let largest = picture.iter().flatten().fold(0.0f32, |a, &b| a.max(b));
    let settings = Settings { spp: bench.count(16, 64) as u32, seed: 1, ..settings };
    // A square of half side 0.1 at height 1, seen from below its centre: four corners of 0.1 x 0.1.
    let root = (1.0f64 + 0.01).sqrt();
    let factor = 4.0 / std::f64::consts::PI * (0.1 / root) * (0.1 / root).atan();
    Ok(vec![
        Finding::exact("largest sample", 5000.0, largest),
        Finding::never("samples that are neither 0 nor 5,000", other as u64, 3 * 64 * 64),
        mean(bench, "mean under the lamp".into(), &scene, &settings, 5000.0 * factor)?,
    ])
}

/// Two closed boxes apart that emit 1e10 and 1e-10: both as bright as they should be, in one film's units.
fn bright_and_faint(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for (x, emission) in [(-3.0, 1e10f32), (3.0, 1e-10)] {
        let mut builder = SceneBuilder::new();
        for (x, emission) in [(-3.0, 1e10), (3.0, 1e-10)] {
            let walls = builder.material(lambert(0.5, emission));
            builder.cuboid([x - 1.0, -1.0, -1.0], [x + 1.0, 1.0, 1.0], walls, true);
        }
        let scene = builder.finish(camera([x, 0.2, 0.3], [x + 0.5, 0.0, 1.0], 70.0), None);
        let settings = Settings { lights: Lights::Bsdf, max_bounces: 8, ..plain_settings(&scene, 8, 8, 32) };
        let picture = bench.render(&scene, &settings)?.film.mean();
        let expected = f64::from(emission) * series(0.5, 8);
        let farther = |a: f64, b: f64| if (b - expected).abs() <= (a - expected).abs() { a } else { b };
        let value = picture.iter().flatten().map(|&value| f64::from(value)).fold(expected, farther);
        let what = format!("farthest pixel of the box that emits {emission:e}");
        let why = "required; a block of the faint one is 4.6e5 units of the film";
        findings.push(Finding::relative(what, expected, value, 1e-4, why));
    }
    Ok(findings)
}

/// 0, infinity, negative numbers and NaN become bytes: black, or white where they are bright.
fn tone_maps(_bench: &TestBench) -> Result<Vec<Finding>> {
    let (mut wrong, mut trials) = (0, 0);
    for tonemap in [Tonemap::None, Tonemap::Reinhard, Tonemap::Aces] {
        for exposure_stops in [0.0, -100.0, 100.0] {
            let display = Display { exposure_stops, tonemap };
            let mut expect = |value: f32, byte: u8| {
                trials += 1;
                wrong += u64::from(display.bytes([value; 3]) != [byte; 3]);
            };
            [0.0, -0.0, -1e-9, -1e38, f32::NEG_INFINITY, f32::NAN].into_iter().for_each(|value| expect(value, 0));
            expect(f32::INFINITY, 255);
            if exposure_stops >= 0.0 {
                expect(1e38, 255);
            }
        }
    }
    Ok(vec![Finding::never("wrong bytes", wrong, trials)])
}
