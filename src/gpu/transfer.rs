//! Bytes up: from the host to device buffers, through a staging ring of fixed size.
//!
//! ```text
//! host bytes ──write──▶ chunk 0 ──copy──▶ device buffer        the device copies chunk 0
//! host bytes ──write──▶ chunk 1                                while the host writes chunk 1
//! ```
//!
//! Comes in: bytes, a destination, and the reason. Goes out: a ledger entry a copy, and bytes that any later dispatch
//! sees. Memory for staging is two chunks, however large the scene: a device that cannot hold a scene twice can still be
//! given it. One queue does the copies and the dispatches, so no buffer changes its queue family and none needs an
//! ownership transfer; with a queue for transfers alone each copy would need a release there and an acquire here.

use std::sync::Arc;

use super::barrier::Barrier;
use super::commands::Recorder;
use super::context::Context;
use super::in_flight::InFlight;
use super::ledger::{Direction, Ledger, LedgerEntry};
use super::memory::{Buffer, BufferUse, Memory};
use crate::Result;

/// Chunks of the ring: the host writes one while the device copies the other.
const CHUNKS: usize = 2;
/// Bytes of a chunk: large enough that the cost of a submit (tens of microseconds) vanishes beside the copy.
const CHUNK_BYTES: u64 = 4 << 20;

/// Copies host bytes into device buffers.
pub struct Uploader {
    context: Context,
    chunks: Vec<Chunk>,
    /// The chunk to write next: the one submitted longest ago.
    next: usize,
    chunk_bytes: usize,
}

/// One part of the ring.
struct Chunk {
    buffer: Arc<Buffer>,
    /// The copy out of it, while the device may still be at it.
    in_flight: Option<InFlight>,
}

impl Chunk {
    /// Waits for the copy out of it, if there is one. Where that fails the chunk stays as it is, so that the host
    /// never writes what the device may still read.
    fn finish(&mut self) -> Result<()> {
        if let Some(copy) = &mut self.in_flight {
            copy.finish()?;
            self.in_flight = None;
        }
        Ok(())
    }
}

impl Uploader {
    /// Makes the ring: 2 chunks of 4 MiB.
    pub fn new(context: &Context) -> Result<Uploader> {
        Uploader::with_ring(context, CHUNKS, CHUNK_BYTES)
    }

    /// Makes a ring of `chunks` chunks (at least 1) of `chunk_bytes` each, rounded up to 16.
    pub fn with_ring(context: &Context, chunks: usize, chunk_bytes: u64) -> Result<Uploader> {
        let mut ring = Vec::new();
        for index in 0..chunks.max(1) {
            let name = format!("staging {index}");
            let buffer = Buffer::new(context, &name, chunk_bytes, BufferUse::default(), Memory::Upload)?;
            ring.push(Chunk { buffer, in_flight: None });
        }
        let chunk_bytes = ring[0].buffer.size_bytes() as usize;
        Ok(Uploader { context: context.clone(), chunks: ring, next: 0, chunk_bytes })
    }

    /// Copies `bytes` to `dst` at `dst_offset`. Work submitted after this sees them; the copy itself may still be in
    /// flight when this returns. `why` goes to the ledger.
    pub fn upload(
        &mut self,
        ledger: &mut Ledger,
        dst: &Arc<Buffer>,
        dst_offset: u64,
        bytes: &[u8],
        why: &str,
    ) -> Result<()> {
        dst.check_device_only("uploaded to")?;
        dst.check_range(dst_offset, bytes.len() as u64)?;
        let mut offset = dst_offset;
        for piece in bytes.chunks(self.chunk_bytes) {
            let chunk = &mut self.chunks[self.next];
            chunk.finish()?;
            // SAFETY: the copy out of this chunk has ended, and this uploader alone knows the chunk's buffer.
            unsafe { chunk.buffer.write_from_host(piece)? };

            let before = [Barrier::ComputeToTransfer, Barrier::TransferToTransfer];
            let after = Barrier::TransferToCompute;
            let clock = ledger.add(LedgerEntry {
                buffer: dst.name().to_string(),
                direction: Direction::Up,
                bytes: piece.len() as u64,
                copies: 1,
                memory_type: dst.memory_type(),
                how: "staged".to_string(),
                barrier: format!("{}; {}; {}", before[0].text(), before[1].text(), after.text()),
                milliseconds: 0.0,
                why: why.to_string(),
            });
            let mut recorder = Recorder::new(&self.context, &format!("upload {}", dst.name()))?;
            // Earlier dispatches read or write `dst` → this copy writes it. Without it a dispatch still in flight could
            // see the new bytes too early. For a fresh buffer there is nothing to wait for.
            recorder.barrier(before[0])?;
            // Earlier copies read or write `dst` → this copy writes it. Without it a readback still in flight could take
            // the new bytes for the old ones.
            recorder.barrier(before[1])?;
            // The host's writes to the chunk need no barrier: the submit makes them visible.
            recorder.record_copy(&chunk.buffer, 0, dst, offset, piece.len() as u64, Some(&clock))?;
            // This copy writes `dst` → later dispatches read it, as texels or storage. Without it they might read what
            // was there before. The barrier also covers dispatches of later submits, as all are on one queue.
            recorder.barrier(after)?;
            chunk.in_flight = Some(recorder.submit()?);
            self.next = (self.next + 1) % self.chunks.len();
            offset += piece.len() as u64;
        }
        Ok(())
    }

    /// Waits for all copies. (Dropping the uploader waits too, but cannot report an error.)
    pub fn finish(&mut self) -> Result<()> {
        for chunk in &mut self.chunks {
            chunk.finish()?;
        }
        Ok(())
    }
}
