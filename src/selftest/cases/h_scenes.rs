//! Group H: whole scenes.

use glam::{DMat3, DVec3};

use crate::Result;
use crate::interface::BLOCK_SAMPLES;
use crate::render::Guard;
use crate::scene::{Camera, Scene};
use crate::selftest::kit::pictures::{bits, compare_tiles, differing, pixel_moments, worst_error};
use crate::selftest::kit::scattering::{Arguments, REFLECTIONS, call};
use crate::selftest::kit::scenes::{SceneBuilder, camera, glass, lambert, mirror};
use crate::selftest::kit::test_bench::plain_settings;
use crate::selftest::{Case, Check, TestBench};
use crate::settings::Settings;
use crate::statistics::Finding;
use crate::statistics::Worst;
use crate::statistics::random::Random;
use crate::statistics::{Moments, fit_line};

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        number: 70,
        title: "scenes far away, tiny or huge",
        meaning: "acne, holes, banding",
        check: Check::Run(placement),
    },
    Case {
        number: 71,
        title: "a white furnace",
        meaning: "objects that gain or lose energy",
        check: Check::Run(white_furnace),
    },
    Case {
        number: 72,
        title: "a closed furnace",
        meaning: "brightness wrong after many bounces",
        check: Check::Run(closed_furnace),
    },
    Case {
        number: 73,
        title: "an integrating sphere",
        meaning: "wrong interreflection",
        check: Check::Run(integrating_sphere),
    },
    Case {
        number: 74,
        title: "a sphere in a sphere",
        meaning: "wrong interreflection",
        check: Check::Run(sphere_in_sphere),
    },
    Case {
        number: 75,
        title: "a point light in a sphere",
        meaning: "wrong brightness of point lights",
        check: Check::Awaits("point lights"),
    },
    Case { number: 76, title: "a box of mirrors", meaning: "drifting directions", check: Check::Run(mirror_box) },
    Case {
        number: 77,
        title: "caustics without light samples",
        meaning: "fireflies that never average out",
        check: Check::Run(caustic),
    },
    Case { number: 78, title: "thin objects far away", meaning: "broken silhouettes", check: Check::Run(needle) },
    Case {
        number: 79,
        title: "pictures of odd sizes",
        meaning: "wrong pixels at the edges",
        check: Check::Run(odd_sizes),
    },
    Case {
        number: 80,
        title: "textures that are not numbers, or of size 0",
        meaning: "NaN textures",
        check: Check::Awaits("textures"),
    },
];

/// Where a scene is put, in file units.
#[derive(Clone, Copy)]
struct Placement {
    scale: f64,
    /// Turned by this angle about (1, 2, 3), in radians.
    angle: f64,
    shift: f64,
}

const HERE: Placement = Placement { scale: 1.0, angle: 0.0, shift: 0.0 };

/// A lit room with a tilted block. `step` is what coordinates are multiples of; 0: they are ordinary decimals.
fn placed_room(bench: &TestBench, step: f64, at: Placement) -> Scene {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), at.angle);
    let place = |[x, y, z]: [f64; 3]| {
        let rounded = |value: f64| if step > 0.0 { (value / step).round() * step } else { value };
        turn * DVec3::new(rounded(x), rounded(y), rounded(z)) * at.scale + at.shift
    };
    let mut builder = SceneBuilder::new();
    let (wall, block) = (builder.material(lambert(0.7, 0.0)), builder.material(lambert(0.4, 0.0)));
    let light = builder.material(lambert(0.0, 1.0));
    let mut quad = |corners: [[f64; 3]; 4], material| {
        let [a, b, c, d] = corners.map(place);
        builder.triangle([a, b, c], material);
        builder.triangle([a, c, d], material);
    };
    let (s, t) = (1.1, 0.3);
    quad([[-s, -s, -s], [-s, -s, s], [s, -s, s], [s, -s, -s]], wall);
    quad([[-s, s, -s], [s, s, -s], [s, s, s], [-s, s, s]], wall);
    quad([[-s, -s, s], [-s, s, s], [s, s, s], [s, -s, s]], wall);
    quad([[-s, -s, -s], [-s, s, -s], [-s, s, s], [-s, -s, s]], wall);
    quad([[s, -s, s], [s, s, s], [s, s, -s], [s, -s, -s]], wall);
    quad([[-t, 1.0, -t], [t, 1.0, -t], [t, 1.0, t], [-t, 1.0, t]], light);
    quad([[-0.6, -0.9, 0.4], [-0.2, -0.1, 0.7], [0.5, -0.2, 0.6], [0.3, -1.0, 0.1]], block);
    let view =
        Camera { origin: place([0.1, 0.2, -2.9]), target: place([0.0, 0.0, 0.0]), up: turn * DVec3::Y, vfov: 42.0 };
    let mut scaling = builder.scaling(None);
    if !bench.has(Guard::Recentre) {
        scaling.centre = DVec3::ZERO;
    }
    if !bench.has(Guard::Rescale) {
        scaling.length_exponent = 0;
    }
    builder.finish_scaled(view, None, scaling)
}

