//! Timestamp queries: how long the device took.
//!
//! Comes in: marks between the commands of one command buffer. Goes out, after the wait for its fence: the time from
//! first to last, and the times of single copies, which go to the clocks of a ledger. Where the queue has no timestamps
//! there is no [`Timer`], and times are those of the host's wait.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use ash::vk;

use super::device::Device;
use super::failure::failed;
use super::handle::Handle;
use crate::Result;

/// Timestamps a command buffer may write: begin, end, and two for each timed copy. Copies past that go untimed.
const QUERIES: u32 = 64;
const BEGIN: u32 = 0;
const END: u32 = 1;

/// Nanoseconds that something took so far; shared by the ledger and the work in flight that it waits for.
#[derive(Clone, Debug, Default)]
pub(super) struct Clock(Arc<AtomicU64>);

impl Clock {
    pub(super) fn add(&self, time: Duration) {
        self.0.fetch_add(time.as_nanos() as u64, Ordering::Relaxed);
    }

    pub(super) fn milliseconds(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 / 1e6
    }
}

/// The timestamps of one command buffer.
pub(super) struct Timer {
    pool: Handle<vk::QueryPool>,
    /// Queries taken, `BEGIN` and `END` included.
    taken: u32,
    /// First query (of two) of each timed copy, and where its time goes.
    copies: Vec<(u32, Clock)>,
}

impl Timer {
    /// A timer, or `None` where the queue has no timestamps.
    pub(super) fn new(device: &Arc<Device>) -> Result<Option<Timer>> {
        if device.info.timestamp_valid_bits == 0 {
            return Ok(None);
        }
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(QUERIES);
        // SAFETY: timestamps need no feature; the handle is the pool's only owner.
        let pool = unsafe {
            let pool = device.raw().create_query_pool(&info, None).map_err(failed("vkCreateQueryPool"))?;
            Handle::own(device, pool, "timestamps")
        };
        Ok(Some(Timer { pool, taken: 2, copies: Vec::new() }))
    }

    /// Records the start.
    ///
    /// # Safety
    /// `commands` is being recorded, outside a render pass, and the timer's earlier work has ended.
    pub(super) unsafe fn begin(&mut self, commands: vk::CommandBuffer) {
        self.taken = 2;
        self.copies.clear();
        let device = self.pool.device().raw();
        // A query must be reset before it is written again, and its first state is undefined: reset all.
        // SAFETY: the caller's promise; the queries are in range; the queue family has timestamps.
        unsafe { device.cmd_reset_query_pool(commands, self.pool.raw(), 0, QUERIES) };
        // TOP_OF_PIPE: written when the device reaches the command, before any of the work below.
        // SAFETY: as above.
        unsafe { self.mark(commands, vk::PipelineStageFlags::TOP_OF_PIPE, BEGIN) };
    }

    /// Records the end.
    ///
    /// # Safety
    /// As for [`Timer::begin`], which was called on the same command buffer.
    pub(super) unsafe fn end(&mut self, commands: vk::CommandBuffer) {
        // BOTTOM_OF_PIPE: written when all commands before it have finished.
        // SAFETY: the caller's promise.
        unsafe { self.mark(commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, END) };
    }

    /// Records the mark before a copy; the mark after it goes to the returned query.
    ///
    /// # Safety
    /// As for [`Timer::end`].
    pub(super) unsafe fn before_copy(&mut self, commands: vk::CommandBuffer, clock: &Clock) -> Option<u32> {
        let first = self.taken;
        if first + 2 > QUERIES {
            return None;
        }
        self.taken += 2;
        self.copies.push((first, clock.clone()));
        // Also BOTTOM_OF_PIPE, so that work before the copy is not counted as the copy's.
        // SAFETY: the caller's promise; the query is in range and was reset by `begin`.
        unsafe { self.mark(commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, first) };
        Some(first + 1)
    }

    /// Records the mark after a copy.
    ///
    /// # Safety
    /// As for [`Timer::end`]; `query` is what [`Timer::before_copy`] returned.
    pub(super) unsafe fn after_copy(&self, commands: vk::CommandBuffer, query: u32) {
        // SAFETY: the caller's promise.
        unsafe { self.mark(commands, vk::PipelineStageFlags::BOTTOM_OF_PIPE, query) };
    }

    unsafe fn mark(&self, commands: vk::CommandBuffer, stage: vk::PipelineStageFlags, query: u32) {
        // SAFETY: all callers pass a recording command buffer and a query that was reset and not written since.
        unsafe { self.pool.device().raw().cmd_write_timestamp(commands, stage, self.pool.raw(), query) };
    }

    /// Reads the marks once the work has ended: adds each copy's time to its clock, returns the whole time.
    pub(super) fn read(&mut self) -> Option<Duration> {
        let mut ticks = [0u64; QUERIES as usize];
        let ticks = &mut ticks[..self.taken as usize];
        let device = self.pool.device();
        // SAFETY: the queries are in range; each gives 8 bytes. Without WAIT the call returns NOT_READY, an error
        // here, if the marks were not written.
        let read =
            unsafe { device.raw().get_query_pool_results(self.pool.raw(), 0, ticks, vk::QueryResultFlags::TYPE_64) };
        let copies = std::mem::take(&mut self.copies);
        if read.is_err() {
            return None;
        }
        // Bits above the valid ones are undefined, and the counter wraps around: subtract, then mask.
        let bits = device.info.timestamp_valid_bits.min(64);
        let mask = u64::MAX >> (64 - bits);
        let period = f64::from(device.info.timestamp_period_ns);
        let between = |first: u32, last: u32| {
            let elapsed = ticks[last as usize].wrapping_sub(ticks[first as usize]) & mask;
            Duration::from_nanos((elapsed as f64 * period) as u64)
        };
        for (first, clock) in copies {
            clock.add(between(first, first + 1));
        }
        Some(between(BEGIN, END))
    }
}
