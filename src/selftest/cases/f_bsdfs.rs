//! Group F: scattering.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::Result;
use crate::scene::Material;
use crate::selftest::cases::lobes;
use crate::selftest::cases::lobes::{direction, wide, with};
use crate::selftest::kit::scattering::{
    Arguments, FRESNEL, GLASS, MAKE_BASIS, Measured, REFRACTION, call, call_sampling, measure, smooth_settings,
};
use crate::selftest::kit::scenes::{SceneBuilder, camera, glass, lambert};
use crate::selftest::{Case, Check, TestBench};
use crate::settings::{Lights, Settings};
use crate::statistics::Finding;
use crate::statistics::Worst;
use crate::statistics::random::Random;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        number: 47,
        title: "roughness near zero",
        meaning: "dark or burnt-out metal",
        check: Check::Run(lobes::distribution),
    },
    Case {
        number: 48,
        title: "grazing angles",
        meaning: "fireflies at silhouettes",
        check: Check::Run(lobes::grazing_weights),
    },
    Case {
        number: 49,
        title: "energy gained or lost",
        meaning: "surfaces that glow or darken by themselves",
        check: Check::Run(lobes::lossless_lobe),
    },
    Case {
        number: 50,
        title: "Fresnel near the critical angle",
        meaning: "a wrong rim of total reflection",
        check: Check::Run(fresnel),
    },
    Case {
        number: 51,
        title: "refraction at total reflection",
        meaning: "NaN in glass",
        check: Check::Run(total_reflection),
    },
    Case {
        number: 52,
        title: "many bounces in a glass slab",
        meaning: "windows of the wrong tint",
        check: Check::Run(slab),
    },
    Case {
        number: 53,
        title: "the scaling of radiance by eta^2",
        meaning: "views from inside glass too dark",
        check: Check::Run(radiance_scale),
    },
    Case {
        number: 54,
        title: "nested, equal and extreme indices of refraction",
        meaning: "NaN or ghosts at matched indices",
        check: Check::Run(nested_glass),
    },
    Case {
        number: 55,
        title: "bases near -z",
        meaning: "directions askew on surfaces that face down",
        check: Check::Run(bases),
    },
    Case {
        number: 56,
        title: "albedo 0, 1 and beyond",
        meaning: "endless or exploding paths",
        check: Check::Run(albedos),
    },
    Case {
        number: 57,
        title: "lobes of probability 0 or 1",
        meaning: "NaN in mixtures",
        check: Check::Run(certain_lobes),
    },
];

/// Fresnel's equations in f64: reflectance, squared cosine of refraction.
fn reflectance(cosine: f64, eta: f64) -> (f64, f64) {
    let beyond2 = 1.0 - (1.0 - cosine) * (1.0 + cosine) / (eta * eta);
    if beyond2 <= 0.0 {
        return (1.0, beyond2);
    }
    let beyond = beyond2.sqrt();
    let parallel = (eta * cosine - beyond) / (eta * cosine + beyond);
    let perpendicular = (cosine - eta * beyond) / (cosine + eta * beyond);
    ((parallel * parallel + perpendicular * perpendicular) / 2.0, beyond2)
}

