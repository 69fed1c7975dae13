//! What limits the number of threads, as far as the system says.
//!
//! Comes in: nothing. Goes out: words for an error. How many threads can be started is found out by starting them
//! (`driver_threads.rs`); this only tells a user where to look.

/// The limits that there are, in brackets after a blank; nothing where none is known.
pub(super) fn in_words() -> String {
    let user = user_limit().map(|most| format!("ulimit -u is {most}"));
    let group = group_limit().map(|most| format!("pids.max of the control group is {most}"));
    let known: Vec<_> = user.into_iter().chain(group).collect();
    if known.is_empty() { String::new() } else { format!(" ({})", known.join(", ")) }
}

/// The number under which the system lists the thread that asks, in [`is_listed`].
#[cfg(target_os = "linux")]
pub(super) fn thread_number() -> i32 {
    rustix::thread::gettid().as_raw_nonzero().get()
}

/// Elsewhere there is no such list.
#[cfg(not(target_os = "linux"))]
pub(super) fn thread_number() -> i32 {
    0
}

/// Whether the system still knows this thread of the process.
pub(super) fn is_listed(thread: i32) -> bool {
    std::fs::exists(format!("/proc/self/task/{thread}")).unwrap_or(false)
}

/// Processes and threads that the user may have.
#[cfg(unix)]
fn user_limit() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::Nproc).current
}

#[cfg(not(unix))]
fn user_limit() -> Option<u64> {
    None
}

/// Tasks that the control group may have: of version 2, whose one line begins with `0::`, or of version 1.
fn group_limit() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    groups.lines().find_map(|line| {
        let (controllers, path) = line.split_once(':')?.1.split_once(':')?;
        let root = match controllers {
            "" => "/sys/fs/cgroup",
            "pids" => "/sys/fs/cgroup/pids",
            _ => return None,
        };
        // Inside a container the path may be the host's: then the root is the container's own group.
        [format!("{root}{path}/pids.max"), format!("{root}/pids.max")]
            .into_iter()
            .find_map(|file| std::fs::read_to_string(file).ok()?.trim().parse().ok())
    })
}
