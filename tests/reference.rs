//! The independent f64 path tracer, held against closed forms and against itself, before it judges the renderer.
//!
//! Every z test here is one of fewer than [`TESTS`] at a family error of 1e-6; seeds are fixed.

mod harness;

use std::path::Path;

use glam::DVec3;
use harness::Assert;
use harness::comparison::compare;
use harness::golden::{Golden, content_hash};
use harness::obj::read as read_obj;
use harness::scenes::{SceneBuilder, camera, glass, lambert, mirror};
use harness::statistics::{Moments, z_test};
use harness::tracer::{Estimate, Lights, render};
use texray::scene::Scene;

const ALL: [Lights; 3] = [Lights::Mis, Lights::Area, Lights::Bsdf];
/// Upper bound of the number of z tests in this file.
const TESTS: usize = 100;
/// Rounding of a path of some hundreds of f64 operations.
const EXACT: f64 = 1e-12;

/// Mean of all pixels and channels, with the variance of that mean.
fn mean(picture: &Estimate) -> (f64, f64) {
    let count = picture.mean.len() as f64;
    let sum = |values: &[[f64; 3]]| values.iter().map(|rgb| rgb[0]).sum::<f64>();
    (sum(&picture.mean) / count, sum(&picture.variance_of_mean) / count / count)
}

/// A cube from -1 to 1, seen from inside it.
fn room(surface: texray::scene::Material) -> Scene {
    let mut builder = SceneBuilder::new();
    let surface = builder.material(surface);
    builder.cuboid([-1.0; 3], [1.0; 3], surface, true);
    builder.finish(camera([0.3, -0.2, 0.1], [1.0, 0.4, -0.3], 60.0), None)
}

fn expect(what: &str, picture: &Estimate, expected: f64) {
    let (mean, variance) = mean(picture);
    z_test(mean, variance, expected).assert(&format!("{what}: {mean} for {expected}"), TESTS);
}

#[test]
fn a_closed_furnace_sums_its_series() {
    // e (1 - a^(n+1)) / (1 - a) after n bounces; a cosine sample's weight is the albedo itself, so no path differs.
    let exact = render(&room(lambert(0.5, 1.0)), 4, 4, 16, 8, 1, Lights::Bsdf);
    for value in exact.mean.iter().flatten() {
        assert!((value - (2.0 - 2f64.powi(-8))).abs() < EXACT, "{value}");
    }
    assert!(exact.variance_of_mean.iter().flatten().all(|&variance| variance < EXACT));
    for lights in [Lights::Mis, Lights::Area] {
        let picture = render(&room(lambert(0.5, 1.0)), 4, 4, 1_000, 8, 2, lights);
        expect(&format!("furnace with {lights:?}"), &picture, 2.0 - 2f64.powi(-8));
    }
    assert_eq!(render(&room(lambert(0.0, 1.0)), 1, 1, 4, 8, 3, Lights::Mis).mean, [[1.0; 3]]);
}

#[test]
fn a_mirror_box_sums_its_series() {
    let picture = render(&room(mirror(0.9, 1.0)), 2, 2, 16, 300, 4, Lights::Mis);
    // f32 holds 0.9 to 2.4e-8; that is the reflectance meant here.
    let r = f64::from(0.9f32);
    for value in picture.mean.iter().flatten() {
        assert!((value - (1.0 - r.powi(301)) / (1.0 - r)).abs() < 300.0 * EXACT, "{value}");
    }
}

#[test]
fn polygon_lights_have_their_form_factors() {
    // Lambert's formula: a unit square 1 above, over its centre and over a corner; a 2x2 square 0.01 above.
    for (size, shift, height, factor) in
        [(1.0, -0.5, 1.0, 0.2394564705), (1.0, 0.0, 1.0, 0.1385316060), (2.0, -1.0, 0.01, 0.99991818)]
    {
        let mut builder = SceneBuilder::new();
        let (floor, light) = (builder.material(lambert(0.5, 0.0)), builder.material(lambert(0.0, 1.0)));
        builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], floor);
        builder.quad([shift, height, shift], [size, 0.0, 0.0], [0.0, 0.0, size], light);
        // A field of view of 1e-6 degrees sees one point.
        let scene = builder.finish(camera([0.0, height / 2.0, 0.0], [0.0; 3], 1e-6), None);
        for lights in ALL {
            let picture = render(&scene, 1, 1, 20_000, 1, 5, lights);
            expect(&format!("square of {size} at {height} with {lights:?}"), &picture, 0.5 * factor);
        }
    }
}

