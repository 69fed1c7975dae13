//! Rung 7: a picture does not depend on how the work is cut: runs, tiles, budgets, crops, trees, buffer kinds, repetition.
//!
//! All tests are exact: bytes of the picture are compared. Scenes of the repository at a small size stand for every effect.

mod harness;

use glam::DVec3;
use harness::device::{Silent, assert_same, assert_valid, bits, context, load, render, render_tuned};
use harness::meshes;
use harness::scenes::{SceneBuilder, camera, lambert};
use texray::bvh::Builder;
use texray::gpu::Direction;
use texray::interface::NO_INDEX;
use texray::render::{Renderer, Settings, StopReason, Tuning, build_accel};
use texray::scene::Camera;
use texray::settings::{AccelKind, Buffers, Roulette, Sampler};

/// A scene of the repository with its own defaults, small: no number of pixels is a multiple of the workgroup's 8.
fn small(name: &str, [width, height]: [u32; 2], spp: u32) -> (texray::scene::Scene, Settings) {
    let scene = load(name);
    let settings = Settings { width, height, spp, ..Settings::for_scene(&scene) };
    (scene, settings)
}

#[test]
fn two_renders_are_the_same_and_another_seed_differs() {
    let (scene, settings) = small("cornell-glass", [33, 25], 5);
    let first = bits(&render(&scene, &settings));
    assert_same(&first, &bits(&render(&scene, &settings)), "second render");
    assert_ne!(first, bits(&render(&scene, &Settings { seed: 1, ..settings })));
}

#[test]
fn budgets_do_not_show() {
    let (scene, settings) = small("cornell-glass", [17, 13], 2);
    let reference = bits(&render(&scene, &settings));
    for accel in [AccelKind::Wide, AccelKind::Binary, AccelKind::Brute] {
        for budget in [64, 1000, 8191] {
            let tuning = Tuning { budget: Some(budget), ..Tuning::default() };
            let settings = Settings { accel, ..settings.clone() };
            let picture = bits(&render_tuned(&scene, &settings, &tuning));
            assert_same(&reference, &picture, &format!("{accel:?}, budget {budget}"));
        }
    }
}

#[test]
fn tiles_and_runs_do_not_show() {
    // 35 samples: two closed blocks and an open one.
    let (scene, settings) = small("cornell-mirror", [26, 21], 35);
    let reference = bits(&render(&scene, &settings));
    for tile in [[26, 21], [26, 7], [9, 21], [13, 11]] {
        for run_samples in [None, Some(1), Some(3), Some(16)] {
            let tuning = Tuning { tile: Some(tile), run_samples, ..Tuning::default() };
            let picture = bits(&render_tuned(&scene, &settings, &tuning));
            assert_same(&reference, &picture, &format!("tile {tile:?}, run {run_samples:?}"));
        }
    }
}

#[test]
fn refill_thresholds_do_not_show() {
    let (scene, settings) = small("cornell-glass", [33, 25], 4);
    let reference = bits(&render(&scene, &settings));
    for eighths in [0, 4, 8] {
        let tuning = Tuning { refill_eighths: Some(eighths), ..Tuning::default() };
        assert_same(&reference, &bits(&render_tuned(&scene, &settings, &tuning)), &format!("{eighths} eighths"));
    }
}

/// Pixels that are left for another dispatch go on among other neighbours, in whatever order they were listed: nothing of it shows,
/// alone and together with budgets that leave paths anywhere.
#[test]
fn lists_of_pixels_do_not_show() {
    // More pixels than are worth another dispatch, in rows that the workgroups do not divide.
    let (scene, settings) = small("cornell-glass", [61, 45], 4);
    // Slices of eight rows, and of 512 listed pixels.
    let picture = |leave, budget| {
        let tuning = Tuning { leave_eighths: Some(leave), budget, slice_pixels: Some(512), ..Tuning::default() };
        render_tuned(&scene, &settings, &tuning)
    };
    let reference = picture(0, None);
    for (leave, budget) in [(3, None), (5, None), (8, None), (0, Some(64)), (5, Some(64)), (5, Some(200))] {
        let listed = picture(leave, budget);
        let what = format!("left below {leave} eighths, budget {budget:?}");
        assert_same(&bits(&reference), &bits(&listed), &what);
        assert_eq!(
            (reference.report.rays, reference.report.paths),
            (listed.report.rays, listed.report.paths),
            "{what}"
        );
        assert!(listed.ledger.bytes_down() > reference.ledger.bytes_down(), "{what}: no dispatch more");
    }
}

