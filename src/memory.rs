//! Host memory: what this process can still have, and refusals with need and have before anything is allocated.
//!
//! Comes in: a need in bytes. Goes out: nothing or a [`Reservation`], or [`Error::Limit`] that names the limit that is
//! short. A foundation below all stages, as [`crate::error`] is. What the process can have is the least of what the
//! system has, what the control groups of Linux leave it, and what its own limits (`ulimit -v`, `ulimit -d`) leave it.
//! Where none of them says (no `/proc`, as on other systems), only the allocator itself can refuse.

use std::fs::read_to_string;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::{Error, Result};

/// A limit on the memory of this process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bound {
    /// What the system can hand out without swapping.
    System,
    /// What the limit of the process's control group, or of one above it, leaves.
    ControlGroup,
    /// What `RLIMIT_AS` leaves of the address space.
    AddressSpace,
    /// What `RLIMIT_DATA` leaves of the data segment.
    Data,
}

impl Bound {
    /// What the bytes are part of, as messages say it.
    pub fn name(self) -> &'static str {
        match self {
            Bound::System => "of the system's memory",
            Bound::ControlGroup => "of the control group's memory",
            Bound::AddressSpace => "of the address space that RLIMIT_AS allows",
            Bound::Data => "of the data segment that RLIMIT_DATA allows",
        }
    }
}

/// Bytes that this process can still have, and the limit that is the least; `None` where no limit is known.
pub fn available() -> Option<(u64, Bound)> {
    let system = read_to_string("/proc/meminfo").ok().and_then(|text| kibibytes(&text, "MemAvailable:"));
    let groups = read_to_string("/proc/self/cgroup").ok().and_then(|text| groups_leave(&text, Path::new(GROUPS)));
    let [space, data] = limits_leave();
    let bounds =
        [(system, Bound::System), (groups, Bound::ControlGroup), (space, Bound::AddressSpace), (data, Bound::Data)];
    bounds.into_iter().filter_map(|(bytes, bound)| Some((bytes?, bound))).min_by_key(|(bytes, _)| *bytes)
}

/// Bytes that are left to everything that is too small to be checked.
const HEADROOM: u64 = 16 << 20;
/// Needs up to this many bytes are granted from [`SPARE`].
const SMALL: u64 = 1 << 20;
/// What the last look at the limits left over for small needs: to look takes longer than to read a small file.
static SPARE: AtomicU64 = AtomicU64::new(0);

/// Bytes that `RLIMIT_AS` leaves of this process's address space; `None` where that is not limited or not known.
pub fn address_space_left() -> Option<u64> {
    let [space, _] = limits_leave();
    space
}

/// Refuses `what` where it needs more bytes than are available, less a little for what nobody checks.
pub fn check(what: &str, need: u64) -> Result<()> {
    let take = |spare: u64| spare.checked_sub(need);
    if need <= SMALL && SPARE.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take).is_ok() {
        return Ok(());
    }
    let free = available().map(|(have, bound)| (have.saturating_sub(HEADROOM), bound));
    match free {
        Some((have, bound)) if need > have => Err(limit(what, need, &left(have, bound))),
        Some((have, _)) => {
            SPARE.store((have - need) / 16, Ordering::Relaxed);
            Ok(())
        }
        None => Ok(()),
    }
}

/// Address space that a thread takes at the most: its stack, and a heap of its own that the allocator sets aside.
const THREAD_BYTES: u64 = 136 << 20;

/// Threads that this process should begin: as many as there are cores, or fewer where a limit of the address space
/// leaves less than four times what they take.
pub fn threads() -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let [space, _] = limits_leave();
    let fit = space.map_or(u64::MAX, |space| space / (4 * THREAD_BYTES)).max(1);
    cores.min(usize::try_from(fit).unwrap_or(usize::MAX))
}

/// Refuses `what` where the allocator cannot give `count` items of `T`; nothing stays allocated.
pub fn probe<T>(what: &str, count: usize) -> Result<()> {
    reserve(what, (size_of::<T>() as u64).saturating_mul(count as u64)).map(drop)
}

/// A list of `count` times `value` for `what`, or the refusal where there is no memory for it.
pub fn filled<T: Clone>(what: &str, value: T, count: usize) -> Result<Vec<T>> {
    let mut list = Vec::new();
    if list.try_reserve_exact(count).is_err() {
        return Err(refused(what, (size_of::<T>() as u64).saturating_mul(count as u64)));
    }
    list.resize(count, value);
    Ok(list)
}

/// Address space that is held, untouched, until it is dropped: what is allocated right after that finds room for as
/// many bytes, whatever else was allocated in between.
#[derive(Debug)]
pub struct Reservation {
    held: Vec<u8>,
}

impl Reservation {
    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.held.capacity()
    }
}

/// Holds `bytes` of address space for `what`, or refuses it where they are not available. Pages that are never written
/// take no memory, so this guards against limits of the address space; that the memory behind it is there is checked
/// once, now.
pub fn reserve(what: &str, bytes: u64) -> Result<Reservation> {
    check(what, bytes)?;
    let mut held = Vec::new();
    let count = usize::try_from(bytes).unwrap_or(usize::MAX);
    match held.try_reserve_exact(count) {
        // The compiler may leave out an allocation that nothing looks at.
        Ok(()) => Ok(Reservation { held: std::hint::black_box(held) }),
        Err(_) => Err(refused(what, bytes)),
    }
}

/// The refusal of what the allocator could not give.
fn refused(what: &str, bytes: u64) -> Error {
    let have = available().map(|(have, bound)| format!("{} at most and not in one piece", left(have, bound)));
    limit(what, bytes, have.as_deref().unwrap_or("less (the allocator refuses)"))
}

