//! How many threads a Vulkan driver for the CPU works with.
//!
//! lavapipe divides a dispatch into as many equal ranges of workgroups as it has threads, and a thread whose range is done takes no part
//! of another's. With a thread a core, which is its default, the core that is slower for the moment keeps the others waiting at the
//! end of every dispatch. With several, the system's scheduler gives the ranges that are left to the core that is free.

use std::fs;
use std::thread::available_parallelism;

/// What lavapipe takes the number of its threads from, when it makes a device.
const VARIABLE: &str = "LP_NUM_THREADS";

/// Threads for each core (docs/performance.md, "Threads that wait").
const THREADS_A_CORE: usize = 4;

/// The most that lavapipe 22.3 makes.
const MOST_THREADS: usize = 16;

/// Asks lavapipe for more threads than there are cores, by its environment variable `LP_NUM_THREADS`; other drivers do not read it.
/// Does nothing where the variable is set, and where the process has begun another thread or cannot tell: a program calls it first of
/// all.
pub fn prefer_many_driver_threads() {
    if let Some(threads) = available_parallelism().ok().and_then(|cores| threads(cores.get()))
        && std::env::var_os(VARIABLE).is_none()
        && is_only_thread()
    {
        // SAFETY: no other thread may read or write the environment meanwhile. There is none, and this one starts none.
        unsafe { std::env::set_var(VARIABLE, threads.to_string()) };
    }
}

/// Threads to ask for on so many cores: none where the driver would make fewer, and some cores had more ranges than others.
fn threads(cores: usize) -> Option<usize> {
    Some(cores * THREADS_A_CORE).filter(|&threads| threads <= MOST_THREADS)
}

/// Whether this thread is the process's only one, by the list that Linux keeps of them.
fn is_only_thread() -> bool {
    fs::read_dir("/proc/self/task").is_ok_and(|threads| threads.count() == 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_threads_a_core_where_the_driver_has_as_many() {
        assert_eq!([1, 2, 4, 5, 16, 64].map(threads), [Some(4), Some(8), Some(16), None, None, None]);
    }

    #[test]
    fn a_process_of_several_threads_keeps_its_environment() {
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let before = std::env::var_os(VARIABLE);
                assert!(!is_only_thread(), "the thread that waits for this one counts");
                prefer_many_driver_threads();
                assert_eq!(std::env::var_os(VARIABLE), before);
            });
        });
    }
}
