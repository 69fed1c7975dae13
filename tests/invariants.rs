//! What holds for any scene, shown on random ones of at most 200 triangles, which shrink to small ones where it does not.
//!
//! Seeds are fixed, so a run is the same everywhere on one driver; [`CASES`] scenes a property. Exact properties compare the
//! bits of pictures. Statistical ones hold two pictures of one expectation against each other, tile by tile, with the variances
//! that their replicates give (z of one of [`TESTS`] at a false-alarm rate of 1e-6 for all). What named scenes show, bit for
//! bit, stands in frames.rs and effects.rs.
//!
//! Of the catalogue's twenty invariants others are shown elsewhere: reciprocity, energy, densities and samples against values
//! (1 to 5) by the cases 48, 49 and 57 of src/selftest, for the one lobe that has them all; drivers (13) by drivers.rs; the CPU's
//! twins (20) by traversal.rs and warps.rs. Resuming (11) and further layers (19) are not built.

mod harness;

use glam::Vec3;
use harness::device::{bits, render, render_tuned};
use harness::random::Random;
use harness::scenes::lambert;
use harness::sketch::{ALL, Sketch, TILE, sketches};
use harness::statistics::z_test;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseError, TestRng, TestRunner};
use texray::bvh::Builder;
use texray::interface::NO_INDEX;
use texray::render::Tuning;
use texray::scene::{Scene, Triangle};
use texray::settings::{AccelKind, Buffers, Hemisphere, LightPick, Lights, Roulette, Settings};

/// Scenes that each property is shown on.
const CASES: u32 = 8;
/// More statistical verdicts than this file gives.
const TESTS: usize = 4000;

type Verdict = Result<(), String>;

/// Shows a property on [`CASES`] random scenes; the smallest that breaks it is printed.
fn for_all(stream: u8, property: impl Fn(&Sketch) -> Verdict) {
    // No file of failures: the seed is fixed.
    let config = Config { cases: CASES, failure_persistence: None, max_shrink_iters: 200, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[stream; 32]));
    let run = runner.run(&sketches(), |sketch| property(&sketch).map_err(TestCaseError::fail));
    if let Err(failure) = run {
        panic!("{failure}");
    }
}

type Bits = Vec<[u32; 3]>;

fn picture(scene: &Scene, settings: &Settings) -> Bits {
    bits(&render(scene, settings))
}

fn same(a: &Bits, b: &Bits, what: impl std::fmt::Debug) -> Verdict {
    let differing = a.iter().zip(b).filter(|(a, b)| a != b).count();
    match a.len() == b.len() && differing == 0 {
        true => Ok(()),
        false => Err(format!("{what:?}: {differing} of {} pixels differ", a.len())),
    }
}

/// Mean and its variance of each tile and channel, where `turned` of the picture from right to left.
fn tiles(scene: &Scene, settings: &Settings, turned: bool) -> Vec<(f64, f64)> {
    let rendered = render(scene, settings);
    assert!(rendered.report.invalid_samples.values().all(|&count| count == 0), "samples were left out");
    let estimate = rendered.film.estimate();
    let (width, tile) = (settings.width as usize, TILE as usize);
    let mut tiles = vec![(0.0, 0.0); 3 * estimate.mean.len() / (tile * tile)];
    for pixel in 0..estimate.mean.len() {
        let (x, y) = (pixel % width, pixel / width);
        let x = if turned { width - 1 - x } else { x };
        for channel in 0..3 {
            let place = &mut tiles[3 * (y / tile * (width / tile) + x / tile) + channel];
            place.0 += f64::from(estimate.mean[pixel][channel]);
            place.1 += estimate.variance[pixel][channel];
        }
    }
    tiles
}

/// Two pictures of one expectation.
fn agree(a: &[(f64, f64)], b: &[(f64, f64)], what: impl std::fmt::Debug) -> Verdict {
    for (tile, (a, b)) in a.iter().zip(b).enumerate() {
        // Where nothing varies, as under a sky alone, both are the same.
        let verdict = z_test(a.0, a.1 + b.1, b.0);
        if a.0 != b.0 && !verdict.passes(TESTS) {
            return Err(format!("{what:?}, tile {tile}: {} and {}, z {:.2}", a.0, b.0, verdict.statistic));
        }
    }
    Ok(())
}

/// Invariant 6: every estimator has the same expectation.
#[test]
fn estimators_agree() {
    for_all(6, |sketch| {
        let scene = sketch.scene();
        let base = sketch.many(&scene, 0);
        let reference = tiles(&scene, &base, false);
        for lights in [Lights::Area, Lights::Bsdf] {
            agree(&reference, &tiles(&scene, &Settings { lights, ..base.clone() }, false), lights)?;
        }
        let hemisphere = Hemisphere::Uniform;
        agree(&reference, &tiles(&scene, &Settings { hemisphere, ..base.clone() }, false), hemisphere)?;
        let roulette = Roulette::Off;
        agree(&reference, &tiles(&scene, &Settings { roulette, ..base.clone() }, false), roulette)?;
        for light_pick in [LightPick::Area, LightPick::Tree] {
            agree(&reference, &tiles(&scene, &Settings { light_pick, ..base.clone() }, false), light_pick)?;
        }
        Ok(())
    });
}

