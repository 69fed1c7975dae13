//! Rung 8: whole pictures against two renderers that share no code with this one: Mitsuba 3 (stored, `tests/golden`) and the
//! tests' own f64 path tracer.
//!
//! Statistic: z of the difference of tile means, by the per-pixel variances of both pictures, largest over the conclusive
//! tiles and channels of a picture, at a false-alarm rate of 1e-6 a picture (harness/comparison.rs). Independent sampler, box
//! filter, fixed seeds; variances from up to 64 replicates a pixel. Mirrors and glass need many samples: paths by way of
//! them to the lamp are rare and bright, and tiles that have met too few have low means with low variances.

mod harness;

use harness::comparison::compare;
use harness::device::{estimate, load, plain_settings};
use harness::golden::Golden;
use harness::random::Random;
use harness::scenes::{SceneBuilder, camera, glass, material};
use harness::statistics::{ROUNDING, critical_z};
use harness::tracer::{self, render as trace};
use texray::render::Settings;
use texray::scene::{MaterialKind, Scene};
use texray::settings::{Lights, Roulette};

/// Compares a scene of the repository with its golden, without roulette and with the default one. The means of the whole
/// picture must agree too, six of them a golden at a false-alarm rate of 1e-6 for all, beside 2e-5 of rounding.
fn agrees_with_mitsuba(name: &str, spp: u32, inconclusive: f64) {
    let golden = Golden::load(name).unwrap_or_else(|why| panic!("{why}"));
    let mut scene = load(name);
    golden.prepare(&mut scene);
    let reference = golden.scaled(&scene.scaling);
    for (roulette, seed) in [(Roulette::Off, 1), (Roulette::Throughput, 2)] {
        let plain = plain_settings(&scene, golden.width, golden.height, spp);
        let settings = Settings { roulette, seed, max_bounces: golden.max_bounces, ..plain };
        let comparison = compare(&estimate(&scene, &settings), &reference, golden.width as usize, 8);
        let conclusive = comparison.tiles.iter().filter(|tile| !tile.inconclusive);
        let squares: f64 = conclusive.clone().map(|tile| tile.z * tile.z).sum();
        let rms = (squares / conclusive.count() as f64).sqrt();
        println!(
            "{name}, {spp} spp, roulette {roulette:?}: worst z {:.2}, rms {rms:.3}, {} of {} tiles inconclusive, mean ratios {:.5?} ± {:.5?}",
            comparison.worst().map_or(0.0, |tile| tile.z),
            comparison.inconclusive().count(),
            comparison.tiles.len(),
            comparison.mean_ratio,
            comparison.ratio_error,
        );
        comparison.assert(&format!("{name}, roulette {roulette:?}"), inconclusive);
        for (ratio, error) in comparison.mean_ratio.into_iter().zip(comparison.ratio_error) {
            assert!(
                (ratio - 1.0).abs() <= critical_z(6) * error + ROUNDING,
                "{name}, roulette {roulette:?}: {ratio} ± {error}"
            );
        }
    }
}

#[test]
fn the_cornell_box_agrees_with_mitsuba() {
    agrees_with_mitsuba("cornell-box", 256, 0.05);
}

#[test]
fn the_mirror_agrees_with_mitsuba() {
    agrees_with_mitsuba("cornell-mirror", 1024, 0.1);
}

#[test]
fn the_glass_agrees_with_mitsuba() {
    agrees_with_mitsuba("cornell-glass", 1024, 0.3);
}

#[test]
fn a_wrong_picture_is_found() {
    // Control: one bounce fewer.
    let golden = Golden::load("cornell-box").unwrap_or_else(|why| panic!("{why}"));
    let mut scene = load("cornell-box");
    golden.prepare(&mut scene);
    let plain = plain_settings(&scene, golden.width, golden.height, 64);
    let picture = estimate(&scene, &Settings { max_bounces: golden.max_bounces - 4, ..plain });
    let comparison = compare(&picture, &golden.scaled(&scene.scaling), golden.width as usize, 8);
    assert!(comparison.worst().expect("a tile").z > 7.0, "{:?}", comparison.worst());
}

