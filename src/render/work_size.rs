//! How much work goes into one submit and one run, by measured time.
//!
//! A submit should end well before any watchdog (2 s on common systems) and soon enough that a stop is answered; a run should
//! end soon enough that the last whole picture is never old. Nothing here can change a picture.

use std::time::Duration;

use crate::gpu::{DeviceInfo, DeviceKind};
use crate::interface::{BLOCK_SAMPLES, BUDGET_LANES, CPU_STEP_BUDGET, MAX_STEP_BUDGET, MIN_STEP_BUDGET};

/// Rows and step budget of a submit.
#[derive(Clone, Copy, Debug)]
pub struct SubmitSize {
    /// Rows of the tile that a submit works on.
    pub rows: u32,
    /// Pixels that a submit works on where a list has them.
    pub listed: u32,
    /// Steps that an invocation may take in a submit.
    pub budget: u32,
    target: Duration,
    adapts_budget: bool,
    samples: u32,
}

impl SubmitSize {
    /// The size for a device, cautious at first: nothing is known of its speed. A CPU has no watchdog and loses time by
    /// leaving paths unfinished, so there rows alone follow the clock; a GPU wants all its lanes filled, so there rows grow
    /// to the tile's height first, then the budget. `cpu_lanes` are those of a CPU's vectors, `None` for other devices;
    /// `fixed_budget` pins the budget, for tests, as far as the driver's limit on loops allows.
    pub fn new(cpu_lanes: Option<u32>, fixed_budget: Option<u32>) -> SubmitSize {
        let is_cpu = cpu_lanes.is_some();
        let budget = match (cpu_lanes, fixed_budget) {
            (Some(lanes), None) => a_lane(CPU_STEP_BUDGET, lanes),
            (Some(lanes), Some(fixed)) => fixed.min(a_lane(MAX_STEP_BUDGET, lanes)),
            (None, fixed) => fixed.unwrap_or(MIN_STEP_BUDGET),
        };
        let budget = budget.max(1);
        SubmitSize {
            rows: if is_cpu { 16 } else { 32 },
            listed: if is_cpu { 1 << 13 } else { 1 << 16 },
            budget,
            target: Duration::from_millis(if is_cpu { 250 } else { 50 }),
            adapts_budget: !is_cpu && fixed_budget.is_none(),
            samples: 1,
        }
    }

    /// Prepares for a run of `samples` samples: where a submit does all of its rows' samples, fewer rows take as long.
    pub fn begin_run(&mut self, samples: u32) {
        if !self.adapts_budget {
            let scaled = |size: u32| {
                (u64::from(size) * u64::from(self.samples) / u64::from(samples.max(1))).clamp(1, 1 << 30) as u32
            };
            (self.rows, self.listed) = (scaled(self.rows), scaled(self.listed));
        }
        self.samples = samples;
    }

    /// Takes note that a submit of `pixels` listed pixels took `elapsed`.
    pub fn note_listed(&mut self, pixels: u32, elapsed: Duration) {
        let ratio = elapsed.as_secs_f64() / self.target.as_secs_f64();
        if ratio > 1.5 {
            self.listed = (pixels / 2).max(1);
        } else if ratio < 0.6 && pixels > self.listed / 2 {
            self.listed = self.listed.saturating_mul(2);
        }
    }

    /// Takes note that a submit of `rows`, in a tile of `height`, took `elapsed`.
    pub fn note(&mut self, rows: u32, height: u32, elapsed: Duration) {
        let ratio = elapsed.as_secs_f64() / self.target.as_secs_f64();
        if ratio > 1.5 {
            match self.adapts_budget && self.budget > MIN_STEP_BUDGET {
                true => self.budget = (self.budget / 2).max(MIN_STEP_BUDGET),
                false => self.rows = (rows / 2).max(1),
            }
        } else if ratio < 0.6 {
            match self.adapts_budget && self.rows >= height {
                true => self.budget = self.budget.saturating_mul(2).min(MAX_STEP_BUDGET),
                false => self.rows = self.rows.saturating_mul(2),
            }
        }
    }
}

/// Lanes of a CPU device's vectors; `None` for other devices, whose loops have no limit.
pub fn cpu_lanes(device: &DeviceInfo) -> Option<u32> {
    (device.kind == DeviceKind::Cpu).then_some(device.subgroup_size)
}

