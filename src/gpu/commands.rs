//! Commands: recorded and submitted.
//!
//! Comes in: pipelines, bind groups, buffers. Goes out: [`InFlight`], the guard of the submitted work. Commands of a recorder, and of recorders submitted later, may overlap wherever no [`Barrier`] stands between them.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

use ash::vk;

use super::barrier::Barrier;
use super::bind_group::BindGroup;
use super::command_slot::CommandSlot;
use super::context::Context;
use super::device::Device;
use super::failure::failed;
use super::in_flight::{InFlight, Uses};
use super::memory::{Buffer, Memory};
use super::pipeline::ComputePipeline;
use super::timer::Clock;
use crate::{Error, Result};

/// Shortest copy that is timed: the device takes as long for the two timestamps (on lavapipe 30 microseconds, since it
/// lets all threads come to rest for each).
const TIMED_COPY_BYTES: u64 = 64 << 10;

/// Records commands for one submit.
pub struct Recorder {
    // `Option`: taken by `submit`, and by `Drop` where nothing was submitted.
    slot: Option<CommandSlot>,
    uses: Uses,
    name: String,
    context: Context,
}

impl Recorder {
    /// Begins recording. `name` appears in errors and validation messages.
    pub fn new(context: &Context, name: &str) -> Result<Recorder> {
        let mut slot = context.take_slot()?;
        slot.begin(name)?;
        Ok(Recorder { slot: Some(slot), uses: Uses::default(), name: name.to_string(), context: context.clone() })
    }

    /// Runs `groups` workgroups of `pipeline` with what `bind_group` binds and `push` as its push constants, which are
    /// exactly as long as the pipeline says.
    pub fn dispatch(
        &mut self,
        pipeline: &Arc<ComputePipeline>,
        bind_group: &Arc<BindGroup>,
        push: &[u8],
        groups: [u32; 3],
    ) -> Result<()> {
        let most = self.context.device_info().max_compute_work_group_count;
        if groups.iter().zip(most).any(|(&count, most)| count > most) {
            return Err(Error::Limit {
                what: format!("workgroups of `{}` (maxComputeWorkGroupCount)", pipeline.name()),
                need: format!("{groups:?}"),
                have: format!("{most:?}"),
            });
        }
        self.check_device(pipeline.device(), pipeline.name())?;
        if push.len() != pipeline.push_constant_bytes() as usize || !bind_group.fits(pipeline) {
            return Err(Error::Internal(format!(
                "`{}` dispatched with {} bytes of push constants, not {}, or with bindings of another layout",
                pipeline.name(),
                push.len(),
                pipeline.push_constant_bytes()
            )));
        }
        let commands = self.commands()?;
        let (device, layout) = (self.context.device().raw(), pipeline.layout());
        // SAFETY: the command buffer is recording; pipeline, layout and set belong to this device and are kept alive
        // below until the work has ended; the set fits the layout, all its bindings are written; push constants fill
        // the layout's one range; the group counts are within limits.
        unsafe {
            device.cmd_bind_pipeline(commands, vk::PipelineBindPoint::COMPUTE, pipeline.raw());
            let sets = [bind_group.raw()];
            device.cmd_bind_descriptor_sets(commands, vk::PipelineBindPoint::COMPUTE, layout, 0, &sets, &[]);
            if !push.is_empty() {
                device.cmd_push_constants(commands, layout, vk::ShaderStageFlags::COMPUTE, 0, push);
            }
            device.cmd_dispatch(commands, groups[0], groups[1], groups[2]);
        }
        self.uses.keep(pipeline);
        self.uses.keep(bind_group);
        Ok(())
    }

    /// Copies within device memory. Copies from and to the host go through [`Uploader`](super::Uploader) and
    /// [`Readback`](super::Readback), which enter them in a ledger.
    pub fn copy(
        &mut self,
        src: &Arc<Buffer>,
        src_offset: u64,
        dst: &Arc<Buffer>,
        dst_offset: u64,
        bytes: u64,
    ) -> Result<()> {
        for buffer in [src, dst] {
            buffer.check_device_only("copied by Recorder::copy")?;
        }
        self.record_copy(src, src_offset, dst, dst_offset, bytes, None)
    }

    /// Fills a range with copies of a 32-bit word; offset and length are multiples of 4 bytes.
    pub fn fill(&mut self, buffer: &Arc<Buffer>, offset: u64, bytes: u64, word: u32) -> Result<()> {
        buffer.check_device_only("filled")?;
        self.check_device(buffer.device(), buffer.name())?;
        buffer.check_range(offset, bytes)?;
        if !(offset | bytes).is_multiple_of(4) {
            let name = buffer.name();
            return Err(Error::Internal(format!("fill of {bytes} bytes at {offset} of `{name}`: not whole words")));
        }
        // Vulkan knows no empty fill.
        if bytes > 0 {
            let commands = self.commands()?;
            // SAFETY: the command buffer is recording; the range is inside the buffer and whole words; the buffer has
            // the transfer usage and is kept alive below.
            unsafe { self.context.device().raw().cmd_fill_buffer(commands, buffer.raw(), offset, bytes, word) };
            self.uses.keep(buffer);
        }
        Ok(())
    }

