//! Plates for docs/numerics.md: a failure beside its cure, as one small PNG.
//!
//! Comes in: a scene or rays, and what is taken away on the left. Goes out: two pictures of one size.

use glam::{DVec3, Vec3};
use texray::bvh::{Builder, Hit, Intersector, Ray, Tracer, WideBvh};
use texray::interface::NO_INDEX;
use texray::output::Display;
use texray::render::{Guard, Tuning};
use texray::scene::{Scene, Triangle};
use texray::selftest::kit::meshes::{cube, displaced_sphere};
use texray::selftest::kit::tracing::{Answer, Departure, Leaving, Mesh};
use texray::selftest::{TestBench, Tier};
use texray::settings::{Lights, Roulette, Settings};

use crate::harness::device::{context, load, plain_settings, render_tuned};
use crate::harness::scenes::{SceneBuilder, camera, glass, lambert};

/// Pixels between the two pictures.
const GAP: usize = 6;

/// A failure (left) and its cure (right).
pub struct Plate {
    /// File name, without extension.
    pub name: &'static str,
    /// Size of each picture in pixels.
    pub size: [usize; 2],
    /// The failure, row by row.
    pub before: Vec<[u8; 3]>,
    /// The cure.
    pub after: Vec<[u8; 3]>,
}

impl Plate {
    /// Both side by side.
    pub fn png(&self) -> Vec<u8> {
        let [width, height] = self.size;
        let mut rows = Vec::new();
        for y in 0..height {
            let row = y * width..(y + 1) * width;
            rows.extend_from_slice(self.before[row.clone()].as_flattened());
            rows.extend_from_slice([[255; 3]; GAP].as_flattened());
            rows.extend_from_slice(self.after[row].as_flattened());
        }
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, (2 * width + GAP) as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(&rows).unwrap();
        writer.finish().unwrap();
        file
    }
}

/// A picture of each of two ways to render: what stands on the left, and what on the right.
fn plate(name: &'static str, [before, after]: [(&Scene, &Settings, Option<Guard>); 2]) -> Plate {
    let shown = |(scene, settings, without_guard): (&Scene, &Settings, Option<Guard>)| {
        let tuning = Tuning { without_guard, ..Tuning::default() };
        let film = render_tuned(scene, settings, &tuning).film;
        film.mean().into_iter().map(|rgb| Display::default().bytes(rgb)).collect()
    };
    let size = [after.1.width as usize, after.1.height as usize];
    Plate { name, size, before: shown(before), after: shown(after) }
}

/// One scene without a guard and with all of them.
fn guarded(name: &'static str, scene: &Scene, settings: &Settings, guard: Guard) -> Plate {
    plate(name, [(scene, settings, Some(guard)), (scene, settings, None)])
}

/// All plates.
pub fn plates() -> Vec<Plate> {
    vec![far(), cracks(), boxes(), acne(), terminator(), light_near_a_wall(), radiance_scale(), dimensions()]
}

const SIZE: [u32; 2] = [160, 120];

/// The Cornell box 2^18 of its own sizes away from the origin: coordinates in f32 have steps of 1/32 there.
fn far() -> Plate {
    let scene = load("cornell-box");
    let settings = Settings { max_bounces: 5, ..plain_settings(&scene, SIZE[0], SIZE[1], 64) };
    let mut moved = scene.clone();
    let shift = Vec3::splat(262_144.0);
    for triangle in &mut moved.triangles {
        triangle.positions = triangle.positions.map(|position| position + shift);
    }
    moved.camera.origin += shift.as_dvec3();
    moved.camera.target += shift.as_dvec3();
    plate("far", [(&moved, &settings, None), (&scene, &settings, None)])
}

/// Grey of a surface by the cosine at which it is seen.
fn grey(mesh: &[Triangle], hit: &Hit, direction: Vec3) -> [u8; 3] {
    let [a, b, c] = mesh[hit.id as usize].positions;
    let cosine = (b - a).cross(c - a).normalize().dot(direction.normalize()).abs();
    [(40.0 + 130.0 * cosine) as u8; 3]
}

/// One ray a pixel, by two ways to trace them; `lost` is the colour of what meets nothing.
fn traced(name: &'static str, rays: &[Ray], mesh: &[Triangle], lost: [u8; 3], ways: [Vec<Answer>; 2]) -> Plate {
    let [before, after] = ways.map(|answers| {
        let shown = rays.iter().zip(&answers);
        shown.map(|(ray, answer)| answer.hit.map_or(lost, |hit| grey(mesh, &hit, ray.direction))).collect()
    });
    Plate { name, size: SIZE.map(|length| length as usize), before, after }
}

