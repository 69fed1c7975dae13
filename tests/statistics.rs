//! The statistics that judge every picture, held against printed tables and against themselves: a sound test gives
//! uniform p-values, a broken picture is found.
//!
//! Reference values: Abramowitz and Stegun (1964), tables 26.1, 26.7, 26.8, 26.10, rounded there to the digits used
//! here, so that each tolerance is half a unit of the last digit.

mod harness;

use harness::Assert;
use harness::comparison::compare;
use harness::random::Random;
use harness::statistics::{
    Moments, chi_square_test, critical_z, fit_line, sidak, t_test, uniform_test, welch_test, z_test,
};
use harness::tracer::Estimate;
use texray::statistics::distributions::{
    beta_lower, chi_square_upper, gamma_upper, kolmogorov_upper, ln_gamma, normal_critical, normal_two_sided,
    student_critical, student_two_sided,
};

fn close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected} ± {tolerance}");
}

/// A standard normal number (Box and Muller 1958).
fn normal(random: &mut Random) -> f64 {
    (-2.0 * (1.0 - random.next()).ln()).sqrt() * (std::f64::consts::TAU * random.next()).cos()
}

#[test]
fn special_functions_have_their_closed_forms() {
    // 1e-12: the rounding of some tens of f64 operations, with room for ln and exp.
    let factorial: f64 = (1..=20).map(f64::from).product();
    close(ln_gamma(21.0) / factorial.ln(), 1.0, 1e-12);
    close(ln_gamma(0.5), std::f64::consts::PI.sqrt().ln(), 1e-12);
    for x in [0.01, 0.5, 1.0, 1.9, 2.1, 10.0, 30.0] {
        close(gamma_upper(1.0, x) / (-x).exp(), 1.0, 1e-12);
        close(gamma_upper(2.0, x) / ((1.0 + x) * (-x).exp()), 1.0, 1e-12);
    }
    for x in [0.0, 0.1, 0.5, 0.9, 1.0] {
        close(beta_lower(1.0, 1.0, x), x, 1e-12);
        close(beta_lower(2.0, 1.0, x), x * x, 1e-12);
        close(beta_lower(3.0, 4.0, x) + beta_lower(4.0, 3.0, 1.0 - x), 1.0, 1e-12);
    }
}

#[test]
fn what_is_not_defined_is_not_a_number() {
    let undefined = [
        gamma_upper(0.0, 1.0),
        gamma_upper(1.0, -1.0),
        gamma_upper(f64::NAN, 1.0),
        gamma_upper(1.0, f64::NAN),
        beta_lower(1.0, 1.0, 1.5),
        beta_lower(-1.0, 1.0, 0.5),
        beta_lower(1.0, f64::NAN, 0.5),
        normal_two_sided(f64::NAN),
        student_two_sided(1.0, 0.0),
        chi_square_upper(-1.0, 3.0),
        normal_critical(0.0),
        normal_critical(1.0),
        normal_critical(f64::NAN),
        student_critical(0.05, 0.0),
        student_critical(0.05, f64::NAN),
    ];
    for (i, value) in undefined.into_iter().enumerate() {
        assert!(value.is_nan(), "case {i} is {value}");
    }
    // A series that takes more terms than are allowed.
    assert!(gamma_upper(1e14, 1e14).is_nan());
}

#[test]
fn tail_probabilities_match_tables() {
    for (z, p) in [(1.959_963_985, 0.05), (2.575_829_304, 0.01), (3.290_526_731, 1e-3), (4.891_638_475, 1e-6)] {
        close(normal_two_sided(z) / p, 1.0, 1e-8);
        close(normal_critical(p), z, 1e-8);
    }
    for (statistic, dof, p) in [
        (3.841_458_821, 1.0, 0.05),
        (18.307_038_05, 10.0, 0.05),
        (29.588_298_45, 10.0, 0.001),
        (124.342_113_4, 100.0, 0.05),
    ] {
        close(chi_square_upper(statistic, dof) / p, 1.0, 1e-7);
    }
    for (t, dof, p) in [
        (12.706_204_74, 1.0, 0.05),
        (2.228_138_852, 10.0, 0.05),
        (2.039_513_446, 31.0, 0.05),
        (63.656_741_16, 1.0, 0.01),
    ] {
        close(student_two_sided(t, dof) / p, 1.0, 1e-7);
    }
    // Smirnov's table of the limit distribution, to five digits.
    for (x, p) in [(1.2238, 0.1), (1.3581, 0.05), (1.6276, 0.01)] {
        close(kolmogorov_upper(x) / p, 1.0, 1e-3);
    }
}

#[test]
fn critical_z_grows_with_the_number_of_tests() {
    for (tests, z) in [(1, 4.892), (10, 5.327), (100, 5.731), (1_000, 6.109), (12_288, 6.498)] {
        close(critical_z(tests), z, 5e-4);
    }
    // The chance of no alarm in 1,000 tests is that of the family.
    close((1.0 - sidak(0.01, 1_000)).powi(1_000), 0.99, 1e-10);
}