fn placement(bench: &TestBench) -> Result<Vec<Finding>> {
    // Every tile needs its variance: 16 replicates.
    let settings =
        |scene: &Scene, seed| Settings { seed, max_bounces: 4, ..plain_settings(scene, 24, 24, 16 * BLOCK_SAMPLES) };
    let step = 2f64.powi(-20);
    let exact = |at| {
        let scene = placed_room(bench, step, at);
        bits(bench, &scene, &settings(&scene, 1))
    };
    let here = exact(HERE)?;
    let mut findings = Vec::new();
    for exponent in [20, -20, -100] {
        let there = exact(Placement { scale: 2f64.powi(exponent), ..HERE })?;
        findings.push(differing(format!("pixels that differ when scaled by 2^{exponent}"), &here, &there));
    }
    let there = exact(Placement { shift: 1e6, ..HERE })?;
    findings.push(differing("pixels that differ when moved by 1e6, coordinates multiples of 2^-20", &here, &there));
    let here = placed_room(bench, 0.0, HERE);
    let around = std::f64::consts::FRAC_PI_4;
    for (name, at) in [
        ("moved by 1e6, decimal coordinates", Placement { shift: 1e6, ..HERE }),
        ("scaled by 1e6", Placement { scale: 1e6, ..HERE }),
        ("scaled by 1e-6", Placement { scale: 1e-6, ..HERE }),
        ("turned by 45 degrees about (1, 2, 3)", Placement { angle: around, ..HERE }),
    ] {
        let there = placed_room(bench, 0.0, at);
        let pair = [(&here, &settings(&here, 1)), (&there, &settings(&there, 2))];
        findings.push(compare_tiles(bench, format!("tiles when {name}"), pair)?);
    }
    Ok(findings)
}

/// Something in front of a white sky that reflects all there is.
fn white_furnace(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let bodies = [("a white cube", lambert(1.0, 0.0)), ("a mirror", mirror(1.0, 0.0)), ("glass", glass(1.5))];
    for (name, body) in bodies {
        for round in [false, true] {
            let mut builder = SceneBuilder::new();
            let body = builder.material(body.clone());
            match round {
                true => builder.sphere([0.0; 3], 1.0, 4, body, false),
                false => builder.cuboid([-1.0; 3], [1.0; 3], body, false),
            }
            let scene = builder.finish(camera([3.0, 2.0, -4.0], [0.0; 3], 40.0), Some([1.0; 3]));
            // A path that total reflection keeps in the glass for as many bounces is cut; the rest leave with weight 1.
            let settings = Settings { max_bounces: 2000, ..plain_settings(&scene, 24, 24, 4) };
            let error = worst_error(bench, &scene, &settings, 1.0)?;
            let shape = if round { "a ball of 2,048 triangles" } else { "a cube" };
            let why = "300 roundings of one sign along a path, 2^-24 each";
            findings.push(Finding::at_most(format!("largest error of a pixel, {name}, {shape}"), 2e-5, error, why));
        }
    }
    Ok(findings)
}

