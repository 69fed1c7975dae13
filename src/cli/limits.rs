//! The limits of a device that matter to a render, each with what it means here.
//!
//! Comes in: what the device says of itself. Goes out: lines of at most 80 columns for `texray devices`.

use texray::gpu::DeviceInfo;
use texray::interface::{PUSH_CONSTANT_BYTES, RECORD_BINDINGS};
use texray::render::kernel::WRITTEN_BINDINGS;
use texray::render::tiles::path_bytes;

/// Entries of a traversal stack that a scene of some hundred thousand triangles needs.
const TYPICAL_STACK: u32 = 10;

/// One line a limit: name, value, meaning.
pub fn lines(info: &DeviceInfo) -> Vec<String> {
    let tile = info.max_storage_buffer_range.min(info.max_memory_allocation_size) / path_bytes(TYPICAL_STACK);
    let memory = info.device_heap_bytes();
    let vote = match (info.subgroup_ballot, info.subgroup_vote) {
        (true, _) => "ballot: lanes refill together",
        (false, _) => "no ballot: the plain kernel is used",
    };
    let storage_buffers = RECORD_BINDINGS + WRITTEN_BINDINGS.len() as u32;
    let rows = [
        ("Vulkan", info.api_version.clone(), "1.1 is enough".to_owned()),
        (
            "texel buffer",
            format!("{} texels", info.max_texel_buffer_elements),
            format!("records, path states: {} a buffer", bytes(16 * info.max_texel_buffer_elements)),
        ),
        (
            "storage buffer",
            bytes(info.max_storage_buffer_range),
            format!("path states of some {} kpixels at a time", tile / 1000),
        ),
        ("allocation", bytes(info.max_memory_allocation_size), "largest buffer of any kind".to_owned()),
        ("device memory", bytes(memory), "half of it for path states at most".to_owned()),
        ("storage bindings", info.max_per_stage_storage_buffers.to_string(), format!("{storage_buffers} needed")),
        ("push constants", format!("{} bytes", info.max_push_constants_bytes), format!("{PUSH_CONSTANT_BYTES} needed")),
        ("subgroup", format!("{} lanes", info.subgroup_size), vote.to_owned()),
        (
            "timestamps",
            format!("{} bits", info.timestamp_valid_bits),
            match info.timestamp_valid_bits {
                0 => "none: times are those of the host".to_owned(),
                _ => format!("of {} ns: copies are timed on the device", info.timestamp_period_ns),
            },
        ),
        (
            "robust access",
            if info.robust_buffer_access2 { "2" } else { "1" }.to_owned(),
            "an index out of range reads no other memory".to_owned(),
        ),
    ];
    rows.into_iter().map(|(name, value, meaning)| format!("   {name:<17} {value:<18} {meaning}")).collect()
}

fn bytes(bytes: u64) -> String {
    match bytes {
        0..0x10_0000 => format!("{} KiB", bytes >> 10),
        0x10_0000..0x4000_0000 => format!("{} MiB", bytes >> 20),
        _ => format!("{:.1} GiB", bytes as f64 / f64::from(1 << 30)),
    }
}