/// A small scene: a room with a lamp, or a floor under a sky (with a lamp or without), and three bodies of random kinds.
fn random_scene(seed: u64) -> Scene {
    let mut random = Random::new(seed, 0);
    let mut builder = SceneBuilder::new();
    let mut colour = |low: f64, high: f64| std::array::from_fn(|_| (low + (high - low) * random.next()) as f32);
    let surface = |kind| material(kind, [0.0; 3]);
    let walls = builder.material(surface(MaterialKind::Lambert { albedo: colour(0.3, 0.8) }));
    let lamp = builder.material(material(MaterialKind::Lambert { albedo: colour(0.0, 0.5) }, colour(2.0, 6.0)));
    let bodies = [
        surface(MaterialKind::Lambert { albedo: colour(0.2, 0.9) }),
        surface(MaterialKind::Mirror { reflectance: colour(0.5, 1.0) }),
        glass(1.5),
        material(MaterialKind::Lambert { albedo: colour(0.2, 0.6) }, colour(0.1, 0.4)),
    ];
    let sky = (seed % 2 == 1).then(|| colour(0.2, 1.0));
    match sky {
        None => builder.cuboid([-1.0; 3], [1.0; 3], walls, true),
        Some(_) => builder.quad([-3.0, -1.0, -3.0], [0.0, 0.0, 6.0], [6.0, 0.0, 0.0], walls),
    }
    if seed % 4 != 3 {
        builder.quad([-0.7, 0.95, -0.7], [1.4, 0.0, 0.0], [0.0, 0.0, 1.4], lamp);
    }
    for (i, at) in [-0.55, 0.05, 0.6].into_iter().enumerate() {
        let body = builder.material(bodies[(seed as usize + i * 3 + i * seed as usize) % 4].clone());
        let [x, z, size] = [at + 0.1 * random.next(), 0.8 * random.next() - 0.5, 0.2 + 0.12 * random.next()];
        match (seed + i as u64) % 3 {
            0 => builder.sphere([x, -0.95 + size, z], size, 0, body, true),
            1 => builder.sphere([x, -0.95 + size, z], size, 1, body, seed.is_multiple_of(2)),
            _ => {
                builder.cuboid([x - size, -0.98, z - size], [x + size * 0.8, -1.0 + 2.0 * size, z + size], body, false)
            }
        }
    }
    let [x, y] = [0.3, 0.2].map(|range| range * (random.next() - 0.5));
    builder.finish(camera([x, y, -0.95], [0.0, -0.35, 0.2], 75.0), sky)
}

#[test]
fn random_rooms_agree_with_the_f64_tracer() {
    agree_with_the_f64_tracer([0, 2, 4, 6]);
}

#[test]
fn random_scenes_under_a_sky_agree_with_the_f64_tracer() {
    agree_with_the_f64_tracer([1, 3, 5, 7]);
}

fn agree_with_the_f64_tracer(seeds: [u64; 4]) {
    const SIDE: u32 = 16;
    for seed in seeds {
        let scene = random_scene(seed);
        assert!(scene.triangles.len() <= 80, "{}", scene.triangles.len());
        let lights = [Lights::Mis, Lights::Mis, Lights::Area, Lights::Mis][seed as usize % 4];
        let max_bounces = 3 + (seed % 3) as u32;
        let plain = plain_settings(&scene, SIDE, SIDE, 2048);
        let picture = estimate(&scene, &Settings { lights, max_bounces, seed, ..plain });
        let reference = trace(&scene, SIDE, SIDE, 512, max_bounces, seed, tracer::Lights::Mis);
        let comparison = compare(&picture, &reference, SIDE as usize, 4);
        println!(
            "scene {seed}: {} triangles, worst z {:.2}, {} of {} tiles inconclusive, mean ratios {:.4?} ± {:.4?}",
            scene.triangles.len(),
            comparison.worst().map_or(0.0, |tile| tile.z),
            comparison.inconclusive().count(),
            comparison.tiles.len(),
            comparison.mean_ratio,
            comparison.ratio_error,
        );
        comparison.assert(&format!("random scene {seed}"), 0.25);
    }
}