fn fresnel(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let known = [(0.0f64, 0.04), (45.0, 0.0502399), (56.3099, 0.0739645)];
    let questions = known.map(|(degrees, _)| [degrees.to_radians().cos() as f32, 1.5, 0.0, 0.0]);
    let why = "the cosine's rounding of 2^-24 moves it by less";
    for ((degrees, expected), [found, ..]) in known.into_iter().zip(call_sampling(bench, FRESNEL, &questions)?) {
        let what = format!("reflectance of 1.5 at {degrees} degrees");
        findings.push(Finding::relative(what, expected, f64::from(found), 1e-5, why));
    }
    let parts = bench.count(1 << 16, 1 << 18);
    for (eta, mean) in [(1.5f32, 0.0917780), (1.0 / 1.5, 0.5963457)] {
        let part = |i: usize| [((i as f64 + 0.5) / parts as f64).sqrt() as f32, eta, 0.0, 0.0];
        let found = call_sampling(bench, FRESNEL, &(0..parts).map(part).collect::<Vec<_>>())?;
        let found = found.iter().map(|answer| f64::from(answer[0])).sum::<f64>() / parts as f64;
        let why = "seven digits known, and equal parts of the squared cosine";
        findings.push(Finding::relative(format!("hemispherical mean for {eta}"), mean, found, 1e-5, why));
    }
    // Squared cosines of refraction around the critical angle: 1 - sin² / eta² errs by the roundings of sin² / eta² near 1.
    let mut random = Random::new(50, 0);
    for eta in [1.0f32 / 1.5, 1.0 / 2.4, 0.1, 0.01] {
        let critical = f64::from(eta).asin();
        let questions: Vec<[f32; 4]> = (0..bench.count(1 << 12, 1 << 16))
            .map(|_| {
                let angle = critical - 10f64.powf(-7.0 * random.next()) * critical;
                [angle.cos() as f32, eta, 0.0, 0.0]
            })
            .collect();
        let mut worst = Worst::default();
        for ([cosine, ..], [_, refracted, ..]) in questions.iter().zip(call_sampling(bench, FRESNEL, &questions)?) {
            let (_, expected) = reflectance(f64::from(*cosine), f64::from(eta));
            worst.add((f64::from(refracted).powi(2) - expected.max(0.0)).abs());
        }
        let what = format!("squared cosine of refraction up to the critical angle of {eta}, error");
        findings.push(Finding::at_most(what, 1e-6, worst.0, "eight roundings of 2^-24 of numbers near 1"));
    }
    Ok(findings)
}

/// Around the critical angle: directions are finite and unit, Snell's law holds, beyond it everything is reflected.
fn total_reflection(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut random = Random::new(51, 0);
    let eta = 1.0f32 / 1.5;
    let critical = f64::from(eta).asin();
    let questions: Vec<Arguments> = (0..bench.count(1 << 16, 1 << 20))
        .map(|i| {
            // Half within 1e-5 of the critical angle, half anywhere up to grazing.
            let theta =
                if i % 2 == 0 { critical + 1e-5 * (2.0 * random.next() - 1.0) } else { FRAC_PI_2 * random.next() };
            [with(direction(theta, TAU * random.next()), eta), [0.0; 4], [0.0; 4]]
        })
        .collect();
    let (mut lengths, mut sines, mut wrong, mut transmitted) = (Worst::default(), Worst::default(), 0, 0u64);
    for ([[x, y, z, _], ..], [[a, b, c, found], [cos_t, ..]]) in
        questions.iter().zip(call(bench, REFRACTION, &questions)?)
    {
        let ([x, y, z], [a, b, c]) = (wide([*x, *y, *z]), wide([a, b, c]));
        let beyond2 = reflectance(z, f64::from(eta)).1;
        wrong += u64::from(!(0.0..=1.0).contains(&found) || !(0.0..=1.0).contains(&cos_t));
        // The squared sine over eta² errs by up to 1e-6: on which side of 1 it falls is open within that.
        wrong += u64::from(beyond2 < -1e-6 && (found != 1.0 || cos_t != 0.0));
        wrong += u64::from(beyond2 > 1e-6 && (found >= 1.0 || cos_t <= 0.0));
        if found < 1.0 {
            transmitted += 1;
            lengths.add((a * a + b * b + c * c - 1.0).abs());
            let across = x.hypot(y) / f64::from(eta);
            // Beside the normal the sine is as small as the roundings of 1.
            sines.add((a.hypot(b) - across).abs() / across.max(1e-2));
        }
    }
    let trials = questions.len() as u64;
    Ok(vec![
        Finding::never("reflectances outside [0, 1], or total reflection on the wrong side", wrong, trials),
        Finding::holds("rays that go through", "some", transmitted.to_string(), transmitted > trials / 4),
        Finding::at_most("refracted directions, | |d|^2 - 1 |", 1e-6, lengths.0, "a normalised vector: 6 roundings"),
        Finding::at_most(
            "sine of refraction, relative error",
            1e-4,
            sines.0,
            "Snell's law, 1e-4 as the catalogue has it",
        ),
    ])
}

