//! The light tree, asked through the renderer's own descent (`glsl/shading/light_tree.glsl`).
//!
//! Comes in: a bench. Goes out: findings about how many words choose each light for a point, and about what is drawn. Words are
//! whole numbers, so that sums are exact.

use glam::{DVec3, Vec3};

use crate::Result;
use crate::bvh::Accel;
use crate::gpu::shaders;
use crate::interface::{LIGHT_TEXELS, LIGHT_TREE_LEVELS, LIGHT_TREE_WORDS, TRIANGLE_TEXELS, TRIANGLE_TRAIL_SHIFT};
use crate::scene::Scene;
use crate::selftest::TestBench;
use crate::selftest::kit::probe_calls::ProbeCalls;
use crate::selftest::kit::scenes::{SceneBuilder, camera, lambert};
use crate::settings::{LightPick, Settings};
use crate::statistics::Finding;
use crate::statistics::chi_square_test;
use crate::statistics::random::Random;
use crate::texels::triangle::geometric_normal;
use crate::texels::{Texel, TexelData};

// Functions of glsl/probe_scattering.comp.
const CHOOSE: u32 = 11;
const WORDS_OF: u32 = 12;
const BOTH: u32 = 13;
const PLACE_IN_WORDS: u32 = 14;

/// A point and its normal, in scaled units.
type Point = (Vec3, Vec3);

/// Small lights that face any way, in a cube of side 2; their radiances differ by as many powers of ten.
pub fn scattered(count: u32, decades: f64) -> Scene {
    let mut builder = SceneBuilder::new();
    let materials: Vec<u32> =
        (0..8).map(|i| builder.material(lambert(0.0, 10f64.powf(decades * f64::from(i) / 7.0) as f32))).collect();
    let mut random = Random::new(43, u64::from(count));
    for _ in 0..count {
        let corner = random.point().as_dvec3();
        let sides = [0; 2].map(|_| random.direction().as_dvec3() * 0.02);
        let material = materials[random.below(materials.len())];
        builder.triangle([corner, corner + sides[0], corner + sides[1]], material);
    }
    builder.finish(camera([0.0, 0.0, -5.0], [0.0; 3], 40.0), None)
}

/// A scene whose lights are chosen by the tree.
struct Lit<'a> {
    bench: &'a TestBench,
    scene: &'a Scene,
    data: TexelData,
    /// Each light's way from the root, in the order of the lights' records.
    trails: Vec<u32>,
}

impl<'a> Lit<'a> {
    fn new(bench: &'a TestBench, scene: &'a Scene) -> Result<Lit<'a>> {
        let settings = Settings { light_pick: LightPick::Tree, ..Settings::for_scene(scene) };
        let data = TexelData::pack(scene, &Accel::brute(), &settings)?;
        let trail = |record: &[Texel]| {
            let triangle = record[1][3];
            data.triangles[(TRIANGLE_TEXELS * triangle) as usize + 1][3] >> TRIANGLE_TRAIL_SHIFT
        };
        let trails = data.lights.chunks_exact(LIGHT_TEXELS as usize).map(trail).collect();
        Ok(Lit { bench, scene, data, trails })
    }

    fn ask(&self, function: u32, input: &[[Texel; 3]]) -> Result<Vec<Texel>> {
        let calls = ProbeCalls {
            scene: Some(self.scene),
            light_pick: Some(LightPick::Tree),
            calls: input.len() as u32,
            output_texels: 2,
            ..ProbeCalls::new(shaders::PROBE_SCATTERING, function, input.as_flattened())
        };
        Ok(calls.run(self.bench)?.into_iter().step_by(2).collect())
    }

    /// How many words choose each light for a point, and the most levels that it took to know.
    fn words(&self, point: Point) -> Result<(Vec<u32>, u32)> {
        let input: Vec<_> = self.trails.iter().map(|&trail| question(point, trail, 0, point.0)).collect();
        let answers = self.ask(WORDS_OF, &input)?;
        Ok((answers.iter().map(|a| a[0]).collect(), answers.iter().map(|a| a[1]).max().unwrap_or(0)))
    }

    /// Whether some corner of a light, at least, sees the front of the point and is seen from its own.
    fn faces(&self, light: usize, (p, n): Point) -> bool {
        let triangle = &self.scene.triangles[self.data.lights[LIGHT_TEXELS as usize * light + 1][3] as usize];
        let normal = geometric_normal(triangle);
        triangle.positions.iter().any(|v| {
            let to_light = (v.as_dvec3() - p.as_dvec3()).normalize();
            to_light.dot(n.as_dvec3()) > 0.01 && to_light.dot(normal) < -0.01
        })
    }
}

