//! The barriers that the renderer needs, each from a writer to a reader.
//!
//! Comes in: nothing but the name of a barrier. Goes out: its stages and accesses. Commands of a queue start in order
//! but run and finish in any order, and what one wrote may sit in a cache that the next does not look at: a barrier makes
//! the second wait for the first, and makes the first one's writes visible to it.
//!
//! Each is a global memory barrier, over all buffers: with one queue and few commands at a time a barrier on one buffer
//! would let nothing more overlap. It covers all commands before it on the queue, earlier submits included.
//!
//! There is no barrier from host writes to copies: `vkQueueSubmit` itself makes visible what the host wrote before it.

use ash::vk;

/// A barrier by its writer and reader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Barrier {
    /// Copies and fills → a dispatch that reads, or adds to, what they wrote. Without it the dispatch may read the bytes
    /// from before the copy.
    TransferToCompute,
    /// A dispatch → the next one, which reads or writes the same buffers, by whatever binding. Without it both may run at
    /// once, and the later one miss path states, lists or sums of the earlier, or be overwritten by it.
    ComputeToCompute,
    /// A dispatch → copies or fills. Without it a copy may take sums that are still being written, or a fill clear
    /// counters that the dispatch is still reading.
    ComputeToTransfer,
    /// Copies and fills → copies or fills of the same bytes. Without it the two writes may land in either order.
    TransferToTransfer,
    /// Copies → the host, after its wait for the fence. Without it the fence says that the copy is done, not that the
    /// bytes have left the device's caches for memory that the host sees.
    TransferToHost,
}

/// One side of a barrier: which stages, and which of their accesses.
type Side = (vk::PipelineStageFlags, vk::AccessFlags);

const COMPUTE_WRITES: Side = (vk::PipelineStageFlags::COMPUTE_SHADER, vk::AccessFlags::SHADER_WRITE);
// Reads of texel buffers and of storage buffers are both SHADER_READ; an atomic is a read and a write.
const COMPUTE_USES: Side = (
    vk::PipelineStageFlags::COMPUTE_SHADER,
    vk::AccessFlags::from_raw(vk::AccessFlags::SHADER_READ.as_raw() | vk::AccessFlags::SHADER_WRITE.as_raw()),
);
const TRANSFER_WRITES: Side = (vk::PipelineStageFlags::TRANSFER, vk::AccessFlags::TRANSFER_WRITE);
const TRANSFER_USES: Side = (
    vk::PipelineStageFlags::TRANSFER,
    vk::AccessFlags::from_raw(vk::AccessFlags::TRANSFER_READ.as_raw() | vk::AccessFlags::TRANSFER_WRITE.as_raw()),
);
const HOST_READS: Side = (vk::PipelineStageFlags::HOST, vk::AccessFlags::HOST_READ);

impl Barrier {
    /// The writer's and the reader's side. A writer's side names writes alone: a read before a write needs the waiting,
    /// which the stages give, and leaves nothing to make visible.
    pub(super) fn sides(self) -> [Side; 2] {
        match self {
            Barrier::TransferToCompute => [TRANSFER_WRITES, COMPUTE_USES],
            Barrier::ComputeToCompute => [COMPUTE_WRITES, COMPUTE_USES],
            Barrier::ComputeToTransfer => [COMPUTE_WRITES, TRANSFER_USES],
            Barrier::TransferToTransfer => [TRANSFER_WRITES, TRANSFER_USES],
            Barrier::TransferToHost => [TRANSFER_WRITES, HOST_READS],
        }
    }

    /// The barrier as a ledger shows it.
    pub fn text(self) -> &'static str {
        match self {
            Barrier::TransferToCompute => "transfer write -> compute shader read/write",
            Barrier::ComputeToCompute => "compute shader write -> compute shader read/write",
            Barrier::ComputeToTransfer => "compute shader write -> transfer read/write",
            Barrier::TransferToTransfer => "transfer write -> transfer read/write",
            Barrier::TransferToHost => "transfer write -> host read",
        }
    }
}