    /// Makes later commands of the barrier's reader wait for, and see, earlier ones of its writer.
    pub fn barrier(&mut self, barrier: Barrier) -> Result<()> {
        let [(src_stages, src), (dst_stages, dst)] = barrier.sides();
        let memory = [vk::MemoryBarrier::default().src_access_mask(src).dst_access_mask(dst)];
        let commands = self.commands()?;
        // SAFETY: the command buffer is recording, outside a render pass; each access belongs to its stage, and the
        // queue family has compute, which has all the stages named.
        unsafe {
            let none = vk::DependencyFlags::empty();
            let device = self.context.device().raw();
            device.cmd_pipeline_barrier(commands, src_stages, dst_stages, none, &memory, &[], &[]);
        }
        Ok(())
    }

    /// Copies between any two buffers. Counts what leaves an upload buffer or enters a readback buffer: this is the one
    /// place that records a copy command. With a clock, the time of
    /// a copy of [`TIMED_COPY_BYTES`] or more is added to it when the work has ended.
    pub(super) fn record_copy(
        &mut self,
        src: &Arc<Buffer>,
        src_offset: u64,
        dst: &Arc<Buffer>,
        dst_offset: u64,
        bytes: u64,
        clock: Option<&Clock>,
    ) -> Result<()> {
        self.check_device(src.device(), src.name())?;
        self.check_device(dst.device(), dst.name())?;
        src.check_range(src_offset, bytes)?;
        dst.check_range(dst_offset, bytes)?;
        if Arc::ptr_eq(src, dst) {
            return Err(Error::Internal(format!("copy within `{}`", src.name())));
        }
        // Vulkan knows no empty copy.
        if bytes == 0 {
            return Ok(());
        }
        let commands = self.commands()?;
        let device = self.context.device().clone();
        let timer = self.slot.as_mut().and_then(|slot| slot.timer.as_mut());
        let mut timing = timer.zip(clock).filter(|_| bytes >= TIMED_COPY_BYTES);
        let region = [vk::BufferCopy { src_offset, dst_offset, size: bytes }];
        // SAFETY: the command buffer is recording and its timer has begun; both ranges are inside their buffers, which
        // differ, have the transfer usages, and are kept alive below.
        unsafe {
            let after = timing.as_mut().and_then(|(timer, clock)| timer.before_copy(commands, clock));
            device.raw().cmd_copy_buffer(commands, src.raw(), dst.raw(), &region);
            if let (Some((timer, _)), Some(query)) = (&timing, after) {
                timer.after_copy(commands, query);
            }
        }
        if src.memory() == Memory::Upload {
            device.count_up(bytes);
        }
        if dst.memory() == Memory::Readback {
            device.count_down(bytes);
            dst.pending_writes.fetch_add(1, Ordering::Relaxed);
            self.uses.written.push(dst.clone());
        }
        self.uses.keep(src);
        self.uses.keep(dst);
        Ok(())
    }

    /// Hands the commands to the device.
    pub fn submit(mut self) -> Result<InFlight> {
        let commands = self.commands()?;
        let device = self.context.device().clone();
        let Some(slot) = &mut self.slot else { return Err(submitted()) };
        // SAFETY: the command buffer is recording, its timer has begun.
        unsafe {
            if let Some(timer) = &mut slot.timer {
                timer.end(commands);
            }
            let ended = device.raw().end_command_buffer(commands);
            ended.map_err(failed(format!("vkEndCommandBuffer for `{}`", self.name)))?;
        }
        let buffers = [commands];
        let submits = [vk::SubmitInfo::default().command_buffers(&buffers)];
        let start = Instant::now();
        // SAFETY: the queue is this thread's while the guard lives; the command buffer is executable and submitted once;
        // the fence is unsignalled and waited for by the `InFlight` below, which keeps all that the work uses. Host
        // writes before this call are visible to the work.
        let result = unsafe { device.raw().queue_submit(*device.queue(), &submits, slot.fence.raw()) };
        result.map_err(failed(format!("vkQueueSubmit for `{}`", self.name)))?;
        let (slot, uses) = (self.slot.take(), std::mem::take(&mut self.uses));
        Ok(InFlight {
            slot,
            given_up: false,
            uses,
            start,
            name: std::mem::take(&mut self.name),
            context: self.context.clone(),
        })
    }

    /// Refuses what another context made.
    fn check_device(&self, device: &Arc<Device>, name: &str) -> Result<()> {
        match Arc::ptr_eq(device, self.context.device()) {
            true => Ok(()),
            false => Err(Error::Internal(format!("`{name}` in `{}` belongs to another context", self.name))),
        }
    }

    fn commands(&self) -> Result<vk::CommandBuffer> {
        self.slot.as_ref().map(|slot| slot.commands).ok_or_else(submitted)
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        // Nothing was submitted, so nothing is in use. A submit that failed leaves the slot as it was: its next user
        // resets it.
        self.uses.settle();
        if let Some(slot) = self.slot.take() {
            self.context.return_slot(slot);
        }
    }
}

fn submitted() -> Error {
    Error::Internal("commands recorded after their submit".to_string())
}
