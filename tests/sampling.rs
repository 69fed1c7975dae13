//! Rung 4, random numbers: drawn by the renderer's own functions (`glsl/probe_sampling.comp`).
//!
//! Exact: no float reaches 1; Sobol' pairs are stratified; pairs, replicates, pixels and samplers differ. Stochastic: moments,
//! correlations and chi-square at fixed seeds, each verdict one of fewer than [`TESTS`] at a false-alarm rate of 1e-6 for
//! all (|z| <= 6.1). Sobol' points of one sequence are not independent, so they are judged across pixels, whose scrambles are.

mod harness;

use harness::Assert;
use harness::draws::{REPLICATES, UNIT_FLOAT, call, correlation, nothing, pairs, uniform_square, unit};
use harness::random::Random;
use harness::statistics::{FAMILY_ALPHA, Moments, chi_square_test, sidak, z_test};
use texray::interface::RANDOM_TABLE_TEXELS;
use texray::scene::Filter;
use texray::settings::Sampler;
use texray::statistics::distributions::chi_square_upper;
use texray::texels::Texel;
use texray::texels::random::random_table_texels;

/// More verdicts than this file gives.
const TESTS: usize = 1000;

#[test]
fn no_float_reaches_one() {
    let mut random = Random::new(1, 0);
    let mut words: Vec<u32> = (0..1 << 16).map(|_| (random.next() * 4_294_967_296.0) as u32).collect();
    // The words that a division by 2^32 - 1 or 2^32 rounds to 1, and both ends.
    words.extend((0..4096).map(|i| u32::MAX - i));
    words.extend([0, 1, 255, 256, 0x7fff_ffff, 0x8000_0000, 0xffff_feff, 0xffff_ff00]);
    let input: Vec<Texel> = words.as_chunks::<4>().0.to_vec();
    let answers = call(&nothing(), Sampler::Independent, Filter::Box, UNIT_FLOAT, &input);
    for (words, floats) in input.iter().zip(answers) {
        for (word, bits) in words.iter().zip(floats) {
            let float = f32::from_bits(bits);
            assert!((0.0..1.0).contains(&float) && f64::from(float) == unit(*word), "{word:08x} becomes {float}");
        }
    }
}

#[test]
fn sobol_pairs_are_nets() {
    const MOST: u32 = 16 << 6;
    for (pixel, replicate, pair) in [([0, 0], 0, 0), ([3, 5], 1, 1), ([639, 479], 3, 2), ([65_535, 65_535], 2, 17)] {
        let points = pairs(Sampler::Sobol, replicate, (0..4 * MOST).map(|i| (pixel, i, pair)));
        for samples in (0..=6).map(|k| 16usize << k) {
            // The first of them, and a later aligned stretch.
            for stretch in [&points[..samples], &points[3 * samples..4 * samples]] {
                // A (0, m, 2)-net: one point in each cell of every grid of that many cells, a column or row each included.
                for columns in (0..=samples.ilog2()).map(|bits| 1usize << bits) {
                    let rows = samples / columns;
                    let mut seen = vec![0; samples];
                    for point in stretch {
                        let [column, row] = [point[0] as usize * columns, point[1] as usize * rows].map(|v| v >> 32);
                        seen[column * rows + row] += 1;
                    }
                    assert!(seen.iter().all(|&n| n == 1), "{pixel:?} {replicate} {pair}: {columns} x {rows}");
                }
            }
        }
    }
    // Control: independent numbers are not stratified.
    let points = pairs(Sampler::Independent, 0, (0..16).map(|i| ([0, 0], i, 0)));
    let mut seen = [0; 16];
    points.iter().for_each(|point| seen[(point[0] >> 28) as usize] += 1);
    assert!(seen.iter().any(|&n| n != 1));
}

