//! What one look at a case found: expected, got, tolerance, verdict.
//!
//! A case has one finding for each thing that it looks at. Expected values are exact or derived; each tolerance says where
//! it comes from.

use std::fmt::Display;

use serde::Serialize;

use crate::statistics::{FAMILY_ALPHA, Moments, z_test};

/// Statistical verdicts that share the false-alarm rate of [`FAMILY_ALPHA`]: more than the catalogue holds.
pub const VERDICTS: usize = 1000;

/// One look.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What was looked at.
    pub what: String,
    /// What should have come.
    pub expected: String,
    /// What came.
    pub got: String,
    /// How far apart they may be, and why.
    pub tolerance: String,
    /// Whether they are no farther apart.
    pub passes: bool,
}

impl Finding {
    /// Two values that must be equal.
    pub fn exact<T: PartialEq + Display>(what: impl Into<String>, expected: T, got: T) -> Finding {
        Finding {
            passes: expected == got,
            what: what.into(),
            expected: expected.to_string(),
            got: got.to_string(),
            tolerance: "exact".into(),
        }
    }

    /// Something that must never happen in `trials` trials.
    pub fn never(what: impl Into<String>, events: u64, trials: u64) -> Finding {
        Finding {
            what: what.into(),
            expected: format!("0 of {trials}"),
            got: format!("{events} of {trials}"),
            tolerance: "exact".into(),
            // No trials show nothing.
            passes: events == 0 && trials > 0,
        }
    }

    /// A value within a relative distance of what is expected; `why` derives the distance.
    pub fn relative(what: impl Into<String>, expected: f64, got: f64, distance: f64, why: &str) -> Finding {
        Finding {
            passes: (got - expected).abs() <= distance * expected.abs(),
            what: what.into(),
            expected: number(expected),
            got: number(got),
            tolerance: format!("{distance:.1e} of it: {why}"),
        }
    }

    /// A value, such as the largest of many errors, that may not exceed a limit; `why` derives the limit.
    pub fn at_most(what: impl Into<String>, limit: f64, got: f64, why: &str) -> Finding {
        Finding {
            passes: got <= limit,
            what: what.into(),
            expected: format!("at most {}", number(limit)),
            got: number(got),
            tolerance: why.into(),
        }
    }

    /// A mean of samples (pixels, replicates) that have one expectation, judged by its z at one of [`VERDICTS`].
    pub fn mean(what: impl Into<String>, expected: f64, samples: &Moments) -> Finding {
        Finding::z(what, expected, samples.mean, samples.variance_of_mean())
    }

    /// A mean of known variance, judged by its z at one of [`VERDICTS`]; a difference of 2e-5 of it is rounding.
    pub fn z(what: impl Into<String>, expected: f64, mean: f64, variance_of_mean: f64) -> Finding {
        let verdict = z_test(mean, variance_of_mean, expected);
        let error = variance_of_mean.sqrt();
        Finding {
            passes: verdict.passes(VERDICTS),
            what: what.into(),
            expected: number(expected),
            got: format!("{} ± {error:.1e}", number(mean)),
            tolerance: format!("z {:.2} of 6.11 (false alarms: {FAMILY_ALPHA:e} a suite)", verdict.statistic),
        }
    }

    /// A condition that has no number.
    pub fn holds(
        what: impl Into<String>,
        expected: impl Into<String>,
        got: impl Into<String>,
        passes: bool,
    ) -> Finding {
        Finding { what: what.into(), expected: expected.into(), got: got.into(), tolerance: "exact".into(), passes }
    }
}

/// Nine digits, as short as they can be.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude != 0.0 && !(1e-3..1e6).contains(&magnitude) {
        return format!("{value:.4e}");
    }
    let text = format!("{value:.9}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn not_a_number_passes_nothing() {
        let nan = f64::NAN;
        assert!(!Finding::exact("", 1.0, nan).passes);
        assert!(!Finding::relative("", 1.0, nan, 1.0, "").passes);
        assert!(!Finding::at_most("", 1.0, nan, "").passes);
        assert!(!Finding::z("", 1.0, nan, 1.0).passes);
        assert!(!Finding::z("", 1.0, 2.0, nan).passes);
        assert!(!Finding::z("", 1.0, 2.0, 0.0).passes);
        assert!(!Finding::never("", 0, 0).passes);
    }
}