fn closed_furnace(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let spp = bench.count(32, 256) as u32;
    for (albedo, max_bounces) in [(0.5f32, 24u32), (0.8, 64), (0.95, 256)] {
        let a = f64::from(albedo);
        let expected = (1.0 - a.powi(max_bounces as i32 + 1)) / (1.0 - a);
        for mixed in [false, true] {
            let mut builder = SceneBuilder::new();
            let walls = builder.material(lambert(albedo, 1.0));
            builder.cuboid([-1.0; 3], [1.0; 3], walls, true);
            if mixed {
                let shiny = builder.material(mirror(albedo, 1.0));
                builder.cuboid([-0.3, -0.9, 0.1], [0.2, -0.4, 0.6], shiny, false);
            }
            let scene = builder.finish(camera([0.1, 0.2, 0.3], [1.0, -0.3, 0.4], 70.0), None);
            let settings = Settings { max_bounces, ..plain_settings(&scene, 32, 32, spp) };
            let moments = pixel_moments(bench, &scene, &settings)?;
            let walls = if mixed { "Lambert walls, a mirror in them" } else { "Lambert walls" };
            findings.push(Finding::mean(
                format!("albedo {albedo}, {walls}, {max_bounces} bounces"),
                expected,
                &moments,
            ));
        }
    }
    Ok(findings)
}

/// The facets of a sphere of 131,072 triangles change form factors by less than this share.
const FACETS: f64 = 2e-4;

/// A mean against an expectation that is itself only good to `share` of it.
fn mean_within(what: String, expected: f64, samples: &Moments, share: f64) -> Finding {
    let allowed = share * expected;
    let nearest = expected + (samples.mean - expected).clamp(-allowed, allowed);
    let beyond = Finding::mean("", nearest, samples);
    let plain = Finding::mean(what, expected, samples);
    let tolerance = format!("{share:.0e} of it for the facets, beyond that {}", beyond.tolerance);
    Finding { passes: beyond.passes, tolerance, ..plain }
}

/// A sphere of one albedo, seen from inside, of which a cap emits.
fn integrating_sphere(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let divisions = bench.count(5, 7) as u32;
    for (fraction, albedo, max_bounces) in [(0.1, 0.5f32, 40u32), (0.05, 0.8, 80), (0.05, 0.95, 300)] {
        let mut builder = SceneBuilder::new();
        let (wall, cap) = (builder.material(lambert(albedo, 0.0)), builder.material(lambert(albedo, 1.0)));
        let share = builder.cap_sphere(divisions, [wall, cap], fraction);
        // The cap is around +y; a wall opposite is seen.
        let scene = builder.finish(camera([0.0, 0.1, 0.2], [0.6, -0.7, -0.4], 40.0), None);
        let rho = f64::from(albedo);
        let expected = rho * share * (1.0 - rho.powi(max_bounces as i32)) / (1.0 - rho);
        let spp = bench.count(16, 64) as u32;
        let settings = Settings { max_bounces, ..plain_settings(&scene, 24, 24, spp) };
        let moments = pixel_moments(bench, &scene, &settings)?;
        let what = format!("cap {share:.6}, albedo {albedo}, {} triangles", scene.triangles.len());
        findings.push(mean_within(what, expected, &moments, FACETS * 4f64.powi(7 - divisions as i32)));
    }
    Ok(findings)
}

/// A black emitting ball of radius 1/2 in a ball of radius 1: form factor 1/4 from the outer to the inner.
fn sphere_in_sphere(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let divisions = bench.count(5, 7) as u32;
    for (albedo, max_bounces) in [(0.5f32, 30), (0.8, 60)] {
        let mut builder = SceneBuilder::new();
        let (wall, light) = (builder.material(lambert(albedo, 0.0)), builder.material(lambert(0.0, 1.0)));
        builder.sphere([0.0; 3], 1.0, divisions, wall, false);
        builder.sphere([0.0; 3], 0.5, divisions, light, false);
        let scene = builder.finish(camera([0.75, 0.0, 0.0], [0.9, 0.3, 0.2], 30.0), None);
        let rho = f64::from(albedo);
        // 1/4 from the emitter at each of k bounces, of which 3/4 stay on the wall.
        let expected = 0.25 * rho * (1.0 - (0.75 * rho).powi(max_bounces)) / (1.0 - 0.75 * rho);
        let settings =
            Settings { max_bounces: max_bounces as u32, ..plain_settings(&scene, 24, 24, bench.count(32, 128) as u32) };
        let moments = pixel_moments(bench, &scene, &settings)?;
        let what = format!("wall of albedo {albedo}, {} triangles", scene.triangles.len());
        findings.push(mean_within(what, expected, &moments, FACETS * 4f64.powi(7 - divisions as i32)));
    }
    Ok(findings)
}

