//! Group D: ray origins.

use glam::{DMat3, DVec3, Vec3};

use crate::Result;
use crate::bvh::{Builder, WideBvh};
use crate::interface::NO_INDEX;
use crate::render::Guard;
use crate::scene::Triangle;
use crate::selftest::cases::shadow_rays;
use crate::selftest::kit::meshes;
use crate::selftest::kit::pictures::{bits, differing, lit_pixels, pixel_moments, worst_error};
use crate::selftest::kit::scenes::{SceneBuilder, camera, glass, lambert};
use crate::selftest::kit::test_bench::plain_settings;
use crate::selftest::kit::tracing::{Arrival, Departure, Leaving, Mesh};
use crate::selftest::{Case, Check, TestBench};
use crate::settings::{Lights, Settings};
use crate::statistics::Finding;
use crate::statistics::Worst;
use crate::statistics::random::Random;

/// The cases.
pub const CASES: &[Case] = &[
    Case {
        number: 30,
        title: "rays that hit where they start",
        meaning: "acne: dark specks on lit surfaces",
        check: Check::Run(self_hits),
    },
    Case {
        number: 31,
        title: "offsets through thin sheets",
        meaning: "light through opaque sheets",
        check: Check::Run(thin_sheet),
    },
    Case {
        number: 32,
        title: "neighbours at a concave edge",
        meaning: "light leaks in corners",
        check: Check::Run(corners),
    },
    Case {
        number: 33,
        title: "shadow rays that hit the light, or pass a blocker at it",
        meaning: "lights that shadow themselves; lost contact shadows",
        check: Check::Run(shadow_rays::check),
    },
    Case {
        number: 34,
        title: "shading normals against the geometry",
        meaning: "black bands, light through surfaces",
        check: Check::Run(terminator),
    },
    Case {
        number: 35,
        title: "surfaces seen from behind, normals that oppose them",
        meaning: "black triangles",
        check: Check::Run(normal_side),
    },
    Case {
        number: 36,
        title: "a camera inside glass or inside a solid",
        meaning: "wrong brightness all over",
        check: Check::Run(camera_inside),
    },
    Case {
        number: 37,
        title: "tiny fields of view, up along the view",
        meaning: "noise or NaN instead of a picture",
        check: Check::Run(narrow_view),
    },
];

/// Triangles of all sizes, from 1e-8 of the scene's to its own, each with its distance to the others left to chance.
fn sized_triangles(count: usize) -> Vec<Triangle> {
    let mut random = Random::new(30, 0);
    (0..count)
        .map(|_| {
            let (at, size) = (random.point() * 0.5, 0.4 * 10f32.powf(-8.0 * random.unit()));
            let mut corner = || at + random.point() * size;
            meshes::triangle(corner(), corner(), corner())
        })
        .filter(|triangle| crate::scene::normalise::has_area(triangle.positions))
        .collect()
}

/// Exits from random points of `triangles`, some of them within 1e-6 of the surface.
fn exits(triangles: &[Triangle], count: usize, seed: u64) -> Vec<Departure> {
    let mut random = Random::new(seed, 1);
    (0..count)
        .map(|i| {
            let id = i % triangles.len();
            let [a, b, c] = triangles[id].positions.map(Vec3::as_dvec3);
            let normal = (b - a).cross(c - a).normalize().as_vec3();
            let (u, v) = (random.unit(), random.unit());
            let barycentrics = if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] };
            let mut d = random.direction();
            if i % 4 == 3 {
                // Grazing: nearly in the plane.
                d = (d - normal * d.dot(normal)).normalize_or(Vec3::X) + normal * (random.unit() - 0.5) * 2e-6;
            }
            Departure { id: id as u32, barycentrics, wo: random.direction(), d, light: NO_INDEX }
        })
        .collect()
}

