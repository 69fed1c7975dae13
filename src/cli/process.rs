//! What the system says about this process.
//!
//! Comes in: `/proc/self/status`. Goes out: peak memory and ignored signals, where there is such a file (Linux).

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
