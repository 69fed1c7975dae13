//! What the test programs share: an independent path tracer, scenes built in code, statistics, and stored references.
//!
//! Each test program is a crate of its own that uses part of this, so what one of them leaves unused is no mistake.
#![allow(dead_code)]

pub mod comparison;
pub mod device;
pub mod draws;
pub mod golden;
pub mod obj;
#[cfg(target_os = "linux")]
pub mod program;
pub mod sketch;
pub mod tracer;

#[allow(unused_imports)]
pub use texray::selftest::kit::{meshes, probe, rays, scenes};
pub use texray::statistics;
pub use texray::statistics::random;

use statistics::{FAMILY_ALPHA, Verdict, sidak};

/// A verdict that must pass.
pub trait Assert {
    /// Panics, naming `what`, where the verdict is an alarm for one of `tests` tests at [`FAMILY_ALPHA`].
    fn assert(&self, what: &str, tests: usize);
}

impl Assert for Verdict {
    fn assert(&self, what: &str, tests: usize) {
        let alpha = sidak(FAMILY_ALPHA, tests);
        assert!(self.passes(tests), "{what}: statistic {:.3}, p {:.3e} below {alpha:.3e}", self.statistic, self.p);
    }
}
