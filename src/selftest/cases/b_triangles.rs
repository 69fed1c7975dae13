//! Group B: triangles.

use glam::{DVec3, Vec3};

use crate::Result;
use crate::bvh::{Accel, Ray};
use crate::gpu::{ShaderModule, shaders};
use crate::interface::NO_INDEX;
use crate::render::Guard;
use crate::scene::normalise::has_area;
use crate::scene::{Scene, Triangle};
use crate::selftest::kit::meshes::{self, displaced_sphere};
use crate::selftest::kit::pictures::{lit_pixels, pixel_moments, worst_error};
use crate::selftest::kit::scenes::{SceneBuilder, camera, lambert};
use crate::selftest::kit::test_bench::plain_settings;
use crate::selftest::kit::tracing::{Mesh, leaks, mismatches, trees};
use crate::selftest::{Case, Check, TestBench};
use crate::settings::Settings;
use crate::statistics::Finding;
use crate::statistics::Worst;
use crate::statistics::random::Random;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        number: 12,
        title: "cracks at shared edges and vertices",
        meaning: "bright pin-holes, light leaks",
        check: Check::Run(cracks),
    },
    Case {
        number: 13,
        title: "contraction in edge functions",
        meaning: "as 12, on devices that fuse",
        check: Check::Run(fused_edges),
    },
    Case {
        number: 14,
        title: "a fixed epsilon for the determinant",
        meaning: "small objects vanish",
        check: Check::Run(small_objects),
    },
    Case {
        number: 15,
        title: "coordinates that underflow",
        meaning: "small scenes are full of holes",
        check: Check::Run(underflow),
    },
    Case {
        number: 16,
        title: "slivers and needles",
        meaning: "spikes and holes at thin triangles",
        check: Check::Run(slivers),
    },
    Case {
        number: 17,
        title: "triangles without area",
        meaning: "NaN normals; fireflies where they emit",
        check: Check::Tests("tests/scene.rs, degenerate_triangles_are_counted_and_do_not_move_the_scene"),
    },
    Case {
        number: 18,
        title: "degenerate triangles that are hit",
        meaning: "stray hits in empty space",
        check: Check::Run(collinear),
    },
    Case {
        number: 19,
        title: "coplanar faces",
        meaning: "speckle that depends on the tree",
        check: Check::Run(coplanar_faces),
    },
    Case {
        number: 20,
        title: "a light flush with a wall",
        meaning: "a light that flickers or is dark",
        check: Check::Run(flush_light),
    },
    Case {
        number: 21,
        title: "rays in a triangle's plane",
        meaning: "cracks seen edge-on",
        check: Check::Run(in_plane),
    },
];

/// Families of rays from inside a closed mesh.
const FAMILIES: [&str; 4] = ["random", "vertex", "edge", "axis"];

/// `count` rays of a family from within `radius` of `centre`, which the mesh encloses.
fn inner_rays(family: usize, mesh: &[Triangle], centre: Vec3, radius: f32, count: usize, seed: u64) -> Vec<Ray> {
    let mut random = Random::new(seed, family as u64);
    (0..count)
        .map(|_| {
            let origin = centre + random.point() * (radius * 0.5);
            let [a, b, c] = mesh[random.below(mesh.len())].positions;
            let direction = match family {
                0 => random.direction(),
                1 => [a, b, c][random.below(3)] - origin,
                2 => a + (b - a) * random.unit() - origin,
                // From a vertex's own lines, so that the ray meets it exactly.
                _ => {
                    let mut from = origin;
                    let axis = random.below(3);
                    from[(axis + 1) % 3] = a[(axis + 1) % 3];
                    from[(axis + 2) % 3] = a[(axis + 2) % 3];
                    let mut direction = Vec3::ZERO;
                    direction[axis] = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
                    // Only if that line still begins inside.
                    if (from - centre).length() < radius {
                        return Ray::new(from, direction);
                    }
                    direction
                }
            };
            Ray::new(origin, direction)
        })
        .collect()
}

