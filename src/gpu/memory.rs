//! Buffers and the memory under them.
//!
//! Comes in: a size, what the buffer is for, and who must reach it. Goes out: a [`Buffer`] bound to memory, or an error
//! that names the buffer and the limit. Every buffer may be source and destination of copies.

use std::fmt;
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use ash::vk;

use super::allocation::Allocated;
use super::context::Context;
use super::device::Device;
use super::failure::failed;
use super::handle::Handle;
use crate::{Error, Result};

/// A texel is four 32-bit lanes; sizes are rounded up to whole texels, and to one at least, since Vulkan has no buffer
/// of size 0.
pub(super) const TEXEL_BYTES: u64 = 16;

/// What a buffer is bound as, beside being copied.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BufferUse {
    /// As a uniform texel buffer.
    pub texel: bool,
    /// As a storage buffer.
    pub storage: bool,
}

/// Who reaches a buffer's bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// The device alone.
    Device,
    /// The host writes, the device copies from it.
    Upload,
    /// The device copies into it, the host reads.
    Readback,
    /// The host alone, in the memory type of this index: to measure what that takes.
    Host(usize),
}

/// A buffer.
pub struct Buffer {
    // The buffer goes before the memory under it.
    raw: Handle<vk::Buffer>,
    allocated: Allocated,
    name: String,
    bytes: u64,
    uses: BufferUse,
    memory: Memory,
    /// Copies into this buffer that are recorded or in flight: while there is one the host may not read.
    pub(super) pending_writes: AtomicU32,
}

