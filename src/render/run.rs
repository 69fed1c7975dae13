//! A run: every pixel of the region through the same samples.
//!
//! Comes in: the scene on the device, first sample and number of samples. Goes out: the sums of every pixel and what
//! the kernel counted. A run goes tile by tile, and in a tile pass by pass (pass.rs), until no path is left unfinished.
//! A tile's sums come back in a copy that overlaps the next tile's first dispatch. What a pixel computes depends on
//! none of these sizes.

use std::time::Instant;

use crate::error::Result;
use crate::film::PixelSum;
use crate::gpu::{DeviceInfo, Ledger};
use crate::interface::BLOCK_SAMPLES;
use crate::memory::filled;
use crate::render::counters::Counts;
use crate::render::device_scene::DeviceScene;
use crate::render::kernel::{self, Dispatch};
use crate::render::pass::Pass;
use crate::render::slice::Slice;
use crate::render::tile_sums::PendingSums;
use crate::render::tiles::Tile;
use crate::render::tuning::Tuning;
use crate::render::work_size::{SubmitSize, cpu_lanes};

/// What runs go by, and what they have brought.
pub(super) struct Run {
    region: [u32; 4],
    size: SubmitSize,
    /// See [`Dispatch::leave_eighths`].
    leave_eighths: u32,
    slice_pixels: Option<u32>,
    /// What came back of the run so far, `[sum.rgb, count]` a pixel of the region.
    sums: Vec<PixelSum>,
    /// The same of the last whole run: the open block of every pixel, if it is open.
    open: Vec<PixelSum>,
    counts: Counts,
    readback_seconds: f64,
}

/// What a whole run has brought.
pub(super) struct RunResult<'a> {
    /// Sums of every pixel of the region.
    pub(super) sums: &'a [PixelSum],
    /// What the kernel counted.
    pub(super) counts: Counts,
    /// Seconds of waiting for sums and of putting them in their places.
    pub(super) readback_seconds: f64,
}

impl Run {
    /// Runs over a region, `[x, y, width, height]`. Refused where the system lacks the memory for its sums.
    pub(super) fn new(device: &DeviceInfo, region: [u32; 4], tuning: &Tuning) -> Result<Run> {
        let pixels = region[2] as usize * region[3] as usize;
        let sums = || filled("memory for the sums of a run", [0; 4], pixels);
        Ok(Run {
            region,
            size: SubmitSize::new(cpu_lanes(device), tuning.budget),
            leave_eighths: tuning.leave_eighths.unwrap_or(kernel::leave_eighths(device.kind)),
            slice_pixels: tuning.slice_pixels,
            sums: sums()?,
            open: sums()?,
            counts: Counts::default(),
            readback_seconds: 0.0,
        })
    }

    /// Takes `samples` samples of every pixel from sample `first` on, which cross no block's end; the runs before it
    /// have taken those up to `first`. After each dispatch it asks `gives_up`, which is told how many paths have ended
    /// and whether the run is whole but for its last copy. Nothing where the run was given up.
    pub(super) fn trace(
        &mut self,
        scene: &mut DeviceScene,
        ledger: &mut Ledger,
        [first, samples]: [u32; 2],
        gives_up: &mut dyn FnMut(u64, bool) -> bool,
    ) -> Result<Option<RunResult<'_>>> {
        (self.counts, self.readback_seconds) = (Counts::default(), 0.0);
        self.size.begin_run(samples);
        let mut pending = None;
        let tiles = scene.tiles.len();
        for index in 0..tiles {
            let tile = scene.tiles[index];
            if tiles > 1 && !first.is_multiple_of(BLOCK_SAMPLES) {
                scene.sums.copy_up(ledger, tile, self.region, &self.open)?;
            }
            let mut next = Some(Pass::over(tile));
            while let Some(mut pass) = next {
                while let Some(slice) = pass.next_slice(self.slice_pixels(&pass, tile)) {
                    let dispatch = Dispatch {
                        tile,
                        slice,
                        fills: pass.fills(),
                        samples: [first, samples],
                        budget: self.size.budget,
                        leave_eighths: pass.leave_eighths(self.leave_eighths),
                    };
                    let start = Instant::now();
                    let frame = scene.submit(ledger, &dispatch)?;
                    if let Some(sums) = pending.take() {
                        self.absorb(scene, sums)?;
                    }
                    pass.note(self.counts.add(scene.counters(frame)?, dispatch.budget)?);
                    match slice {
                        Slice::Rows { count, .. } => self.size.note(count, tile.height, start.elapsed()),
                        Slice::Listed { count, .. } => self.size.note_listed(count, start.elapsed()),
                    }
                    if gives_up(self.counts.paths(), index + 1 == tiles && pass.is_last()) {
                        return Ok(None);
                    }
                }
                next = pass.next();
            }
            pending = Some(scene.sums.copy_down(ledger, tile, index)?);
        }
        if let Some(sums) = pending {
            self.absorb(scene, sums)?;
        }
        std::mem::swap(&mut self.sums, &mut self.open);
        let readback_seconds = self.readback_seconds;
        Ok(Some(RunResult { sums: &self.open, counts: self.counts, readback_seconds }))
    }

    fn absorb(&mut self, scene: &DeviceScene, sums: PendingSums) -> Result<()> {
        let start = Instant::now();
        scene.sums.absorb(sums, self.region, &mut self.sums)?;
        self.readback_seconds += start.elapsed().as_secs_f64();
        Ok(())
    }

    /// Pixels of the next slice of a pass. The counts of its dispatch fit their 32 bits.
    fn slice_pixels(&self, pass: &Pass, tile: Tile) -> u32 {
        let by_clock = if pass.is_listed() { self.size.listed } else { self.size.rows.saturating_mul(tile.width) };
        self.slice_pixels.unwrap_or(by_clock).min(u32::MAX / self.size.budget.max(1))
    }
}