/// A closed mesh put somewhere in file units, as loading brings it to the device. Also its centre and an inner radius.
fn placed(bench: &TestBench, mesh: &[Triangle], scale: f64, at: DVec3) -> (Vec<Triangle>, Vec3, f32) {
    let mut builder = SceneBuilder::new();
    let material = builder.material(lambert(0.5, 1.0));
    for triangle in mesh {
        builder.triangle(triangle.positions.map(|position| position.as_dvec3() * scale + at), material);
    }
    let mut scaling = builder.scaling(None);
    if !bench.has(Guard::Recentre) {
        scaling.centre = DVec3::ZERO;
    }
    if !bench.has(Guard::Rescale) {
        scaling.length_exponent = 0;
    }
    let scene = builder.finish_scaled(camera([0.0; 3], [0.0, 0.0, 1.0], 40.0), None, scaling);
    let radius = 0.25 * scale * 2f64.powi(scaling.length_exponent);
    (scene.triangles, scaling.point(at).as_vec3(), radius as f32)
}

/// Where case 12 puts its mesh: the second is Embree's own place.
const PLACES: [(&str, f64, [f64; 3]); 5] = [
    ("the origin", 1.0, [0.0; 3]),
    ("(148376, 1234, -223423)", 1.0, [148376.0, 1234.0, -223423.0]),
    ("1e6", 1.0, [1e6; 3]),
    ("the origin, scaled by 1e6", 1e6, [0.0; 3]),
    ("the origin, scaled by 1e-6", 1e-6, [0.0; 3]),
];

fn cracks(bench: &TestBench) -> Result<Vec<Finding>> {
    let sphere = displaced_sphere(17, 32);
    let count = bench.count(20_000, 200_000);
    let mut findings = Vec::new();
    for (seed, (name, scale, at)) in (0..).zip(PLACES) {
        let (triangles, centre, radius) = placed(bench, &sphere, scale, DVec3::from_array(at));
        let mesh = Mesh::wide(&triangles)?;
        let rays: Vec<Ray> =
            (0..4).flat_map(|family| inner_rays(family, &triangles, centre, radius, count, seed)).collect();
        let answers = mesh.trace(bench, &rays)?;
        for (family, answers) in FAMILIES.iter().zip(answers.chunks(count)) {
            findings.push(leaks(format!("rays that leave a closed mesh at {name}, {family}"), answers));
        }
    }
    Ok(findings)
}

/// Operations of a module that may not be contracted.
fn uncontracted(module: ShaderModule) -> usize {
    const OP_DECORATE: u32 = 71;
    const NO_CONTRACTION: u32 = 42;
    let mut count = 0;
    let mut rest = module.words().get(5..).unwrap_or_default();
    while let Some(&first) = rest.first() {
        let words = (first >> 16).max(1) as usize;
        count += usize::from(first & 0xffff == OP_DECORATE && rest.get(2) == Some(&NO_CONTRACTION));
        rest = rest.get(words..).unwrap_or_default();
    }
    count
}

fn fused_edges(bench: &TestBench) -> Result<Vec<Finding>> {
    let sphere = displaced_sphere(17, 32);
    let mesh = Mesh::wide(&sphere)?;
    let mut findings = Vec::new();
    for (family, name) in FAMILIES.iter().enumerate().skip(1) {
        let rays = inner_rays(family, &sphere, Vec3::ZERO, 0.25, bench.count(50_000, 200_000), 70);
        findings.push(leaks(format!("rays that leave a closed mesh, {name}"), &mesh.trace(bench, &rays)?));
    }
    // A multiplication and a subtraction of each of three edge functions are among them.
    for (name, module) in [
        ("path tracer", shaders::PATH_TRACE),
        ("path tracer that keeps NaN", shaders::PATH_TRACE_KEEP_NAN),
        ("probe", shaders::PROBE_TRACE),
    ] {
        let count = uncontracted(module);
        let expected = "100 or more".to_owned();
        findings.push(Finding::holds(
            format!("operations of the {name} that no driver may fuse"),
            expected,
            count.to_string(),
            count >= 100,
        ));
    }
    Ok(findings)
}