#[test]
fn squares_exchange_their_form_factors() {
    // The picture of a camera half above the unit square at 90 degrees is that square, uniformly.
    let parallel = ([-0.5, 1.0, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.1998248957);
    let upright = ([-0.5, 0.0, -0.5], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], 0.2000437761);
    for (corner, a, b, factor) in [parallel, upright] {
        let mut builder = SceneBuilder::new();
        let (floor, light) = (builder.material(lambert(0.8, 0.0)), builder.material(lambert(0.0, 1.0)));
        builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], floor);
        // Turned so that the front, a × b, faces the floor or the square.
        let faces_it = DVec3::from_array(a).cross(b.into()).dot(DVec3::new(0.0, 0.5, 0.0) - DVec3::from_array(corner));
        if faces_it > 0.0 {
            builder.quad(corner, a, b, light)
        } else {
            builder.quad(corner, b, a, light)
        }
        let scene = builder.finish(camera([0.0, 0.5, 0.0], [0.0; 3], 90.0), None);
        for lights in ALL {
            let picture = render(&scene, 1, 1, 20_000, 1, 6, lights);
            expect(&format!("square at {corner:?} with {lights:?}"), &picture, f64::from(0.8f32) * factor);
        }
    }
}

#[test]
fn emission_leaves_the_front_only() {
    let mut builder = SceneBuilder::new();
    let light = builder.material(lambert(0.0, 1.0));
    builder.quad([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], light);
    let back = builder.finish(camera([0.0, -1.0, 0.0], [0.0; 3], 10.0), Some([0.0; 3]));
    assert_eq!(render(&back, 1, 1, 4, 2, 7, Lights::Mis).mean, [[0.0; 3]]);
    let mut front = back.clone();
    front.camera.origin = -front.camera.origin;
    assert_eq!(render(&front, 1, 1, 4, 2, 7, Lights::Mis).mean, [[1.0; 3]]);
}

#[test]
fn a_glass_slab_transmits_what_fresnel_says() {
    // T = (1 - R) / (1 + R) summed over all inner reflections; black above, radiance 1 below.
    for (ior, degrees, transmitted) in [
        (1.5, 0.0f64, 0.9230769),
        (1.5, 45.0, 0.9043268),
        (1.5, 60.0, 0.8362325),
        (1.5, 85.0, 0.2400796),
        (2.4, 0.0, 0.7100592),
    ] {
        let mut builder = SceneBuilder::new();
        let (slab, light) = (builder.material(glass(ior)), builder.material(lambert(0.0, 1.0)));
        builder.cuboid([-16.0, -0.125, -16.0], [16.0, 0.125, 16.0], slab, false);
        builder.quad([-16.0, -0.25, -16.0], [0.0, 0.0, 32.0], [32.0, 0.0, 0.0], light);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let scene = builder.finish(camera([sin, 0.125 + cos, 0.0], [0.0, 0.125, 0.0], 1e-6), None);
        // f32 keeps 2.4 to 1e-8, far below the standard error of 0.0015 of 100,000 paths.
        let picture = render(&scene, 1, 1, 100_000, 200, 8, Lights::Mis);
        expect(&format!("slab of {ior} at {degrees} degrees"), &picture, transmitted);
    }
}

#[test]
fn glass_in_a_white_furnace_vanishes_and_from_inside_is_its_index_squared() {
    let ball = |smooth| {
        let mut builder = SceneBuilder::new();
        let ball = builder.material(glass(1.5));
        builder.sphere([0.0; 3], 1.0, 2, ball, smooth);
        let outside = builder.finish(camera([0.0, 0.0, 4.0], [0.0; 3], 40.0), Some([1.0; 3]));
        let mut inside = outside.clone();
        inside.camera.origin = DVec3::new(0.01, 0.02, 0.03);
        [(outside, 1.0), (inside, 2.25)]
    };
    // Each path that leaves carries exactly the sky's 1, or η² to the camera in the glass. Of flat facets, inner
    // reflections keep none for 2,000 bounces.
    for (scene, expected) in ball(false) {
        for value in render(&scene, 16, 16, 8, 2_000, 9, Lights::Mis).mean.iter().flatten() {
            assert!((value - expected).abs() < 2_000.0 * EXACT, "{value} for {expected}");
        }
    }
    // Interpolated normals turn some rays that enter at grazing angles into rays that circle below the surface for
    // ever, by total reflection at each facet: nothing is gained, and fewer than 1 % of the paths are lost.
    for (scene, expected) in ball(true) {
        let picture = render(&scene, 16, 16, 8, 2_000, 9, Lights::Mis);
        assert!(picture.mean.iter().flatten().all(|&value| value < expected + 2_000.0 * EXACT));
        assert!(mean(&picture).0 > 0.99 * expected, "{:?} for {expected}", mean(&picture));
    }
}