/// Invariant 7: light of 2^k times the radiance gives 2^k times the picture, bit for bit.
#[test]
fn light_scales_exactly_by_powers_of_two() {
    for_all(7, |sketch| {
        let (scene, exponent) = (sketch.scene(), (sketch.seed % 160) as i32 - 80);
        let scaled = sketch.lit(ALL.map(|light| light * 2f32.powi(exponent)));
        let settings = sketch.settings(&scene);
        let unscale = |pixel: [u32; 3]| pixel.map(|bits| (f32::from_bits(bits) * 2f32.powi(-exponent)).to_bits());
        let back: Bits = picture(&scaled, &settings).into_iter().map(unscale).collect();
        same(&picture(&scene, &settings), &back, exponent)
    });
}

/// Invariant 7: light adds up. Paths that know nothing of the light (no light samples, no roulette) are the same whatever
/// shines, so each pixel's sum is off by rounding alone: 300 of 2^-24.
#[test]
fn light_adds_up() {
    for_all(8, |sketch| {
        let [lamp, glow, sky] = ALL;
        let pictures = [ALL, [lamp, 0.0, 0.0], [0.0, glow, sky]].map(|light| {
            let scene = sketch.lit(light);
            let (lights, roulette) = (Lights::Bsdf, Roulette::Off);
            let settings = Settings { lights, roulette, allow_black: true, ..sketch.settings(&scene) };
            render(&scene, &settings).film.mean()
        });
        let [whole, lamp, rest] = pictures.each_ref().map(|picture| picture.as_flattened());
        for (place, whole) in whole.iter().enumerate() {
            let sum = lamp[place] + rest[place];
            if (whole - sum).abs() > 2e-5 * whole {
                return Err(format!("pixel {}: {whole}, not {sum}", place / 3));
            }
        }
        Ok(())
    });
}

/// Invariant 8: what no path reaches does not show. Behind the camera, beyond the wall, stands a black box; two specks keep
/// the bounds the same with it and without.
#[test]
fn a_black_object_behind_the_camera_does_not_show() {
    for_all(9, |sketch| {
        let sketch = Sketch { room: true, ..sketch.clone() };
        let scene = |hidden: bool| {
            let mut builder = sketch.builder([ALL[0], ALL[1]]);
            let black = builder.material(lambert(0.0, 0.0));
            for at in [[-2.0, -2.0, -4.0], [2.0, 2.0, -1.5]] {
                builder.cuboid(at, at.map(|x| x + 0.01), black, false);
            }
            if hidden {
                builder.cuboid([-0.7, -0.6, -3.1], [0.4, 0.9, -1.3], black, false);
            }
            builder.finish(sketch.camera(), None)
        };
        let settings = sketch.settings(&scene(false));
        same(&picture(&scene(false), &settings), &picture(&scene(true), &settings), "hidden box")
    });
}

/// Invariant 9: a kernel with only the effects that the scene calls for, and one with all.
#[test]
fn all_effects_change_nothing() {
    for_all(10, |sketch| {
        let scene = sketch.scene();
        let settings = sketch.settings(&scene);
        let all = Settings { all_effects: true, ..settings.clone() };
        same(&picture(&scene, &settings), &picture(&scene, &all), "all effects")
    });
}

/// Invariants 10 and 12: neither the cut of the work nor a repetition shows; another seed does.
#[test]
fn neither_cuts_nor_repetition_show() {
    for_all(11, |sketch| {
        let scene = sketch.scene();
        let settings = sketch.settings(&scene);
        let reference = picture(&scene, &settings);
        same(&reference, &picture(&scene, &settings), "again")?;
        let mut random = Random::new(sketch.seed, 0);
        let mut number = |from: usize, to: usize| (from + random.below(to - from + 1)) as u32;
        let tuning = Tuning {
            tile: Some([number(4, 21), number(3, 17)]),
            run_samples: Some(number(1, 16)),
            budget: Some(number(64, 2000)),
            refill_eighths: Some(number(0, 8)),
            ..Tuning::default()
        };
        same(&reference, &bits(&render_tuned(&scene, &settings, &tuning)), &tuning)?;
        let other = picture(&scene, &Settings { seed: !settings.seed, ..settings });
        let flat = reference.windows(2).all(|pair| pair[0] == pair[1]);
        if flat || other != reference { Ok(()) } else { Err("the seed does not show".into()) }
    });
}

