//! Errors made on purpose, to prove that validation is listening.
//!
//! Comes in: a context under validation. Goes out: two messages in its report, one of core validation and one of
//! synchronisation validation. Without this a test that finds no message could mean that nobody looked.

use ash::vk;

use super::commands::Recorder;
use super::context::Context;
use super::failure::failed;
use super::handle::Handle;
use super::memory::{Buffer, BufferUse, Memory};
use crate::Result;

/// Makes one core error (a buffer without any usage) and one synchronisation hazard (two fills of one buffer with no
/// barrier between them). Neither is ever used or run by the device, and nothing is left behind.
pub fn provoke(context: &Context) -> Result<()> {
    let device = context.device();
    // Core: usage must not be empty (VUID-VkBufferCreateInfo-usage-requiredbitmask).
    let info = vk::BufferCreateInfo::default().size(16).sharing_mode(vk::SharingMode::EXCLUSIVE);
    // SAFETY: this call breaks its valid usage on purpose: `usage` is empty. The buffer is never bound or used, only
    // destroyed by its handle, and drivers only store the usage. Run this under validation and in tests only.
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