#[test]
fn pixels_replicates_and_pairs_have_numbers_of_their_own() {
    for sampler in [Sampler::Sobol, Sampler::Independent, Sampler::Table] {
        let of = |pixel, replicate, pair| pairs(sampler, replicate, (0..256).map(|i| (pixel, i, pair)));
        let streams = [
            of([7, 9], 0, 0),
            of([8, 9], 0, 0),
            of([7, 10], 0, 0),
            of([9, 7], 0, 0),
            of([7, 9], 1, 0),
            of([7, 9], 0, 1),
        ];
        for (i, a) in streams.iter().enumerate() {
            for b in &streams[..i] {
                let equal = a.iter().flatten().zip(b.iter().flatten()).filter(|(a, b)| a == b).count();
                // 512 pairs of words: one equal pair has a chance of 1.2e-7.
                assert_eq!(equal, 0, "{sampler:?}: two streams share numbers");
            }
        }
        assert_eq!(of([7, 9], 0, 0), streams[0], "{sampler:?}: the same numbers again");
    }
}

/// Draws of one sample across `side` x `side` pixels.
fn across(sampler: Sampler, side: u32, index: u32, pair: u32) -> Vec<[u32; 2]> {
    pairs(sampler, 0, (0..side * side).map(|i| ([i % side, i / side], index, pair)))
}

#[test]
fn numbers_across_pixels_are_uniform_and_independent() {
    // 2^18 pixels. The table has 2^18 entries, drawn with replacement: with 2^12 pixels that inflates variances by 1.6 %.
    for (sampler, side, cells) in [(Sampler::Sobol, 512, 64), (Sampler::Independent, 512, 64), (Sampler::Table, 64, 16)]
    {
        let draws = [(0, 0), (1, 0), (0, 1), (0, 2)].map(|(index, pair)| across(sampler, side, index, pair));
        let [first, next_sample, next_pair, second_pair] = &draws;
        for (dimension, words) in (0..2).map(|d| (d, first.iter().map(move |words| words[d]))) {
            let what = |what: &str| format!("{sampler:?}, dimension {dimension}: {what}");
            let numbers = || words.clone().map(unit);
            let count = f64::from(side * side);
            let moments = Moments::of(numbers());
            z_test(moments.mean, 1.0 / 12.0 / count, 0.5).assert(&what("mean"), TESTS);
            // Variance of u² is 1/5 - 1/9.
            let squares = Moments::of(numbers().map(|u| u * u));
            z_test(squares.mean, 4.0 / 45.0 / count, 1.0 / 3.0).assert(&what("mean square"), TESTS);
            // The bytes that floats are made of. (The lowest one of pcg4d's first lane is not uniform.)
            for byte in 1..4 {
                let mut counts = [0.0; 256];
                words.clone().for_each(|word| counts[(word >> (8 * byte) & 255) as usize] += 1.0);
                chi_square_test(&counts, &[count / 256.0; 256]).assert(&what(&format!("byte {byte}")), TESTS);
            }
            let right = (0..first.len()).filter(|i| (i + 1) % side as usize != 0).map(|i| (i, i + 1));
            let below = (0..first.len() - side as usize).map(|i| (i, i + side as usize));
            let at = |i: usize| unit(first[i][dimension]);
            correlation(right.map(|(a, b)| (at(a), at(b)))).assert(&what("pixel to the right"), TESTS);
            correlation(below.map(|(a, b)| (at(a), at(b)))).assert(&what("pixel below"), TESTS);
            let mut others = vec![("the next pair", next_pair), ("the pair after that", second_pair)];
            if sampler != Sampler::Sobol {
                others.push(("the next sample", next_sample));
            }
            for (name, other) in others {
                let pairs = || (0..first.len()).map(|i| (at(i), unit(other[i][dimension])));
                correlation(pairs()).assert(&what(name), TESTS);
                uniform_square(pairs(), cells).assert(&what(&format!("square with {name}")), TESTS);
            }
        }
        let both = || first.iter().map(|&[a, b]| (unit(a), unit(b)));
        correlation(both()).assert(&format!("{sampler:?}, within a pair"), TESTS);
        uniform_square(both(), cells).assert(&format!("{sampler:?}, square of a pair"), TESTS);
    }
    // Control: neighbouring Sobol' samples of one pixel are far from independent, and found so.
    let (first, second) = (across(Sampler::Sobol, 64, 0, 0), across(Sampler::Sobol, 64, 1, 0));
    assert!(correlation(first.iter().zip(&second).map(|(a, b)| (unit(a[0]), unit(b[0])))).p < 1e-9);
}