/// Mirrors that emit 1 and reflect .9: no variance, so that a ray that leaves shows. Radiance does not show lengths: directions
/// reflected a hundred times about any normals are looked at by themselves.
fn mirror_box(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut builder = SceneBuilder::new();
    let mirrors = builder.material(mirror(0.9, 1.0));
    builder.cuboid([-1.0, -0.7, -0.9], [1.0, 0.8, 1.1], mirrors, true);
    let scene = builder.finish(camera([0.1, 0.2, 0.3], [1.0, 0.37, -0.6], 90.0), None);
    let mut findings = Vec::new();
    for max_bounces in [1, 8, 200] {
        let expected = (1.0 - f64::from(0.9f32).powi(max_bounces as i32 + 1)) / (1.0 - f64::from(0.9f32));
        let settings = Settings { max_bounces, ..plain_settings(&scene, 32, 32, 4) };
        let error = worst_error(bench, &scene, &settings, expected)?;
        let why = "roundings of products, 2^-24 each, weighted by .9^k";
        findings.push(Finding::at_most(format!("largest error of a pixel, {max_bounces} bounces"), 2e-5, error, why));
    }
    let mut random = Random::new(76, 0);
    let questions: Vec<Arguments> = (0..bench.count(1 << 14, 1 << 18))
        .map(|_| {
            let d = random.direction();
            [[d.x, d.y, d.z, 0.0], [100.0, 0.0, 0.0, 0.0], [0.0; 4]]
        })
        .collect();
    let mut worst = Worst::default();
    for [[.., length2], _] in call(bench, REFLECTIONS, &questions)? {
        worst.add((f64::from(length2) - 1.0).abs());
    }
    let why = "a normalised vector: 6 roundings, whatever was before";
    findings.push(Finding::at_most("| |d|^2 - 1 | of directions reflected 100 times", 1e-6, worst.0, why));
    Ok(findings)
}

/// A lamp in a glass ball: its light reaches the floor by BSDF samples alone.
fn caustic(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut builder = SceneBuilder::new();
    let floor = builder.material(lambert(0.7, 0.0));
    let light = builder.material(lambert(0.0, 1.0));
    let ball = builder.material(glass(1.5));
    builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], floor);
    builder.sphere([0.0, 0.6, 0.0], 0.5, 3, ball, true);
    builder.quad([-1.5, 3.0, -1.5], [3.0, 0.0, 0.0], [0.0, 0.0, 3.0], light);
    let scene = builder.finish(camera([0.0, 2.0, -3.0], [0.0, 0.2, 0.0], 40.0), None);
    let picture = |seed: u64, spp: u32| -> Result<Vec<f64>> {
        let settings = Settings { seed, max_bounces: 6, ..plain_settings(&scene, 32, 32, spp) };
        Ok(bench.render(&scene, &settings)?.film.mean().into_iter().map(|pixel| f64::from(pixel[0])).collect())
    };
    let most = bench.count(256, 1024) as u32;
    let reference = picture(1000, 16 * most)?;
    let mut points = Vec::new();
    let mut heaviest: f64 = 0.0;
    for spp in (4..).map(|k| 1u32 << k).take_while(|&spp| spp <= most) {
        // Fewer samples need more pictures for a mean of as many samples.
        let seeds = u64::from(most / spp).min(8);
        let mut error = 0.0;
        for seed in 0..seeds {
            let mut squares: Vec<f64> = picture(seed + 10 * u64::from(spp), spp)?
                .iter()
                .zip(&reference)
                .map(|(x, r)| (x - r).powi(2) / (r * r + 0.01))
                .collect();
            squares.sort_by(f64::total_cmp);
            let total: f64 = squares.iter().sum();
            heaviest = heaviest.max(squares.last().copied().unwrap_or(0.0) / total);
            error += total / squares.len() as f64 / seeds as f64;
        }
        // The reference's own noise is as that of a picture of its samples.
        points.push((f64::from(spp).ln(), (error / (1.0 + f64::from(spp) / f64::from(16 * most))).ln()));
    }
    let line = fit_line(&points);
    let why = "an unbiased mean of independent samples; scatter of heavy tails allowed for";
    Ok(vec![
        Finding::relative("slope of log error against log samples", -1.0, line.slope, 0.1, why),
        Finding::at_most("largest share of one pixel in an error of 1,024", 1.0, heaviest, "printed, not judged"),
    ])
}

