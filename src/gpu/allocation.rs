//! Pieces of device memory.
//!
//! Comes in: what a buffer needs, and who must reach it. Goes out: an [`Allocated`] piece, counted by heap, which is given
//! back when dropped; or an error that names the buffer, need and have. Small pieces share blocks of the allocator.
//!
//! Memory types, best first:
//! - `Device`: device-local.
//! - `Upload`: host-visible and coherent, outside the device's own memory: the host writes it once, front to back, and
//!   the device reads it once, while copying.
//! - `Host`: the one that is asked for, if the host reaches it.
//! - `Readback`: the same and host-cached: uncached memory is read by the host at a crawl.
//!
//! Host-visible memory is always coherent here (Vulkan promises that such a type exists), so there is nothing to flush
//! after a host write or to invalidate before a host read.

use std::sync::Arc;

use ash::vk;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use gpu_allocator::{AllocationError, MemoryLocation};

use super::address_space;
use super::device::{DEVICE_BLOCK_BYTES, Device};
use super::memory::Memory;
use crate::{Error, Result};

/// A piece of memory of the allocator; given back when dropped.
pub(super) struct Allocated {
    pub(super) allocation: Allocation,
    pub(super) memory_type: usize,
    device: Arc<Device>,
}

impl Allocated {
    pub(super) fn new(
        device: &Arc<Device>,
        name: &str,
        needs: vk::MemoryRequirements,
        memory: Memory,
    ) -> Result<Allocated> {
        let (memory_type, heap) = choose_type(device, needs.memory_type_bits, memory)?;
        let heap_size = device.info.heaps[heap].bytes;
        let mut state = device.memory();
        let limit = |used: u64| Error::Limit {
            what: format!("buffer `{name}` (memory heap {heap})"),
            need: format!("{} bytes", needs.size),
            have: format!("{} of {heap_size} bytes", heap_size.saturating_sub(used)),
        };
        let used = state.heap_bytes[heap];
        if used.saturating_add(needs.size) > heap_size {
            return Err(limit(used));
        }
        let allocator = state.allocator.as_mut().ok_or_else(|| Error::Internal("no allocator".to_string()))?;
        let allocated = allocator.allocate(&AllocationCreateDesc {
            name,
            // The type is chosen above; the mask leaves the allocator no other, and `Unknown` asks for no more of it.
            requirements: vk::MemoryRequirements { memory_type_bits: 1 << memory_type, ..needs },
            location: MemoryLocation::Unknown,
            // A buffer has no tiling: the allocator need not keep it apart from tiled images.
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        });
        let allocation = allocated.map_err(|error| match error {
            // The heap has room, as seen above: the system has not.
            AllocationError::OutOfMemory => Error::Limit {
                what: format!("buffer `{name}` (memory heap {heap}, of which {used} of {heap_size} bytes are taken)"),
                need: format!("{} bytes, or a block to share of up to {} bytes", needs.size, DEVICE_BLOCK_BYTES),
                have: format!("less: the driver gets no more from the system{}", address_space::in_words()),
            },
            error => Error::Vulkan { call: format!("allocating memory for `{name}`"), code: error.to_string() },
        })?;
        state.heap_bytes[heap] += allocation.size();
        let local = state.heap_bytes.iter().zip(&device.info.heaps).filter(|(_, heap)| heap.device_local);
        let device_bytes = local.map(|(bytes, _)| bytes).sum::<u64>();
        state.device_bytes_peak = state.device_bytes_peak.max(device_bytes);
        drop(state);
        let allocated = Allocated { allocation, memory_type, device: device.clone() };
        address_space::check_after(&device.info, name)?;
        Ok(allocated)
    }
}

impl Drop for Allocated {
    fn drop(&mut self) {
        let heap = self.device.memory_types[self.memory_type].heap_index as usize;
        let allocation = std::mem::take(&mut self.allocation);
        let mut state = self.device.memory();
        state.heap_bytes[heap] = state.heap_bytes[heap].saturating_sub(allocation.size());
        let freed = state.allocator.as_mut().map(|allocator| allocator.free(allocation));
        if let Some(Err(error)) = freed {
            self.device.instance.log.error(&format!("memory cannot be given back: {error}"));
        }
    }
}

/// Index and heap of the best memory type for `memory` among the allowed `type_bits`.
fn choose_type(device: &Device, type_bits: u32, memory: Memory) -> Result<(usize, usize)> {
    const LOCAL: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::DEVICE_LOCAL;
    const NONE: vk::MemoryPropertyFlags = vk::MemoryPropertyFlags::empty();
    let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
    let cached = host | vk::MemoryPropertyFlags::HOST_CACHED;
    // Wanted and unwanted properties, best first.
    let asked_for = if let Memory::Host(index) = memory { Some(index) } else { None };
    let wishes: &[_] = match memory {
        Memory::Device => &[(LOCAL, NONE), (NONE, NONE)],
        Memory::Upload => &[(host, LOCAL), (host, NONE)],
        Memory::Host(_) => &[(host, NONE)],
        Memory::Readback => &[(cached, LOCAL), (cached, NONE), (host, NONE)],
    };
    let types = &device.memory_types;
    let fits = |index: usize, (wanted, unwanted): (vk::MemoryPropertyFlags, vk::MemoryPropertyFlags)| {
        let flags = types[index].property_flags;
        asked_for.is_none_or(|asked_for| asked_for == index)
            && type_bits & (1 << index) != 0
            && flags.contains(wanted)
            && !flags.intersects(unwanted)
    };
    let found = wishes.iter().find_map(|&wish| (0..types.len()).find(|&index| fits(index, wish)));
    let index = found.ok_or_else(|| Error::NoDevice(format!("{} has no memory type for buffers", device.info.name)))?;
    Ok((index, types[index].heap_index as usize))
}