/// Invariant 14: trees, builders, kinds of buffer; and the order of triangles, as far as it is not the order of lights.
#[test]
fn neither_trees_nor_the_order_of_triangles_show() {
    for_all(12, |sketch| {
        let scene = sketch.scene();
        let settings = sketch.settings(&scene);
        let reference = picture(&scene, &settings);
        for (accel, builder, buffers) in [
            (AccelKind::Brute, Builder::Sah, Buffers::Texel),
            (AccelKind::Binary, Builder::Median, Buffers::Storage),
            (AccelKind::Wide, Builder::Median, Buffers::Texel),
        ] {
            let settings = Settings { accel, builder, buffers, ..settings.clone() };
            same(&reference, &picture(&scene, &settings), (accel, builder, buffers))?;
        }
        let emits = |triangle: &Triangle| scene.materials[triangle.material as usize].emits();
        let dark: Vec<usize> = (0..scene.triangles.len()).filter(|&i| !emits(&scene.triangles[i])).collect();
        let mut random = Random::new(sketch.seed, 1);
        let mut shuffled = scene.clone();
        for i in (1..dark.len()).rev() {
            shuffled.triangles.swap(dark[i], dark[random.below(i + 1)]);
        }
        same(&reference, &picture(&shuffled, &settings), "shuffled")
    });
}

/// Invariant 15: the order of all triangles, lights too, and the diagonal that cuts a parallelogram.
#[test]
fn order_and_diagonals_keep_the_mean() {
    for_all(13, |sketch| {
        let scene = sketch.scene();
        let reference = tiles(&scene, &sketch.many(&scene, 0), false);
        let mut reversed = scene.clone();
        reversed.triangles.reverse();
        agree(&reference, &tiles(&reversed, &sketch.many(&scene, 1), false), "reversed")?;
        let mut cut = scene.clone();
        let mut turned = 0;
        for first in 0..cut.triangles.len() - 1 {
            let [[a, b, c], [a2, c2, d]] = [first, first + 1].map(|i| cut.triangles[i].positions);
            // Rounding moves a corner by at most 2^-24 an operation.
            let parallelogram = a == a2 && c == c2 && (a + c - b - d).abs().max_element() < 1e-6;
            if parallelogram && cut.triangles[first].corners == NO_INDEX {
                (cut.triangles[first].positions, cut.triangles[first + 1].positions) = ([a, b, d], [b, c, d]);
                turned += 1;
            }
        }
        assert!(turned > 0, "the lamp is a parallelogram");
        agree(&reference, &tiles(&cut, &sketch.many(&scene, 2), false), "other diagonals")
    });
}

/// Invariant 16: the mirrored scene has the mirrored picture.
#[test]
fn a_mirrored_scene_has_the_mirrored_picture() {
    let seen = std::cell::Cell::new(false);
    for_all(14, |sketch| {
        let scene = sketch.scene();
        let reference = tiles(&scene, &sketch.many(&scene, 0), false);
        let mut turned = scene.clone();
        let flip = Vec3::new(-1.0, 1.0, 1.0);
        // Two corners change places, so that the front stays the front.
        for triangle in &mut turned.triangles {
            let [a, b, c] = triangle.positions.map(|position| position * flip);
            triangle.positions = [a, c, b];
        }
        for corners in &mut turned.corners {
            let [a, b, c] = corners.normals.map(|normal| normal * flip);
            corners.normals = [a, c, b];
        }
        turned.camera.origin.x *= -1.0;
        turned.camera.target.x *= -1.0;
        let settings = sketch.many(&scene, 1);
        seen.set(seen.get() || agree(&reference, &tiles(&turned, &settings, false), "as it is").is_err());
        agree(&reference, &tiles(&turned, &settings, true), "mirrored")
    });
    assert!(seen.get(), "control: no scene tells its picture from the mirrored one");
}

/// Invariant 17: a crop is that part of the picture.
#[test]
fn crops_are_parts() {
    for_all(15, |sketch| {
        let scene = sketch.scene();
        let settings = sketch.settings(&scene);
        let whole = picture(&scene, &settings);
        let mut random = Random::new(sketch.seed, 2);
        let mut window = |size: u32| {
            let start = random.below(size as usize) as u32;
            (start, 1 + random.below((size - start) as usize) as u32)
        };
        let ((x, width), (y, height)) = (window(settings.width), window(settings.height));
        let row = |row: u32| &whole[(row * settings.width + x) as usize..][..width as usize];
        let part: Bits = (y..y + height).flat_map(row).copied().collect();
        let crop = Some([x, y, width, height]);
        same(&part, &picture(&scene, &Settings { crop, ..settings.clone() }), crop)
    });
}

/// Invariant 18: twice as many lights, each of half the power. A surface light hides a copy of itself, so each is cut in two
/// by its area and keeps its radiance.
#[test]
fn lights_cut_in_two_keep_the_mean() {
    for_all(16, |sketch| {
        let scene = sketch.scene();
        let reference = tiles(&scene, &sketch.many(&scene, 0), false);
        let mut halves = scene.clone();
        for at in 0..scene.triangles.len() {
            let triangle = scene.triangles[at];
            if scene.materials[triangle.material as usize].emits() && triangle.corners == NO_INDEX {
                let [a, b, c] = triangle.positions;
                let middle = (b + c) / 2.0;
                halves.triangles[at].positions = [a, b, middle];
                halves.triangles.push(Triangle { positions: [a, middle, c], ..triangle });
            }
        }
        agree(&reference, &tiles(&halves, &sketch.many(&scene, 1), false), "lights in two")
    });
}
