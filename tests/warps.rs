//! Rung 4, warps: what the renderer's own functions (`glsl/probe_sampling.comp`) make of numbers in [0, 1).
//!
//! Chi-square and z of 2^18 draws at fixed seeds, each verdict one of fewer than [`TESTS`] at a false-alarm rate of 1e-6 for
//! all. Known values are those of the hard cases 7, 45, 50 and 55, with the tolerance that rounding allows beside each.

mod harness;

use std::f64::consts::TAU;

use harness::Assert;
use harness::draws::{
    COSINE_HEMISPHERE, FILTER_OFFSET, FRESNEL, MAKE_BASIS, PICK_LIGHT, POWER_HEURISTIC, SQUARE_TO_TRIANGLE,
    UNIFORM_HEMISPHERE, call, call_floats, nothing,
};
use harness::random::Random;
use harness::scenes::{SceneBuilder, camera, lambert};
use harness::statistics::{Moments, chi_square_test, z_test};
use texray::bvh::Accel;
use texray::interface::FILTER_ENTRIES;
use texray::scene::Filter;
use texray::settings::{Sampler, Settings};
use texray::texels::TexelData;
use texray::texels::camera::filter_texels;
use texray::texels::triangle::area;

const TESTS: usize = 100;
const DRAWS: usize = 1 << 18;

/// Numbers with 24 bits, as the renderer's are, four a call.
fn numbers(seed: u64) -> Vec<[f32; 4]> {
    let mut random = Random::new(seed, 0);
    let mut next = || (random.next() * 16_777_216.0).floor() as f32 / 16_777_216.0;
    (0..DRAWS).map(|_| [next(), next(), 0.0, 0.0]).collect()
}

fn borders() -> Vec<[f32; 4]> {
    let values =
        [0.0, 1.0 / 16_777_216.0, 0.25, 0.5, 0.5f32.next_down(), 0.5f32.next_up(), 0.75, 1.0 - 1.0 / 16_777_216.0];
    values.iter().flat_map(|&u| values.map(|v| [u, v, 0.0, 0.0])).collect()
}

/// Chi-square over 21 parts of the cosine and 42 of the angle, `below(c)` the probability of a cosine below c.
fn directions(
    function: u32,
    seed: u64,
    below: impl Fn(f64) -> f64,
    [mean, mean_square, mean_fourth]: [f64; 3],
    what: &str,
) {
    const COSINES: usize = 21;
    const ANGLES: usize = 42;
    let mut counts = vec![0.0; COSINES * ANGLES];
    let (mut cosines, mut squares) = (Moments::default(), Moments::default());
    let (draws, borders) = (call_floats(function, &numbers(seed)), call_floats(function, &borders()));
    for [x, y, z, _] in draws.iter().chain(&borders).map(|d| d.map(f64::from)) {
        let length2 = x * x + y * y + z * z;
        assert!((length2 - 1.0).abs() <= 1e-6 && z >= 0.0, "{what}: ({x}, {y}, {z}) has the squared length {length2}");
    }
    for [x, y, z, _] in draws.iter().map(|d| d.map(f64::from)) {
        let angle = (y.atan2(x) / TAU).rem_euclid(1.0);
        let [row, column] = [(z, COSINES), (angle, ANGLES)].map(|(v, n)| ((v * n as f64) as usize).min(n - 1));
        counts[row * ANGLES + column] += 1.0;
        cosines.add(z);
        squares.add(z * z);
    }
    let edge = |row: usize| below(row as f64 / COSINES as f64);
    let expected = |cell: usize| (edge(cell / ANGLES + 1) - edge(cell / ANGLES)) / ANGLES as f64 * DRAWS as f64;
    let expected: Vec<f64> = (0..counts.len()).map(expected).collect();
    chi_square_test(&counts, &expected).assert(what, TESTS);
    let count = DRAWS as f64;
    z_test(cosines.mean, (mean_square - mean * mean) / count, mean).assert(&format!("{what}: mean cosine"), TESTS);
    let variance = (mean_fourth - mean_square * mean_square) / count;
    z_test(squares.mean, variance, mean_square).assert(&format!("{what}: mean squared cosine"), TESTS);
}

#[test]
fn hemispheres_have_their_densities() {
    directions(COSINE_HEMISPHERE, 1, |c| c * c, [2.0 / 3.0, 0.5, 1.0 / 3.0], "density cos / π");
    directions(UNIFORM_HEMISPHERE, 2, |c| c, [0.5, 1.0 / 3.0, 0.2], "density 1 / 2π");
}