/// Triangles that wait for the next visit are tested in another order: the same hits, under every budget and in every tree.
#[test]
fn queues_of_triangles_do_not_show() {
    let (scene, settings) = small("bunny", [33, 25], 4);
    for accel in [AccelKind::Wide, AccelKind::Binary, AccelKind::Brute] {
        let settings = Settings { accel, ..settings.clone() };
        let picture = |tests_a_visit, budget| {
            let tuning = Tuning { tests_a_visit: Some(tests_a_visit), budget, ..Tuning::default() };
            render_tuned(&scene, &settings, &tuning)
        };
        let reference = picture(0, None);
        for (tests, budget) in [(1, None), (1, Some(64)), (2, None), (2, Some(64))] {
            let queued = picture(tests, budget);
            let what = format!("{accel:?}, {tests} tests a visit, budget {budget:?}");
            assert_same(&bits(&reference), &bits(&queued), &what);
            // What waits culls nothing yet: the queue shows in the work, so it was there.
            assert!(accel == AccelKind::Brute || queued.report.node_visits > reference.report.node_visits);
        }
    }
}

/// The modules that keep NaN and those that leave it to the driver.
#[test]
fn keeping_nan_does_not_show() {
    for name in ["cornell-glass", "cornell-mirror", "teapot"] {
        let (scene, settings) = small(name, [33, 25], 4);
        let kept = bits(&render(&scene, &settings));
        let tuning = Tuning { nan_by_driver: true, ..Tuning::default() };
        assert_same(&kept, &bits(&render_tuned(&scene, &settings, &tuning)), name);
    }
}

#[test]
fn a_crop_is_that_part_of_the_picture() {
    let (scene, settings) = small("cornell-box", [40, 30], 20);
    let whole = bits(&render(&scene, &settings));
    for [x, y, width, height] in [[0, 0, 40, 30], [7, 3, 11, 13], [39, 29, 1, 1], [0, 12, 40, 1]] {
        let crop = Settings { crop: Some([x, y, width, height]), ..settings.clone() };
        let part: Vec<_> =
            (y..y + height).flat_map(|row| whole[(row * 40 + x) as usize..][..width as usize].to_vec()).collect();
        assert_same(&part, &bits(&render(&scene, &crop)), &format!("crop {x},{y} {width}x{height}"));
    }
}

#[test]
fn trees_builders_and_buffer_kinds_do_not_show() {
    for name in ["cornell-box", "cornell-coplanar", "room", "teapot"] {
        let (scene, settings) = small(name, [29, 22], 1);
        let reference = bits(&render(&scene, &settings));
        for accel in [AccelKind::Wide, AccelKind::Binary, AccelKind::Brute] {
            for builder in [Builder::Sah, Builder::Median] {
                for buffers in [Buffers::Texel, Buffers::Storage] {
                    if accel == AccelKind::Brute && (builder, buffers) != (Builder::Sah, Buffers::Storage) {
                        continue;
                    }
                    let settings = Settings { accel, builder, buffers, ..settings.clone() };
                    let picture = bits(&render(&scene, &settings));
                    assert_same(&reference, &picture, &format!("{name}, {accel:?} {builder:?} {buffers:?}"));
                }
            }
        }
    }
}

