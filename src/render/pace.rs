//! How much work goes into one submit and one run, by measured time.
//!
//! A submit should end well before any watchdog (2 s on common systems) and soon enough that a stop is answered; a run should
//! end soon enough that the last whole picture is never old. Nothing here can change a picture.

use std::time::Duration;

use crate::interface::{BLOCK_SAMPLES, CPU_STEP_BUDGET, MAX_STEP_BUDGET, MIN_STEP_BUDGET};

/// Rows and step budget of a submit.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Rows of the tile that a submit works on.
    pub rows: u32,
    /// Steps that an invocation may take in a submit.
    pub budget: u32,
    target: Duration,
    adapts_budget: bool,
}

impl Pace {
    /// The pace for a device, cautious at first: nothing is known of its speed. A CPU has no watchdog and loses time by
    /// leaving paths unfinished, so there rows alone follow the clock; a GPU wants all its lanes filled, so there rows grow
    /// to the tile's height first, then the budget. `fixed_budget` pins the budget, for tests.
    pub fn new(is_cpu: bool, fixed_budget: Option<u32>) -> Pace {
        Pace {
            rows: if is_cpu { 16 } else { 32 },
            budget: fixed_budget.unwrap_or(if is_cpu { CPU_STEP_BUDGET } else { MIN_STEP_BUDGET }),
            target: Duration::from_millis(if is_cpu { 250 } else { 50 }),
            adapts_budget: !is_cpu && fixed_budget.is_none(),
        }
    }

    /// Takes note that a slice of `rows`, in a tile of `height`, took `elapsed` in its first submit.
    pub fn note(&mut self, rows: u32, height: u32, elapsed: Duration) {
        let ratio = elapsed.as_secs_f64() / self.target.as_secs_f64();
        if ratio > 1.5 {
            match self.adapts_budget && self.budget > MIN_STEP_BUDGET {
                true => self.budget = (self.budget / 2).max(MIN_STEP_BUDGET),
                false => self.rows = (rows / 2).max(1),
            }
        } else if ratio < 0.6 {
            match self.adapts_budget && self.rows >= height {
                true => self.budget = (self.budget * 2).min(MAX_STEP_BUDGET),
                false => self.rows = self.rows.saturating_mul(2),
            }
        }
    }
}

/// Lengths of runs: powers of two that never cross a block's end, doubling while a run stays short.
#[derive(Clone, Copy, Debug)]
pub struct RunLength {
    limit: u32,
    fixed: bool,
}

/// A run should not take longer than this, so that the last whole picture is never older. Longer runs are faster: lanes that
/// finish early wait for their neighbours at the end of each (docs/performance.md).
const RUN_TARGET: Duration = Duration::from_secs(10);

impl RunLength {
    /// Starts at one sample; `fixed` pins the length, for tests.
    pub fn new(fixed: Option<u32>) -> RunLength {
        RunLength { limit: fixed.unwrap_or(1).clamp(1, BLOCK_SAMPLES), fixed: fixed.is_some() }
    }

    /// Samples of the run that begins at sample `first`, of `spp`.
    pub fn next(&self, first: u32, spp: u32) -> u32 {
        let in_block = first % BLOCK_SAMPLES;
        let aligned = match (self.fixed, in_block) {
            (true, _) => BLOCK_SAMPLES - in_block,
            (false, 0) => BLOCK_SAMPLES,
            (false, place) => 1 << place.trailing_zeros(),
        };
        aligned.min(self.limit).min(spp - first)
    }

    /// Takes note that a run of `samples` took `elapsed`.
    pub fn note(&mut self, samples: u32, elapsed: Duration) {
        if self.fixed {
            return;
        }
        if elapsed > RUN_TARGET {
            self.limit = (samples / 2).max(1);
        } else if elapsed * 2 < RUN_TARGET {
            self.limit = (self.limit.max(samples) * 2).min(BLOCK_SAMPLES);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_never_cross_a_block_and_end_at_spp() {
        for fixed in [None, Some(1), Some(3), Some(16)] {
            for spp in [1, 2, 15, 16, 17, 100] {
                let mut length = RunLength::new(fixed);
                let mut first = 0;
                while first < spp {
                    let samples = length.next(first, spp);
                    assert!(samples >= 1 && first % BLOCK_SAMPLES + samples <= BLOCK_SAMPLES && first + samples <= spp);
                    first += samples;
                    length.note(samples, Duration::from_millis(10));
                }
            }
        }
    }

    #[test]
    fn submits_follow_the_clock() {
        let mut pace = Pace::new(false, None);
        for _ in 0..20 {
            pace.note(pace.rows.min(100), 100, Duration::from_millis(1));
        }
        assert!(pace.rows >= 100 && pace.budget == MAX_STEP_BUDGET);
        for _ in 0..20 {
            pace.note(100, 100, Duration::from_secs(1));
        }
        assert_eq!((pace.budget, pace.rows), (MIN_STEP_BUDGET, 50));
    }
}
