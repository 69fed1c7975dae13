//! What the system says about this process.
//!
//! Comes in: `/proc/self/status` and limits. Goes out: peak memory and ignored signals, where there is such a file
//! (Linux); as many threads as the limits allow.

/// Begins no more threads of the library than a limit of the address space has room for: without it, the first work
/// for many threads would end in a panic. Without such a limit they begin when they are needed.
pub fn limit_threads() {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = texray::memory::threads();
    if threads < cores {
        // Fails only where the threads are there already.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
    }
}

/// Largest resident memory so far, in bytes.
pub fn peak_rss_bytes() -> Option<u64> {
    status("VmHWM:")?.strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Whether whoever started this process wants it to ignore `signal`, as `nohup` does.
pub fn ignores(signal: i32) -> bool {
    let mask = status("SigIgn:").and_then(|mask| u64::from_str_radix(&mask, 16).ok()).unwrap_or(0);
    (1..=64).contains(&signal) && mask >> (signal - 1) & 1 == 1
}

fn status(key: &str) -> Option<String> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(key))?;
    Some(line.trim().to_string())
}
