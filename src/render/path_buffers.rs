//! The buffers of a tile's unfinished pixels: their path states, and the lists of which they are.
//!
//! Comes in: the tile's size and the stack's. Goes out: what to bind. A dispatch writes the states as storage, and the next one reads
//! them as texels: four lanes a fetch, where storage is read word by word. Both are bindings of one buffer. Where it has more
//! texels than the device allows a view, or texel buffers are not wanted, it is read as storage, too. May be assumed: on a CPU
//! device no state of a path is in the buffer before a dispatch has stored one.

use std::sync::Arc;

use crate::error::Result;
use crate::gpu::{Buffer, BufferUse, Context, DeviceKind, InFlight, Memory, Recorder, Resource, TexelBuffer};
use crate::interface::{BINDING_LISTS, BINDING_PATHS, BINDING_PATHS_WRITTEN};
use crate::render::tiles::{LIST_BYTES, path_bytes};
use crate::settings::Buffers;

/// Each word of a state before it is stored. No path has such a one: its phase says that it has finished, its throughput is not a
/// number and its stack is too large, so a state that was read before it was stored would show.
const NO_STATE: u32 = 0xffff_ffff;

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
        let read_as = read_as(wanted, TexelBuffer::fits(context, bytes));
        let (view, written) = match read_as {
            Buffers::Texel => {
                let view = TexelBuffer::written_by_shaders(context, "path states", bytes)?;
                let buffer = view.buffer().clone();
                (view, buffer)
            }
            Buffers::Storage => (null_texel.clone(), storage("path states", bytes)?),
        };
        let resources = [
            (BINDING_PATHS, Resource::Texel(view)),
            (BINDING_PATHS_WRITTEN, Resource::Storage(written.clone())),
            (BINDING_LISTS, Resource::Storage(storage("lists of pixels", pixels * LIST_BYTES)?)),
        ];
        Ok(PathBuffers { resources, written, read_as })
    }

    /// Has a CPU device write [`NO_STATE`] to the states: a system that hands out memory when it is first touched does so now, on
    /// another core than the one that makes the pipeline. Other devices have their memory, and need no fill.
    pub fn touch(&self, context: &Context) -> Result<Option<InFlight>> {
        if context.device_info().kind != DeviceKind::Cpu {
            return Ok(None);
        }
        let mut recorder = Recorder::new(context, "touch path states")?;
        recorder.fill(&self.written, 0, self.written.size_bytes(), NO_STATE)?;
        recorder.submit().map(Some)
    }

    /// What to bind, by binding number.
    pub fn resources(&self) -> &[(u32, Resource)] {
        &self.resources
    }
}

/// How states are read that are to be read as `wanted` and fit a texel buffer, or do not.
fn read_as(wanted: Buffers, fits_texels: bool) -> Buffers {
    if fits_texels { wanted } else { Buffers::Storage }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_texels_where_they_are_wanted_and_fit() {
        let [texel, storage] = [Buffers::Texel, Buffers::Storage];
        let cases =
            [(texel, true, texel), (texel, false, storage), (storage, true, storage), (storage, false, storage)];
        for (wanted, fits, expected) in cases {
            assert_eq!(read_as(wanted, fits), expected, "{wanted:?} {fits}");
        }
    }
}