fn limit(what: &str, need: u64, have: &str) -> Error {
    Error::Limit { what: what.into(), need: mebibytes(need), have: have.into() }
}

fn left(have: u64, bound: Bound) -> String {
    format!("{} {}", mebibytes(have), bound.name())
}

/// Bytes in words.
pub fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / (1u64 << 20) as f64)
}

/// The value in bytes of a line such as `MemAvailable:    2048 kB`.
fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    rest.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// Where control groups are mounted: version 2 here or in `unified`, the memory controller of version 1 in `memory`.
const GROUPS: &str = "/sys/fs/cgroup";

/// The least that a control group leaves, of those that `memberships` (`/proc/self/cgroup`) names and those above them.
/// A group that is not below `root` (as seen from within a container) has no limit that could be read.
fn groups_leave(memberships: &str, root: &Path) -> Option<u64> {
    let groups = memberships.lines().filter_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, group) = (fields.next()?, fields.next()?.trim_start_matches('/'));
        let version_1 = controllers.split(',').any(|controller| controller == "memory");
        (version_1 || controllers.is_empty()).then_some((version_1, group))
    });
    let folders = groups.flat_map(|(version_1, group)| {
        let mounts = if version_1 { vec![root.join("memory")] } else { vec![root.to_owned(), root.join("unified")] };
        mounts.into_iter().map(move |mount| (version_1, mount.join(group), mount))
    });
    let leaves = |(version_1, group, mount): (bool, PathBuf, PathBuf)| {
        let up = group.ancestors().take_while(|folder| folder.starts_with(&mount));
        up.filter_map(|folder| group_leaves(folder, version_1)).min()
    };
    folders.filter_map(leaves).min()
}

/// What the limit of one group leaves. Cached pages of files count as used there, but are given up when asked for.
fn group_leaves(folder: &Path, version_1: bool) -> Option<u64> {
    let (limit, used, cached) = match version_1 {
        true => ("memory.limit_in_bytes", "memory.usage_in_bytes", ["total_inactive_file", "total_active_file"]),
        false => ("memory.max", "memory.current", ["inactive_file", "active_file"]),
    };
    let number = |name: &str| read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
    // A group without a limit says `max`, which is no number, or in version 1 a number near 2^63.
    let (limit, used) = (number(limit)?, number(used)?);
    let stat = read_to_string(folder.join("memory.stat")).unwrap_or_default();
    let value = |name: &str| {
        let value = stat.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        value.and_then(|value| value.trim().parse::<u64>().ok()).unwrap_or(0)
    };
    let given_up = cached.into_iter().map(value).fold(0, u64::saturating_add);
    Some(limit.saturating_sub(used.saturating_sub(given_up)))
}

/// What the process's own limits leave of its address space and of its data segment.
#[cfg(unix)]
fn limits_leave() -> [Option<u64>; 2] {
    use rustix::process::{Resource, getrlimit};
    let status = read_to_string("/proc/self/status").unwrap_or_default();
    [(Resource::As, "VmSize:"), (Resource::Data, "VmData:")].map(|(resource, used)| {
        let limit = getrlimit(resource).current?;
        Some(limit.saturating_sub(kibibytes(&status, used)?))
    })
}

#[cfg(not(unix))]
fn limits_leave() -> [Option<u64>; 2] {
    [None, None]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_lines_of_kibibytes() {
        assert_eq!(kibibytes("MemTotal: 10 kB\nMemAvailable:    2048 kB\n", "MemAvailable:"), Some(2 << 20));
        assert_eq!(kibibytes("MemTotal: 10 kB\n", "MemAvailable:"), None);
        assert_eq!(kibibytes("MemAvailable: many kB\n", "MemAvailable:"), None);
    }

    #[test]
    fn refuses_what_cannot_be() {
        let error = probe::<[i128; 3]>("a film", usize::MAX).unwrap_err();
        assert!(matches!(&error, Error::Limit { what, .. } if what == "a film"), "{error}");
        assert!(reserve("a picture", u64::MAX).is_err());
    }

    #[test]
    fn a_reservation_holds_its_bytes() {
        let held = reserve("a picture", 64 << 20).unwrap();
        assert!(held.bytes() >= 64 << 20);
    }

    #[test]
    fn the_least_group_above_counts_without_its_cached_files() {
        let root = tempfile::tempdir().unwrap();
        let write = |folder: &str, files: &[(&str, &str)]| {
            let folder = root.path().join(folder);
            std::fs::create_dir_all(&folder).unwrap();
            files.iter().for_each(|(name, text)| std::fs::write(folder.join(name), text).unwrap());
        };
        let stat = ("memory.stat", "anon 10\nactive_file 30\ninactive_file 20\ntotal_inactive_file 7\n");
        write("a", &[("memory.max", "1000\n"), ("memory.current", "400\n"), stat]);
        write("a/b", &[("memory.max", "max\n"), ("memory.current", "100\n"), stat]);
        write("memory/c", &[("memory.limit_in_bytes", "500\n"), ("memory.usage_in_bytes", "100\n"), stat]);
        assert_eq!(groups_leave("0::/a/b\n", root.path()), Some(650));
        assert_eq!(groups_leave("4:cpu,memory:/c/gone\n0::/a/b\n", root.path()), Some(407));
        assert_eq!(groups_leave("4:cpu:/c\n0::/elsewhere\n", root.path()), None);
    }

    #[test]
    fn there_is_a_thread_at_least() {
        assert!((1..=std::thread::available_parallelism().unwrap().get()).contains(&threads()));
    }

    #[test]
    fn every_bound_has_its_name() {
        let (bytes, bound) = available().unwrap();
        let Err(Error::Limit { have, .. }) = check("it", u64::MAX) else { panic!("refused") };
        assert!(bytes > 0 && have.ends_with(bound.name()), "{have}");
    }
}
