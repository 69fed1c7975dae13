//! Rung 5: scenes whose radiance is known.
//!
//! Exact cases state the rounding they allow. In the statistical ones every pixel has the same expectation and draws its own
//! numbers, whatever the sampler, so the spread over 1,024 pixels is the error of their mean. z is judged at a false-alarm
//! rate of 1e-6 for a family of 1,000 such verdicts (|z| <= 6.109); the relative bias that would be seen nine times in ten is
//! printed beside it. Seeds are fixed.

mod harness;

use harness::Assert;
use harness::device::{plain_settings, render};
use harness::scenes::{SceneBuilder, camera, glass, lambert, mirror};
use harness::statistics::{Moments, critical_z, z_test};
use texray::render::Settings;
use texray::scene::Scene;
use texray::settings::{Hemisphere, LightPick, Lights, Roulette, Sampler};

/// A closed cube of one emissive Lambert material, seen from inside.
fn furnace(albedo: f32) -> Scene {
    let mut builder = SceneBuilder::new();
    let walls = builder.material(lambert(albedo, 1.0));
    builder.cuboid([-1.0; 3], [1.0; 3], walls, true);
    builder.finish(camera([0.1, 0.2, 0.3], [1.0, 0.0, 0.0], 70.0), None)
}

/// Verdicts that share the false-alarm rate: more than this file holds.
const TESTS: usize = 1000;

/// Every pixel within `tolerance` (relative) of `expected`.
fn assert_every_pixel(scene: &Scene, settings: &Settings, expected: f64, tolerance: f64, what: &str) {
    for (index, pixel) in render(scene, settings).film.mean().into_iter().enumerate() {
        for value in pixel.map(f64::from) {
            let error = (value / expected - 1.0).abs();
            assert!(error <= tolerance, "{what}: pixel {index} is {value}, not {expected} (relative error {error:e})");
        }
    }
}

/// The mean over a picture of 32 x 32 pixels, all of one expectation, against that. Channels of grey scenes are equal, so one
/// of them counts.
fn assert_mean(scene: &Scene, settings: &Settings, expected: f64, what: &str) {
    let settings = Settings { width: 32, height: 32, ..settings.clone() };
    let rendered = render(scene, &settings);
    assert!(rendered.report.invalid_samples.values().all(|&count| count == 0), "{what}: samples were left out");
    let pixels = Moments::of(rendered.film.mean().into_iter().map(|pixel| f64::from(pixel[0])));
    let verdict = z_test(pixels.mean, pixels.variance_of_mean(), expected);
    let seen = (critical_z(TESTS) + 1.28) * pixels.variance_of_mean().sqrt() / expected;
    println!(
        "{what}: {:.6} for {expected:.6}, z {:.2}, a bias of {:.1e} would show",
        pixels.mean, verdict.statistic, seen
    );
    verdict.assert(what, TESTS);
}

/// Cosine sampling of Lambert has no variance in a furnace: each bounce multiplies by the albedo. 1/2 and 1 are exact in
/// f32, what is left is the rounding of the division by the sample count.
#[test]
fn a_closed_furnace_is_exact_without_light_sampling() {
    let scene = furnace(0.5);
    let settings = Settings { lights: Lights::Bsdf, max_bounces: 8, ..plain_settings(&scene, 16, 16, 8) };
    assert_every_pixel(&scene, &settings, 2.0 - 2f64.powi(-8), 2e-5, "furnace 1/2");
    for max_bounces in [1, 2, 5] {
        let settings = Settings { max_bounces, ..settings.clone() };
        assert_every_pixel(&scene, &settings, 2.0 - 0.5f64.powi(max_bounces as i32), 2e-5, "capped furnace");
    }
}

#[test]
fn furnaces_of_every_estimator_agree() {
    for (albedo, expected) in [(0.5f32, 2.0 - 0.5f64.powi(8)), (0.8, (1.0 - 0.8f64.powi(9)) / 0.2)] {
        let scene = furnace(albedo);
        let base = Settings { max_bounces: 8, ..plain_settings(&scene, 32, 32, 64) };
        for lights in [Lights::Mis, Lights::Area, Lights::Bsdf] {
            for hemisphere in [Hemisphere::Cosine, Hemisphere::Uniform] {
                for roulette in [Roulette::Off, Roulette::Throughput, Roulette::Fixed(0.7)] {
                    let settings = Settings { lights, hemisphere, roulette, ..base.clone() };
                    let what = format!("furnace {albedo}, {lights:?} {hemisphere:?} {roulette:?}");
                    assert_mean(&scene, &settings, expected, &what);
                }
            }
        }
        for light_pick in [LightPick::Power, LightPick::Area, LightPick::Tree] {
            let settings = Settings { light_pick, ..base.clone() };
            assert_mean(&scene, &settings, expected, &format!("furnace {albedo}, {light_pick:?}"));
        }
        for sampler in [Sampler::Sobol, Sampler::Table] {
            let settings = Settings { sampler, roulette: Roulette::Throughput, spp: 32, ..base.clone() };
            assert_mean(&scene, &settings, expected, &format!("furnace {albedo}, {sampler:?}"));
        }
    }
}

/// A convex white body under a white sky: one bounce, weight exactly 1.
#[test]
fn a_white_body_vanishes_in_a_white_furnace() {
    let mut builder = SceneBuilder::new();
    let white = builder.material(lambert(1.0, 0.0));
    builder.cuboid([-1.0; 3], [1.0; 3], white, false);
    let scene = builder.finish(camera([3.0, 2.0, -4.0], [0.0; 3], 40.0), Some([1.0; 3]));
    assert_every_pixel(&scene, &plain_settings(&scene, 24, 24, 4), 1.0, 2e-5, "white cube");
}

