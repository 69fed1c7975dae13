//! Group E: light sampling.

use glam::{DVec3, Vec3};

use crate::Result;
use crate::bvh::Accel;
use crate::scene::Scene;
use crate::selftest::cases::light_trees;
use crate::selftest::kit::form_factors;
use crate::selftest::kit::furnaces::{furnace, series};
use crate::selftest::kit::scattering::{
    ARC_TANGENT, Arguments, LIGHT_SAMPLE, Measured, PICK_LIGHTS, POWER_HEURISTIC, SOLID_ANGLE, call, call_in,
    call_sampling, call_words, measure, smooth_settings,
};
use crate::selftest::kit::scenes::{SceneBuilder, camera, lambert};
use crate::selftest::{Case, Check, TestBench, Tier};
use crate::settings::{LightPick, Lights, Settings};
use crate::statistics::Finding;
use crate::statistics::Worst;
use crate::statistics::chi_square_test;
use crate::statistics::random::Random;
use crate::texels::TexelData;
use crate::texels::triangle::area;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        number: 38,
        title: "1/r^2 near an area light",
        meaning: "fireflies along lights",
        check: Check::Run(near_lights),
    },
    Case {
        number: 39,
        title: "solid angles of small triangles",
        meaning: "wrong brightness of small lights",
        check: Check::Run(solid_angles),
    },
    Case {
        number: 40,
        title: "far lights",
        meaning: "wrong brightness of distant lights",
        check: Check::Run(|bench| form_factors::check(bench, &form_factors::far())),
    },
    Case {
        number: 41,
        title: "form factors",
        meaning: "wrong brightness of lit surfaces",
        check: Check::Run(|bench| form_factors::check(bench, &form_factors::oblique())),
    },
    Case {
        number: 42,
        title: "a light that touches a wall",
        meaning: "a bright or dark seam",
        check: Check::Run(|bench| form_factors::check(bench, &form_factors::touching())),
    },
    Case {
        number: 43,
        title: "lights of no power, lights from behind, many lights",
        meaning: "light from nowhere, lights that are out",
        check: Check::Run(picks),
    },
    Case {
        number: 44,
        title: "very bright and very faint lights together",
        meaning: "faint lights are out",
        check: Check::Run(bright_and_faint),
    },
    Case {
        number: 45,
        title: "weights of 0/0 and inf/inf",
        meaning: "NaN at lights and specular surfaces",
        check: Check::Run(heuristic),
    },
    Case {
        number: 46,
        title: "estimators that disagree",
        meaning: "brightness that depends on an option",
        check: Check::Run(estimators),
    },
];

/// Both strategies' samples are bounded, whatever the distance, and the sum is right.
///
/// With the density p of light sampling, q = cos / π of BSDF sampling and the power heuristic, a light sample is worth
/// ρ Le q p / (p² + q²) ≤ ρ Le / 2, a BSDF sample ρ Le q² / (p² + q²) ≤ ρ Le.
fn near_lights(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut builder = SceneBuilder::new();
    let light = builder.material(lambert(0.0, 1.0));
    builder.quad([-1.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], light);
    let scene = builder.finish(camera([0.0, -1.0, 0.1], [0.0; 3], 40.0), None);
    let mut random = Random::new(38, 0);
    let count = bench.count(1 << 17, 1 << 20);
    let questions: Vec<Arguments> = (0..count)
        .map(|i| {
            // The scene is scaled to [-1/2, 1/2]; distances 1e-7 to 10, half of the points at the height of the light's edge.
            let distance = 10f64.powf(8.0 * random.next() - 7.0) as f32;
            let normal = if i % 2 == 0 { Vec3::Y } else { random.direction() };
            let o = [random.unit() - 0.5, -distance, random.unit() - 0.5, f32::from_bits(i as u32 / 2 % 2)];
            [o, [random.unit(), random.unit(), 1.0, 0.0], [normal.x, normal.y, normal.z, 0.0]]
        })
        .collect();
    let (mut by_light, mut by_bsdf, mut below) = (Worst::default(), Worst::default(), 0);
    for [[light, bsdf, ..], _] in call_in(bench, &scene, LIGHT_SAMPLE, &questions)? {
        by_light.add(f64::from(light));
        by_bsdf.add(f64::from(bsdf));
        below += u64::from(light.is_nan() || light < 0.0 || bsdf.is_nan() || bsdf < 0.0);
    }
    let why = "the bound, and 1e-5 for rounding";
    let mut findings = vec![
        Finding::at_most("largest light sample, in units of albedo times emission", 0.5 * 1.00001, by_light.0, why),
        Finding::at_most("largest BSDF sample", 1.00001, by_bsdf.0, why),
        Finding::never("samples below 0", below, count as u64),
    ];
    findings.extend(form_factors::check(bench, &form_factors::near())?);
    findings.push(light_trees::cluster_around_a_point(bench)?);
    Ok(findings)
}