/// T = (1 - R) / (1 + R) for a slab of glass, black above, 1 below.
fn slab(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for (ior, degrees, transmitted) in [
        (1.5, 0.0f64, 0.9230769),
        (1.5, 45.0, 0.9043268),
        (1.5, 60.0, 0.8362325),
        (1.5, 85.0, 0.2400796),
        (2.4, 0.0, 0.7100592),
    ] {
        let mut builder = SceneBuilder::new();
        let (slab, light) = (builder.material(glass(ior)), builder.material(lambert(0.0, 1.0)));
        builder.cuboid([-400.0, -0.5, -400.0], [400.0, 0.5, 400.0], slab, false);
        builder.quad([-400.0, -1.0, -400.0], [0.0, 0.0, 800.0], [800.0, 0.0, 0.0], light);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let origin = [-3.0 * sin, 0.5 + 3.0 * cos, 0.01];
        let scene = builder.finish(camera(origin, [0.0, 0.5, 0.01], 1e-3), None);
        let settings = Settings { max_bounces: 32, ..smooth_settings(&scene, 32, bench.count(128, 1024) as u32) };
        let Measured { mean, variance, invalid, .. } = measure(bench, &scene, &settings)?;
        findings.push(Finding::z(format!("slab of {ior} at {degrees} degrees"), transmitted, mean, variance));
        findings.push(Finding::exact(format!("slab of {ior} at {degrees} degrees: samples left out"), 0, invalid));
    }
    Ok(findings)
}

/// A body in a white furnace: every pixel must show `expected`.
fn in_a_furnace(
    bench: &TestBench,
    what: &str,
    scene: SceneBuilder,
    view: ([f64; 3], [f64; 3]),
    expected: f64,
) -> Result<Vec<Finding>> {
    let scene = scene.finish(camera(view.0, view.1, 20.0), Some([1.0; 3]));
    // What total reflection keeps inside for longer is cut; a path rarely takes 64 bounces, and 2,000 hardly ever.
    let settings = Settings { max_bounces: 2000, ..smooth_settings(&scene, 16, bench.count(16, 64) as u32) };
    let Measured { range, invalid, .. } = measure(bench, &scene, &settings)?;
    let worst = range.map(|pixel| (pixel / expected - 1.0).abs());
    let why = "no variance; roundings along a path of many bounces, 2^-24 each";
    Ok(vec![
        Finding::at_most(
            format!("{what}: largest distance of a pixel from {expected}"),
            2e-5,
            worst[0].max(worst[1]),
            why,
        ),
        Finding::exact(format!("{what}: samples left out"), 0, invalid),
    ])
}

const OUTSIDE: ([f64; 3], [f64; 3]) = ([0.0, 0.0, -4.0], [0.0; 3]);
const INSIDE: ([f64; 3], [f64; 3]) = ([0.1, 0.05, 0.0], [1.0, 0.3, 0.2]);

/// A sphere of a material.
fn ball(material: Material) -> SceneBuilder {
    let mut builder = SceneBuilder::new();
    let body = builder.material(material);
    builder.sphere([0.0; 3], 1.0, 4, body, false);
    builder
}

/// Radiance over squared index is what stays constant along a ray.
fn radiance_scale(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = in_a_furnace(bench, "glass seen from outside", ball(glass(1.5)), OUTSIDE, 1.0)?;
    findings.extend(in_a_furnace(bench, "glass seen from inside", ball(glass(1.5)), INSIDE, 2.25)?);
    Ok(findings)
}