#[test]
fn independent_samples_of_one_pixel_are_uniform_and_independent() {
    let words = pairs(Sampler::Independent, 0, (0..1 << 18).map(|index| ([5, 3], index, 0)));
    for dimension in 0..2 {
        let at = |i: usize| unit(words[i][dimension]);
        for lag in [1, 2, 16, 64] {
            let pairs = || (0..words.len() - lag).map(|i| (at(i), at(i + lag)));
            correlation(pairs()).assert(&format!("dimension {dimension}, {lag} samples on"), TESTS);
            // Every second pair, so that no number is in two of them.
            let apart = pairs().enumerate().filter(|(i, _)| i / lag % 2 == 0).map(|(_, pair)| pair);
            uniform_square(apart, 64).assert(&format!("dimension {dimension}, square, {lag} samples on"), TESTS);
        }
    }
}

/// Means over a picture of 64 x 64 pixels scatter as those of independent numbers do: the squares of 256 such means, in units of
/// their standard error, are chi-square. A sum over pixels finds what a test of neighbours cannot: weak correlations of many.
#[test]
fn means_over_a_picture_scatter_as_they_should() {
    const SIDE: u32 = 64;
    for sampler in [Sampler::Sobol, Sampler::Independent] {
        let mut squares = [0.0; 3];
        for replicate in 0..REPLICATES {
            let place = |i: u32| ([i % SIDE, i / SIDE % SIDE], 5, i / (SIDE * SIDE));
            let words = pairs(sampler, replicate, (0..64 * SIDE * SIDE).map(place));
            for picture in words.chunks_exact((SIDE * SIDE) as usize) {
                let mut sums = [0.0; 3];
                for words in picture {
                    let [a, b] = words.map(|word| (unit(word) - 0.5) * 12f64.sqrt());
                    sums.iter_mut().zip([a, b, a * b]).for_each(|(sum, value)| *sum += value);
                }
                squares.iter_mut().zip(sums).for_each(|(square, sum)| *square += sum * sum / f64::from(SIDE * SIDE));
            }
        }
        for (what, square) in ["first", "second", "product"].iter().zip(squares) {
            // Both tails: too even is as wrong as too uneven.
            let upper = chi_square_upper(square, 256.0);
            println!("{sampler:?}, {what}: {square:.1} for 256 ± 22.6");
            assert!(upper.min(1.0 - upper) * 2.0 > sidak(FAMILY_ALPHA, TESTS), "{sampler:?}, {what}: {square} for 256");
        }
    }
}

#[test]
fn the_hosts_table_is_uniform() {
    let table = random_table_texels(0);
    for dimension in 0..4 {
        for byte in 0..4 {
            let mut counts = [0.0; 256];
            table.iter().for_each(|texel| counts[(texel[dimension] >> (8 * byte) & 255) as usize] += 1.0);
            let expected = f64::from(RANDOM_TABLE_TEXELS) / 256.0;
            chi_square_test(&counts, &[expected; 256]).assert(&format!("dimension {dimension}, byte {byte}"), TESTS);
        }
        let pairs = table.as_chunks::<2>().0.iter().map(|[a, b]| (unit(a[dimension]), unit(b[dimension])));
        uniform_square(pairs, 64).assert(&format!("dimension {dimension}, neighbours"), TESTS);
    }
}