/// Solid angle in f64, of edges.
fn solid_angle(p: DVec3, [v0, v1, v2]: [DVec3; 3]) -> (f64, f64) {
    let [a, b, c] = [v0 - p, v1 - p, v2 - p];
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let volume = a.dot((v1 - v0).cross(v2 - v0)).abs();
    let rest = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    (2.0 * volume.atan2(rest), volume / (la * (v1 - v0).length() * (v2 - v0).length()))
}

/// Each vector's components are rounded by 2^-24 of themselves and their products add some ten roundings more; the volume
/// makes 1 / condition of that, where the condition is the volume over the product of the three lengths that it is made of.
fn solid_angles(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut random = Random::new(39, 0);
    let tangents: Vec<Arguments> = (0..bench.count(1 << 16, 1 << 18))
        .map(|_| {
            let x = 10f64.powf(12.0 * random.next() - 6.0) * if random.next() < 0.5 { -1.0 } else { 1.0 };
            [[random.unit().max(1e-6), x as f32, 0.0, 0.0], [0.0; 4], [0.0; 4]]
        })
        .collect();
    let mut worst = Worst::default();
    for ([[y, x, ..], ..], [[angle, ..], _]) in tangents.iter().zip(call(bench, ARC_TANGENT, &tangents)?) {
        worst.add((f64::from(angle) / f64::from(*y).atan2(f64::from(*x)) - 1.0).abs());
    }
    let why = "3e-7 of the polynomial, and ten roundings of 2^-24";
    let mut findings = vec![Finding::at_most("arc tangent, relative error", 1e-6, worst.0, why)];

    let vector = |v: [f32; 4]| Vec3::new(v[0], v[1], v[2]).as_dvec3();
    for side in [1.0f32, 1e-1, 1e-2, 1e-3, 1e-4] {
        let count = bench.count(1 << 14, 100_000);
        let mut questions: Vec<Arguments> = Vec::new();
        while questions.len() < count {
            let (p, centre) = (random.point(), random.point());
            let corners = [0; 3].map(|_| centre + random.point() * (0.5 * side));
            if solid_angle(p.as_dvec3(), corners.map(Vec3::as_dvec3)).1 >= 0.05 {
                questions.push(std::array::from_fn(|i| [corners[i].x, corners[i].y, corners[i].z, p[i]]));
            }
        }
        let mut worst = Worst::default();
        for (question, [[found, ..], _]) in questions.iter().zip(call(bench, SOLID_ANGLE, &questions)?) {
            let p = DVec3::from_array(question.map(|texel| f64::from(texel[3])));
            worst.add((f64::from(found) / solid_angle(p, question.map(vector)).0 - 1.0).abs());
        }
        let why = "16 roundings of 2^-24 over a condition of 0.05";
        findings.push(Finding::at_most(format!("solid angles of triangles of side {side}"), 2e-5, worst.0, why));
    }
    Ok(findings)
}

/// Lights of different powers, black ones between them.
fn many_lights(count: u32) -> Scene {
    let mut builder = SceneBuilder::new();
    let black = builder.material(lambert(0.5, 0.0));
    let powers = [0.01, 0.3, 1.0, 100.0].map(|emission| builder.material(lambert(0.0, emission)));
    for i in 0..count {
        let material = if i % 5 == 4 { black } else { powers[(i % 5) as usize] };
        let corner = DVec3::new(f64::from(i % 1000), f64::from(i / 1000), 0.0);
        builder.triangle([corner, corner + DVec3::X * 0.7, corner + DVec3::Y * 0.6], material);
    }
    builder.finish(camera([0.0, 0.0, -5.0], [0.0; 3], 40.0), None)
}