#[test]
fn points_on_a_triangle_are_uniform() {
    const SIDE: usize = 32;
    let mut counts = vec![0.0; SIDE * SIDE];
    let mut means = [Moments::default(), Moments::default()];
    let questions = [numbers(3), borders()].concat();
    for (i, [b1, b2, ..]) in call_floats(SQUARE_TO_TRIANGLE, &questions).into_iter().enumerate() {
        assert!(b1 >= 0.0 && b2 >= 0.0 && b1 + b2 <= 1.0 + f32::EPSILON, "({b1}, {b2}) is outside");
        if i >= DRAWS {
            continue; // The borders are not random.
        }
        let [mut row, column] = [b1, b2].map(|b| ((b * SIDE as f32) as usize).min(SIDE - 1));
        // A sum rounded up to 1 belongs to the diagonal's cell.
        row = row.min(SIDE - 1 - column);
        counts[row * SIDE + column] += 1.0;
        [b1, b2].into_iter().zip(&mut means).for_each(|(b, mean)| mean.add(f64::from(b)));
    }
    let cell = |i: usize| match (i / SIDE + i % SIDE).cmp(&(SIDE - 1)) {
        std::cmp::Ordering::Less => 2.0,
        std::cmp::Ordering::Equal => 1.0,
        std::cmp::Ordering::Greater => 0.0,
    };
    let expected: Vec<f64> = (0..counts.len()).map(|i| cell(i) * DRAWS as f64 / (SIDE * SIDE) as f64).collect();
    chi_square_test(&counts, &expected).assert("triangle", TESTS);
    for mean in means {
        z_test(mean.mean, 1.0 / 18.0 / DRAWS as f64, 1.0 / 3.0).assert("mean barycentric", TESTS);
    }
}

/// Filters in closed form, in pixels from the centre, not normalised.
fn filter_value(filter: Filter, x: f64) -> f64 {
    match filter {
        Filter::Box => 1.0,
        Filter::Tent => 1.0 - x.abs(),
        Filter::Gaussian => (-x * x / (2.0 * 0.5 * 0.5)).exp(),
        Filter::BlackmanHarris => {
            let wave = |k: f64| (k * TAU * x / 3.0).cos();
            0.35875 + 0.48829 * wave(1.0) + 0.14128 * wave(2.0) + 0.01168 * wave(3.0)
        }
    }
}

#[test]
fn filter_offsets_follow_the_table_and_the_table_its_filter() {
    for (filter, radius, seed) in [(Filter::Tent, 1.0, 4), (Filter::Gaussian, 1.5, 5), (Filter::BlackmanHarris, 1.5, 6)]
    {
        let table: Vec<f32> = filter_texels(filter).into_iter().flatten().map(f32::from_bits).collect();
        assert_eq!(table.len(), FILTER_ENTRIES as usize);
        // The table against the filter's own distribution, by Simpson's rule (error far below 1e-6).
        let integral = |from: f64, to: f64| {
            let (steps, width) = (200, (to - from) / 200.0);
            let weight = |i: usize| {
                if i == 0 || i == steps {
                    1.0
                } else if i % 2 == 1 {
                    4.0
                } else {
                    2.0
                }
            };
            (0..=steps).map(|i| weight(i) * filter_value(filter, from + i as f64 * width)).sum::<f64>() * width / 3.0
        };
        let half = integral(0.0, radius);
        for (i, &offset) in table.iter().enumerate() {
            let offset = f64::from(offset);
            let below = 0.5 + integral(0.0, offset.abs()) / half / 2.0 * offset.signum();
            let due = i as f64 / f64::from(FILTER_ENTRIES - 1);
            assert!((below - due).abs() < 1e-5, "{filter:?}: entry {i}, {offset}, is the quantile {below}, not {due}");
        }
        // The device against the table: the same interpolation in f32, bit for bit.
        let inputs: Vec<[u32; 4]> =
            numbers(seed).into_iter().chain(borders()).map(|call| call.map(f32::to_bits)).collect();
        let found = call(&nothing(), Sampler::Independent, filter, FILTER_OFFSET, &inputs);
        let mut moments = Moments::default();
        for (input, found) in inputs.iter().zip(&found) {
            let place = f32::from_bits(input[0]) * (FILTER_ENTRIES - 1) as f32;
            let entry = (place as usize).min(FILTER_ENTRIES as usize - 2);
            let expected = table[entry] + (table[entry + 1] - table[entry]) * (place - entry as f32);
            assert_eq!(found[0], expected.to_bits(), "{filter:?} at {}", f32::from_bits(input[0]));
        }
        found[..DRAWS].iter().for_each(|found| moments.add(f64::from(f32::from_bits(found[0]))));
        let variance = moments.variance() / DRAWS as f64;
        // Symmetric to 2e-3 of a pixel in one entry at each end (texels/camera.rs): 4e-6 of the mean at most.
        let excess = (moments.mean.abs() - 4e-6).max(0.0);
        z_test(excess, variance, 0.0).assert(&format!("{filter:?}: mean offset"), TESTS);
    }
}

