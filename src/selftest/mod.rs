//! The self-test: every hard case of path tracing in f32 as a test with an expected value, run on the user's own device.
//!
//! Comes in: a device. Goes out: a [`CaseReport`] a case: what was expected, what came, and how far apart they may be. It
//! stands above all stages and uses them as a render does: the same shaders, the same records, the same frame loop. What
//! the cases are made of (meshes, rays, scenes, probes, statistics) is public, as the test programs use it too.
//!
//! The catalogue has 80 cases in eight groups, one file a group in `cases/`. docs/numerics.md explains each.

pub mod bench;
pub mod calls;
pub mod case;
pub mod cases;
pub mod directions;
pub mod draws;
pub mod faults;
pub mod finding;
pub mod form_factors;
pub mod furnaces;
pub mod light_trees;
pub mod lobes;
pub mod meshes;
pub mod microfacets;
pub mod pictures;
pub mod probe;
pub mod random;
pub mod rays;
pub mod roulette;
pub mod scattering;
pub mod scenes;
pub mod shadow_rays;
pub mod startup;
pub mod statistics;
pub mod streams;
pub mod tracing;

use std::time::Instant;

pub use bench::{Bench, Tier};
pub use case::{Case, Check, Group};
pub use cases::GROUPS;
pub use finding::Finding;

/// What a case came to.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It ran: everything that was looked at.
    Ran(Vec<Finding>),
    /// A test program shows it: this one.
    ShownBy(&'static str),
    /// Nothing to show before this is built.
    Awaits(&'static str),
    /// It could not be run: the error.
    Failed(String),
}

impl Outcome {
    /// Whether nothing is wrong.
    pub fn passes(&self) -> bool {
        match self {
            Outcome::Ran(findings) => !findings.is_empty() && findings.iter().all(|finding| finding.passes),
            Outcome::ShownBy(_) | Outcome::Awaits(_) => true,
            Outcome::Failed(_) => false,
        }
    }
}

/// A case with its outcome.
#[derive(Clone, Debug)]
pub struct CaseReport {
    /// The case.
    pub case: &'static Case,
    /// What it came to.
    pub outcome: Outcome,
    /// How long it took, in seconds.
    pub seconds: f64,
}

/// Runs one case. An error of the library is an outcome, so that the others still run.
pub fn run_case(bench: &Bench, case: &'static Case) -> CaseReport {
    let started = Instant::now();
    let outcome = match case.check {
        Check::Run(check) => match check(bench) {
            Ok(findings) => Outcome::Ran(findings),
            Err(error) => Outcome::Failed(error.to_string()),
        },
        Check::Tests(program) => Outcome::ShownBy(program),
        Check::Awaits(effect) => Outcome::Awaits(effect),
    };
    CaseReport { case, outcome, seconds: started.elapsed().as_secs_f64() }
}

/// The case of this number, 1 to 80.
pub fn case(number: u8) -> Option<&'static Case> {
    GROUPS.iter().flat_map(|group| group.cases).find(|case| case.number == number)
}