#[test]
fn how_path_states_are_read_does_not_show() {
    for name in ["cornell-box", "cornell-glass", "lanterns", "teapot"] {
        let (scene, settings) = small(name, [29, 22], 3);
        // A small budget stores and loads each path many times.
        let tuned = |path_buffers| Tuning { path_buffers: Some(path_buffers), budget: Some(64), ..Tuning::default() };
        let [texel, storage] = [Buffers::Texel, Buffers::Storage].map(|path_buffers| {
            let rendered = render_tuned(&scene, &settings, &tuned(path_buffers));
            assert_eq!(rendered.report.path_buffers, path_buffers, "{name}");
            bits(&rendered)
        });
        assert_same(&texel, &storage, name);
        assert_same(&texel, &bits(&render(&scene, &settings)), name);
    }
}

#[test]
fn samplers_repeat_and_differ() {
    let (scene, settings) = small("cornell-box", [33, 25], 17);
    let picture = |sampler| bits(&render(&scene, &Settings { sampler, ..settings.clone() }));
    let pictures = [Sampler::Sobol, Sampler::Independent, Sampler::Table].map(picture);
    assert_same(&pictures[2], &picture(Sampler::Table), "table again");
    assert_ne!(pictures[0], pictures[1]);
    assert_ne!(pictures[1], pictures[2]);
}

/// The thesis's version, one thread a pixel over all triangles in one go, crashed above 3,000 triangles; here a path stops
/// and goes on, so 100,000 triangles only take their time.
#[test]
fn brute_force_over_a_hundred_thousand_triangles_agrees_with_the_tree() {
    let mut builder = SceneBuilder::new();
    let (grey, light) = (builder.material(lambert(0.7, 0.0)), builder.material(lambert(0.0, 1.0)));
    // 8 * 4^6 = 32,768 triangles a sphere, and 8,192 in the small one.
    builder.sphere([-1.0, 0.0, 0.0], 1.0, 6, grey, false);
    builder.sphere([1.0, 0.0, 0.0], 1.0, 6, grey, false);
    builder.sphere([0.0, 1.2, 1.0], 0.9, 6, light, false);
    builder.sphere([0.0, -0.7, -1.2], 0.3, 5, grey, false);
    builder.quad([-9.0, -1.0, -9.0], [0.0, 0.0, 18.0], [18.0, 0.0, 0.0], grey);
    let mut scene = builder.finish(camera([0.0, 1.0, -5.0], [0.0, 0.0, 0.0], 50.0), None);
    scene.film.width = 16;
    scene.film.height = 16;
    let settings = Settings { spp: 1, max_bounces: 2, ..Settings::for_scene(&scene) };
    assert!(scene.triangles.len() >= 100_000);
    let reference = bits(&render(&scene, &settings));
    let brute = Settings { accel: AccelKind::Brute, ..settings };
    for budget in [64, 1000, 8191] {
        let tuning = Tuning { budget: Some(budget), ..Tuning::default() };
        assert_same(&reference, &bits(&render_tuned(&scene, &brute, &tuning)), &format!("budget {budget}"));
    }
}

/// Triangles at x = 2^-k make the deepest trees: 27 levels wide and 44 binary, on either side of what the kernel keeps in
/// registers. A ray from the small end along the row visits all of it, thousands of times a dispatch.
#[test]
fn deep_trees_do_not_show() {
    let mut scene = load("cornell-box");
    scene.triangles = meshes::exponential(2000);
    scene.triangles.iter_mut().for_each(|triangle| (triangle.material, triangle.corners) = (0, NO_INDEX));
    scene.corners.clear();
    scene.sky = Some([1.0; 3]);
    scene.camera =
        Camera { origin: DVec3::new(-1e-25, 0.0, 0.0), target: DVec3::new(1.0, 0.05, 0.05), up: DVec3::Y, vfov: 12.0 };
    let settings = Settings {
        width: 16,
        height: 8,
        spp: 16,
        max_bounces: 30,
        roulette: Roulette::Off,
        ..Settings::for_scene(&scene)
    };
    let brute = bits(&render(&scene, &Settings { accel: AccelKind::Brute, ..settings.clone() }));
    let mut depths = Vec::new();
    for accel in [AccelKind::Wide, AccelKind::Binary] {
        let settings = Settings { accel, ..settings.clone() };
        depths.push(build_accel(&scene, &settings).stack_entries());
        for budget in [300, 8191] {
            let tuning = Tuning { budget: Some(budget), run_samples: Some(16), ..Tuning::default() };
            let picture = bits(&render_tuned(&scene, &settings, &tuning));
            assert_same(&brute, &picture, &format!("{accel:?} of {depths:?} levels, budget {budget}"));
        }
    }
    assert!(depths[0] > 24 && depths[1] > 32, "the trees are too shallow to show anything: {depths:?}");
}

