//! Tests of hypotheses (z, t, Welch, chi-square, Kolmogorov-Smirnov), and the false alarms that a suite of them may
//! raise.
//!
//! Comes in: means with variances, samples, counts. Goes out: a [`Verdict`]. Assumes independent samples: those of one
//! Sobol' sequence are not, use replicates or `--sampler independent`.

use super::distributions::{chi_square_upper, kolmogorov_upper, normal_critical, normal_two_sided, student_two_sided};
use super::moments::Moments;

/// Chance that a family of tests raises a false alarm.
pub const FAMILY_ALPHA: f64 = 1e-6;
/// Share of the expected value that f32 arithmetic may move a radiance by, along a path of some tens of operations
/// of relative error 2^-24 each and with roundings of one sign: 300 of them.
pub const ROUNDING: f64 = 2e-5;

/// Chance of a false alarm that each of `tests` independent tests may have for `family` to hold for all (Šidák).
pub fn sidak(family: f64, tests: usize) -> f64 {
    -((-family).ln_1p() / tests as f64).exp_m1()
}

/// Two-sided critical z of one of `tests` tests at [`FAMILY_ALPHA`].
pub fn critical_z(tests: usize) -> f64 {
    normal_critical(sidak(FAMILY_ALPHA, tests))
}

/// A statistic, the probability of one at least as extreme, and where it stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// z, t, chi-square or Kolmogorov's D √n.
    pub statistic: f64,
    /// Probability of a statistic at least as extreme where nothing is wrong.
    pub p: f64,
}

impl Verdict {
    /// Whether this is no false alarm for one of `tests` tests at [`FAMILY_ALPHA`].
    pub fn passes(&self, tests: usize) -> bool {
        self.p >= sidak(FAMILY_ALPHA, tests)
    }
}

/// z test: `mean`, whose variance is known well, against `expected`. What lies within [`ROUNDING`] is not held
/// against it.
pub fn z_test(mean: f64, variance_of_mean: f64, expected: f64) -> Verdict {
    // A maximum with a NaN is the other number: without this, not a number would pass.
    if !mean.is_finite() || !variance_of_mean.is_finite() {
        return Verdict { statistic: f64::NAN, p: 0.0 };
    }
    let excess = ((mean - expected).abs() - ROUNDING * expected.abs()).max(0.0);
    let z = if excess == 0.0 { 0.0 } else { excess / variance_of_mean.sqrt() };
    Verdict { statistic: z.copysign(mean - expected), p: if z.is_finite() { normal_two_sided(z) } else { 0.0 } }
}

/// t test: the mean of samples, few of them, against `expected` (normal samples; 32 replicate means are enough).
pub fn t_test(samples: &Moments, expected: f64) -> Verdict {
    let difference = samples.mean - expected;
    if difference == 0.0 {
        return Verdict { statistic: 0.0, p: 1.0 };
    }
    let t = difference / samples.variance_of_mean().sqrt();
    Verdict { statistic: t, p: if t.is_finite() { student_two_sided(t, samples.count - 1.0) } else { 0.0 } }
}

/// Welch's test of two means from few samples each, of unequal variances.
pub fn welch_test(a: &Moments, b: &Moments) -> Verdict {
    let (va, vb) = (a.variance_of_mean(), b.variance_of_mean());
    if a.mean == b.mean {
        return Verdict { statistic: 0.0, p: 1.0 };
    }
    let t = (a.mean - b.mean) / (va + vb).sqrt();
    let dof = (va + vb).powi(2) / (va * va / (a.count - 1.0) + vb * vb / (b.count - 1.0));
    Verdict { statistic: t, p: if t.is_finite() { student_two_sided(t, dof) } else { 0.0 } }
}

/// Chi-square test of counts against expected counts. Bins of fewer than 5 expected are pooled, in order, until they
/// hold 5; degrees of freedom are the pooled bins less one. A count where none is expected is certain to be wrong.
pub fn chi_square_test(observed: &[f64], expected: &[f64]) -> Verdict {
    assert_eq!(observed.len(), expected.len(), "as many observed bins as expected ones");
    let (mut statistic, mut bins, mut pool) = (0.0, 0.0, (0.0, 0.0));
    let mut close = |seen: f64, due: f64| {
        statistic += (seen - due) * (seen - due) / due;
        bins += 1.0;
    };
    for (&seen, &due) in observed.iter().zip(expected) {
        if due == 0.0 && seen > 0.0 {
            return Verdict { statistic: f64::INFINITY, p: 0.0 };
        }
        pool = (pool.0 + seen, pool.1 + due);
        if pool.1 >= 5.0 {
            close(pool.0, pool.1);
            pool = (0.0, 0.0);
        }
    }
    // What is left over at the end, fewer than 5, still has to fit.
    if pool.1 > 0.0 {
        close(pool.0, pool.1);
    }
    assert!(bins >= 2.0, "a chi-square test needs two bins of 5 expected or more");
    Verdict { statistic, p: chi_square_upper(statistic, bins - 1.0) }
}

/// Kolmogorov-Smirnov test that numbers are uniform in [0, 1], such as p-values of a sound test. Uses the limit
/// distribution with Stephens's correction (error of p below 1e-3 from 20 numbers on).
pub fn uniform_test(values: &[f64]) -> Verdict {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distance = |(i, &value): (usize, &f64)| (value - i as f64 / n).max((i as f64 + 1.0) / n - value);
    let largest = sorted.iter().enumerate().map(distance).fold(0.0, f64::max);
    let statistic = largest * (n.sqrt() + 0.12 + 0.11 / n.sqrt());
    Verdict { statistic, p: kolmogorov_upper(statistic) }
}