fn nested_glass(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let mut bubble = ball(glass(1.5));
    let inner = bubble.material(glass(1.5));
    bubble.cuboid([-0.4, -0.3, -0.35], [0.4, 0.45, 0.3], inner, true);
    findings.extend(in_a_furnace(bench, "an air bubble in glass", bubble, OUTSIDE, 1.0)?);
    for ior in [0.5, 1.0, 1.000_001] {
        let what = format!("a ball of index {ior}");
        findings.extend(in_a_furnace(bench, &what, ball(glass(ior)), OUTSIDE, 1.0)?);
    }
    // An index of 100 keeps its light for more bounces than there are: less than 1, and a number.
    let scene = ball(glass(100.0)).finish(camera(OUTSIDE.0, OUTSIDE.1, 20.0), Some([1.0; 3]));
    let settings = Settings { max_bounces: 64, ..smooth_settings(&scene, 16, 64) };
    let Measured { range, invalid, .. } = measure(bench, &scene, &settings)?;
    let got = format!("{:.4} to {:.4}, {invalid} samples left out", range[0], range[1]);
    let passes = invalid == 0 && range[0] >= 0.0 && range[1] <= 1.0001;
    findings.push(Finding::holds("a ball of index 100", "pixels from 0 to 1, no sample left out", got, passes));
    // A ball of index 1 before a checker is not there at all.
    let picture = |ball: bool| -> Result<Vec<[u32; 3]>> {
        let mut builder = SceneBuilder::new();
        let squares = [1.0, 0.25].map(|emission| builder.material(lambert(0.0, emission)));
        for i in 0..64 {
            let [x, y] = [i % 8, i / 8].map(f64::from);
            let material = squares[(i % 8 + i / 8) as usize % 2];
            builder.quad([x - 4.0, y - 4.0, 2.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], material);
        }
        let air = builder.material(glass(1.0));
        // Outside of the view, where it is not wanted: the same extent gives the same scale.
        let place = if ball { [0.0; 3] } else { [0.0, 0.0, -12.0] };
        builder.sphere(place, 1.0, 4, air, false);
        builder.sphere([0.0, 0.0, 12.0], 1.0, 0, air, false);
        builder.sphere([0.0, 0.0, -12.0], 1.0, 0, air, false);
        let scene = builder.finish(camera([0.3, 0.2, -4.0], [0.0; 3], 40.0), None);
        let rendered = bench.render(&scene, &smooth_settings(&scene, 48, 64))?;
        Ok(rendered.film.mean().into_iter().map(|pixel| pixel.map(f32::to_bits)).collect())
    };
    let (with, without) = (picture(true)?, picture(false)?);
    let differing = with.iter().zip(&without).filter(|(with, without)| with != without).count();
    findings.push(Finding::never("pixels that a ball of index 1 changes", differing as u64, with.len() as u64));
    Ok(findings)
}

/// The vectors of pbrt's own test, the axes, the neighbourhood of -z, and random directions.
fn bases(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut normals = vec![
        [0.000_385_273_16, 0.000_384_600_16, -0.999_999_9, 0.0],
        [-0.000_198_135_81, -0.000_089_468_39, -0.999_999_9, 0.0f32],
    ];
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            normals.push(std::array::from_fn(|i| if i == axis { sign } else { 0.0 }));
            normals.push(std::array::from_fn(|i| if i == axis { sign } else { -0.0 }));
        }
    }
    let mut random = Random::new(55, 0);
    for _ in 0..bench.count(1 << 14, 1 << 17) {
        let near_pole = std::f64::consts::PI - 10f64.powf(-6.0 * random.next());
        normals.push(with(direction(near_pole, TAU * random.next()), 0.0));
    }
    for _ in 0..bench.count(1 << 15, 1 << 20) {
        let direction = random.direction();
        normals.push([direction.x, direction.y, direction.z, 0.0]);
    }
    let mut worst = Worst::default();
    for [handed, s, t, crossed] in call_sampling(bench, MAKE_BASIS, &normals)? {
        worst.add([s, t, crossed, handed - 1.0].map(|error| f64::from(error).powi(2)).iter().sum::<f64>());
    }
    let why = "four errors of 5e-6 at most; n itself is unit to 1e-6";
    Ok(vec![Finding::at_most("sum of squared errors of length, angle and handedness", 1e-10, worst.0, why)])
}

