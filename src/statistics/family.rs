//! The rate of false alarms of a suite, shared out among its tests.
//!
//! Comes in: how many tests there are. Goes out: the share of each, its critical z, and whether a [`Verdict`] passes.

use super::distributions::normal_critical;

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