/// A closed mesh of a millionth of the scene's size.
fn small_objects(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut triangles = displaced_sphere(17, 32);
    for triangle in &mut triangles {
        triangle.positions = triangle.positions.map(|position| position * 2f32.powi(-20));
    }
    let inner = triangles.clone();
    triangles.extend(meshes::cube(2).into_iter().map(|mut triangle| {
        triangle.positions = triangle.positions.map(|position| position * 1.9);
        triangle
    }));
    let mesh = Mesh::wide(&triangles)?;
    let mut findings = Vec::new();
    for (family, name) in FAMILIES.iter().enumerate() {
        let rays = inner_rays(family, &inner, Vec3::ZERO, 0.25 * 2f32.powi(-20), bench.count(10_000, 100_000), 71);
        let answers = mesh.trace(bench, &rays)?;
        let missed = answers.iter().filter(|answer| answer.hit.is_none_or(|hit| hit.id >= inner.len() as u32)).count();
        let what = format!("rays that leave a closed mesh of 2^-20 of the scene's size, {name}");
        findings.push(Finding::never(what, missed as u64, answers.len() as u64));
    }
    Ok(findings)
}

fn underflow(bench: &TestBench) -> Result<Vec<Finding>> {
    let sphere = displaced_sphere(17, 32);
    let answers = |scale: f64| {
        let (triangles, centre, _) = placed(bench, &sphere, scale, DVec3::ZERO);
        let rays = inner_rays(1, &sphere, centre, 0.25, bench.count(10_000, 100_000), 72);
        Mesh::wide(&triangles)?.trace(bench, &rays)
    };
    Ok(vec![mismatches(
        "hits that change when the scene is scaled by 2^-100",
        &answers(1.0)?,
        &answers(2f64.powi(-100))?,
    )])
}

/// A closed cube, two opposite faces of which are cut into strips, most of them 1e6 times longer than wide; the strips' ids come first.
fn sliced_cube(strips: usize) -> (Vec<Triangle>, usize) {
    let mut cuts: Vec<f32> = (0..=strips).map(|i| -0.5 + i as f32 * 1e-6).collect();
    cuts.push(0.5);
    let quad = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| [meshes::triangle(a, b, c), meshes::triangle(a, c, d)];
    let mut triangles = Vec::new();
    for z in [-0.5, 0.5] {
        for pair in cuts.windows(2) {
            let at = |x, y| Vec3::new(x, y, z);
            triangles.extend(quad(at(pair[0], -0.5), at(pair[1], -0.5), at(pair[1], 0.5), at(pair[0], 0.5)));
        }
    }
    let slivers = triangles.len();
    // Faces that share the strips' short edges are cut alike, or there would be T-junctions.
    for y in [-0.5, 0.5] {
        for pair in cuts.windows(2) {
            let at = |x, z| Vec3::new(x, y, z);
            triangles.extend(quad(at(pair[0], -0.5), at(pair[1], -0.5), at(pair[1], 0.5), at(pair[0], 0.5)));
        }
    }
    for x in [-0.5, 0.5] {
        let at = |y, z| Vec3::new(x, y, z);
        triangles.extend(quad(at(-0.5, -0.5), at(0.5, -0.5), at(0.5, 0.5), at(-0.5, 0.5)));
    }
    (triangles, slivers)
}

/// The box of a sliver in a plane is that plane, grown by 2^-20 of the reach (below 1.7) in distance; planes are 0.1 away or more.
const PLANE_ERROR: f64 = 2.0 * 1.7 / 0.1 / 1048576.0;
const PLANE_ERROR_WHY: &str =
    "the pad of the sliver's own box over the least distance of its plane; f64 is the measure";