/// A room with a lamp, a block, a mirror and a smooth ball: every path between them that the estimators treat apart.
fn mixed_room() -> Scene {
    let mut builder = SceneBuilder::new();
    let white = builder.material(lambert(0.7, 0.0));
    let lamp = builder.material(lambert(0.4, 4.0));
    let dim = builder.material(lambert(0.5, 0.25));
    let shiny = builder.material(mirror(0.8, 0.0));
    builder.cuboid([-1.0; 3], [1.0; 3], white, true);
    builder.quad([-0.5, 0.9, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], lamp);
    builder.cuboid([-0.8, -1.0, -0.8], [-0.2, 0.0, -0.2], dim, false);
    builder.quad([0.9, -0.8, -0.8], [0.0, 0.0, 1.6], [0.0, 1.6, 0.0], shiny);
    builder.sphere([0.3, -0.6, 0.1], 0.4, 1, white, true);
    builder.finish(camera([0.0, 0.0, 0.95], [0.0, -0.1, 0.0], 80.0), None)
}

#[test]
fn the_three_estimators_agree() {
    let scene = mixed_room();
    let picture = |seed, spp, lights| render(&scene, 24, 24, spp, 4, seed, lights);
    let mis = picture(10, 64, Lights::Mis);
    for (seed, spp, lights) in [(11, 64, Lights::Area), (12, 256, Lights::Bsdf)] {
        // A lamp's edge through a tile's pixel may hold most of its variance: up to a tenth of the tiles.
        compare(&mis, &picture(seed, spp, lights), 24, 8).assert(&format!("MIS and {lights:?}"), 0.1);
    }
    // Control: one bounce fewer is a darker picture, and is found.
    let short = render(&scene, 24, 24, 64, 3, 13, Lights::Mis);
    assert!(compare(&mis, &short, 24, 8).worst().expect("a tile").z > 6.0);
}

#[test]
fn vertex_normals_of_a_flat_wall_change_nothing() {
    // Along the geometric normal, against it, or of another length before loading: the same numbers.
    let wall = |normal: Option<DVec3>| {
        let mut builder = SceneBuilder::new();
        let white = builder.material(lambert(0.8, 0.0));
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        match normal {
            Some(normal) => builder.smooth_triangle(corners, [normal; 3], white),
            None => builder.triangle(corners, white),
        }
        let scene = builder.finish(camera([0.2, 0.2, 1.0], [0.3, 0.3, 0.0], 40.0), Some([1.0; 3]));
        render(&scene, 4, 4, 4, 4, 14, Lights::Mis).mean
    };
    let flat = wall(None);
    for normal in [DVec3::Z, -DVec3::Z, 1e-3 * DVec3::Z] {
        for (a, b) in flat.iter().flatten().zip(wall(Some(normal)).iter().flatten()) {
            assert!((a - b).abs() < EXACT, "{a} and {b} with the normal {normal}");
        }
    }
}

#[test]
fn smooth_spheres_lose_little_in_a_furnace_and_never_gain() {
    // Directions below the geometric surface are lost; the loss falls with the angle between the two normals.
    let loss = |divisions: u32| {
        let mut builder = SceneBuilder::new();
        let white = builder.material(lambert(1.0, 0.0));
        builder.sphere([0.0; 3], 1.0, divisions, white, true);
        let scene = builder.finish(camera([0.0, 0.0, 4.0], [0.0; 3], 20.0), Some([1.0; 3]));
        let picture = render(&scene, 32, 32, 32, 8, 15, Lights::Mis);
        assert!(picture.mean.iter().flatten().all(|&value| value <= 1.0 + EXACT));
        1.0 - mean(&picture).0
    };
    let losses = [loss(1), loss(2), loss(3)];
    assert!(losses[0] > losses[1] && losses[1] > losses[2] && losses[2] > 0.0, "{losses:?}");
}

