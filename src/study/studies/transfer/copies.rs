//! One copy, many times.
//!
//! Comes in: a way to copy, a size. Goes out: gigabytes a second, warmed up. A staged copy up is the host's write to the ring and the
//! device's copy from it; one down is the device's copy and the host's read of it.

use std::hint::black_box;
use std::time::Instant;

use crate::Result;
use crate::gpu::{
    Buffer, BufferUse, Context, HostBuffer, HostMemoryType, InFlight, Ledger, Memory, Readback, Recorder, Uploader,
};
use crate::study::engine::Values;

/// Bytes that a measurement moves at least.
const MOVED_BYTES: u64 = 64 << 20;
/// Copies that it makes at most.
const MOST_COPIES: u64 = 256;
/// Bytes of a chunk of the ring, as a render has them.
const CHUNK_BYTES: u64 = 4 << 20;

/// A way to move bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Copy {
    /// From the host through a ring of so many chunks to a texel buffer or a storage buffer.
    Up {
        /// Chunks of the ring.
        in_flight: usize,
        /// Whether it is a texel buffer.
        texel: bool,
    },
    /// From a storage buffer to the host, so many copies submitted before the first is read.
    Down {
        /// Readbacks in turn.
        in_flight: usize,
    },
    /// The host's write to memory of this type, in place.
    Write {
        /// Its place in the list of types.
        memory_type: usize,
    },
    /// The host's read of memory of this type, in place.
    Read {
        /// Its place in the list of types.
        memory_type: usize,
    },
}

impl Copy {
    /// Every way, on a device with so many memory types that the host reaches.
    pub fn all(memory_types: usize) -> Vec<Copy> {
        let up = |texel| [1, 2].map(|in_flight| Copy::Up { in_flight, texel });
        let down = [1, 2].map(|in_flight| Copy::Down { in_flight });
        let mut all = [up(true), up(false), down].concat();
        for memory_type in 0..memory_types {
            all.extend([Copy::Write { memory_type }, Copy::Read { memory_type }]);
        }
        all
    }

    /// Its name in rows.
    pub fn name(&self, memory: &[HostMemoryType]) -> String {
        let of_type = |place: usize| memory.get(place).map_or("?", |memory_type| memory_type.name.as_str());
        match self {
            Copy::Up { in_flight, texel } => {
                format!("up, staged, {in_flight} in flight, {}", if *texel { "texel" } else { "storage" })
            }
            Copy::Down { in_flight } => format!("down, staged, {in_flight} in flight"),
            Copy::Write { memory_type } => format!("up, direct, {}", of_type(*memory_type)),
            Copy::Read { memory_type } => format!("down, direct, {}", of_type(*memory_type)),
        }
    }

    /// Whether a texel buffer is the target.
    pub fn is_texel(&self) -> bool {
        matches!(self, Copy::Up { texel: true, .. })
    }

    /// Moves `bytes` bytes again and again, once before the clock starts.
    pub fn measure(self, context: &Context, memory: &[HostMemoryType], bytes: u64) -> Result<Values> {
        let copies = (MOVED_BYTES / bytes).clamp(1, MOST_COPIES);
        let host = vec![0x5au8; bytes as usize];
        let mut ledger = Ledger::default();
        let seconds = match self {
            Copy::Up { in_flight, texel } => {
                let uses = BufferUse { texel, storage: !texel };
                let target = Buffer::new(context, "target", bytes, uses, Memory::Device)?;
                let mut uploader = Uploader::with_ring(context, in_flight, CHUNK_BYTES)?;
                timed(copies, |count| {
                    for _ in 0..count {
                        uploader.upload(&mut ledger, &target, 0, &host, "measured")?;
                    }
                    uploader.finish()
                })?
            }
            Copy::Down { in_flight } => down(context, &mut ledger, &host, in_flight, copies)?,
            Copy::Write { memory_type } => {
                let mut target = HostBuffer::new(context, &memory[memory_type], bytes)?;
                timed(copies, |count| (0..count).try_for_each(|_| target.write(black_box(&host))))?
            }
            Copy::Read { memory_type } => {
                let mut source = HostBuffer::new(context, &memory[memory_type], bytes)?;
                source.write(&host)?;
                let mut into = host.clone();
                timed(copies, |count| {
                    for _ in 0..count {
                        into.copy_from_slice(&source.bytes()?[..bytes as usize]);
                        black_box(&mut into);
                    }
                    Ok(())
                })?
            }
        };
        let moved = (copies * bytes) as f64;
        Ok(vec![
            ("bytes", bytes as f64),
            ("copies", copies as f64),
            ("gb_per_second", moved / seconds / 1e9),
            ("us_per_copy", 1e6 * seconds / copies as f64),
        ])
    }
}

/// Seconds of `copies` copies, after one that does not count.
fn timed(copies: u64, mut run: impl FnMut(u64) -> Result<()>) -> Result<f64> {
    run(1)?;
    let start = Instant::now();
    run(copies)?;
    Ok(start.elapsed().as_secs_f64().max(1e-9))
}

/// Copies a device buffer down; the oldest of `in_flight` copies is waited for and read before its readback is used again.
fn down(context: &Context, ledger: &mut Ledger, host: &[u8], in_flight: usize, copies: u64) -> Result<f64> {
    let bytes = host.len() as u64;
    let uses = BufferUse { texel: false, storage: true };
    let source = Buffer::new(context, "source", bytes, uses, Memory::Device)?;
    let mut uploader = Uploader::new(context)?;
    uploader.upload(ledger, &source, 0, host, "what is read back")?;
    uploader.finish()?;
    let mut readbacks: Vec<(Readback, Option<InFlight>)> = Vec::new();
    for _ in 0..in_flight {
        readbacks.push((Readback::new(context, "readback", bytes)?, None));
    }
    let mut into = vec![0u8; host.len()];
    let mut read = |(readback, copy): &mut (Readback, Option<InFlight>)| -> Result<()> {
        if let Some(copy) = copy.take() {
            copy.wait()?;
            into.copy_from_slice(readback.bytes()?);
            black_box(&mut into);
        }
        Ok(())
    };
    timed(copies, |count| {
        for copy in 0..count {
            let slot = &mut readbacks[copy as usize % in_flight];
            read(slot)?;
            let mut recorder = Recorder::new(context, "readback")?;
            slot.0.copy_from(&mut recorder, ledger, &source, 0, 0, bytes, "measured")?;
            slot.1 = Some(recorder.submit()?);
        }
        readbacks.iter_mut().try_for_each(&mut read)
    })
}