fn slivers(bench: &TestBench) -> Result<Vec<Finding>> {
    let (triangles, count) = sliced_cube(bench.count(2_000, 25_000));
    let mut random = Random::new(73, 0);
    let rays: Vec<Ray> = (0..bench.count(20_000, 200_000))
        .map(|_| {
            let origin = random.point() * 0.4;
            let [a, b, c] = triangles[random.below(count)].positions;
            let target = a + (b - a) * random.unit() + (c - a) * random.unit();
            Ray::new(origin, target - origin)
        })
        .collect();
    let answers = Mesh::wide(&triangles)?.trace(bench, &rays)?;
    // The sliver's plane is z = -1/2 or 1/2: the distance along the ray follows in f64.
    let error = |(ray, answer): (&Ray, &crate::selftest::kit::tracing::Answer)| match answer.hit {
        Some(hit) if (hit.id as usize) < count => {
            let plane = f64::from(0.5f32.copysign(ray.direction.z));
            let t = (plane - f64::from(ray.origin.z)) / f64::from(ray.direction.z);
            (f64::from(hit.key) / t - 1.0).abs()
        }
        _ => 0.0,
    };
    let mut worst = Worst::default();
    rays.iter().zip(&answers).map(error).for_each(|error| worst.add(error));
    let mut findings = vec![
        leaks("rays that leave a closed cube of slivers, 1e6 to 1", &answers),
        Finding::at_most("largest relative error of their distances", PLANE_ERROR, worst.0, PLANE_ERROR_WHY),
    ];
    findings.push(beyond_the_tip(bench)?);
    Ok(findings)
}

/// Rays past the tips of needles, in the line of the needle: the edge functions alone agree that they hit.
fn beyond_the_tip(bench: &TestBench) -> Result<Finding> {
    let mut random = Random::new(74, 0);
    let mut triangles = Vec::new();
    let mut rays = Vec::new();
    for _ in 0..bench.count(500, 2_000) {
        let (base, along) = (random.point() * 0.3, random.direction() * 0.2);
        let across = along.cross(random.direction()).normalize_or(Vec3::X) * 1e-7;
        triangles.push(meshes::triangle(base, base + across, base + along));
        for _ in 0..20 {
            let target = base + along * (1.5 + 2.0 * random.unit());
            let origin = target + random.direction() * 0.7;
            rays.push(Ray::new(origin, target - origin));
        }
    }
    let answers = Mesh::wide(&triangles)?.trace(bench, &rays)?;
    // Another needle may stand in the way; this one, half its length and more away from the ray, may not.
    let events =
        answers.iter().enumerate().filter(|(i, answer)| answer.hit.is_some_and(|hit| hit.id as usize == i / 20));
    Ok(Finding::never(
        "rays that hit a needle half its length beyond its tip",
        events.count() as u64,
        rays.len() as u64,
    ))
}

/// The triangle and ray of pbrt's "bad cases": three collinear points (shapes_test.cpp), scaled into [-1, 1]. Rounding gives
/// their sheared images an area, so the loader has to refuse them.
fn collinear(bench: &TestBench) -> Result<Vec<Finding>> {
    let scale = 2f32.powi(-11);
    let point = |x: f32, y: f32, z: f32| Vec3::new(x, y, z) * scale;
    let corners = [
        point(-1_113.454_6, -79.049614, -56.243_19),
        point(-1_113.454_6, -87.092_27, -56.243_19),
        point(-1_113.454_6, -79.209_015, -56.243_19),
    ];
    let ray =
        Ray::new(point(-1_081.479_2, 99.999_954, 87.770_11), Vec3::new(-32.107_3, -183.355_87, -144.607_64) * scale);
    let kept: Vec<Triangle> = Some(meshes::triangle(corners[0], corners[1], corners[2]))
        .filter(|triangle| !bench.has(Guard::DropDegenerate) || has_area(triangle.positions))
        .into_iter()
        .collect();
    let mesh = Mesh::wide(&kept)?;
    let hits = mesh.trace(bench, &[ray])?.iter().filter(|answer| answer.hit.is_some()).count();
    Ok(vec![Finding::never("hits of three collinear points", hits as u64, 1)])
}

