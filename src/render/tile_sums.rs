//! The open sums of a tile on the device, and their way to the host and back.
//!
//! Comes in: a tile that has finished a run. Goes out: its sums, in a copy that overlaps the next tile's first
//! dispatch.

use std::sync::Arc;

use crate::error::Result;
use crate::film::PixelSum;
use crate::gpu::{Buffer, BufferUse, Context, InFlight, Ledger, Memory, Readback, Recorder, Uploader};
use crate::render::tiles::{SUM_BYTES, Tile};

/// Sums of the tile that is on the device.
pub(super) struct TileSums {
    context: Context,
    buffer: Arc<Buffer>,
    /// Two places for them to come back to: one is read while the other is written.
    readbacks: [Readback; 2],
}

/// A copy of a tile's sums that is under way.
pub(super) struct PendingSums {
    copy: InFlight,
    tile: Tile,
    readback: usize,
}

impl TileSums {
    /// Room for tiles of `pixels` pixels.
    pub(super) fn new(context: &Context, pixels: u64) -> Result<TileSums> {
        let bytes = pixels * SUM_BYTES;
        let storage = BufferUse { texel: false, storage: true };
        let readback = |name| Readback::new(context, name, bytes);
        Ok(TileSums {
            context: context.clone(),
            buffer: Buffer::new(context, "open sums", bytes, storage, Memory::Device)?,
            readbacks: [readback("sums readback 0")?, readback("sums readback 1")?],
        })
    }

    /// What the kernel writes.
    pub(super) fn buffer(&self) -> &Arc<Buffer> {
        &self.buffer
    }

    /// Starts the copy of the sums of `tile`, the one of this index.
    pub(super) fn copy_down(&mut self, ledger: &mut Ledger, tile: Tile, index: usize) -> Result<PendingSums> {
        let mut recorder = Recorder::new(&self.context, "read back sums")?;
        let (bytes, readback) = (tile.pixels() * SUM_BYTES, index % 2);
        let to = &mut self.readbacks[readback];
        to.copy_from(&mut recorder, ledger, &self.buffer, 0, 0, bytes, "sums of a run")?;
        Ok(PendingSums { copy: recorder.submit()?, tile, readback })
    }

    /// Waits for a tile's sums and puts them in their place among those of `region`, `[x, y, width, height]`.
    pub(super) fn absorb(&self, pending: PendingSums, region: [u32; 4], sums: &mut [PixelSum]) -> Result<()> {
        let PendingSums { copy, tile, readback } = pending;
        copy.wait()?;
        let bytes = &self.readbacks[readback].bytes()?[..(tile.pixels() * SUM_BYTES) as usize];
        for (row, line) in (0..tile.height).zip(bytes.chunks_exact(SUM_BYTES as usize * tile.width as usize)) {
            let at = place(region, tile, row);
            bytemuck::cast_slice_mut(&mut sums[at..at + tile.width as usize]).copy_from_slice(line);
        }
        Ok(())
    }

    /// Gives a tile its open sums back: another tile has been on the device since.
    pub(super) fn copy_up(&self, ledger: &mut Ledger, tile: Tile, region: [u32; 4], sums: &[PixelSum]) -> Result<()> {
        let mut open = Vec::with_capacity(tile.pixels() as usize);
        for row in 0..tile.height {
            let at = place(region, tile, row);
            open.extend_from_slice(&sums[at..at + tile.width as usize]);
        }
        let mut uploader = Uploader::new(&self.context)?;
        uploader.upload(ledger, &self.buffer, 0, bytemuck::cast_slice(&open), "open sums of a tile")?;
        uploader.finish()
    }
}

/// Where a row of a tile begins among the pixels of the region.
fn place([x, y, width, _]: [u32; 4], tile: Tile, row: u32) -> usize {
    (tile.y - y + row) as usize * width as usize + (tile.x - x) as usize
}