/// Black, white, and a closed white box that only the bounce cap ends.
fn albedos(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for (albedo, bounces, expected) in [(0.0, 8, 1.0), (1.0, 1, 2.0), (1.0, 30, 31.0)] {
        let mut builder = SceneBuilder::new();
        let walls = builder.material(lambert(albedo, 1.0));
        builder.cuboid([-1.0; 3], [1.0; 3], walls, true);
        let scene = builder.finish(camera([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 70.0), None);
        let settings = Settings { lights: Lights::Bsdf, max_bounces: bounces, ..smooth_settings(&scene, 16, 16) };
        let Measured { range, invalid, .. } = measure(bench, &scene, &settings)?;
        let what = format!("closed box of albedo {albedo}, {bounces} bounces: pixels, samples left out");
        let got = format!("{} to {}, {invalid}", range[0], range[1]);
        findings.push(Finding::exact(what, format!("{expected} to {expected}, 0"), got));
    }
    let mut builder = SceneBuilder::new();
    let white = builder.material(lambert(1.0, 0.0));
    builder.cuboid([-1.0; 3], [1.0; 3], white, false);
    let scene = builder.finish(camera([3.0, 2.0, -4.0], [0.0; 3], 40.0), Some([1.0; 3]));
    let Measured { range, .. } = measure(bench, &scene, &smooth_settings(&scene, 24, 16))?;
    let got = format!("{} to {}", range[0], range[1]);
    findings.push(Finding::exact("a white body in a white furnace: pixels", "1 to 1".to_owned(), got));
    Ok(findings)
}

/// Glass that reflects with probability 0 or 1, at random numbers 0 and 1 - 2^-24.
fn certain_lobes(bench: &TestBench) -> Result<Vec<Finding>> {
    let numbers = [0.0, 1.0 / 16_777_216.0, 0.5, 1.0 - 1.0 / 16_777_216.0];
    let mut questions: Vec<Arguments> = Vec::new();
    let mut expected = Vec::new();
    for i in 1..90 {
        let theta = f64::from(i).to_radians();
        let inside_reflects = theta.sin() * 1.5 > 1.0;
        for u in numbers {
            // Matched indices from both sides: all goes through, save where the rounded reflectance of 1e-13 meets u = 0.
            for front in [0.0, 1.0] {
                questions.push([with(direction(theta, 0.3), 1.0), [u, front, 0.0, 0.0], [0.0; 4]]);
                expected.push(if u > 0.0 { Some(1.0) } else { None });
            }
            // From inside glass beyond the critical angle: nothing goes through.
            questions.push([with(direction(theta, 0.3), 1.5), [u, 0.0, 0.0, 0.0], [0.0; 4]]);
            expected.push(if inside_reflects { Some(0.0) } else { None });
        }
    }
    let (mut wrong, mut invalid) = (0, 0);
    for ((question, expected), [[x, y, z, weight], [scale, transmitted, ..]]) in
        questions.iter().zip(&expected).zip(call(bench, GLASS, &questions)?)
    {
        let length2 = x * x + y * y + z * z;
        let worth = if transmitted > 0.0 { question[0][3].powi(2) } else { 1.0 };
        let sound = (length2 - 1.0).abs() < 1e-6 && (weight / worth - 1.0).abs() < 1e-6;
        invalid += u64::from(!sound || (scale * worth - 1.0).abs() > 1e-6);
        wrong += u64::from(expected.is_some_and(|expected: f32| expected != transmitted));
    }
    Ok(vec![
        Finding::never("lobes of probability 0 that were chosen", wrong, questions.len() as u64),
        Finding::never("directions or weights that are wrong, NaN among them", invalid, questions.len() as u64),
    ])
}