fn picks(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let large = bench.count(100_000, 1_250_000) as u32;
    for (triangles, draws) in [(20, bench.count(1 << 19, 10_000_000)), (large, 1 << 20)] {
        let scene = many_lights(triangles);
        let by_power = Settings { light_pick: LightPick::Power, ..Settings::for_scene(&scene) };
        let data = TexelData::pack(&scene, &Accel::brute(), &by_power)?;
        let records = data.lights.as_chunks::<5>().0;
        let lights = records.len();
        let shares: Vec<f64> = records
            .iter()
            .map(|&[_, [.., triangle], [.., density], ..]| {
                f64::from(f32::from_bits(density)) * area(&scene.triangles[triangle as usize])
            })
            .collect();
        let sum = shares.iter().sum::<f64>();
        let why = "each density is rounded once to f32";
        findings.push(Finding::relative(format!("{lights} lights, sum of densities times areas"), 1.0, sum, 1e-6, why));
        let is_black = |&[_, [.., triangle], ..]: &[[u32; 4]; 5]| scene.triangles[triangle as usize].material == 0;
        let mut random = Random::new(43, u64::from(triangles));
        let words: Vec<[u32; 4]> = (0..draws / 4)
            .map(|_| {
                let (a, b) = (random.bits(), random.bits());
                [a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32]
            })
            .collect();
        let (mut counts, mut black) = (vec![0.0; lights], 0);
        for light in call_words(bench, &scene, PICK_LIGHTS, &words)?.into_iter().flatten() {
            match records.get(light as usize) {
                Some(record) if !is_black(record) => counts[light as usize] += 1.0,
                _ => black += 1,
            }
        }
        let trials = 4.0 * words.len() as f64;
        findings.push(Finding::never(format!("{lights} lights, black ones picked"), black, trials as u64));
        let expected: Vec<f64> = shares.iter().map(|share| share * trials).collect();
        let verdict = chi_square_test(&counts, &expected);
        findings.push(Finding {
            what: format!("{lights} lights, frequencies of picks"),
            expected: "densities times areas".into(),
            got: format!("chi-square {:.1}, p {:.2e}", verdict.statistic, verdict.p),
            tolerance: "p 1e-9: one false alarm in 1e6 suites of 1000 verdicts".into(),
            passes: verdict.p >= 1e-9,
        });
    }
    findings.extend(light_trees::picks(bench)?);
    // A light that shows its back adds nothing, by any estimator.
    let estimators = [Lights::Mis, Lights::Area, Lights::Bsdf].map(|lights| (lights, LightPick::Power));
    let by_tree = [Lights::Mis, Lights::Area].map(|lights| (lights, LightPick::Tree));
    for (lights, light_pick) in estimators.into_iter().chain(by_tree) {
        let mut builder = SceneBuilder::new();
        let (floor, light) = (builder.material(lambert(0.5, 0.0)), builder.material(lambert(0.5, 1.0)));
        builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], floor);
        builder.quad([-1.0, 1.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], light);
        let scene = builder.finish(camera([0.0, 0.5, -1.5], [0.0; 3], 30.0), None);
        let settings = Settings { lights, light_pick, max_bounces: 3, ..smooth_settings(&scene, 16, 64) };
        let Measured { range, invalid, .. } = measure(bench, &scene, &settings)?;
        let what =
            format!("floor under the back of a light, {lights:?}, {light_pick:?}: largest pixel, samples left out");
        findings.push(Finding::exact(what, "0, 0".to_owned(), format!("{}, {invalid}", range[1])));
    }
    Ok(findings)
}

/// A faint light over a floor, and a bright one that shows the floor its back.
///
/// Sums of samples are whole numbers of 2^-80 of the brightest emission (film): what a light 1e20 times fainter adds to a
/// block is some 1e4 of these. The power of lights never picks it; BSDF samples find it.
fn bright_and_faint(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let powers = [(1e10f32, 1e10f32), (1e10, 1.0), (1e10, 1e-10)];
    let cases = powers.into_iter().flat_map(|powers| [LightPick::Power, LightPick::Tree].map(|pick| (powers, pick)));
    for ((bright, faint), light_pick) in cases {
        let mut builder = SceneBuilder::new();
        let floor = builder.material(lambert(0.5, 0.0));
        let [dim, glaring] = [faint, bright].map(|emission| builder.material(lambert(0.0, emission)));
        builder.quad([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], floor);
        builder.quad([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], dim);
        builder.quad([-1.0, 1.5, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], glaring);
        let scene = builder.finish(camera([0.0, 0.4, 0.0], [0.0; 3], 1e-3), None);
        let spp = bench.count(128, 1024) as u32;
        let settings = Settings { max_bounces: 1, light_pick, ..smooth_settings(&scene, 32, spp) };
        let measured = measure(bench, &scene, &settings)?;
        let expected = 0.5 * 0.1385316060 * f64::from(faint);
        let what = format!("floor under a light of {faint:e}, a hidden one has {bright:e}, {light_pick:?}");
        findings.push(Finding::z(what.clone(), expected, measured.mean, measured.variance));
        let why = "so that the verdict says something";
        let limit = if bench.tier() == Tier::Full { 3e-3 } else { 3e-2 };
        findings.push(Finding::at_most(
            format!("{what}: relative standard error"),
            limit,
            measured.relative_error(),
            why,
        ));
    }
    findings.push(light_trees::bright_beside_faint(bench)?);
    Ok(findings)
}