/// A bar 1 unit wide and a million units away, with a scene of its size at the camera.
fn needle(bench: &TestBench) -> Result<Vec<Finding>> {
    const FAR: f64 = 1e6;
    let mut builder = SceneBuilder::new();
    let (near, bar) = (builder.material(lambert(0.5, 0.0)), builder.material(lambert(0.0, 1.0)));
    builder.cuboid([-3.0, -1.0, 1.0], [-2.0, 0.0, 2.0], near, false);
    let (left, height) = (0.2, 40.0);
    builder.quad([left, -height / 2.0, FAR], [0.0, height, 0.0], [1.0, 0.0, 0.0], bar);
    let (columns, rows) = (32u32, 8u32);
    // A pixel is 1/8 of the bar's width.
    let half = f64::from(rows) / 8.0 / 2.0 / FAR;
    let vfov = 2.0 * half.atan().to_degrees();
    let view = Camera { origin: DVec3::ZERO, target: DVec3::new(0.0, 0.0, FAR), up: DVec3::Y, vfov };
    let mut scaling = builder.scaling(None);
    if !bench.has(Guard::Recentre) {
        scaling.centre = DVec3::ZERO;
    }
    let scene = builder.finish_scaled(view, None, scaling);
    let settings = Settings { max_bounces: 1, ..plain_settings(&scene, columns, rows, bench.count(256, 4096) as u32) };
    let film = bench.render(&scene, &settings)?.film;
    let (mut lit, mut moment) = (0.0, 0.0);
    for (pixel, rgb) in film.mean().iter().enumerate() {
        let column = (pixel % columns as usize) as f64 + 0.5;
        lit += f64::from(rgb[0]);
        moment += f64::from(rgb[0]) * column;
    }
    let width = lit / f64::from(rows);
    let centre = moment / lit - f64::from(columns) / 2.0;
    // The camera looks along +z with y up, so x grows to the left.
    let expected = -(left + 0.5) * 8.0;
    let why = "of a pixel, the catalogue's limit";
    Ok(vec![
        Finding::at_most("error of the bar's width, pixels", 0.1, (width - 8.0).abs(), why),
        Finding::at_most("error of the bar's centre, pixels", 0.1, (centre - expected).abs(), why),
    ])
}

/// Pixels are keyed by their place in the whole picture, so any window shows what the whole shows.
fn odd_sizes(bench: &TestBench) -> Result<Vec<Finding>> {
    let scene = placed_room(bench, 0.0, HERE);
    let mut findings = Vec::new();
    for ([width, height], crop) in [
        ([61, 47], [13, 9, 7, 5]),
        ([61, 47], [60, 46, 1, 1]),
        ([61, 47], [3, 0, 9, 47]),
        ([1, 16384], [0, 16000, 1, 384]),
        ([16384, 1], [16383, 0, 1, 1]),
        ([7, 5], [0, 0, 7, 5]),
        ([1, 1], [0, 0, 1, 1]),
    ] {
        let whole = Settings { max_bounces: 3, ..plain_settings(&scene, width, height, 2) };
        let picture = bits(bench, &scene, &whole)?;
        let window = bits(bench, &scene, &Settings { crop: Some(crop), ..whole })?;
        let [x, y, w, h] = crop;
        let place = |row: u32, column: u32| (row * width + column) as usize;
        let expected: Vec<_> = (y..y + h)
            .flat_map(|row| (x..x + w).map(move |column| (row, column)))
            .map(|(r, c)| picture[place(r, c)])
            .collect();
        findings.push(differing(format!("pixels of {w}x{h} in {width}x{height} that differ"), &expected, &window));
    }
    Ok(findings)
}