fn self_hits(bench: &TestBench) -> Result<Vec<Finding>> {
    // One triangle a mesh would be as many uploads; all in one mesh, what is hit says whether it was the own one.
    let triangles = sized_triangles(bench.count(20_000, 250_000));
    let departures = exits(&triangles, 4 * triangles.len(), 30);
    let mesh = Mesh::wide(&triangles)?;
    let arrivals = mesh.leave(bench, &departures, Leaving::Extension)?;
    let bare = mesh.leave(bench, &departures, Leaving::Bare)?;
    let own = |arrivals: &[Arrival]| {
        departures.iter().zip(arrivals).filter(|(departure, arrival)| arrival.hit == Some(departure.id)).count() as u64
    };
    let exits = departures.len() as u64;
    let by_offset = own(&mesh.leave(&bench.without(Guard::SkipSource), &departures, Leaving::Extension)?);
    // Of the point against f64, and of the origin against the point, in parts of the triangle's place and size.
    let (mut farthest, mut error) = (Worst::default(), Worst::default());
    for (departure, arrival) in departures.iter().zip(&arrivals) {
        let [a, b, c] = triangles[departure.id as usize].positions.map(Vec3::as_dvec3);
        let [b1, b2] = departure.barycentrics.map(f64::from);
        let exact = a + (b - a) * b1 + (c - a) * b2;
        let extent = a.abs().max(b.abs()).max(c.abs()).max_element();
        farthest.add((arrival.origin.as_dvec3() - exact).length() / extent);
        error.add((arrival.point.as_dvec3() - exact).abs().max_element() / extent);
    }
    Ok(vec![
        Finding::never("exits that hit the triangle they leave", own(&arrivals), exits),
        Finding::never("the same from the bare point, where the skipped index alone helps", own(&bare), exits),
        Finding::at_most(
            "share of the same where the offset alone helps",
            1e-4,
            by_offset as f64 / exits as f64,
            "the skipped index is the cure; the offset alone is to miss few",
        ),
        Finding::at_most(
            "largest error of a hit point, of the triangle's extent",
            2.5e-7,
            error.0,
            "4 roundings, 2^-24 each",
        ),
        Finding::at_most("largest distance of an origin from its point", 1e-5, farthest.0, "the catalogue's"),
    ])
}

/// Two quads a hundred-thousandth of the scene apart: rays that leave one of them inwards meet the other, and so does a shadow
/// ray to a light beyond it.
fn thin_sheet(bench: &TestBench) -> Result<Vec<Finding>> {
    // Turned and off the origin, so that no coordinate is special.
    let place = DVec3::new(-0.31, -0.27, 0.12);
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let quad = |height: f64, size: f64| {
        let at = |x: f64, z: f64| (place + turn * DVec3::new(x * size, height, z * size)).as_vec3();
        let (a, b, c, d) = (at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0));
        [meshes::triangle(a, b, c), meshes::triangle(a, c, d)]
    };
    let triangles = [quad(0.0, 0.4), quad(1e-5, 0.4), quad(0.3, 0.2)].concat();
    let mesh = Mesh::new(&triangles, WideBvh::build(&triangles, Builder::Sah).into(), |id| id >= 4)?;
    let up = (turn * DVec3::Y).as_vec3();
    let mut random = Random::new(31, 0);
    let departures: Vec<Departure> = (0..bench.count(50_000, 1_000_000))
        .map(|i| {
            // Well inside, so that no ray leaves by the open sides.
            let barycentrics = [0.1 + 0.4 * random.unit(), 0.1 + 0.4 * random.unit()];
            let direction = random.direction();
            let direction = if direction.dot(up) < 0.0 { -direction } else { direction };
            let (u, v) = (random.unit(), random.unit());
            let [a, b, c] = triangles[4].positions;
            let on_light = a + (b - a) * (u * (1.0 - v)) + (c - a) * (u * v);
            let d = if i % 2 == 0 { direction + up * 0.05 } else { on_light };
            Departure { id: i as u32 / 2 % 2, barycentrics, wo: up, d, light: if i % 2 == 0 { NO_INDEX } else { 4 } }
        })
        .collect();
    let mut findings = Vec::new();
    for (parity, leaving, name) in
        [(0, Leaving::Extension, "rays"), (1, Leaving::Shadow, "shadow rays to a light beyond")]
    {
        let some: Vec<Departure> = departures.iter().skip(parity).step_by(2).copied().collect();
        let arrivals = mesh.leave(bench, &some, leaving)?;
        let through = arrivals.iter().filter(|arrival| arrival.hit.is_none_or(|id| !(2..4).contains(&id))).count();
        let what = format!("{name} from inside a sheet 1e-5 thick that its other side does not stop");
        findings.push(Finding::never(what, through as u64, some.len() as u64));
    }
    Ok(findings)
}

