//! A buffer that shaders read as texels.
//!
//! Comes in: a size. Goes out: a device buffer with a view of the format R32G32B32A32_UINT, which a shader reads through
//! a `utextureBuffer`. Vulkan promises this format for uniform texel buffers on every device. A shader may also write such a
//! buffer, by a binding of its own, where it was made as a storage buffer too.

use std::fmt;
use std::sync::Arc;

use ash::vk;

use super::context::Context;
use super::failure::failed;
use super::handle::Handle;
use super::memory::{Buffer, BufferUse, Memory, TEXEL_BYTES};
use crate::Result;

/// A device buffer and its texel view.
pub struct TexelBuffer {
    // The view goes before the buffer that it looks at.
    view: Handle<vk::BufferView>,
    buffer: Arc<Buffer>,
}

impl TexelBuffer {
    /// Whether the device allows a texel buffer of `size_bytes`.
    pub fn fits(context: &Context, size_bytes: u64) -> bool {
        size_bytes.div_ceil(TEXEL_BYTES) <= context.device_info().max_texel_buffer_elements
    }

    /// Makes a texel buffer of `size_bytes`, rounded up to whole texels of 16 bytes. Refused, by name, where the device
    /// has a smaller `maxTexelBufferElements`.
    pub fn new(context: &Context, name: &str, size_bytes: u64) -> Result<Arc<TexelBuffer>> {
        TexelBuffer::with(context, name, size_bytes, BufferUse { texel: true, storage: false })
    }

    /// The same, to be written by shaders as well: [`TexelBuffer::buffer`] can be bound as a storage buffer.
    pub fn written_by_shaders(context: &Context, name: &str, size_bytes: u64) -> Result<Arc<TexelBuffer>> {
        TexelBuffer::with(context, name, size_bytes, BufferUse { texel: true, storage: true })
    }

    fn with(context: &Context, name: &str, size_bytes: u64, uses: BufferUse) -> Result<Arc<TexelBuffer>> {
        let buffer = Buffer::new(context, name, size_bytes, uses, Memory::Device)?;
        let info = vk::BufferViewCreateInfo::default()
            .buffer(buffer.raw())
            // Integers, also where lanes hold floats: a small integer read as a float would be a denormal, which a
            // device may flush to zero. Shaders recover floats by their bits.
            .format(vk::Format::R32G32B32A32_UINT)
            .offset(0)
            .range(vk::WHOLE_SIZE);
        let device = context.device();
        // SAFETY: the buffer has the texel usage, is bound to memory and outlives the view (order of the fields); its
        // size is whole texels, within maxTexelBufferElements. The handle is the view's only owner.
        let view = unsafe {
            let view = device.raw().create_buffer_view(&info, None);
            let view = view.map_err(failed(format!("vkCreateBufferView for `{name}`")))?;
            Handle::own(device, view, &format!("{name} view"))
        };
        Ok(Arc::new(TexelBuffer { view, buffer }))
    }

    /// The buffer, to copy to and from.
    pub fn buffer(&self) -> &Arc<Buffer> {
        &self.buffer
    }

    pub(super) fn view(&self) -> vk::BufferView {
        self.view.raw()
    }
}

impl fmt::Debug for TexelBuffer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Texel{:?}", self.buffer)
    }
}