/// A closed box of mirrors that emit 1 and reflect 0.9: 1 + .9 + .9² + …, without variance. 0.9 is off by 2.6e-8 of itself in
/// f32 and each of 200 products rounds by at most 6e-8, weighted by .9^k: far below 2e-5. A direction that drifted off unit
/// length, or a ray that left by an edge, would show.
#[test]
fn a_mirror_box_sums_its_geometric_series() {
    let mut builder = SceneBuilder::new();
    let mirrors = builder.material(mirror(0.9, 1.0));
    builder.cuboid([-1.0, -0.7, -0.9], [1.0, 0.8, 1.1], mirrors, true);
    let scene = builder.finish(camera([0.1, 0.2, 0.3], [1.0, 0.37, -0.6], 90.0), None);
    for max_bounces in [1, 8, 200] {
        let expected = (1.0 - 0.9f64.powi(max_bounces as i32 + 1)) / 0.1;
        let settings = Settings { max_bounces, ..plain_settings(&scene, 32, 32, 4) };
        assert_every_pixel(&scene, &settings, expected, 2e-5, &format!("mirror box, {max_bounces} bounces"));
    }
}

/// Radiance over squared index is what stays constant along a ray: a glass body in a white furnace is invisible from outside
/// and shows n^2 from inside. Paths that the bounce cap cuts are lost. Facets keep some that enter at a grazing angle going
/// around by total reflection: of 2 million paths 64 bounces lose 6e-5, 256 lose 1e-5, and 1,024 none.
#[test]
fn glass_in_a_furnace_shows_one_outside_and_n_squared_inside() {
    for (origin, target, expected) in [([0.0, 0.0, -4.0], [0.0; 3], 1.0), ([0.1, 0.05, 0.0], [1.0, 0.3, 0.2], 2.25)] {
        let mut builder = SceneBuilder::new();
        let body = builder.material(glass(1.5));
        builder.sphere([0.0; 3], 1.0, 4, body, false);
        let scene = builder.finish(camera(origin, target, 20.0), Some([1.0; 3]));
        let settings = Settings { max_bounces: 4096, ..plain_settings(&scene, 16, 16, 16) };
        assert_every_pixel(&scene, &settings, expected, 1e-4, "glass sphere in a furnace");
    }
}

/// Irradiance under a square light, by the form factor (hard-cases, case 41): L = albedo * F * Le.
#[test]
fn form_factors_are_lamberts() {
    for (corner, factor) in [([-0.5, 1.0, -0.5], 0.2394564705), ([0.0, 1.0, 0.0], 0.1385316060)] {
        let mut builder = SceneBuilder::new();
        let (floor, light) = (builder.material(lambert(0.5, 0.0)), builder.material(lambert(0.0, 1.0)));
        builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], floor);
        builder.quad(corner, [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], light);
        let scene = builder.finish(camera([0.0, 0.9, -3.0], [0.0; 3], 1e-3), None);
        for lights in [Lights::Mis, Lights::Area] {
            let settings = Settings { lights, max_bounces: 1, ..plain_settings(&scene, 32, 32, 512) };
            assert_mean(&scene, &settings, 0.5 * factor, &format!("form factor {factor}, {lights:?}"));
        }
    }
}

/// Two lights of one form factor, one 16 times the other's radiance: their probabilities differ, their sum does not.
#[test]
fn lights_of_unlike_power_add_up() {
    let mut builder = SceneBuilder::new();
    let floor = builder.material(lambert(0.5, 0.0));
    let (dim, bright) = (builder.material(lambert(0.0, 1.0)), builder.material(lambert(0.0, 16.0)));
    builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], floor);
    builder.quad([0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], dim);
    builder.quad([-1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], bright);
    let scene = builder.finish(camera([0.0, 0.9, -3.0], [0.0; 3], 1e-3), None);
    for light_pick in [LightPick::Power, LightPick::Area, LightPick::Tree] {
        let settings = Settings { light_pick, max_bounces: 1, ..plain_settings(&scene, 32, 32, 512) };
        assert_mean(&scene, &settings, 0.5 * 0.138531606 * 17.0, &format!("two lights, by {light_pick:?}"));
    }
}

/// Radiance is scaled by a power of two before it reaches f32: neither 1e-30 nor 1e30 is near the edge of anything.
#[test]
fn emission_of_any_size_is_exact() {
    for exponent in [-100, 0, 100] {
        let mut scene = furnace(0.5);
        scene.scaling.radiance_exponent = -exponent;
        let settings = Settings { lights: Lights::Bsdf, max_bounces: 8, ..plain_settings(&scene, 8, 8, 4) };
        let rendered = render(&scene, &settings);
        for value in rendered.film.mean().into_iter().flatten() {
            let unit = f64::from(value) * 2f64.powi(-exponent);
            assert!((unit / (2.0 - 2f64.powi(-8)) - 1.0).abs() < 1e-5, "2^{exponent}: {unit}");
        }
        assert!(rendered.report.invalid_samples.values().all(|&count| count == 0));
    }
}

/// Nothing a scene can hold makes a black furnace shine or a sky alone fail.
#[test]
fn degenerate_scenes_render() {
    let black = furnace(0.0);
    let settings = plain_settings(&black, 8, 8, 4);
    assert_every_pixel(&black, &Settings { lights: Lights::Bsdf, ..settings.clone() }, 1.0, 0.0, "black furnace");
    let sky = SceneBuilder::new().finish(camera([0.0; 3], [0.0, 0.0, 1.0], 40.0), Some([1.0, 1.0, 1.0]));
    assert_every_pixel(&sky, &plain_settings(&sky, 8, 8, 4), 1.0, 0.0, "sky alone");
}