#[test]
fn sound_tests_give_uniform_p_values() {
    // 4 families of 1,000 p-values each, from a fixed seed: a false alarm would have shown when this was written.
    let mut random = Random::new(1, 0);
    let mut families: [Vec<f64>; 4] = Default::default();
    for _ in 0..1_000 {
        let samples = Moments::of((0..32).map(|_| 3.0 + normal(&mut random)));
        let others = Moments::of((0..8).map(|_| 3.0 + 5.0 * normal(&mut random)));
        families[0].push(z_test(normal(&mut random), 1.0, 0.0).p);
        families[1].push(t_test(&samples, 3.0).p);
        families[2].push(welch_test(&samples, &others).p);
        let mut counts = [0.0; 10];
        (0..1_000).for_each(|_| counts[(random.next() * 10.0) as usize] += 1.0);
        families[3].push(chi_square_test(&counts, &[100.0; 10]).p);
    }
    for (name, family) in ["z", "t", "Welch", "chi-square"].iter().zip(&families) {
        uniform_test(family).assert(name, families.len());
    }
    // Control: p-values of a test that understates its variance by a fifth are not uniform.
    let wrong: Vec<f64> = (0..1_000).map(|_| z_test(normal(&mut random), 0.8 * 0.8, 0.0).p).collect();
    assert!(uniform_test(&wrong).p < 1e-6);
}

#[test]
fn tests_find_what_is_wrong() {
    let mut random = Random::new(2, 0);
    // Off by 8 standard errors: missed with a probability of 1e-3 at z = 4.9.
    assert!(z_test(1.008, 1e-6, 1.0).p < 1e-6);
    let shifted = Moments::of((0..256).map(|_| 0.5 + normal(&mut random)));
    assert!(t_test(&shifted, 0.0).p < 1e-6);
    assert_eq!(chi_square_test(&[10.0, 10.0, 1.0], &[10.0, 10.0, 0.0]).p, 0.0);
    assert!(chi_square_test(&[200.0, 100.0], &[150.0, 150.0]).p < 1e-6);
    // Without any variance only rounding is forgiven.
    assert_eq!(z_test(1.000_01, 0.0, 1.0).p, 1.0);
    assert_eq!(z_test(1.000_03, 0.0, 1.0).p, 0.0);
}

#[test]
fn small_bins_are_pooled() {
    // Bins of 1 expected pool to 5 and 5: statistic (7-5)²/5 + (3-5)²/5 = 1.6 at one degree of freedom.
    let verdict = chi_square_test(&[3.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0], &[1.0; 10]);
    close(verdict.statistic, 1.6, 1e-12);
    close(verdict.p, chi_square_upper(1.6, 1.0), 0.0);
}

#[test]
fn moments_and_lines_are_exact_on_known_numbers() {
    let moments = Moments::of([1.0, 2.0, 3.0, 4.0]);
    close(moments.mean, 2.5, 0.0);
    close(moments.variance(), 5.0 / 3.0, 1e-15);
    close(Moments::of(std::iter::repeat_n(0.1, 1_000)).variance(), 0.0, 0.0);
    let line = fit_line(&[(0.0, 5.0), (1.0, 4.0), (2.0, 3.0)]);
    close(line.slope, -1.0, 1e-15);
    close(line.intercept, 5.0, 1e-15);
    // Residuals 1/6, -1/3, 1/6 about the slope 1/2: error √((1/6) / 1 / 2).
    let bent = fit_line(&[(0.0, 0.0), (1.0, 0.0), (2.0, 1.0)]);
    close(bent.slope, 0.5, 1e-15);
    close(bent.slope_error, (1.0f64 / 12.0).sqrt(), 1e-15);
}

#[test]
fn a_comparison_finds_the_tile_that_is_off() {
    let mut random = Random::new(3, 0);
    let mut picture = || Estimate {
        mean: (0..32 * 32).map(|_| [1.0 + 0.01 * normal(&mut random); 3]).collect(),
        variance_of_mean: vec![[1e-4; 3]; 32 * 32],
    };
    let (a, mut b) = (picture(), picture());
    let agreed = compare(&a, &b, 32, 8);
    assert_eq!(agreed.tiles.len(), 16 * 3);
    agreed.assert("two pictures of one expectation", 0.0);
    // 2 % more in the tile at (8, 16): 8 standard errors of 0.0141 / √64 and more.
    for (y, x) in (16..24).flat_map(|y| (8..16).map(move |x| (y, x))) {
        b.mean[y * 32 + x][1] += 0.02;
    }
    let worst = *compare(&a, &b, 32, 8).worst().expect("a tile");
    assert!((worst.x, worst.y, worst.channel) == (8, 16, 1) && worst.z > critical_z(48), "{worst:?}");
    // One pixel with most of the variance silences its tile.
    b.variance_of_mean[16 * 32 + 8] = [1.0; 3];
    let silenced = compare(&a, &b, 32, 8);
    assert_eq!(silenced.inconclusive().map(|tile| (tile.x, tile.y)).collect::<Vec<_>>(), [(8, 16); 3]);
}
