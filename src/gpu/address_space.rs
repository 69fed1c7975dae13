//! The process's address space: how much of it is left under `ulimit -v`.
//!
//! Comes in: what the driver, or a buffer, is about to take. Goes out: nothing, or [`Error::Limit`] with need and
//! have. A driver for the CPU compiles kernels inside the process, and where its compiler or one of its threads gets
//! no memory it ends the process or waits for ever: so it is asked for nothing that there is no room for. Where there
//! is no limit, or the system does not say what is taken, nothing is refused here.

use super::device_info::{DeviceInfo, DeviceKind};
use super::driver_threads::POOLS;
use crate::memory::address_space_left;
use crate::{Error, Result};

const MIB: u64 = 1 << 20;

// Measured with lavapipe 22.3 on two cores: see `docs/performance.md`, "Address space".
/// What the Vulkan loader and the drivers take when they are loaded, before there is a device.
const LOADED_BYTES: u64 = 240 * MIB;
/// What a driver for the CPU takes for a device beside its threads: the first blocks of buffers, and its compiler.
const DEVICE_BYTES: u64 = 144 * MIB;
/// What must be left for the compiler once a buffer is made.
const COMPILER_BYTES: u64 = 64 * MIB;
/// Beside the stack of a thread.
const GUARD_BYTES: u64 = 64 << 10;
/// Stack of a thread where the system sets no limit to it.
const STACK_BYTES: u64 = 8 * MIB;

/// Stack of a new thread of a driver, which takes the system's default.
#[cfg(unix)]
fn stack_bytes() -> u64 {
    // glibc has a default of its own where the limit is none.
    rustix::process::getrlimit(rustix::process::Resource::Stack).current.unwrap_or(STACK_BYTES)
}

#[cfg(not(unix))]
fn stack_bytes() -> u64 {
    STACK_BYTES
}

/// What `threads` threads of a driver's pools take.
fn pool_bytes(threads: usize) -> u64 {
    stack_bytes().saturating_add(GUARD_BYTES).saturating_mul((POOLS * threads) as u64)
}

/// Where address space is limited, has all threads share one piece of memory to allocate from: the C library else
/// reserves 64 MiB for each, and more where it cannot place them, of which a thread of a driver uses next to nothing.
pub(super) fn share_arenas() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    if address_space_left().is_some() {
        // SAFETY: any thread may call it at any time; it sets a number that is read when a thread allocates for the
        // first time.
        unsafe { libc::mallopt(libc::M_ARENA_MAX, 1) };
    }
}

/// The most threads, of at most `wanted`, for whose pools there is room before the drivers are loaded.
pub(super) fn threads_with_room(wanted: usize) -> usize {
    share_arenas();
    address_space_left().map_or(wanted, |left| threads_within(left, wanted))
}

fn threads_within(left: u64, wanted: usize) -> usize {
    let fits = |threads: usize| (LOADED_BYTES + DEVICE_BYTES).saturating_add(pool_bytes(threads)) <= left;
    (0..=wanted).rev().find(|&threads| fits(threads)).unwrap_or(0)
}

/// Refuses to load the Vulkan drivers where there is no room for them.
pub(super) fn check_loader() -> Result<()> {
    share_arenas();
    check("the Vulkan loader and drivers", LOADED_BYTES)
}

/// Refuses a device whose driver works inside the process, in so many threads, where there is no room for it.
pub(super) fn check_device(info: &DeviceInfo, threads: usize) -> Result<()> {
    if info.kind != DeviceKind::Cpu {
        return Ok(());
    }
    check(&format!("the driver of {}", info.name), DEVICE_BYTES + pool_bytes(threads))
}

/// Refuses the buffer `name`, for which memory was just taken, where the driver's compiler is left with too little.
pub(super) fn check_after(info: &DeviceInfo, name: &str) -> Result<()> {
    match info.kind {
        DeviceKind::Cpu => check(&format!("the driver's compiler, beside buffer `{name}`"), COMPILER_BYTES),
        _ => Ok(()),
    }
}

/// The limit in words, for a failure that may have to do with it; nothing where there is none.
pub(super) fn in_words() -> String {
    address_space_left()
        .map(|left| format!(" ({} of address space are left, ulimit -v)", mebibytes(left)))
        .unwrap_or_default()
}

fn check(what: &str, need: u64) -> Result<()> {
    refuse(what, need, address_space_left())
}

fn refuse(what: &str, need: u64, left: Option<u64>) -> Result<()> {
    match left {
        Some(have) if need > have => Err(Error::Limit {
            what: format!("address space (ulimit -v) for {what}"),
            need: format!("about {} MiB", need.div_ceil(MIB)),
            have: mebibytes(have),
        }),
        _ => Ok(()),
    }
}

fn mebibytes(bytes: u64) -> String {
    format!("{} MiB", bytes / MIB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_need_beyond_what_is_left_is_refused_with_both() {
        let refused = |need| refuse("a driver", need, Some(300 * MIB));
        assert!(refused(300 * MIB).is_ok() && refuse("a driver", u64::MAX, None).is_ok());
        let error = refused(300 * MIB + 1).unwrap_err();
        assert_eq!(error.exit_code(), 4);
        let said = "address space (ulimit -v) for a driver: about 301 MiB needed, 300 MiB available";
        assert_eq!(error.to_string(), said);
    }

    #[test]
    fn fewer_threads_take_less() {
        let least = LOADED_BYTES + DEVICE_BYTES;
        assert_eq!(threads_within(least - 1, 16), 0);
        assert_eq!(threads_within(least, 16), 0);
        assert_eq!(threads_within(least + pool_bytes(5), 16), 5);
        assert_eq!(threads_within(least + pool_bytes(5) - 1, 16), 4);
        assert_eq!(threads_within(u64::MAX, 16), 16);
    }
}