fn pixels() -> impl Iterator<Item = [f32; 2]> {
    let [width, height] = SIZE;
    (0..height).flat_map(move |y| (0..width).map(move |x| [x as f32 / width as f32, y as f32 / height as f32]))
}

/// Rays from inside of a closed mesh; those that come near an edge are aimed exactly at it.
fn cracks() -> Plate {
    let mesh = displaced_sphere(17, 32);
    let accel = WideBvh::build(&mesh, Builder::Sah).into();
    let tracer = Tracer::new(&accel, &mesh, |_| false, Intersector::Watertight);
    let origin = Vec3::new(0.013, 0.021, -0.017);
    let rays: Vec<Ray> = pixels()
        .map(|[x, y]| {
            let direction = Vec3::new(1.6 * (x - 0.5), 1.2 * (0.5 - y), 0.55);
            let ray = Ray::new(origin, direction);
            let hit = tracer.closest(&ray).expect("the mesh is closed");
            let [a, b, c] = mesh[hit.id as usize].positions;
            let mut weights = [1.0 - hit.b1 - hit.b2, hit.b1, hit.b2];
            let nearest = (0..3).min_by(|&i, &j| weights[i].total_cmp(&weights[j])).expect("three weights");
            if weights[nearest] > 0.12 {
                return ray;
            }
            weights[nearest] = 0.0;
            let sum: f32 = weights.iter().sum();
            Ray::new(origin, (a * weights[0] + b * weights[1] + c * weights[2]) / sum - origin)
        })
        .collect();
    let bench = TestBench::new(context(), Tier::Fast);
    let ways = [Intersector::MollerTrumbore, Intersector::Watertight].map(|intersector| {
        let mesh = Mesh::wide(&mesh).expect("the mesh fits").with_intersector(intersector);
        mesh.trace(&bench, &rays).expect("the rays are traced")
    });
    traced("cracks", &rays, &mesh, [255; 3], ways)
}

/// Rays over a field of blocks; each second one has a direction of exactly 0 in x, and runs in the plane of a block's side.
fn boxes() -> Plate {
    let mut mesh = Vec::new();
    for i in 0..32 {
        let height = 0.1 + 0.09 * (i * 7 % 5) as f32;
        let at = Vec3::new((i % 8) as f32 * 0.2 - 0.75, 0.0, (i / 8) as f32 * 0.25 - 0.5);
        mesh.extend(cube(1).into_iter().map(|mut triangle| {
            triangle.positions =
                triangle.positions.map(|position| (position + 0.5) * Vec3::new(0.15, height, 0.18) + at);
            triangle
        }));
    }
    let planes: Vec<f32> = mesh.iter().flat_map(|triangle| triangle.positions.map(|position| position.x)).collect();
    let rays: Vec<Ray> = pixels()
        .enumerate()
        .map(|(pixel, [x, y])| {
            let mut at = Vec3::new(1.7 * (x - 0.5), 1.3 * (0.55 - y), 0.0);
            let mut direction = Vec3::new(1e-3, -0.6, 1.0);
            if (pixel + pixel / SIZE[0] as usize).is_multiple_of(2) {
                direction.x = 0.0;
                let near = |a: &&f32, b: &&f32| (*a - at.x).abs().total_cmp(&(*b - at.x).abs());
                at.x = *planes.iter().min_by(near).expect("there are blocks");
            }
            Ray::new(at - direction * 2.0, direction)
        })
        .collect();
    let bench = TestBench::new(context(), Tier::Fast);
    let records = Mesh::wide(&mesh).expect("the mesh fits");
    let ways = [bench.without(Guard::DirectionFloor), bench]
        .map(|bench| records.trace(&bench, &rays).expect("the rays are traced"));
    traced("boxes", &rays, &mesh, [0; 3], ways)
}

