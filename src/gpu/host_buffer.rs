//! Memory of one type that the host writes and reads in place, to measure what that takes.
//!
//! Comes in: a memory type. Goes out: a buffer that no work of the device ever uses, so that the host may touch it at any time. A
//! render has no such buffer: what it uploads goes through [`Uploader`](super::Uploader), what comes back through
//! [`Readback`](super::Readback).

use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::memory::{Buffer, BufferUse, Memory};
use crate::Result;

/// A memory type that the host can reach.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HostMemoryType {
    index: usize,
    /// What tells it from the others, such as "device-local cached 0", the last its heap: all are host-visible and coherent.
    pub name: String,
}

/// Every memory type for buffers that is host-visible and coherent.
pub fn host_memory_types(context: &Context) -> Vec<HostMemoryType> {
    let host = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
    let types = context.device().memory_types.iter().enumerate();
    let reachable = types.filter(|(_, memory_type)| memory_type.property_flags.contains(host));
    // One that buffers cannot have makes no buffer.
    reachable
        .filter_map(|(index, _)| {
            let buffer = HostBuffer::in_type(context, index, 16).ok()?;
            let name = buffer.buffer.memory_type().replace("host-visible ", "").replace("coherent", "");
            Some(HostMemoryType { index, name: name.replace(", heap", "").replace("  ", " ") })
        })
        .collect()
}

/// A buffer for the host alone.
pub struct HostBuffer {
    buffer: Arc<Buffer>,
}

impl HostBuffer {
    /// Makes a buffer of `bytes` bytes in memory of this type.
    pub fn new(context: &Context, memory_type: &HostMemoryType, bytes: u64) -> Result<HostBuffer> {
        HostBuffer::in_type(context, memory_type.index, bytes)
    }

    fn in_type(context: &Context, index: usize, bytes: u64) -> Result<HostBuffer> {
        let buffer = Buffer::new(context, "host buffer", bytes, BufferUse::default(), Memory::Host(index))?;
        Ok(HostBuffer { buffer })
    }

    /// Writes `bytes` at its start.
    pub fn write(&mut self, bytes: &[u8]) -> Result<()> {
        // SAFETY: no device work knows the buffer, which this value alone has, and `&mut self` keeps other threads away.
        unsafe { self.buffer.write_from_host(bytes) }
    }

    /// Its bytes; undefined where nothing was written.
    pub fn bytes(&self) -> Result<&[u8]> {
        // SAFETY: no device work knows the buffer, and a write by the host needs `&mut self`, which the result excludes.
        unsafe { self.buffer.read_by_host() }
    }
}