/// Weights of every pair of densities that may meet.
fn heuristic(bench: &TestBench) -> Result<Vec<Finding>> {
    let values = [0.0, 1.2e-38, 1e-20, 1.0, 1e20, f32::INFINITY];
    let pairs: Vec<[f32; 4]> = values.iter().flat_map(|&a| values.map(|b| [a, b, 0.0, 0.0])).collect();
    let (mut outside, mut sums) = (0, Worst::default());
    for ([a, b, ..], [mine, other, ..]) in pairs.iter().zip(call_sampling(bench, POWER_HEURISTIC, &pairs)?) {
        let in_range = (0.0..=1.0).contains(&mine) && (0.0..=1.0).contains(&other);
        outside += u64::from(!in_range || (a < b && mine >= other) || (*a == 0.0 && mine != 0.0));
        // What neither strategy draws has no weight.
        let expected = if *a == 0.0 && *b == 0.0 { 0.0 } else { 1.0 };
        sums.add((f64::from(mine) + f64::from(other) - expected).abs());
    }
    Ok(vec![
        Finding::never("weights outside [0, 1], or larger for the smaller density", outside, pairs.len() as u64),
        Finding::at_most("distance of two weights' sum from 1", 1e-6, sums.0, "four roundings of 2^-24 each"),
    ])
}

/// A closed box that emits 1 and reflects a: (1 - a^(n + 1)) / (1 - a) after n bounces. Light samples alone are judged in a room
/// whose light touches nothing: where a surface meets a light, 1 / r² has no variance, and a mean no error to be judged by.
fn estimators(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let spp = bench.count(64, 256) as u32;
    for albedo in [0.5f32, 0.8] {
        let scene = furnace(albedo, false);
        let max_bounces = bench.count(8, if albedo < 0.7 { 24 } else { 64 }) as u32;
        for lights in [Lights::Bsdf, Lights::Mis] {
            let settings = Settings { lights, max_bounces, ..smooth_settings(&scene, 16, spp) };
            let measured = measure(bench, &scene, &settings)?;
            let what = format!("closed box of albedo {albedo}, {max_bounces} bounces, {lights:?}");
            findings.push(Finding::z(&what, series(albedo, max_bounces), measured.mean, measured.variance));
            findings.push(Finding::exact(format!("{what}: samples left out"), 0, measured.invalid));
        }
    }
    let mut builder = SceneBuilder::new();
    let (walls, light) = (builder.material(lambert(0.6, 0.0)), builder.material(lambert(0.3, 1.0)));
    builder.cuboid([-1.0; 3], [1.0; 3], walls, true);
    builder.quad([-0.3, 0.4, -0.3], [0.6, 0.0, 0.0], [0.0, 0.0, 0.6], light);
    let scene = builder.finish(camera([0.1, -0.2, -0.8], [0.0, -0.4, 1.0], 70.0), None);
    let of = |lights, seed| {
        let settings = Settings { lights, seed, max_bounces: 6, ..smooth_settings(&scene, 16, 4 * spp) };
        measure(bench, &scene, &settings)
    };
    let by_both = of(Lights::Mis, 1)?;
    for (lights, seed) in [(Lights::Area, 2), (Lights::Bsdf, 3)] {
        let alone = of(lights, seed)?;
        let what = format!("room with a light that touches nothing, {lights:?} against Mis");
        findings.push(Finding::z(&what, by_both.mean, alone.mean, alone.variance + by_both.variance));
        let error = (alone.variance + by_both.variance).sqrt() / by_both.mean;
        let limit = if bench.tier() == Tier::Full { 1e-2 } else { 2e-2 };
        findings.push(Finding::at_most(
            format!("{what}: relative standard error"),
            limit,
            error,
            "so that the verdict says something",
        ));
    }
    Ok(findings)
}
