//! Host memory: what the system still has, and refusals with need and have before anything is allocated.
//!
//! Comes in: a need in bytes. Goes out: nothing, or [`Error::Limit`]. Where the system does not say what is available
//! (no `/proc/meminfo`), only the allocator itself can refuse.

use crate::{Error, Result};

/// Bytes that the system can hand out without swapping, where it says so.
pub fn available() -> Option<u64> {
    parse(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

fn parse(meminfo: &str) -> Option<u64> {
    let rest = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    rest.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Refuses `what` where it needs more bytes than are available.
pub fn check(what: &str, need: u64) -> Result<()> {
    match available() {
        Some(have) if need > have => Err(limit(what, need, &mebibytes(have))),
        _ => Ok(()),
    }
}

/// Refuses `what` where the allocator cannot give `count` items of `T`; nothing stays allocated.
pub fn probe<T>(what: &str, count: usize) -> Result<()> {
    let need = (size_of::<T>() as u64).saturating_mul(count as u64);
    Vec::<T>::new().try_reserve_exact(count).map_err(|_| limit(what, need, "less (the allocator refuses)"))
}

fn limit(what: &str, need: u64, have: &str) -> Error {
    Error::Limit { what: what.into(), need: mebibytes(need), have: have.into() }
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / (1u64 << 20) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_meminfo() {
        assert_eq!(parse("MemTotal: 10 kB\nMemAvailable:    2048 kB\n"), Some(2 << 20));
        assert_eq!(parse("MemTotal: 10 kB\n"), None);
        assert_eq!(parse("MemAvailable: many kB\n"), None);
    }

    #[test]
    fn refuses_what_cannot_be() {
        let error = probe::<[i128; 3]>("a film", usize::MAX).unwrap_err();
        assert!(matches!(&error, Error::Limit { what, .. } if what == "a film"), "{error}");
    }
}