/// A lit mesh: rays to the light from the bare hit points, which may meet the triangle they leave, and as they are.
fn acne() -> Plate {
    let mesh = displaced_sphere(17, 32);
    let accel = WideBvh::build(&mesh, Builder::Sah).into();
    let tracer = Tracer::new(&accel, &mesh, |_| false, Intersector::Watertight);
    let light = Vec3::new(-0.6, 0.7, -0.5).normalize();
    let hits: Vec<Option<(Hit, Vec3)>> = pixels()
        .map(|[x, y]| {
            let direction = Vec3::new(0.44 * (x - 0.5), 0.33 * (0.5 - y), 1.0).normalize();
            tracer.closest(&Ray::new(Vec3::new(0.0, 0.0, -5.0), direction)).map(|hit| (hit, direction))
        })
        .collect();
    let departures: Vec<Departure> = hits
        .iter()
        .flatten()
        .map(|&(Hit { id, b1, b2, .. }, direction)| Departure {
            id,
            barycentrics: [b1, b2],
            wo: -direction,
            d: light,
            light: NO_INDEX,
        })
        .collect();
    let bench = TestBench::new(context(), Tier::Fast);
    let records = Mesh::wide(&mesh).expect("the mesh fits");
    let ways = [(bench.without(Guard::SkipSource), Leaving::Bare), (bench, Leaving::Extension)];
    let [before, after] = ways.map(|(bench, leaving)| {
        let mut arrivals = records.leave(&bench, &departures, leaving).expect("the rays are traced").into_iter();
        hits.iter()
            .map(|hit| {
                let Some((hit, direction)) = hit else { return [255; 3] };
                let [a, b, c] = mesh[hit.id as usize].positions;
                let normal = (b - a).cross(c - a).normalize();
                let normal = if normal.dot(*direction) > 0.0 { -normal } else { normal };
                let free = arrivals.next().is_some_and(|arrival| arrival.hit.is_none());
                let lit = if free { normal.dot(light).max(0.0) } else { 0.0 };
                Display::default().bytes([0.03 + 0.7 * lit; 3])
            })
            .collect()
    });
    Plate { name: "acne", size: SIZE.map(|length| length as usize), before, after }
}

/// A light close to a wall, which it faces: light samples alone have no bound.
fn light_near_a_wall() -> Plate {
    let mut builder = SceneBuilder::new();
    let (wall, light) = (builder.material(lambert(0.7, 0.0)), builder.material(lambert(0.0, 4.0)));
    builder.quad([-2.0, 0.0, -2.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0], wall);
    for x in [-0.7, 0.0, 0.7] {
        builder.quad([x - 0.05, 0.03, -0.8], [0.1, 0.0, 0.0], [0.0, 0.0, 1.6], light);
    }
    let scene = builder.finish(camera([0.0, 2.0, -1.5], [0.0, 0.0, 0.0], 40.0), None);
    let settings = Settings { max_bounces: 2, ..plain_settings(&scene, SIZE[0], SIZE[1], 16) };
    let alone = Settings { lights: Lights::Area, ..settings.clone() };
    plate("light-near-a-wall", [(&scene, &alone, None), (&scene, &settings, None)])
}

/// A bent screen of two facets with the normals of a cylinder. The lamp above is just behind the plane of the upper one, whose
/// upper normals lean towards it.
fn terminator() -> Plate {
    let mut builder = SceneBuilder::new();
    let (screen, light) = (builder.material(lambert(0.8, 0.0)), builder.material(lambert(0.0, 120.0)));
    for bottom in [-115.0f64, -55.0] {
        let normal = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            DVec3::new(0.0, sin, -cos)
        };
        let [low, high] = [bottom, bottom + 60.0].map(normal);
        let [left, right] = [-1.0, 1.0].map(|x| DVec3::X * x);
        builder.smooth_triangle([low + left, high + left, high + right], [low, high, high], screen);
        builder.smooth_triangle([low + left, high + right, low + right], [low, high, low], screen);
    }
    builder.quad([-0.5, 4.0, -2.5], [1.0, 0.0, 0.0], [0.0, 0.0, 0.5], light);
    let scene = builder.finish(camera([0.0, -0.5, -5.0], [0.0, -0.45, 0.0], 26.0), Some([0.05, 0.06, 0.08]));
    let settings = Settings { max_bounces: 1, ..plain_settings(&scene, SIZE[0], SIZE[1], 64) };
    guarded("terminator", &scene, &settings, Guard::GeometricSide)
}

/// Roulette at 0.7 a bounce, every bounce with numbers of its own, and all with the same: a path that survives once survives
/// for ever, and is raised each time.
fn dimensions() -> Plate {
    let scene = load("cornell-box");
    let roulette = Roulette::Fixed(0.7);
    let settings = Settings { max_bounces: 5, roulette, ..plain_settings(&scene, SIZE[0], SIZE[1], 256) };
    guarded("dimensions", &scene, &settings, Guard::BounceDimensions)
}

/// A camera inside glass, in a white furnace.
fn radiance_scale() -> Plate {
    let mut builder = SceneBuilder::new();
    let (water, floor) = (builder.material(glass(1.33)), builder.material(lambert(0.5, 0.0)));
    builder.cuboid([-1.0, -0.5, -1.0], [1.0, 0.5, 1.0], water, false);
    builder.quad([-3.0, -0.8, -3.0], [0.0, 0.0, 6.0], [6.0, 0.0, 0.0], floor);
    let scene = builder.finish(camera([0.0, 0.0, -0.8], [0.0, -0.1, 1.0], 60.0), Some([0.4, 0.45, 0.5]));
    let settings = Settings { max_bounces: 16, ..plain_settings(&scene, SIZE[0], SIZE[1], 64) };
    guarded("radiance-scale", &scene, &settings, Guard::RadianceScale)
}
