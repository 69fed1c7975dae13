//! Work that the device is doing, and what it uses.
//!
//! Comes in: a submitted command slot and an `Arc` of all that its commands use. Goes out, after the wait for the
//! fence: the time that the work took; the slot goes back to the context, the rest is let go. Dropping the guard
//! waits too, so that nothing in use is ever freed. A wait that fails says nothing about the work: what that uses is
//! then kept for good.

use std::any::Any;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use ash::vk;

use super::command_slot::CommandSlot;
use super::context::Context;
use super::failure::failed;
use super::memory::Buffer;
use crate::{Error, Result};

/// Work that the device is doing.
#[must_use = "dropping it waits for the device"]
pub struct InFlight {
    /// There until the work has ended, or is given up.
    pub(super) slot: Option<CommandSlot>,
    /// Whether a wait has failed, on a device that was not lost: whether the work has ended is unknown from then on.
    pub(super) given_up: bool,
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
        let Some(slot) = &self.slot else { return Ok(!self.given_up) };
        // SAFETY: the fence is alive and this guard's own.
        unsafe { self.context.device().raw().get_fence_status(slot.fence.raw()) }
            .map_err(failed(format!("vkGetFenceStatus for `{}`", self.name)))
    }

    /// [`InFlight::wait`] for who keeps the guard until the work has ended: it fails again where it has failed.
    pub(super) fn finish(&mut self) -> Result<Duration> {
        if self.given_up {
            return Err(Error::Vulkan {
                call: format!("waiting for `{}`", self.name),
                code: "an earlier wait failed, and the work may still run".to_string(),
            });
        }
        let Some(mut slot) = self.slot.take() else { return Ok(Duration::ZERO) };
        let device = self.context.device();
        let limit = device.wait_limit();
        let nanoseconds = limit.map_or(u64::MAX, |limit| u64::try_from(limit.as_nanos()).unwrap_or(u64::MAX));
        // SAFETY: the fence is alive and was submitted once.
        let waited = unsafe { device.raw().wait_for_fences(&[slot.fence.raw()], true, nanoseconds) };
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
                    // The wait itself failed (out of memory, or out of time) and the work may still run: nothing that
                    // it uses may be freed, so all of it is given up for good. A lost device does no work, and its
                    // objects may go.
                    std::mem::forget((slot, std::mem::take(&mut self.uses)));
                    self.given_up = true;
                }
                match (code, limit) {
                    (vk::Result::TIMEOUT, Some(limit)) => Err(Error::NoDevice(format!(
                        "{} does not answer: `{}` has not ended in {} s",
                        device.info.summary(),
                        self.name,
                        limit.as_secs_f64()
                    ))),
                    (code, _) => Err(failed(format!("vkWaitForFences for `{}`", self.name))(code)),
                }
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