fn question((p, n): Point, first: u32, second: u32, other: Vec3) -> [Texel; 3] {
    let texel = |v: Vec3, word| [v.x.to_bits(), v.y.to_bits(), v.z.to_bits(), word];
    [texel(p, first), texel(n, second), texel(other, 0)]
}

/// Words of every light add up, none is without, those that matter have more; what is drawn has the words that it is divided by.
pub fn picks(bench: &TestBench) -> Result<Vec<Finding>> {
    let mut findings = Vec::new();
    let large = bench.count(20_000, 100_000) as u32;
    for (count, points, draws) in
        [(1, 4, 1 << 10), (2, 8, 1 << 14), (5, 8, 1 << 14), (200, 32, 1 << 18), (large, 2, 1 << 14)]
    {
        let scene = scattered(count, 2.0);
        let lit = Lit::new(bench, &scene)?;
        let mut random = Random::new(44, u64::from(count));
        let (mut unsound, mut without, mut starved, mut facing, mut levels) = (0, 0, 0, 0, 0);
        let (mut others, mut twice) = (0, 0);
        for _ in 0..points {
            let point = (random.point() * 0.5, random.direction());
            let (words, deepest) = lit.words(point)?;
            levels = levels.max(deepest);
            unsound += u64::from(words.iter().map(|&w| u64::from(w)).sum::<u64>() != u64::from(LIGHT_TREE_WORDS));
            without += words.iter().filter(|&&w| w == 0).count();
            if count <= 200 {
                let seen = (0..words.len()).filter(|&light| lit.faces(light, point));
                let seen: Vec<usize> = seen.collect();
                facing += seen.len();
                starved += seen.iter().filter(|&&light| words[light] <= 1).count();
            }
            let drawn: Vec<u32> = (0..draws / points).map(|_| random.bits() as u32).collect();
            let input: Vec<_> = drawn.iter().map(|&word| question(point, word, 0, point.0)).collect();
            let answers = lit.ask(CHOOSE, &input)?;
            let own = |a: &&Texel| words.get(a[0] as usize) != Some(&a[2]) || a[1] >= a[2] || a[3] > LIGHT_TREE_LEVELS;
            others += answers.iter().filter(own).count();
            // With a light that was met on the way, from the same point, both answers are the same as alone.
            let last = words.len() - 1;
            let input: Vec<_> = drawn.iter().map(|&word| question(point, word, lit.trails[last], point.0)).collect();
            let both = lit.ask(BOTH, &input)?;
            let same = |(one, both): &(&Texel, &Texel)| one[..3] == both[..3] && both[3] == words[last];
            twice += answers.iter().zip(&both).filter(|pair| !same(pair)).count();
        }
        let asked = u64::from(count) * points as u64;
        let mut never = |what: &str, events: usize, trials: u64| {
            findings.push(Finding::never(format!("tree of {count} lights, {what}"), events as u64, trials));
        };
        never("points whose lights' words do not add up to 2^31", unsound as usize, points as u64);
        never("lights without a word", without, asked);
        never("picks with other words than the light's own", others, draws as u64);
        never("answers that differ where two are asked for at once", twice, draws as u64);
        if facing > 0 {
            never("lights that face the point and have one word", starved, facing as u64);
        }
        let why = "two descents are within the steps that shading may take";
        let deepest = f64::from(LIGHT_TREE_LEVELS);
        findings.push(Finding::at_most(format!("tree of {count} lights, levels"), deepest, f64::from(levels), why));
    }
    findings.push(frequencies(bench)?);
    Ok(findings)
}

/// How often each light is picked for one point.
fn frequencies(bench: &TestBench) -> Result<Finding> {
    let scene = scattered(200, 2.0);
    let lit = Lit::new(bench, &scene)?;
    let point = (Vec3::new(0.1, -0.2, 0.05), Vec3::Y);
    let (words, _) = lit.words(point)?;
    let mut random = Random::new(45, 0);
    let draws = bench.count(1 << 18, 1 << 21);
    let input: Vec<_> = (0..draws).map(|_| question(point, random.bits() as u32, 0, point.0)).collect();
    let mut counts = vec![0.0; words.len()];
    for answer in lit.ask(CHOOSE, &input)? {
        if let Some(count) = counts.get_mut(answer[0] as usize) {
            *count += 1.0;
        }
    }
    let share = |&words: &u32| f64::from(words) / f64::from(LIGHT_TREE_WORDS) * draws as f64;
    let verdict = chi_square_test(&counts, &words.iter().map(share).collect::<Vec<_>>());
    Ok(Finding {
        what: "tree of 200 lights, frequencies of picks for a point".into(),
        expected: "words".into(),
        got: format!("chi-square {:.1}, p {:.2e}", verdict.statistic, verdict.p),
        tolerance: "p 1e-9: one false alarm in 1e6 suites of 1000 verdicts".into(),
        passes: verdict.p >= 1e-9,
    })
}