/// A cube of unit side, turned so that its faces round.
fn turned_cube(cells: usize) -> (Vec<Triangle>, DMat3) {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let mut triangles = meshes::cube(cells);
    for triangle in &mut triangles {
        triangle.positions = triangle.positions.map(|position| (turn * position.as_dvec3()).as_vec3());
    }
    (triangles, turn)
}

/// Rays from points on the edges of triangles in a closed cube, to its inside: none leaves, none meets a neighbour at once.
fn corners(bench: &TestBench) -> Result<Vec<Finding>> {
    let (triangles, turn) = turned_cube(6);
    let back = turn.transpose();
    let mut random = Random::new(32, 0);
    let departures: Vec<Departure> = (0..bench.count(50_000, 1_000_000))
        .map(|i| {
            let id = random.below(triangles.len());
            let along = random.unit();
            // On an edge, or at a corner.
            let barycentrics = [[along, 0.0], [0.0, along], [along, 1.0 - along], [0.0, 0.0]][i % 4];
            let [a, b, c] = triangles[id].positions;
            let p = a + (b - a) * barycentrics[0] + (c - a) * barycentrics[1];
            let inside = (turn * (random.point() * 0.499).as_dvec3()).as_vec3();
            let d = (inside - p).normalize();
            Departure { id: id as u32, barycentrics, wo: d, d, light: NO_INDEX }
        })
        .collect();
    let arrivals = Mesh::wide(&triangles)?.leave(bench, &departures, Leaving::Extension)?;
    let left = arrivals.iter().filter(|arrival| arrival.hit.is_none()).count() as u64;
    // How far the ray goes inside of the cube, in f64.
    let chord = |departure: &Departure, arrival: &Arrival| {
        let (o, d) = (back * arrival.point.as_dvec3(), back * departure.d.as_dvec3());
        let exits: [f64; 3] = std::array::from_fn(|axis| (0.5f64.copysign(d[axis]) - o[axis]) / d[axis]);
        exits.into_iter().fold(f64::INFINITY, f64::min)
    };
    let early = departures
        .iter()
        .zip(&arrivals)
        .filter(|(departure, arrival)| f64::from(arrival.key) < 0.999 * chord(departure, arrival) - 1e-5)
        .count() as u64;
    let rays = departures.len() as u64;
    Ok(vec![
        Finding::never("rays from edges that leave a closed cube", left, rays),
        Finding::never("rays from edges that meet a neighbour at once", early, rays),
        sealed_room(bench)?,
    ])
}

/// A white room, closed, in front of a white sky: whatever is seen came through a wall.
fn sealed_room(bench: &TestBench) -> Result<Finding> {
    let (triangles, turn) = turned_cube(bench.count(20, 60));
    let mut builder = SceneBuilder::new();
    let white = builder.material(lambert(1.0, 0.0));
    triangles.iter().for_each(|triangle| builder.triangle(triangle.positions.map(Vec3::as_dvec3), white));
    let scene = builder.finish(camera([0.0; 3], (turn * DVec3::splat(0.5)).to_array(), 60.0), Some([1.0; 3]));
    let settings = Settings { max_bounces: 64, ..plain_settings(&scene, 32, 32, bench.count(16, 64) as u32) };
    let lit = lit_pixels(bench, &scene, &settings)?;
    let bounces = 64 * 1024 * settings.spp;
    Ok(Finding::never(format!("pixels of a closed room that see the sky, {bounces} bounces"), lit, 1024))
}

