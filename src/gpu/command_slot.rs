//! A command slot: what one submit needs, and what can be used again when it has ended.
//!
//! Comes in: a device. Goes out: a command pool with one command buffer, a fence, a timer. A small dispatch takes a tenth
//! of a millisecond, as long as making these objects would: the context keeps ended slots for the next recorder.
//!
//! A slot has a pool of its own because Vulkan asks that a pool be used by one thread at a time: a slot belongs to one
//! recorder, then to one submit, so nothing needs a lock.

use std::sync::Arc;

use ash::vk;

use super::device::Device;
use super::failure::failed;
use super::handle::Handle;
use super::timer::Timer;
use crate::Result;

/// Command pool and buffer, fence, timer.
pub(super) struct CommandSlot {
    /// Freed with its pool.
    pub(super) commands: vk::CommandBuffer,
    pool: Handle<vk::CommandPool>,
    pub(super) fence: Handle<vk::Fence>,
    pub(super) timer: Option<Timer>,
}

impl CommandSlot {
    pub(super) fn new(device: &Arc<Device>) -> Result<CommandSlot> {
        // TRANSIENT: its command buffers live for one submit.
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(device.info.queue_family);
        // SAFETY: the family is one of the device's; the handle is the pool's only owner.
        let pool = unsafe {
            let pool = device.raw().create_command_pool(&info, None).map_err(failed("vkCreateCommandPool"))?;
            Handle::own(device, pool, "command pool")
        };
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(pool.raw())
            .level(vk::CommandBufferLevel::PRIMARY)
            .command_buffer_count(1);
        // SAFETY: the pool is alive and this thread's own; the buffer is freed with it.
        let commands =
            unsafe { device.raw().allocate_command_buffers(&info) }.map_err(failed("vkAllocateCommandBuffers"))?[0];
        // SAFETY: the handle is the fence's only owner. It is made unsignalled, ready for a submit.
        let fence = unsafe {
            let fence = device.raw().create_fence(&vk::FenceCreateInfo::default(), None);
            Handle::own(device, fence.map_err(failed("vkCreateFence"))?, "submit fence")
        };
        Ok(CommandSlot { commands, pool, fence, timer: Timer::new(device)? })
    }

    /// Empties the slot and begins recording.
    pub(super) fn begin(&mut self, name: &str) -> Result<()> {
        let device = self.pool.device();
        // ONE_TIME_SUBMIT: recorded anew each time, so the driver need not keep it for a second submit.
        let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: a slot in nobody's hands has no work in flight, so its pool and fence may be reset; resetting the pool
        // puts the command buffer into its initial state, from which recording may begin.
        unsafe {
            let pool = self.pool.raw();
            let reset = device.raw().reset_command_pool(pool, vk::CommandPoolResetFlags::empty());
            reset.map_err(failed("vkResetCommandPool"))?;
            device.raw().reset_fences(&[self.fence.raw()]).map_err(failed("vkResetFences"))?;
            device.name(self.commands, name);
            device.raw().begin_command_buffer(self.commands, &info).map_err(failed("vkBeginCommandBuffer"))?;
        }
        if let Some(timer) = &mut self.timer {
            // SAFETY: recording has just begun, and the slot's earlier work has ended.
            unsafe { timer.begin(self.commands) };
        }
        Ok(())
    }
}
