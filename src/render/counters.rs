//! The kernel's counters: what the dispatches of a run have counted.
//!
//! Comes in: the counters of a dispatch as they came back. Goes out: their sums, by name.

use crate::interface::{
    CAUSE_NAMES, COUNTER_INVALID, COUNTER_MAX_STEPS, COUNTER_PATHS, COUNTER_STACK_OVERFLOW, COUNTER_UNFINISHED,
    COUNTERS, INVALID_KIND_NAMES, INVALID_KINDS,
};
use crate::{Error, Result};

/// Bytes of the counters.
pub(super) const COUNTER_BYTES: u64 = 4 * COUNTERS as u64;

/// Sums of counters over the dispatches of a run.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts([u64; COUNTERS as usize]);

impl Counts {
    /// Adds the counters of a dispatch with this step budget; how many pixels it left unfinished.
    pub(super) fn add(&mut self, counters: [u32; COUNTERS as usize], budget: u32) -> Result<u32> {
        let steps = counters[COUNTER_MAX_STEPS as usize];
        if steps > budget {
            return Err(Error::Internal(format!("an invocation took {steps} steps of a budget of {budget}")));
        }
        if counters[COUNTER_STACK_OVERFLOW as usize] > 0 {
            return Err(Error::Internal("the traversal stack is too small for the tree".into()));
        }
        for (sum, count) in self.0.iter_mut().zip(counters) {
            *sum += u64::from(count);
        }
        Ok(counters[COUNTER_UNFINISHED as usize])
    }

    /// The sum of a counter, one of `interface::COUNTER_*`.
    pub(super) fn of(&self, counter: u32) -> u64 {
        self.0[counter as usize]
    }

    /// Paths that have ended.
    pub(super) fn paths(&self) -> u64 {
        self.of(COUNTER_PATHS)
    }

    /// Invalid samples by kind.
    pub(super) fn invalid_kinds(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        (COUNTER_INVALID..).zip(INVALID_KIND_NAMES).map(|(counter, name)| (name, self.of(counter)))
    }

    /// Invalid samples by cause.
    pub(super) fn causes(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        (COUNTER_INVALID + INVALID_KINDS..).zip(CAUSE_NAMES).map(|(counter, name)| (name, self.of(counter)))
    }
}
