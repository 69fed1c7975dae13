//! Errors made on purpose, to prove that validation is listening.
//!
//! Comes in: a context under validation. Goes out: two messages in its report, one of core validation and one of
//! synchronisation validation; or, when the context goes, two messages about leaks. Without this a test that finds no message could mean that nobody looked.

use ash::vk;

use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{AllocationCreateDesc, AllocationScheme};

use super::commands::Recorder;
use super::context::Context;
use super::failure::failed;
use super::handle::Handle;
use super::memory::{Buffer, BufferUse, Memory};
use crate::{Error, Result};

/// Makes one core error (a buffer without any usage) and one synchronisation hazard (two fills of one buffer with no
/// barrier between them). Neither is ever used or run by the device, and nothing is left behind. Refused without
/// validation.
pub fn provoke(context: &Context) -> Result<()> {
    let device = context.device();
    check_validated(context)?;
    // Core: usage must not be empty (VUID-VkBufferCreateInfo-usage-requiredbitmask).
    let info = vk::BufferCreateInfo::default().size(16).sharing_mode(vk::SharingMode::EXCLUSIVE);
    // SAFETY: this call breaks its valid usage on purpose: `usage` is empty. The buffer is never bound or used, only
    // destroyed by its handle; drivers merely store a usage, and the layers report the call.
    let faulty = unsafe {
        let raw = device.raw().create_buffer(&info, None).map_err(failed("vkCreateBuffer for the canary"))?;
        Handle::own(device, raw, "canary")
    };
    drop(faulty);

    // Synchronisation: transfer write → transfer write of the same bytes, which needs a TransferToTransfer barrier.
    // The hazard is found while recording; the recorder is dropped, so it never runs.
    let target = Buffer::new(context, "canary target", 64, BufferUse::default(), Memory::Device)?;
    let mut recorder = Recorder::new(context, "canary")?;
    recorder.fill(&target, 0, 64, 1)?;
    recorder.fill(&target, 0, 64, 2)
}

/// Leaves a fence and a piece of memory behind, which nothing owns: when the last clone of the context goes, the
/// layers report the fence and the device reports the memory. Refused without validation.
pub fn leak(context: &Context) -> Result<()> {
    let device = context.device();
    check_validated(context)?;
    // SAFETY: the call is valid; what is not is vkDestroyDevice later, with this fence still there, which is the point.
    // The fence is never used, so a driver has nothing to do for it.
    unsafe { device.raw().create_fence(&vk::FenceCreateInfo::default(), None) }
        .map_err(failed("vkCreateFence for the canary"))?;
    let requirements = vk::MemoryRequirements { size: 64, alignment: 16, memory_type_bits: u32::MAX };
    let desc = AllocationCreateDesc {
        name: "canary memory",
        requirements,
        location: MemoryLocation::Unknown,
        linear: true,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    };
    // An `Allocation` is only a note of a place; dropping it gives nothing back.
    let allocated = device.memory().allocator.as_mut().map(|allocator| allocator.allocate(&desc).map(drop));
    match allocated {
        Some(Ok(())) => Ok(()),
        failure => Err(Error::Internal(format!("the canary got no memory: {failure:?}"))),
    }
}

fn check_validated(context: &Context) -> Result<()> {
    match context.device().instance.validates() {
        true => Ok(()),
        false => Err(Error::Internal("the canary needs a context under validation".to_string())),
    }
}
