//! Statistical tests with a stated rate of false alarms.
//!
//! Comes in: samples, means with variances, counts. Goes out: a statistic with its probability, or a [`Verdict`]. It
//! stands beneath all stages: whoever judges numbers uses it, film and comparison, self-test, study and the test
//! programs. Assumes independent samples: those of one Sobol' sequence are not, use replicates or `--sampler
//! independent`.
//!
//! A suite is judged at [`FAMILY_ALPHA`]: one false alarm in a million runs. A test of `m` numbers gives each of them
//! the share of Šidák, so that the chance of any false alarm among them is the family's. Two-sided critical z:
//!
//! | m | 1 | 10 | 100 | 1,000 | 12,288 (64² pixels, 3 channels) |
//! |---|---|---|---|---|---|
//! | z | 4.892 | 5.327 | 5.731 | 6.109 | 6.498 |
//!
//! Relative bias that is found with probability 0.9 at critical z from n samples of coefficient of variation cv:
//! (z + 1.28) cv / √n.

pub mod distributions;
pub mod finding;
pub mod hypothesis;
pub mod line;
pub mod moments;
pub mod random;

pub use finding::Finding;
pub use hypothesis::{
    FAMILY_ALPHA, ROUNDING, Verdict, chi_square_test, critical_z, sidak, t_test, uniform_test, welch_test, z_test,
};
pub use line::{Line, fit_line};
pub use moments::{Moments, Worst};