/// Fresnel's equations in f64, squared sines kept apart near the critical angle.
fn fresnel(cosine: f64, eta: f64) -> (f64, f64) {
    let sine2 = (1.0 - cosine) * (1.0 + cosine) / (eta * eta);
    if sine2 >= 1.0 {
        return (1.0, 0.0);
    }
    let beyond = (1.0 - sine2).sqrt();
    let parallel = (eta * cosine - beyond) / (eta * cosine + beyond);
    let perpendicular = (cosine - eta * beyond) / (cosine + eta * beyond);
    ((parallel * parallel + perpendicular * perpendicular) / 2.0, beyond)
}

#[test]
fn fresnels_equations_have_their_known_values() {
    // Hard case 50. The cosine of an angle in f32 is good to 6e-8, which moves R by less than 1e-5 of itself.
    let from = |degrees: f64, eta: f32| [degrees.to_radians().cos() as f32, eta, 0.0, 0.0];
    let known = [(0.0, 0.04), (45.0, 0.0502399), (56.3099, 0.0739645)];
    let found = call_floats(FRESNEL, &known.map(|(degrees, _)| from(degrees, 1.5)));
    for ((degrees, expected), [found, ..]) in known.into_iter().zip(found) {
        assert!((f64::from(found) / expected - 1.0).abs() < 1e-5, "{found} at {degrees} degrees, not {expected}");
    }
    // Beyond the critical angle of 41.81 degrees everything is reflected, exactly; equal indices reflect nothing.
    let inside = call_floats(FRESNEL, &[41.82, 45.0, 60.0, 89.9].map(|degrees| from(degrees, 1.0 / 1.5)));
    assert!(inside.iter().all(|answer| answer[..2] == [1.0, 0.0]), "{inside:?}");
    for [reflectance, cosine, ..] in call_floats(FRESNEL, &[0.0, 30.0, 60.0, 80.0].map(|degrees| from(degrees, 1.0))) {
        assert!((0.0..1e-12).contains(&reflectance) && cosine > 0.0, "{reflectance} at equal indices");
    }
    // Means over the hemisphere: squared cosines at the middles of 2^18 equal parts.
    for (eta, mean) in [(1.5f32, 0.0917780), (1.0 / 1.5, 0.5963457)] {
        let part = |i: usize| [((i as f64 + 0.5) / DRAWS as f64).sqrt() as f32, eta, 0.0, 0.0];
        let found = call_floats(FRESNEL, &(0..DRAWS).map(part).collect::<Vec<_>>());
        let found = found.iter().map(|answer| f64::from(answer[0])).sum::<f64>() / DRAWS as f64;
        assert!((found / mean - 1.0).abs() < 1e-5, "{found} is the mean for {eta}, not {mean}");
    }
}

#[test]
fn fresnels_equations_agree_with_f64() {
    let etas = [1.5f32, 1.0 / 1.5, 2.4, 1.0 / 2.4, 1.33, 1.000_001, 100.0];
    let questions: Vec<[f32; 4]> =
        numbers(7).iter().zip(etas.iter().cycle()).map(|(u, &eta)| [u[0].max(1e-6), eta, 0.0, 0.0]).collect();
    let mut beside = 0;
    for ([cosine, eta, ..], [found, cos_t, ..]) in questions.iter().zip(call_floats(FRESNEL, &questions)) {
        assert!((0.0..=1.0).contains(&found) && (0.0..=1.0).contains(&cos_t), "{found}, {cos_t} at {cosine} for {eta}");
        let (expected, beyond) = fresnel(f64::from(*cosine), f64::from(*eta));
        // The squared sine errs by 4 roundings of 6e-8; within 1e-3 of the critical angle the root makes more of it.
        if beyond * beyond < 1e-3 {
            beside += 1;
            continue;
        }
        let error = (f64::from(found) - expected).abs();
        assert!(error < 2e-5, "{found} at {cosine} for {eta}, not {expected}");
        assert!((f64::from(cos_t) - beyond).abs() < 1e-5, "{cos_t} at {cosine} for {eta}, not {beyond}");
    }
    assert!(beside < DRAWS / 3, "most questions are answered: {beside}");
}