/// Smooth normals that lean towards a light behind the surface, and smooth balls in a white furnace.
fn terminator(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut builder = SceneBuilder::new();
    let (wall, light) = (builder.material(lambert(0.8, 0.0)), builder.material(lambert(0.0, 1.0)));
    let lean = DVec3::new(0.0, 0.9, -0.2).normalize();
    for corners in [[[-1.0, -1.0], [1.0, 1.0], [1.0, -1.0]], [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]] {
        builder.smooth_triangle(corners.map(|[x, y]| DVec3::new(x, y, 0.0)), [lean; 3], wall);
    }
    // Behind the wall, above: in the hemisphere of the shading normal.
    builder.quad([-1.0, 3.0, 0.2], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], light);
    let scene = builder.finish(camera([0.0, 0.0, -4.0], [0.0; 3], 20.0), None);
    let mut findings = Vec::new();
    for lights in [Lights::Mis, Lights::Bsdf] {
        let settings =
            Settings { lights, max_bounces: 1, ..plain_settings(&scene, 32, 32, bench.count(64, 512) as u32) };
        let what = format!("pixels that light behind the surface reaches, {lights:?}");
        findings.push(Finding::never(what, lit_pixels(bench, &scene, &settings)?, 1024));
    }
    let mut losses = Vec::new();
    for divisions in [1, 2, 4] {
        let mut builder = SceneBuilder::new();
        let white = builder.material(lambert(1.0, 0.0));
        builder.sphere([0.0; 3], 1.0, divisions, white, true);
        let scene = builder.finish(camera([0.0, 0.0, -6.0], [0.0; 3], 12.0), Some([1.0; 3]));
        let settings = plain_settings(&scene, 32, 32, bench.count(64, 512) as u32);
        let moments = pixel_moments(bench, &scene, &settings)?;
        let above = (moments.mean - 1.0).max(0.0);
        let what = format!("what a ball of {} facets adds to a furnace", 8 << (2 * divisions));
        findings.push(Finding::z(what, 0.0, above, moments.variance_of_mean()));
        losses.push(1.0 - moments.mean);
    }
    let falls = losses.windows(2).all(|pair| pair[1] < pair[0]);
    let list: Vec<String> = losses.iter().map(|loss| format!("{loss:.5}")).collect();
    findings.push(Finding::holds(
        "loss at the terminator of balls of 32, 128, 2048 facets",
        "falling",
        list.join(", "),
        falls,
    ));
    Ok(findings)
}

/// A wall is two-sided: a light on the viewer's side lights it, front or back, and one on the other side does not.
fn normal_side(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for (side, z) in [("front", 1.0), ("back", -1.0)] {
        for lit_side in [z, -z] {
            let mut builder = SceneBuilder::new();
            let (grey, light) = (builder.material(lambert(0.5, 0.0)), builder.material(lambert(0.0, 1.0)));
            builder.quad([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], grey);
            let (a, b) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
            let (a, b) = if lit_side > 0.0 { (b, a) } else { (a, b) };
            builder.quad([-0.5, -0.5, lit_side], a, b, light);
            let scene = builder.finish(camera([0.0, 1.5, z], [0.0; 3], 1e-3), None);
            let spp = bench.count(64, 256) as u32;
            let settings = Settings { max_bounces: 1, ..plain_settings(&scene, 32, 32, spp) };
            if lit_side == z {
                let moments = pixel_moments(bench, &scene, &settings)?;
                // Form factor of a unit square at distance 1.
                findings.push(Finding::mean(format!("{side} of a wall, lit"), 0.5 * 0.2394564705, &moments));
            } else {
                let lit = lit_pixels(bench, &scene, &settings)?;
                findings.push(Finding::never(
                    format!("pixels of the {side} of a wall, lit from its other side"),
                    lit,
                    1024,
                ));
            }
        }
    }
    findings.push(opposed_normals(bench)?);
    Ok(findings)
}

