//! The buffers of a tile's unfinished pixels: their path states, and the lists of which they are.
//!
//! Comes in: the tile's size and the stack's. Goes out: what to bind. A dispatch writes the states as storage, and the next one reads
//! them as texels: four lanes a fetch, where storage is read word by word. Both are bindings of one buffer. Where it has more
//! texels than the device allows a view, or texel buffers are not wanted, it is read as storage, too.

use std::sync::Arc;

use crate::error::Result;
use crate::gpu::{Buffer, BufferUse, Context, InFlight, Memory, Recorder, Resource, TexelBuffer};
use crate::interface::{BINDING_LISTS, BINDING_PATHS, BINDING_PATHS_WRITTEN};
use crate::render::tiles::{LIST_BYTES, path_bytes};
use crate::settings::Buffers;

/// Path states and lists of a tile.
pub struct PathBuffers {
    resources: [(u32, Resource); 3],
    written: Arc<Buffer>,
    /// How the states are read.
    pub read_as: Buffers,
}

impl PathBuffers {
    /// Makes the buffers for `pixels` pixels with traversal stacks of `stack_entries`, to be read as `wanted` where the device can.
    /// `null_texel` is bound where there is no view.
    pub fn new(
        context: &Context,
        pixels: u64,
        stack_entries: u32,
        wanted: Buffers,
        null_texel: &Arc<TexelBuffer>,
    ) -> Result<PathBuffers> {
        let storage =
            |name, bytes| Buffer::new(context, name, bytes, BufferUse { texel: false, storage: true }, Memory::Device);
        let bytes = pixels * path_bytes(stack_entries);
        let fits = TexelBuffer::fits(context, bytes);
        let (read_as, view, written) = if wanted == Buffers::Texel && fits {
            let view = TexelBuffer::written_by_shaders(context, "path states", bytes)?;
            let buffer = view.buffer().clone();
            (Buffers::Texel, view, buffer)
        } else {
            (Buffers::Storage, null_texel.clone(), storage("path states", bytes)?)
        };
        let resources = [
            (BINDING_PATHS, Resource::Texel(view)),
            (BINDING_PATHS_WRITTEN, Resource::Storage(written.clone())),
            (BINDING_LISTS, Resource::Storage(storage("lists of pixels", pixels * LIST_BYTES)?)),
        ];
        Ok(PathBuffers { resources, written, read_as })
    }

    /// Has the device clear the states, which need not be clear: a system that hands out memory when it is first touched does so
    /// now, on another core than the one that makes the pipeline.
    pub fn clear(&self, context: &Context) -> Result<InFlight> {
        let mut recorder = Recorder::new(context, "clear path states")?;
        recorder.fill(&self.written, 0, self.written.size_bytes(), 0)?;
        recorder.submit()
    }

    /// What to bind, by binding number.
    pub fn resources(&self) -> &[(u32, Resource)] {
        &self.resources
    }
}