#[test]
fn bases_are_orthonormal_and_right_handed() {
    // Hard case 55: the vectors of pbrt's own test, the axes, and random directions.
    let mut normals = vec![
        [0.000_385_273_16, 0.000_384_600_16, -0.999_999_9, 0.0],
        [-0.000_198_135_81, -0.000_089_468_39, -0.999_999_9, 0.0f32],
    ];
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut normal = [0.0; 4];
            normal[axis] = sign;
            normals.push(normal);
            normals.push(std::array::from_fn(|i| if i == axis { sign } else { -0.0 }));
        }
    }
    let mut random = Random::new(8, 0);
    normals.extend((0..100_000).map(|_| {
        let (z, angle) = (2.0 * random.next() - 1.0, TAU * random.next());
        let radius = (1.0 - z * z).sqrt();
        [radius * angle.cos(), radius * angle.sin(), z, 0.0].map(|v: f64| v as f32)
    }));
    for (normal, [handed, s, t, crossed]) in normals.iter().zip(call_floats(MAKE_BASIS, &normals)) {
        let metric = [s, t, crossed, handed - 1.0].map(|error| f64::from(error).powi(2)).iter().sum::<f64>();
        assert!(metric < 1e-10, "{normal:?}: errors {s:e} {t:e} {crossed:e}, handedness {handed}");
    }
}

#[test]
fn power_heuristics_add_up_to_one() {
    // Hard case 45. Both infinite is left out: a BSDF's density is at most 1 / π.
    let values = [0.0, 1.2e-38, 1e-20, 1.0, 1e20, f32::INFINITY];
    let pairs: Vec<[f32; 4]> = values.iter().flat_map(|&a| values.map(|b| [a, b, 0.0, 0.0])).collect();
    for ([a, b, ..], [mine, other, ..]) in pairs.iter().zip(call_floats(POWER_HEURISTIC, &pairs)) {
        if a.is_infinite() && b.is_infinite() {
            continue;
        }
        let expected = if *a == 0.0 && *b == 0.0 { 0.0 } else { 1.0 };
        assert!((f64::from(mine) + f64::from(other) - expected).abs() <= 1e-6, "{a} against {b}: {mine} and {other}");
        assert!(mine >= 0.0 && other >= 0.0 && (a <= b || mine > other), "{a} against {b}: {mine} and {other}");
    }
}

#[test]
fn lights_are_picked_as_often_as_their_densities_say() {
    // Seven pairs of triangles whose powers differ by 10^8.
    let mut builder = SceneBuilder::new();
    for i in 0..7 {
        let light = builder.material(lambert(0.0, 10f32.powi(i - 3)));
        let size = 1.0 + f64::from(i % 3);
        builder.quad([f64::from(i) * 4.0, 0.0, 0.0], [size, 0.0, 0.0], [0.0, size, 0.0], light);
    }
    let scene = builder.finish(camera([0.0, 0.0, 5.0], [0.0; 3], 40.0), None);
    let data = TexelData::pack(&scene, &Accel::brute(), &Settings::for_scene(&scene)).expect("the scene can be packed");
    assert_eq!(data.light_count, 14);
    let lights = data.lights.as_chunks::<5>().0;
    let share = |&[_, [_, _, _, triangle], [_, _, _, density], ..]: &[[u32; 4]; 5]| {
        f64::from(f32::from_bits(density)) * area(&scene.triangles[triangle as usize])
    };
    let shares: Vec<f64> = lights.iter().map(share).collect();
    // Each density is rounded once to f32.
    assert!((shares.iter().sum::<f64>() - 1.0).abs() < 1e-6, "{shares:?}");
    assert!(shares.iter().all(|&share| share > 0.003), "no light starves: {shares:?}");

    let pick = |words: &[u32]| -> Vec<u32> {
        let input: Vec<[u32; 4]> = words.iter().map(|&word| [word, 0, 0, 0]).collect();
        call(&scene, Sampler::Independent, Filter::Box, PICK_LIGHT, &input).iter().map(|answer| answer[0]).collect()
    };
    // Both ends of each share, exactly.
    let mut begin = 0;
    for (light, &[[_, _, _, end], ..]) in (0..).zip(lights) {
        assert_eq!(pick(&[begin, end]), [light, light]);
        begin = end.wrapping_add(1);
    }
    assert_eq!(begin, 0, "the last share ends with the last word");
    let mut random = Random::new(9, 0);
    let words: Vec<u32> = (0..DRAWS).map(|_| (random.next() * 4_294_967_296.0) as u32).collect();
    let mut counts = [0.0; 14];
    pick(&words).into_iter().for_each(|light| counts[light as usize] += 1.0);
    let expected: Vec<f64> = shares.iter().map(|share| share * DRAWS as f64).collect();
    chi_square_test(&counts, &expected).assert("picked lights", TESTS);
}
