//! Stage 5: the frame loop.
//!
//! A run takes every pixel of the region through the same samples: tile by tile, and in a tile pass by pass (pass.rs),
//! until no path is left unfinished. A tile's open sums come back in a copy that overlaps the next tile's first
//! dispatch; when the run is whole they enter the film, as a closed block or as the open one. So every run boundary is a valid
//! place to stop, and what a pixel computes depends on none of these sizes.

use std::sync::Arc;
use std::time::Instant;

use crate::error::{Error, Result};
use crate::film::{Film, replicate_of_block};
use crate::gpu::{
    Barrier, BindGroup, Buffer, ComputePipeline, Context, InFlight, Ledger, Readback, Recorder, Uploader,
};
use crate::interface::*;
use crate::render::Rendered;
use crate::render::effects::Effects;
use crate::render::ending::EstimateClock;
use crate::render::kernel::{self, Dispatch};
use crate::render::pace::{Pace, RunLength};
use crate::render::pass::{Pass, Slice};
use crate::render::report::{Bytes, Observer, Progress, RenderReport, StopReason};
use crate::render::stop::{Forecast, Looks, StopRules};
use crate::render::tiles::{SUM_BYTES, Tile};
use crate::settings::{Sampler, Settings};

/// Bytes of the counters.
pub(super) const COUNTER_BYTES: u64 = 4 * COUNTERS as u64;

/// A scene on the device, ready to be rendered.
pub struct Renderer {
    pub(super) context: Context,
    pub(super) settings: Settings,
    pub(super) effects: Effects,
    /// Replicates of the film.
    pub(super) replicates: u32,
    pub(super) pipeline: Arc<ComputePipeline>,
    pub(super) bind_group: Arc<BindGroup>,
    pub(super) tiles: Vec<Tile>,
    pub(super) sums: Arc<Buffer>,
    pub(super) counters: Arc<Buffer>,
    /// Two places for a tile's sums to come back to: one is read while the other is written.
    pub(super) readbacks: [Readback; 2],
    pub(super) counter_readback: Readback,
    pub(super) pace: Pace,
    /// See [`Dispatch::leave_eighths`].
    pub(super) leave_eighths: u32,
    pub(super) slice_pixels: Option<u32>,
    pub(super) run_length: RunLength,
    pub(super) film: Film,
    /// What came back of the run so far, `[sum.rgb, count]` a pixel of the region.
    pub(super) run_sums: Vec<[u32; 4]>,
    /// The same of the last whole run: the open block of every pixel, if it is open.
    pub(super) open_sums: Vec<[u32; 4]>,
    /// Counters of the run so far.
    pub(super) run_counts: [u64; COUNTERS as usize],
    pub(super) ledger: Ledger,
    pub(super) report: RenderReport,
    pub(super) estimate: EstimateClock,
    pub(super) rules: StopRules,
    pub(super) looks: Looks,
    /// What the first look, and the last one, forecast of the target.
    pub(super) forecasts: Option<(Forecast, Forecast)>,
}

/// A copy of a tile's sums that is under way.
struct PendingTile {
    copy: InFlight,
    tile: Tile,
    slot: usize,
}

impl Renderer {
    /// Ends the render by these rules too.
    pub fn stop_by(mut self, rules: StopRules) -> Renderer {
        self.rules = rules;
        self
    }

    /// Renders until the samples are done, a rule is met or the observer stops it, after the first whole run at the earliest.
    pub fn render(mut self, observer: &mut dyn Observer) -> Result<Rendered> {
        self.rules.check()?;
        let start = Instant::now();
        let spp = self.settings.spp;
        let mut done = 0;
        while done < spp {
            let run_start = Instant::now();
            let Some(samples) = self.next_run(done) else {
                self.report.stop_reason = StopReason::TimeLimit;
                break;
            };
            if !self.run(done, samples, start, observer)? {
                self.report.stop_reason = self.why_given_up(observer);
                break;
            }
            self.commit(done, samples)?;
            done += samples;
            self.run_length.note(samples, run_start.elapsed());
            self.report.seconds_per_sample = run_start.elapsed().as_secs_f64() / f64::from(samples);
            self.estimate_error(start.elapsed());
            let met = self.look(done, start.elapsed());
            self.tell(done, start, observer);
            if met {
                self.report.stop_reason = StopReason::TargetError;
                break;
            }
            if done < spp && observer.stop_requested() {
                self.report.stop_reason = StopReason::Interrupted;
                break;
            }
        }
        self.last_look(done);
        self.report.spp = done;
        self.report.table_wraps = self.table_wraps(done);
        self.report.seconds.render = start.elapsed().as_secs_f64();
        self.report.seconds.estimate = self.estimate.cost().as_secs_f64();
        self.report.bytes = Bytes {
            uploaded: self.ledger.bytes_up(),
            read_back: self.ledger.bytes_down(),
            device: self.context.device_bytes_peak(),
        };
        Ok(Rendered { film: self.film, report: self.report, ledger: self.ledger, effects: self.effects })
    }