/// The most steps that an invocation may take in a dispatch on a device.
pub fn max_step_budget(device: &DeviceInfo) -> u32 {
    cpu_lanes(device).map_or(MAX_STEP_BUDGET, |lanes| a_lane(MAX_STEP_BUDGET, lanes))
}

/// What is left of a step budget for each lane of a vector with more than [`BUDGET_LANES`].
fn a_lane(budget: u32, lanes: u32) -> u32 {
    (budget * BUDGET_LANES / lanes.max(BUDGET_LANES)).max(MIN_STEP_BUDGET)
}

/// Lengths of runs, which never cross a block's end: one sample first, for a picture soon, then as long as a run may take.
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

    /// Samples of the run that begins at sample `first`, of `spp`: what is left of the block, in equal parts where it takes
    /// more than one run; none where `first` is past the last sample.
    pub fn next(&self, first: u32, spp: u32) -> u32 {
        let left = (BLOCK_SAMPLES - first % BLOCK_SAMPLES).min(spp.saturating_sub(first));
        let runs = if self.fixed { 1 } else { left.div_ceil(self.limit) };
        left.div_ceil(runs.max(1)).min(self.limit)
    }

    /// Takes note that a run of `samples` took `elapsed`.
    pub fn note(&mut self, samples: u32, elapsed: Duration) {
        if !self.fixed {
            let affordable = RUN_TARGET.as_secs_f64() * f64::from(samples) / elapsed.as_secs_f64().max(1e-9);
            self.limit = affordable.clamp(1.0, f64::from(BLOCK_SAMPLES)) as u32;
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
    fn runs_take_as_long_as_they_may() {
        let lengths = |spp: u32, sample_seconds: f64| {
            let mut length = RunLength::new(None);
            let (mut first, mut lengths) = (0, Vec::new());
            while first < spp {
                let samples = length.next(first, spp);
                lengths.push(samples);
                first += samples;
                length.note(samples, Duration::from_secs_f64(sample_seconds * f64::from(samples)));
            }
            lengths
        };
        assert_eq!(lengths(40, 0.1), [1, 15, 16, 8]);
        assert_eq!(lengths(33, 0.9), [1, 8, 7, 8, 8, 1]);
        assert_eq!(lengths(3, 60.0), [1, 1, 1]);
        assert_eq!(lengths(20, 0.0), [1, 15, 4]);
    }

    #[test]
    fn a_submit_of_longer_runs_has_fewer_rows() {
        let mut size = SubmitSize::new(Some(8), None);
        size.rows = 320;
        size.begin_run(16);
        assert_eq!((size.rows, size.listed), (20, 512));
        size.begin_run(1);
        assert_eq!(size.rows, 320);
        let mut size = SubmitSize::new(None, None);
        size.begin_run(16);
        assert_eq!(size.rows, 32);
    }

    #[test]
    fn the_lanes_of_a_cpus_vector_share_its_iterations() {
        let budget = |lanes, fixed| SubmitSize::new(lanes, fixed).budget;
        assert_eq!([4, 8, 16, 32].map(|lanes| budget(Some(lanes), None)), [4000, 4000, 2000, 1000]);
        assert_eq!([8, 16].map(|lanes| budget(Some(lanes), Some(8191))), [8191, 4095]);
        assert_eq!((budget(Some(16), Some(64)), budget(Some(1 << 16), None)), (64, MIN_STEP_BUDGET));
        assert_eq!((budget(None, Some(8191)), budget(None, None)), (8191, MIN_STEP_BUDGET));
    }

    #[test]
    fn submits_follow_the_clock() {
        let mut size = SubmitSize::new(None, None);
        for _ in 0..20 {
            size.note(size.rows.min(100), 100, Duration::from_millis(1));
        }
        assert!(size.rows >= 100 && size.budget == MAX_STEP_BUDGET);
        for _ in 0..20 {
            size.note(100, 100, Duration::from_secs(1));
        }
        assert_eq!((size.budget, size.rows), (MIN_STEP_BUDGET, 50));
        size.note_listed(1000, Duration::from_millis(1)); // The list's end: no reason to take more.
        assert_eq!(size.listed, 1 << 16);
        size.note_listed(1 << 16, Duration::from_millis(1));
        assert_eq!(size.listed, 1 << 17);
        size.note_listed(1000, Duration::from_secs(1));
        assert_eq!(size.listed, 500);
    }
}