/// Which of several coplanar triangles is hit does not depend on the tree.
fn coplanar_faces(bench: &TestBench) -> Result<Vec<Finding>> {
    let triangles = meshes::coplanar(150, 3);
    let mut random = Random::new(75, 0);
    let rays: Vec<Ray> = (0..bench.count(20_000, 200_000))
        .map(|_| {
            let origin = random.point() * 2.0;
            Ray::new(origin, triangles[random.below(triangles.len())].positions[0] + random.point() * 0.1 - origin)
        })
        .collect();
    let emits = |id: u32| id % 5 == 2;
    let brute = Mesh::new(&triangles, Accel::brute(), emits)?.trace(bench, &rays)?;
    let mut findings = Vec::new();
    for (name, accel) in trees(&triangles) {
        let answers = Mesh::new(&triangles, accel, emits)?.trace(bench, &rays)?;
        findings.push(mismatches(format!("hits of coplanar triangles that the {name} tree changes"), &brute, &answers));
    }
    Ok(findings)
}

/// A room's ceiling with a square light in its very plane.
fn flush_ceiling(view: crate::scene::Camera) -> Scene {
    let mut builder = SceneBuilder::new();
    let (floor, ceiling) = (builder.material(lambert(0.5, 0.0)), builder.material(lambert(0.0, 0.0)));
    let light = builder.material(lambert(0.0, 1.0));
    builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], floor);
    builder.quad([-2.0, 1.0, -2.0], [4.0, 0.0, 0.0], [0.0, 0.0, 4.0], ceiling);
    builder.quad([-0.5, 1.0, -0.5], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], light);
    builder.finish(view, None)
}

fn flush_light(bench: &TestBench) -> Result<Vec<Finding>> {
    let up = flush_ceiling(camera([0.1, 0.1, -0.2], [0.05, 1.0, 0.1], 20.0));
    let seen = worst_error(bench, &up, &Settings { max_bounces: 1, ..plain_settings(&up, 16, 16, 16) }, 1.0)?;
    // The ceiling beside the light, its border just out of view.
    let beside = flush_ceiling(camera([1.2, 0.1, 0.0], [1.2, 1.0, 0.0], 70.0));
    let dark = lit_pixels(bench, &beside, &Settings { max_bounces: 1, ..plain_settings(&beside, 16, 16, 16) })?;
    let down = flush_ceiling(camera([0.0, 0.9, -1.5], [0.0; 3], 1e-3));
    let spp = bench.count(64, 1024) as u32;
    let lit = pixel_moments(bench, &down, &Settings { max_bounces: 1, ..plain_settings(&down, 32, 32, spp) })?;
    Ok(vec![
        Finding::at_most("largest error of a pixel of the light, seen from below", 0.0, seen, "exact"),
        Finding::never("pixels of the black ceiling around it that are lit", dark, 256),
        Finding::mean("the floor under it, form factor 0.2394564705", 0.5 * 0.2394564705, &lit),
    ])
}

/// Rays in the plane of a face meet its neighbours.
fn in_plane(bench: &TestBench) -> Result<Vec<Finding>> {
    let triangles = meshes::cube(6);
    let mut random = Random::new(76, 0);
    let rays: Vec<Ray> = (0..bench.count(20_000, 100_000))
        .map(|_| {
            let axis = random.below(3);
            let mut origin = random.point() * 0.49;
            let mut direction = random.direction();
            origin[axis] = 0.5f32.copysign(random.unit() - 0.5);
            direction[axis] = 0.0;
            Ray { origin, direction, skip: NO_INDEX }
        })
        .collect();
    Ok(vec![leaks("rays in a face of a closed cube that meet nothing", &Mesh::wide(&triangles)?.trace(bench, &rays)?)])
}