    /// One run over all tiles; false where it was given up. The first run ends where it is to be the first picture.
    fn run(&mut self, first: u32, samples: u32, start: Instant, observer: &mut dyn Observer) -> Result<bool> {
        let mut pending: Option<PendingTile> = None;
        self.pace.begin_run(samples);
        for index in 0..self.tiles.len() {
            let tile = self.tiles[index];
            if self.tiles.len() > 1 && !first.is_multiple_of(BLOCK_SAMPLES) {
                self.upload_open_sums(tile)?;
            }
            let last_tile = index + 1 == self.tiles.len();
            let mut next = Some(Pass::over(tile));
            while let Some(mut pass) = next {
                while let Some(slice) = pass.next_slice(self.slice_pixels(&pass, tile)) {
                    let dispatch = Dispatch {
                        tile,
                        slice,
                        fills: pass.fills(),
                        samples: [first, samples],
                        budget: self.pace.budget,
                        leave_eighths: pass.leave_eighths(self.leave_eighths),
                    };
                    let start_of_slice = Instant::now();
                    let frame = self.submit(&dispatch)?;
                    if let Some(tile) = pending.take() {
                        self.absorb(tile)?;
                    }
                    pass.note(self.finish(frame, dispatch.budget)?);
                    match slice {
                        Slice::Rows { count, .. } => self.pace.note(count, tile.height, start_of_slice.elapsed()),
                        Slice::Listed { count, .. } => self.pace.note_listed(count, start_of_slice.elapsed()),
                    }
                    self.tell(first, start, observer);
                    // What the run has already paid for in full is kept.
                    let whole = last_tile && pass.is_last();
                    if self.may_give_up(first) && !whole && self.is_given_up(observer) {
                        return Ok(false);
                    }
                }
                next = pass.next();
            }
            pending = Some(self.copy_sums(tile, index % 2)?);
        }
        if let Some(tile) = pending {
            self.absorb(tile)?;
        }
        Ok(true)
    }

    /// Pixels of the next slice of a pass. The counts of its dispatch fit their 32 bits.
    fn slice_pixels(&self, pass: &Pass, tile: Tile) -> u32 {
        let by_clock = if pass.is_listed() { self.pace.listed } else { self.pace.rows.saturating_mul(tile.width) };
        self.slice_pixels.unwrap_or(by_clock).min(u32::MAX / self.pace.budget.max(1))
    }

    /// Records and submits one dispatch, its counters cleared before and copied after.
    fn submit(&mut self, dispatch: &Dispatch) -> Result<InFlight> {
        let mut recorder = Recorder::new(&self.context, "frame")?;
        // The last frame's shader and copy have used the counters before they are cleared.
        recorder.barrier(Barrier::ComputeToTransfer)?;
        recorder.barrier(Barrier::TransferToTransfer)?;
        recorder.fill(&self.counters, 0, COUNTER_BYTES, 0)?;
        // The counters are cleared, the path states are touched (path_buffers.rs), and the copy of the last tile's sums has read
        // them, before this frame's shader writes.
        recorder.barrier(Barrier::TransferToCompute)?;
        // The last frame's shader has written the path states, lists and sums that this one reads.
        recorder.barrier(Barrier::ComputeToCompute)?;
        let push = kernel::push(dispatch, self.replicates);
        recorder.dispatch(&self.pipeline, &self.bind_group, &push.bytes(), dispatch.groups())?;
        let why = "unfinished paths and counts of a frame";
        self.counter_readback.copy_from(&mut recorder, &mut self.ledger, &self.counters, 0, 0, COUNTER_BYTES, why)?;
        recorder.submit()
    }

    /// Waits for a frame and adds up its counters; returns how many pixels are unfinished.
    fn finish(&mut self, frame: InFlight, budget: u32) -> Result<u32> {
        frame.wait()?;
        let mut counters = [0u32; COUNTERS as usize];
        bytemuck::cast_slice_mut(&mut counters).copy_from_slice(self.counter_readback.bytes()?);
        let counter = |index: u32| u64::from(counters[index as usize]);
        let steps = counter(COUNTER_MAX_STEPS);
        if steps > u64::from(budget) {
            return Err(Error::Internal(format!("an invocation took {steps} steps of a budget of {budget}")));
        }
        if counter(COUNTER_STACK_OVERFLOW) > 0 {
            return Err(Error::Internal("the traversal stack is too small for the tree".into()));
        }
        for (sum, count) in self.run_counts.iter_mut().zip(counters) {
            *sum += u64::from(count);
        }
        Ok(counters[COUNTER_UNFINISHED as usize])
    }

