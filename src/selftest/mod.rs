//! The self-test: every hard case of path tracing in f32 as a test with an expected value, run on the user's own device.
//!
//! Comes in: a device. Goes out: a [`CaseReport`] a case: what was expected, what came, and how far apart they may be. It
//! stands above all stages and uses them as a render does: the same shaders, the same records, the same frame loop.
//!
//! ```text
//! kit    what cases are made of, for the test programs and the studies too
//! cases  the catalogue: one file per group, and beside them the cases that fill a file of their own
//! case   a case and how it is tested
//! ```
//!
//! The catalogue has 80 cases in eight groups. docs/numerics.md explains each.

pub mod case;
pub mod cases;
pub mod kit;

use std::time::Instant;

pub use case::{Case, Check, Group};
pub use cases::GROUPS;
pub use kit::{TestBench, Tier};

use crate::statistics::Finding;

/// What a case came to.
#[derive(Clone, Debug, PartialEq)]
pub enum CaseOutcome {
    /// It ran: everything that was looked at.
    Ran(Vec<Finding>),
    /// A test program shows it: this one.
    ShownBy(&'static str),
    /// Nothing to show before this is built.
    Awaits(&'static str),
    /// It could not be run: the error.
    Failed(String),
}

impl CaseOutcome {
    /// Whether nothing is wrong.
    pub fn passes(&self) -> bool {
        match self {
            CaseOutcome::Ran(findings) => !findings.is_empty() && findings.iter().all(|finding| finding.passes),
            CaseOutcome::ShownBy(_) | CaseOutcome::Awaits(_) => true,
            CaseOutcome::Failed(_) => false,
        }
    }
}

/// A case with its outcome.
#[derive(Clone, Debug)]
pub struct CaseReport {
    /// The case.
    pub case: &'static Case,
    /// What it came to.
    pub outcome: CaseOutcome,
    /// How long it took, in seconds.
    pub seconds: f64,
}

/// Runs one case. An error of the library is an outcome, so that the others still run.
pub fn run_case(bench: &TestBench, case: &'static Case) -> CaseReport {
    let started = Instant::now();
    let outcome = match case.check {
        Check::Run(check) => match check(bench) {
            Ok(findings) => CaseOutcome::Ran(findings),
            Err(error) => CaseOutcome::Failed(error.to_string()),
        },
        Check::Tests(program) => CaseOutcome::ShownBy(program),
        Check::Awaits(effect) => CaseOutcome::Awaits(effect),
    };
    CaseReport { case, outcome, seconds: started.elapsed().as_secs_f64() }
}

/// The case of this number, 1 to 80.
pub fn case(number: u8) -> Option<&'static Case> {
    GROUPS.iter().flat_map(|group| group.cases).find(|case| case.number == number)
}
