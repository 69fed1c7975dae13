//! Many lights: the light tree against the other ways to choose one.
//!
//! Comes in: rooms with lights of many powers that face any way. Every estimator has one expectation, judged by z at 1e-6 for a
//! family of a thousand such verdicts (|z| <= 6.11), with standard errors from replicates; seeds are fixed. Equal pictures are
//! compared bit by bit. How words are shared out and drawn is hard case 43 (`src/selftest/cases/light_trees.rs`).

mod harness;

use harness::device::{assert_same, bits, context, plain_settings, render, render_tuned};
use harness::random::Random;
use harness::scenes::{SceneBuilder, camera, lambert};
use harness::statistics::{critical_z, z_test};
use texray::render::Tuning;
use texray::scene::Scene;
use texray::selftest::kit::scattering::{Measured, measure};
use texray::selftest::{TestBench, Tier};
use texray::settings::{Buffers, LightPick, Lights, Sampler, Settings};

/// More verdicts than this file gives.
const TESTS: usize = 1000;

/// A room of 4 x 2 x 4 whose walls reflect, with lights of radiances from 1 to 100 in its upper half that face any way, among
/// them slivers. The camera looks at the floor and sees none of them: lights in view would be most of a pixel's variance.
fn room(lights: u32, largest: f64) -> Scene {
    let mut builder = SceneBuilder::new();
    let walls = builder.material(lambert(0.6, 0.0));
    let shine: Vec<u32> = (0..5).map(|i| builder.material(lambert(0.2, 10f32.powf(i as f32 / 2.0)))).collect();
    builder.cuboid([-2.0, 0.0, -2.0], [2.0, 2.0, 2.0], walls, true);
    builder.cuboid([-0.5, 0.0, -0.5], [0.5, 0.7, 0.5], walls, false);
    let mut random = Random::new(7, u64::from(lights));
    let size = largest / f64::from(lights).sqrt();
    for i in 0..lights {
        let corner = random.point().as_dvec3() * glam::DVec3::new(1.8, 0.5, 1.8) + glam::DVec3::Y * 1.4;
        let [a, b] = [0; 2].map(|_| random.direction().as_dvec3() * size);
        let b = if i % 7 == 0 { a * 0.5 + b * 1e-3 } else { b };
        builder.triangle([corner, corner + a, corner + b], shine[random.below(shine.len())]);
    }
    builder.finish(camera([0.0, 0.75, 1.9], [0.0, 0.0, 0.3], 30.0), None)
}

fn of(scene: &Scene, lights: Lights, light_pick: LightPick, seed: u64, spp: u32) -> Measured {
    let base = plain_settings(scene, 32, 32, spp);
    let sampler = Sampler::Sobol;
    let settings = Settings { lights, light_pick, seed, sampler, max_bounces: 3, replicates: Some(4), ..base };
    let measured =
        measure(&TestBench::new(context(), Tier::Full), scene, &settings).expect("the scene can be rendered");
    assert_eq!(measured.invalid, 0, "{lights:?} {light_pick:?}: samples were left out");
    measured
}

#[test]
fn every_way_to_choose_a_light_has_one_expectation() {
    for count in [3, 40, 1000] {
        let scene = room(count, 0.5);
        let tree = of(&scene, Lights::Mis, LightPick::Tree, 1, 256);
        for (seed, (lights, pick)) in (2..).zip([
            (Lights::Mis, LightPick::Power),
            (Lights::Mis, LightPick::Area),
            (Lights::Bsdf, LightPick::Power),
            (Lights::Area, LightPick::Tree),
        ]) {
            let other = of(&scene, lights, pick, seed, 256);
            let verdict = z_test(other.mean, other.variance + tree.variance, tree.mean);
            let error = (other.variance + tree.variance).sqrt() / tree.mean;
            println!("{count} lights, {lights:?} {pick:?}: z {:.2}, relative error {error:.1e}", verdict.statistic);
            assert!(verdict.passes(TESTS), "{count} lights, {lights:?} {pick:?}: {} and {}", other.mean, tree.mean);
            assert!(error < 0.1, "the verdict says something: {error} ({})", critical_z(TESTS));
        }
    }
}

/// What the tree is for: with many lights a sample by the tree is worth more than one by power.
#[test]
fn a_sample_by_the_tree_is_worth_more() {
    let scene = room(200, 0.1);
    let [tree, power] = [LightPick::Tree, LightPick::Power].map(|pick| of(&scene, Lights::Mis, pick, 3, 64).variance);
    println!("variance by power over that by the tree: {:.1}", power / tree);
    assert!(tree * 2.0 < power, "{tree} by the tree, {power} by power");
}

#[test]
fn the_default_goes_by_the_number_of_lights() {
    for (count, expected) in [(1, LightPick::Power), (15, LightPick::Power), (16, LightPick::Tree)] {
        assert_eq!(Settings::for_scene(&room(count, 0.1)).light_pick, expected, "{count} lights");
    }
}

/// Descents stop and go on with the path: neither the budget nor the kind of buffer shows, with as many lights as the issue asks for.
#[test]
fn a_hundred_thousand_lights_at_any_budget() {
    let scene = room(100_000, 0.3);
    let base = plain_settings(&scene, 24, 16, 4);
    let settings = Settings { light_pick: LightPick::Tree, max_bounces: 3, ..base };
    let expected = bits(&render(&scene, &settings));
    assert!(expected.iter().flatten().any(|&word| word != 0));
    for budget in [64, 300, 8191] {
        let tuning = Tuning { budget: Some(budget), ..Tuning::default() };
        assert_same(&bits(&render_tuned(&scene, &settings, &tuning)), &expected, &format!("budget {budget}"));
    }
    let storage = Settings { buffers: Buffers::Storage, ..settings };
    assert_same(&bits(&render(&scene, &storage)), &expected, "storage buffers");
}

/// Lights that all show their backs: no light at all, exactly. The floor is seen, not the lights.
#[test]
fn lights_from_behind_give_nothing() {
    let mut builder = SceneBuilder::new();
    let (floor, light) = (builder.material(lambert(0.5, 0.0)), builder.material(lambert(0.0, 1.0)));
    builder.quad([-4.0, 0.0, -4.0], [0.0, 0.0, 8.0], [8.0, 0.0, 0.0], floor);
    for i in 0..20 {
        builder.quad([f64::from(i) * 0.2 - 2.0, 1.0, -1.0], [0.0, 0.0, 0.1], [0.1, 0.0, 0.0], light);
    }
    let scene = builder.finish(camera([0.0, 0.5, -1.5], [0.0; 3], 30.0), None);
    for lights in [Lights::Mis, Lights::Area] {
        let settings =
            Settings { lights, light_pick: LightPick::Tree, max_bounces: 2, ..plain_settings(&scene, 16, 16, 32) };
        let rendered = render(&scene, &settings);
        assert!(rendered.film.mean().into_iter().flatten().all(|value| value == 0.0), "{lights:?}");
        assert!(rendered.report.invalid_samples.values().all(|&count| count == 0));
    }
}