    /// Starts the copy of a finished tile's sums to readback `slot`.
    fn copy_sums(&mut self, tile: Tile, slot: usize) -> Result<PendingTile> {
        let mut recorder = Recorder::new(&self.context, "read back sums")?;
        let bytes = tile.pixels() * SUM_BYTES;
        let readback = &mut self.readbacks[slot];
        readback.copy_from(&mut recorder, &mut self.ledger, &self.sums, 0, 0, bytes, "sums of a run")?;
        Ok(PendingTile { copy: recorder.submit()?, tile, slot })
    }

    /// Waits for a tile's sums and puts them in their place in the run.
    fn absorb(&mut self, pending: PendingTile) -> Result<()> {
        let start = Instant::now();
        let PendingTile { copy, tile, slot } = pending;
        copy.wait()?;
        let bytes = &self.readbacks[slot].bytes()?[..(tile.pixels() * SUM_BYTES) as usize];
        let [x, y, width, _] = self.settings.region();
        for (row, line) in (0..tile.height).zip(bytes.chunks_exact(16 * tile.width as usize)) {
            let at = (tile.y - y + row) as usize * width as usize + (tile.x - x) as usize;
            bytemuck::cast_slice_mut(&mut self.run_sums[at..at + tile.width as usize]).copy_from_slice(line);
        }
        self.report.seconds.readback += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Gives a tile its open sums back: another tile has been on the device since.
    fn upload_open_sums(&mut self, tile: Tile) -> Result<()> {
        let [x, y, width, _] = self.settings.region();
        let mut sums = Vec::with_capacity(tile.pixels() as usize);
        for row in 0..tile.height {
            let at = (tile.y - y + row) as usize * width as usize + (tile.x - x) as usize;
            sums.extend_from_slice(&self.open_sums[at..at + tile.width as usize]);
        }
        let mut uploader = Uploader::new(&self.context)?;
        uploader.upload(&mut self.ledger, &self.sums, 0, bytemuck::cast_slice(&sums), "open sums of a tile")?;
        uploader.finish()
    }

    /// Enters a whole run into the film, and its counts into the report: what a stop throws away is not reported.
    fn commit(&mut self, first: u32, samples: u32) -> Result<()> {
        let start = Instant::now();
        let counts = std::mem::take(&mut self.run_counts);
        let count = |index: u32| counts[index as usize];
        self.report.rays += count(COUNTER_RAYS);
        self.report.paths += count(COUNTER_PATHS);
        self.report.node_visits += count(COUNTER_NODES);
        self.report.triangle_tests += count(COUNTER_TRIANGLES);
        for (index, kind) in INVALID_KIND_NAMES.into_iter().enumerate() {
            *self.report.invalid_kinds.entry(kind).or_default() += count(COUNTER_INVALID + index as u32);
        }
        for (index, cause) in CAUSE_NAMES.into_iter().enumerate() {
            let counter = COUNTER_INVALID + INVALID_KINDS + index as u32;
            *self.report.invalid_samples.entry(cause).or_default() += count(counter);
        }
        let end = first + samples;
        let replicate = replicate_of_block(first / BLOCK_SAMPLES, self.replicates);
        let whole = [0, 0, self.film.width(), self.film.height()];
        if end.is_multiple_of(BLOCK_SAMPLES) {
            self.film.add_block(replicate, whole, &self.run_sums)?;
        } else {
            self.film.set_open(replicate, whole, &self.run_sums)?;
        }
        std::mem::swap(&mut self.run_sums, &mut self.open_sums);
        self.report.seconds.readback += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Times that a pixel's samples went around the table of random numbers.
    fn table_wraps(&self, spp: u32) -> u64 {
        let stride = u64::from((PAIRS_PER_BOUNCE * (1 + self.settings.max_bounces)) | 1);
        match self.settings.sampler {
            Sampler::Table => u64::from(spp) * stride / u64::from(RANDOM_TABLE_TEXELS),
            _ => 0,
        }
    }

    fn tell(&self, spp_done: u32, start: Instant, observer: &mut dyn Observer) {
        let pixels = self.film.pixels() as f64;
        let forecast = self.forecasts.map(|(_, last)| last);
        let spp_target =
            forecast.map_or(u64::from(u32::MAX), |forecast| forecast.spp).min(u64::from(self.settings.spp)) as u32;
        let paths_of_run = self.run_counts[COUNTER_PATHS as usize];
        let all = pixels * f64::from(spp_target);
        observer.progress(&Progress {
            spp_done,
            spp_target,
            fraction: ((pixels * f64::from(spp_done) + paths_of_run as f64) / all).max(self.time_share(start)).min(1.0),
            paths: self.report.paths + paths_of_run,
            seconds: start.elapsed().as_secs_f64(),
            relative_rmse: self.report.relative_rmse,
            target: self.rules.target.map(|target| (target, forecast)),
        });
    }
}
