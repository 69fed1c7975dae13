//! Bytes down: from device buffers to memory that the host reads.
//!
//! Comes in: a device buffer, copied within a recorder's other work. Goes out: a ledger entry a copy, and after the wait
//! for that work the bytes, read in place. A frame loop holds two readbacks: the host reads one while the device fills
//! the other.

use std::sync::Arc;

use super::barrier::Barrier;
use super::commands::Recorder;
use super::context::Context;
use super::ledger::{Direction, Ledger, LedgerEntry};
use super::memory::{Buffer, BufferUse, Memory};
use crate::{Error, Result};

/// A buffer that the device copies into and the host reads.
#[derive(Debug)]
pub struct Readback {
    /// Nobody else has it, so copies into it are those of `copy_from`, which needs `&mut self`.
    buffer: Arc<Buffer>,
    bytes: usize,
}

impl Readback {
    /// Makes a readback of `bytes` bytes, all zero.
    pub fn new(context: &Context, name: &str, bytes: u64) -> Result<Readback> {
        let buffer = Buffer::new(context, name, bytes, BufferUse::default(), Memory::Readback)?;
        let bytes = bytes as usize;
        // SAFETY: the buffer is new: no device work knows it, and no other thread.
        unsafe { buffer.clear_by_host()? };
        Ok(Readback { buffer, bytes })
    }

    /// Records a copy of `bytes` bytes of `src` at `src_offset` to `dst_offset` here, with the barriers around it: what
    /// earlier dispatches of the queue wrote to `src` is what arrives. (What *copies* wrote to it needs a
    /// [`Barrier::TransferToTransfer`] before.) `why` goes to the ledger.
    #[expect(clippy::too_many_arguments, reason = "a copy has two ends, a recorder, a ledger and a reason")]
    pub fn copy_from(
        &mut self,
        recorder: &mut Recorder,
        ledger: &mut Ledger,
        src: &Arc<Buffer>,
        src_offset: u64,
        dst_offset: u64,
        bytes: u64,
        why: &str,
    ) -> Result<()> {
        src.check_device_only("read back")?;
        src.check_range(src_offset, bytes)?;
        self.buffer.check_range(dst_offset, bytes)?;
        if bytes == 0 {
            return Ok(());
        }
        let before = Barrier::ComputeToTransfer;
        let after = Barrier::TransferToHost;
        let clock = ledger.add(LedgerEntry {
            buffer: src.name().to_string(),
            direction: Direction::Down,
            bytes,
            copies: 1,
            memory_type: self.buffer.memory_type(),
            how: "staged".to_string(),
            barrier: format!("{}; {}", before.text(), after.text()),
            milliseconds: 0.0,
            why: why.to_string(),
        });
        // Earlier dispatches write `src` → this copy reads it. Without it the copy may take sums half written.
        recorder.barrier(before)?;
        recorder.record_copy(src, src_offset, &self.buffer, dst_offset, bytes, Some(&clock))?;
        // This copy writes the readback → the host reads it after the fence. Without it the bytes may still be in a
        // cache of the device when the fence is signalled.
        recorder.barrier(after)
    }

    /// The bytes that the copies brought. An error while a copy is recorded or in flight: wait for its work first.
    pub fn bytes(&self) -> Result<&[u8]> {
        if !self.buffer.is_settled() {
            return Err(Error::Internal(format!("`{}` read before the work that fills it ended", self.buffer.name())));
        }
        // SAFETY: no copy into the buffer is recorded or in flight, and a new one needs `&mut self`, which the result's
        // borrow excludes. The memory is coherent, and the copy's barrier and fence made its bytes visible to the host.
        let bytes = unsafe { self.buffer.read_by_host()? };
        Ok(&bytes[..self.bytes])
    }
}