/// A flat wall whose vertex normals point away from its front, or along it; what loading does to normals is shown by
/// tests/scene.rs, `negated_short_or_missing_normals_of_a_flat_wall_change_nothing`.
fn opposed_normals(bench: &TestBench) -> Result<Finding> {
    let picture = |normal: Option<DVec3>| {
        let mut builder = SceneBuilder::new();
        let (grey, light) = (builder.material(lambert(0.5, 0.0)), builder.material(lambert(0.0, 1.0)));
        for [a, b, c] in [[[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0]], [[-2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]] {
            let corners = [a, b, c].map(|[x, y]: [f64; 2]| DVec3::new(x, y, 0.0));
            match normal {
                Some(normal) => builder.smooth_triangle(corners, [normal; 3], grey),
                None => builder.triangle(corners, grey),
            }
        }
        builder.quad([-0.5, -0.5, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], light);
        let scene = builder.finish(camera([0.0, 1.5, 1.0], [0.0; 3], 30.0), None);
        bits(bench, &scene, &Settings { max_bounces: 2, ..plain_settings(&scene, 16, 16, 16) })
    };
    let flat = picture(None)?;
    let (opposed, along) = (picture(Some(DVec3::NEG_Z))?, picture(Some(DVec3::X))?);
    let worse = [opposed, along].into_iter().map(|other| differing("", &flat, &other)).find(|finding| !finding.passes);
    let equal = || Finding::never("", 0, flat.len() as u64);
    Ok(Finding {
        what: "pixels of a flat wall that opposed vertex normals, or such that lie in it, change".into(),
        ..worse.unwrap_or_else(equal)
    })
}

fn camera_inside(bench: &TestBench) -> Result<Vec<Finding>> {
    let inside = camera([0.1, 0.05, 0.0], [1.0, 0.3, 0.2], 40.0);
    let mut builder = SceneBuilder::new();
    let body = builder.material(glass(1.5));
    builder.sphere([0.0; 3], 1.0, 4, body, false);
    let scene = builder.finish(inside, Some([1.0; 3]));
    let settings = Settings { max_bounces: 200, ..plain_settings(&scene, 32, 32, bench.count(64, 512) as u32) };
    let moments = pixel_moments(bench, &scene, &settings)?;
    let mut findings = vec![Finding::mean("inside a glass ball in a furnace: the squared index", 2.25, &moments)];
    let mut builder = SceneBuilder::new();
    let solid = builder.material(lambert(0.5, 1.0));
    builder.sphere([0.0; 3], 1.0, 4, solid, false);
    let scene = builder.finish(inside, Some([1.0; 3]));
    let settings = Settings { max_bounces: 24, allow_black: true, ..plain_settings(&scene, 32, 32, 16) };
    let lit = lit_pixels(bench, &scene, &settings)?;
    // It emits to the outside alone.
    findings.push(Finding::never("pixels inside a solid ball that see light", lit, 1024));
    Ok(findings)
}

fn narrow_view(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    for (vfov, up) in [(1e-4, DVec3::Y), (1e-4, DVec3::new(0.0, 1e-6, 1.0)), (179.0, DVec3::Y)] {
        let mut builder = SceneBuilder::new();
        let wall = builder.material(lambert(0.0, 1.0));
        builder.quad([-1e3, -1e3, 2.0], [0.0, 2e3, 0.0], [2e3, 0.0, 0.0], wall);
        let view = crate::scene::Camera { origin: DVec3::ZERO, target: DVec3::Z, up, vfov };
        let scene = builder.finish(view, None);
        let error = worst_error(bench, &scene, &plain_settings(&scene, 16, 16, 4), 1.0)?;
        let what = format!("error of an even wall, view of {vfov} degrees, up ({}, {}, {})", up.x, up.y, up.z);
        findings.push(Finding::at_most(what, 0.0, error, "exact"));
    }
    Ok(findings)
}