#[test]
fn variances_of_means_are_true() {
    // 1,000 pixels that see one thing: the spread of their means is what each of them states, within 6 standard
    // errors of a variance from 1,000 values, √(2/999) each.
    let mut builder = SceneBuilder::new();
    let white = builder.material(lambert(0.5, 0.0));
    let light = builder.material(lambert(0.0, 1.0));
    builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], white);
    builder.quad([-0.5, 1.0, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], light);
    let scene = builder.finish(camera([0.0, 0.5, 0.0], [0.0; 3], 1e-6), None);
    let picture = render(&scene, 40, 25, 64, 1, 16, Lights::Bsdf);
    let spread = Moments::of(picture.mean.iter().map(|rgb| rgb[0])).variance();
    let stated = Moments::of(picture.variance_of_mean.iter().map(|rgb| rgb[0])).mean;
    assert!((spread / stated - 1.0).abs() < 6.0 * (2.0f64 / 999.0).sqrt(), "{spread} and {stated}");
}

#[test]
fn goldens_are_refused_where_they_do_not_fit() {
    let folder = tempfile::tempdir().expect("a folder");
    let (base, obj) = (folder.path().join("golden"), folder.path().join("scene.obj"));
    let refusal = || Golden::read(&base, &obj).expect_err("a refusal");
    std::fs::write(&obj, "mtllib scene.mtl\n# a comment\nv 0  0 0\nf 1 1 1\n").expect("a file");
    std::fs::write(folder.path().join("scene.mtl"), "newmtl a\nKd 1 1 1\n").expect("a file");
    assert!(refusal().contains("mitsuba_golden.py"));
    let content = content_hash(&obj).expect("a hash");
    let view = r#"{"origin": [0, 0, 1], "target": [0, 0, 0], "up": [0, 1, 0], "vfov": 30}"#;
    let sizes = r#""width": 2, "height": 1, "max_bounces": 8"#;
    let header = |content: &str| format!(r#"{{{sizes}, "scene_content": "{content}", "camera": {view}}}"#);
    let write = |extension, bytes: &[u8]| std::fs::write(base.with_extension(extension), bytes).expect("a file");
    write("json", header("0123456789abcdef").as_bytes());
    assert!(refusal().contains("another scene"));
    write("json", header(&content).as_bytes());
    write("bin", &[0; 47]);
    assert!(refusal().contains("take 48"));
    write("bin", &[0xff; 48]);
    assert!(refusal().contains("NaN"));
    let numbers: Vec<u8> = (0..12).flat_map(|number| (number as f32).to_le_bytes()).collect();
    write("bin", &numbers);
    let golden = Golden::read(&base, &obj).expect("a golden");
    assert_eq!((golden.picture.mean[1], golden.picture.variance_of_mean[1]), ([3.0, 4.0, 5.0], [9.0, 10.0, 11.0]));
    // Comments and spaces say nothing; numbers do.
    std::fs::write(&obj, "mtllib scene.mtl\nv 0 0 0\n\nf 1 1 1 # end\n").expect("a file");
    assert_ne!(content_hash(&obj).expect("a hash"), content);
    std::fs::write(&obj, "mtllib   scene.mtl\nv 0 0 0\n\nf 1 1 1\n").expect("a file");
    assert_eq!(content_hash(&obj).expect("a hash"), content);
}

#[test]
fn the_tracer_agrees_with_mitsuba() {
    // Two programs that share nothing but the scene's file; 192 tiles and channels. The box alone: with the mirror or
    // the glass, paths by way of it to the lamp are so rare and bright that at few samples most tiles have met none,
    // and their means are low with small variances, which no z test can tell from a bias. The mirror agrees from some
    // 512 samples on (at 640: worst z 3.2, root mean square 0.99), which takes this tracer a minute and more.
    let golden = Golden::load("cornell-box").unwrap_or_else(|why| panic!("{why}"));
    let obj = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box.obj");
    let mut scene = read_obj(&obj).finish(golden.camera, None);
    golden.prepare(&mut scene);
    let picture = render(&scene, golden.width, golden.height, 64, golden.max_bounces, 17, Lights::Mis);
    // A lamp's edge through a pixel may hold most of a tile's variance: up to a twentieth of the tiles.
    compare(&picture, &golden.scaled(&scene.scaling), golden.width as usize, 8).assert("cornell-box", 0.05);
}
