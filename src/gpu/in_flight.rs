//! Work that the device is doing, and what it uses.
//!
//! Comes in: a submitted command slot and an `Arc` of all that its commands use. Goes out, after the wait for the fence:
//! the time that the work took; the slot goes back to the context, the rest is let go. Dropping the guard waits too, so
//! that nothing in use is ever freed.

use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use ash::vk;

use super::context::Context;
use super::failure::failed;
use super::memory::Buffer;
use super::slot::CommandSlot;
use crate::Result;

/// Work that the device is doing.
#[must_use = "dropping it waits for the device"]
pub struct InFlight {
    /// There until the work has ended.
    pub(super) slot: Option<CommandSlot>,
    pub(super) uses: Uses,
    pub(super) start: Instant,
    pub(super) name: String,
    pub(super) context: Context,
}

impl InFlight {
    /// Waits until the work has ended. Returns the device's time for it, by timestamps; where the queue has none, the
    /// wall time since the submit.
    pub fn wait(mut self) -> Result<Duration> {
        self.finish()
    }

    /// Whether the work has ended, without waiting.
    pub fn is_done(&self) -> Result<bool> {
        let Some(slot) = &self.slot else { return Ok(true) };
        // SAFETY: the fence is alive and this guard's own.
        unsafe { self.context.device().raw().get_fence_status(slot.fence.raw()) }
            .map_err(failed(format!("vkGetFenceStatus for `{}`", self.name)))
    }

    fn finish(&mut self) -> Result<Duration> {
        let Some(mut slot) = self.slot.take() else { return Ok(Duration::ZERO) };
        // No time-out: a lost device ends the wait with an error, and until then the objects must stay.
        // SAFETY: the fence is alive and was submitted once.
        let waited = unsafe { self.context.device().raw().wait_for_fences(&[slot.fence.raw()], true, u64::MAX) };
        match waited {
            Ok(()) => {
                let time = slot.timer.as_mut().and_then(|timer| timer.read()).unwrap_or_else(|| self.start.elapsed());
                self.uses.settle();
                self.uses.kept.clear();
                self.context.return_slot(slot);
                Ok(time)
            }
            Err(code) => {
                if code != vk::Result::ERROR_DEVICE_LOST {
                    // The wait itself failed (out of memory) and the work may still run: nothing that it uses may be
                    // freed, so all of it is given up for good. A lost device does no work, and its objects may go.
                    std::mem::forget((slot, std::mem::take(&mut self.uses)));
                }
                Err(failed(format!("vkWaitForFences for `{}`", self.name))(code))
            }
        }
    }
}

impl Drop for InFlight {
    fn drop(&mut self) {
        // An error has no way out of here; the next call on the device gives it again.
        let _ = self.finish();
    }
}

/// What recorded or submitted work keeps alive, or keeps the host away from.
#[derive(Default)]
pub(super) struct Uses {
    kept: Vec<Arc<dyn Any + Send + Sync>>,
    /// Readback buffers that the work writes, one entry a copy; each counts in its buffer's `pending_writes`.
    pub(super) written: Vec<Arc<Buffer>>,
}

impl Uses {
    pub(super) fn keep<T: Any + Send + Sync>(&mut self, used: &Arc<T>) {
        // A handful of things used many times: a search among few beats a set.
        if !self.kept.iter().any(|kept| std::ptr::addr_eq(Arc::as_ptr(kept), Arc::as_ptr(used))) {
            self.kept.push(used.clone());
        }
    }

    /// The work has ended, or will never run: the host may read what it wrote.
    pub(super) fn settle(&mut self) {
        for buffer in self.written.drain(..) {
            // Release: pairs with the host's check before it reads.
            buffer.pending_writes.fetch_sub(1, Ordering::Release);
        }
    }
}