/// Somebody else than `render` may drive the frame loop, and look at the film after each run.
#[test]
fn a_render_by_steps_is_the_same() {
    let (scene, settings) = small("cornell-glass", [33, 25], 35);
    let tuning = Tuning { run_samples: Some(5), ..Tuning::default() };
    let whole = render_tuned(&scene, &settings, &tuning);
    let mut renderer = Renderer::new(context(), &scene, &settings, &tuning).expect("a renderer");
    let mut seen = Vec::new();
    let reason = loop {
        let ended = renderer.step(&mut Silent).expect("a step");
        let counts = renderer.film().sample_counts();
        assert!(counts.iter().all(|&count| count == u64::from(renderer.report().spp)), "a film between two runs");
        seen.push(renderer.report().spp);
        if let Some(reason) = ended {
            break reason;
        }
    };
    // Runs of five, cut at the ends of blocks.
    assert_eq!((reason, seen.as_slice()), (StopReason::Spp, &[5, 10, 15, 16, 21, 26, 31, 32, 35][..]));
    assert_eq!(renderer.step(&mut Silent).expect("no step"), Some(StopReason::Spp));
    let stepped = renderer.finish();
    assert_same(&bits(&whole), &bits(&stepped), "by steps");
    let figures = |rendered: &texray::render::Rendered| {
        let report = &rendered.report;
        (report.spp, report.stop_reason, report.rays, report.paths, report.error, report.bytes.uploaded)
    };
    assert_eq!(figures(&whole), figures(&stepped));
    assert_valid(context());
}

/// Another camera begins another picture: that of a renderer made for it, with nothing but the camera copied to the
/// device, in one tile and in several, and wherever the picture before was left.
#[test]
fn another_camera_needs_no_other_upload() {
    let (scene, settings) = small("cornell-glass", [33, 25], 20);
    let mut moved = scene.clone();
    moved.camera.origin += DVec3::new(0.05, 0.1, 0.0);
    moved.camera.vfov *= 1.1;
    for (buffers, tile) in [(Buffers::Texel, None), (Buffers::Storage, Some([17, 9]))] {
        let settings = Settings { buffers, ..settings.clone() };
        let tuning = Tuning { tile, run_samples: Some(3), ..Tuning::default() };
        let fresh = render_tuned(&moved, &settings, &tuning);
        for steps in [0, 2, 100] {
            let mut renderer = Renderer::new(context(), &scene, &settings, &tuning).expect("a renderer");
            for _ in 0..steps {
                renderer.step(&mut Silent).expect("a step");
            }
            renderer.set_camera(&moved.camera).expect("another camera");
            assert_eq!((renderer.report().spp, renderer.report().paths), (0, 0));
            let other = renderer.render(&mut Silent).expect("the render ends");
            assert_same(&bits(&fresh), &bits(&other), &format!("{buffers:?}, {steps} steps before"));
            assert_eq!((fresh.report.rays, fresh.report.error), (other.report.rays, other.report.error));
            let up = |rendered: &texray::render::Rendered| {
                let entries = rendered.ledger.entries().into_iter();
                entries
                    .filter(|entry| entry.direction == Direction::Up && entry.buffer != "open sums")
                    .map(|entry| (entry.buffer, entry.bytes))
                    .collect::<Vec<_>>()
            };
            assert_eq!(up(&other), [("camera".to_owned(), 64)]);
            assert!(up(&fresh).len() > 5, "a fresh renderer copies every record");
        }
    }
    assert_valid(context());
}