impl Buffer {
    /// Makes a buffer of `size_bytes`, rounded up to 16. `name` appears in errors, ledgers and validation messages.
    ///
    /// Its content is undefined until something is copied or filled in.
    pub fn new(context: &Context, name: &str, size_bytes: u64, uses: BufferUse, memory: Memory) -> Result<Arc<Buffer>> {
        let device = context.device();
        let bytes = size_bytes.max(1).checked_next_multiple_of(TEXEL_BYTES).unwrap_or(u64::MAX);
        let info = &device.info;
        let check = |limit: &str, need: u64, have: u64, unit: &str| match need > have {
            true => Err(Error::Limit {
                what: format!("buffer `{name}` ({limit})"),
                need: format!("{need} {unit}"),
                have: format!("{have} {unit}"),
            }),
            false => Ok(()),
        };
        if uses.texel {
            check("maxTexelBufferElements", bytes / TEXEL_BYTES, info.max_texel_buffer_elements, "texels")?;
        }
        if uses.storage {
            check("maxStorageBufferRange", bytes, info.max_storage_buffer_range, "bytes")?;
        }
        check("maxMemoryAllocationSize", bytes, info.max_memory_allocation_size, "bytes")?;

        let mut usage = vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST;
        if uses.texel {
            usage |= vk::BufferUsageFlags::UNIFORM_TEXEL_BUFFER;
        }
        if uses.storage {
            usage |= vk::BufferUsageFlags::STORAGE_BUFFER;
        }
        // EXCLUSIVE: one queue family uses it, so it never changes its owner.
        let create = vk::BufferCreateInfo::default().size(bytes).usage(usage).sharing_mode(vk::SharingMode::EXCLUSIVE);
        // SAFETY: size and usage are not zero; the new buffer is owned by the handle alone.
        let raw = unsafe {
            let raw = device.raw().create_buffer(&create, None);
            Handle::own(device, raw.map_err(failed(format!("vkCreateBuffer for `{name}`")))?, name)
        };
        // SAFETY: the buffer is alive.
        let requirements = unsafe { device.raw().get_buffer_memory_requirements(raw.raw()) };
        // The driver may ask for more than the buffer's size.
        check("maxMemoryAllocationSize", requirements.size, info.max_memory_allocation_size, "bytes")?;
        let allocated = Allocated::new(device, name, requirements, memory)?;
        // SAFETY: the buffer is not bound yet; memory type, size and alignment are the required ones; the memory
        // outlives the buffer (order of the fields below).
        unsafe {
            let memory = allocated.allocation.memory();
            device.raw().bind_buffer_memory(raw.raw(), memory, allocated.allocation.offset())
        }
        .map_err(failed(format!("vkBindBufferMemory for `{name}`")))?;
        let (name, pending_writes) = (name.to_string(), AtomicU32::new(0));
        Ok(Arc::new(Buffer { raw, allocated, name, bytes, uses, memory, pending_writes }))
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Its size: the one asked for, rounded up to 16.
    pub fn size_bytes(&self) -> u64 {
        self.bytes
    }

    /// Who reaches its bytes.
    pub fn memory(&self) -> Memory {
        self.memory
    }

    /// The memory it got, such as "device-local host-visible coherent, heap 0".
    pub fn memory_type(&self) -> String {
        let memory_type = self.device().memory_types[self.allocated.memory_type];
        let flags = [
            (vk::MemoryPropertyFlags::DEVICE_LOCAL, "device-local"),
            (vk::MemoryPropertyFlags::HOST_VISIBLE, "host-visible"),
            (vk::MemoryPropertyFlags::HOST_COHERENT, "coherent"),
            (vk::MemoryPropertyFlags::HOST_CACHED, "cached"),
        ];
        let has = |flag| memory_type.property_flags.contains(flag);
        let words: Vec<_> = flags.into_iter().filter(|(flag, _)| has(*flag)).map(|(_, word)| word).collect();
        format!("{}, heap {}", words.join(" "), memory_type.heap_index)
    }

    pub(super) fn uses(&self) -> BufferUse {
        self.uses
    }

    pub(super) fn raw(&self) -> vk::Buffer {
        self.raw.raw()
    }

    pub(super) fn device(&self) -> &Arc<Device> {
        self.raw.device()
    }

    /// Refuses a range that is not inside the buffer.
    pub(super) fn check_range(&self, offset: u64, bytes: u64) -> Result<()> {
        match offset.checked_add(bytes).is_some_and(|end| end <= self.bytes) {
            true => Ok(()),
            false => Err(Error::Internal(format!(
                "{bytes} bytes at {offset} of buffer `{}`, which has {}",
                self.name, self.bytes
            ))),
        }
    }

    /// Refuses a buffer that the host reaches: its bytes are safe to touch through `Uploader` and `Readback` only.
    pub(super) fn check_device_only(&self, what: &str) -> Result<()> {
        match self.memory {
            Memory::Device => Ok(()),
            memory => Err(Error::Internal(format!("buffer `{}` in {memory:?} memory cannot be {what}", self.name))),
        }
    }

    /// Writes `data` at the buffer's start.
    ///
    /// # Safety
    /// No device work that reads or writes the buffer is in flight, and no other thread touches its bytes.
    pub(super) unsafe fn write_from_host(&self, data: &[u8]) -> Result<()> {
        self.check_range(0, data.len() as u64)?;
        let target = self.mapped()?;
        // SAFETY: the memory is mapped for as long as it is allocated, and is at least `bytes` long; `data` cannot
        // overlap it, since a borrow of mapped memory is only ever given out by `read_by_host`, for other buffers.
        unsafe { std::ptr::copy_nonoverlapping(data.as_ptr(), target.as_ptr(), data.len()) };
        Ok(())
    }

    /// Writes zeros over all of the buffer.
    ///
    /// # Safety
    /// As for [`Buffer::write_from_host`].
    pub(super) unsafe fn clear_by_host(&self) -> Result<()> {
        let target = self.mapped()?;
        // SAFETY: mapped and long enough as above; nobody else touches the bytes, says the caller.
        unsafe { std::ptr::write_bytes(target.as_ptr(), 0, self.bytes as usize) };
        Ok(())
    }

    /// The buffer's bytes.
    ///
    /// # Safety
    /// While the result lives, no device work writes the buffer and no thread writes its bytes.
    pub(super) unsafe fn read_by_host(&self) -> Result<&[u8]> {
        let source = self.mapped()?;
        // SAFETY: mapped and long enough as above; nobody writes while the result lives, says the caller.
        Ok(unsafe { std::slice::from_raw_parts(source.as_ptr(), self.bytes as usize) })
    }

    /// Where the host sees the buffer's first byte.
    fn mapped(&self) -> Result<NonNull<u8>> {
        let mapped = self.allocated.allocation.mapped_ptr().map(NonNull::cast);
        let coherent = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        mapped.filter(|_| self.allocated.allocation.memory_properties().contains(coherent)).ok_or_else(|| {
            Error::Internal(format!("buffer `{}` is not in coherent memory that the host can reach", self.name))
        })
    }

    /// Whether the host may read: no copy into the buffer is recorded or in flight.
    pub(super) fn is_settled(&self) -> bool {
        // Acquire: what the wait for the device made visible is visible to this thread too.
        self.pending_writes.load(Ordering::Acquire) == 0
    }
}

impl fmt::Debug for Buffer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Buffer(`{}`, {} bytes, {:?})", self.name, self.bytes, self.memory)
    }
}