/// Eight lights in a ring around the origin that face inwards, and eight at `distance` along x that face the origin.
fn ring_and_wall(distance: f64, [ring, wall]: [f32; 2]) -> Scene {
    let mut builder = SceneBuilder::new();
    let [ring, wall] = [ring, wall].map(|emission| builder.material(lambert(0.0, emission)));
    for i in 0..8 {
        let (sine, cosine) = (f64::from(i) * std::f64::consts::FRAC_PI_4 + 0.2).sin_cos();
        let out = DVec3::new(cosine, 0.0, sine);
        let across = DVec3::new(-sine, 0.0, cosine) * 0.02;
        // across × y points inwards.
        builder.triangle([out * 0.1, out * 0.1 + across, out * 0.1 + DVec3::Y * 0.02], ring);
        let corner = DVec3::new(distance, 0.1 * cosine, 0.1 * sine);
        builder.triangle([corner, corner + DVec3::Z * 0.02, corner + DVec3::Y * 0.02], wall);
    }
    builder.finish(camera([0.0, 0.0, -5.0], [0.0; 3], 40.0), None)
}

/// A point in the centre of a cluster: the cluster is nearer than any other, but not infinitely so.
pub fn cluster_around_a_point(bench: &TestBench) -> Result<Finding> {
    let scene = ring_and_wall(0.4, [1.0, 1.0]);
    let lit = Lit::new(bench, &scene)?;
    let [x, y, z] = [0, 1, 2].map(|lane| f32::from_bits(lit.data.light_nodes[0][lane]));
    let centre = Vec3::new(x, y, z);
    let (words, _) = lit.words((centre, -centre.normalize()))?;
    let own = lit.trails.iter().zip(&words).filter(|(trail, _)| *trail & 3 == 0).map(|(_, &w)| f64::from(w));
    let share = own.sum::<f64>() / f64::from(LIGHT_TREE_WORDS);
    let why = "it has a quarter of the power, and its radius is a quarter of the distance to those in front";
    Ok(Finding::at_most("share of a cluster with the point in its centre", 0.99, share, why))
}

/// Lights 10^10 times brighter, which may all be hidden, leave the others a share.
pub fn bright_beside_faint(bench: &TestBench) -> Result<Finding> {
    let scene = ring_and_wall(0.4, [1e-10, 1.0]);
    let lit = Lit::new(bench, &scene)?;
    let (words, _) = lit.words((scene.scaling.point(DVec3::ZERO).as_vec3(), Vec3::X))?;
    let bright = |light: &usize| lit.data.lights[LIGHT_TEXELS as usize * light + 1][3] % 2 == 1;
    let share = (0..words.len()).filter(bright).map(|light| f64::from(words[light])).sum::<f64>();
    let why = "half of a 256th goes to the other half of the lights";
    Ok(Finding::at_most("share of lights 10^10 times brighter", 0.9985, share / f64::from(LIGHT_TREE_WORDS), why))
}

/// Where a draw stands among a light's words is below 1, whatever its digits.
pub fn places_in_words(bench: &TestBench) -> Result<Finding> {
    let scene = scattered(1, 0.0);
    let lit = Lit::new(bench, &scene)?;
    let sizes = (0..=31).flat_map(|exponent| [1u32 << exponent, (1 << exponent) - 1]).filter(|&size| size > 0);
    let input: Vec<[Texel; 3]> = sizes
        .flat_map(|size| {
            let place =
                move |place: u32| [0.0, 0.5, 1.0 - 2f32.powi(-24)].map(|digits| [digits.to_bits(), place, size, 0]);
            [0, size / 2, size - 1].into_iter().flat_map(place)
        })
        .map(|call| [call, [0; 4], [0; 4]])
        .collect();
    let answers = lit.ask(PLACE_IN_WORDS, &input)?;
    let outside = answers.iter().filter(|answer| !(0.0..1.0).contains(&f32::from_bits(answer[0]))).count();
    Ok(Finding::never("places among a light's words outside [0, 1)", outside as u64, input.len() as u64))
}
