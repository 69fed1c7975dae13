//! Threads: how many the process can start, and how many of them a Vulkan driver for the CPU works with.
//!
//! Comes in: the machine's cores, and whatever limits the process (`ulimit -u`, a control group, memory). Goes out:
//! the environment variable that lavapipe reads, and what is left for texray's own workers; or a refusal, before the
//! driver starts fewer threads than it then waits for.
//!
//! lavapipe divides a dispatch into as many equal ranges of workgroups as it has threads, and a thread whose range is
//! done takes no part of another's. With a thread a core, which is its default, the core that is slower for the
//! moment keeps the others waiting at the end of every dispatch. With several, the system's scheduler gives the
//! ranges that are left to the core that is free. It takes no note of a thread that it could not start, and waits for
//! it for ever: so it is asked for no more than there can be.

use std::fs;
use std::sync::{Mutex, PoisonError};
use std::thread::{self, available_parallelism};
use std::time::{Duration, Instant};

use super::device_info::{DeviceInfo, DeviceKind};
use super::{address_space, thread_limits};
use crate::{Error, Result};

/// What lavapipe takes the number of its threads from, when it makes a device.
const VARIABLE: &str = "LP_NUM_THREADS";

/// Threads for each core (docs/performance.md, "Threads that wait").
const THREADS_A_CORE: usize = 4;

/// The most that lavapipe 22.3 makes.
const MOST_THREADS: usize = 16;

/// Pools of so many threads that lavapipe has: one rasterises, one computes.
pub(super) const POOLS: usize = 2;

/// Threads that lavapipe starts beside its pools: one for the queue, without which there is no device,
const QUEUE_THREADS: usize = 1;
/// and one for its cache on disk, which it can do without.
const CACHE_THREADS: usize = 1;

/// The thread of the program that waits for signals.
const SIGNAL_THREADS: usize = 1;
/// What else may start a thread during a render: the writers of pictures, which can do without.
const SPARE_THREADS: usize = 2;

/// Stack of a thread that only shows that it can be started.
const TRIAL_STACK_BYTES: usize = 64 << 10;

/// How long the system may take to forget a thread that has ended.
const FORGET_LIMIT: Duration = Duration::from_secs(1);

/// How the threads that can be started are shared out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ThreadShares {
    /// Threads for work of the host in parallel; 0: the thread that asks does it. `None`: as many as there are cores,
    /// for there are threads enough.
    pub workers: Option<usize>,
    /// What to tell a user where there are fewer threads than wanted.
    pub warning: Option<String>,
}

/// Shares the threads out that the process can start: for lavapipe, by its environment variable `LP_NUM_THREADS`,
/// which other drivers do not read, and for the host. A number that a user gave lavapipe stays where there are so
/// many. Does nothing where the process has begun another thread or cannot tell: a program calls it first of all.
pub fn share_out_threads() -> ThreadShares {
    let cores = cores();
    if !is_only_thread() {
        return ThreadShares::default();
    }
    let given = given_threads();
    let driver = given.unwrap_or_else(|| threads(cores).unwrap_or(cores.min(MOST_THREADS)));
    let wanted = needed(driver) + CACHE_THREADS + SIGNAL_THREADS + cores + SPARE_THREADS;
    let roomy = address_space::threads_with_room(driver);
    let startable = startable(wanted);
    let (set, shares) = if startable < wanted {
        let (fewer, workers) = shares(roomy, cores, startable);
        let warning = format!(
            "{startable} threads can be started and {wanted} are wanted{}: a driver for the CPU works with {fewer} \
             of {driver}, texray itself with {} of {cores}",
            thread_limits::in_words(),
            workers.max(1)
        );
        (
            Some(fewer),
            ThreadShares { workers: Some(workers), warning: (fewer < driver || workers < cores).then_some(warning) },
        )
    } else if roomy < driver {
        let warning = format!(
            "there is little address space{}: a driver for the CPU works with {roomy} threads instead of {driver}",
            address_space::in_words()
        );
        (Some(roomy), ThreadShares { workers: None, warning: Some(warning) })
    } else {
        (threads(cores).filter(|_| given.is_none()), ThreadShares::default())
    };
    if let Some(threads) = set.filter(|_| is_only_thread()) {
        // SAFETY: no other thread may read or write the environment meanwhile. There is none: those of the trial have
        // ended, and this one starts none.
        unsafe { std::env::set_var(VARIABLE, threads.to_string()) };
    }
    shares
}

/// Refuses a CPU device whose driver would start more threads than it can have.
pub(super) fn check(info: &DeviceInfo) -> Result<()> {
    if info.kind != DeviceKind::Cpu {
        return Ok(());
    }
    let threads = driver_threads(info, cores());
    address_space::check_device(info, threads)?;
    let need = match info.name.contains("llvmpipe") {
        true => needed(threads),
        false => threads + QUEUE_THREADS,
    };
    let have = startable(need);
    match have == need {
        true => Ok(()),
        false => Err(Error::Limit {
            what: format!("threads of the driver of {}", info.name),
            need: format!("{need} threads"),
            have: format!("{have}{}", thread_limits::in_words()),
        }),
    }
}

/// Threads that the driver of a CPU device works with. (SwiftShader has one a core, and ends the process without them.)
fn driver_threads(info: &DeviceInfo, cores: usize) -> usize {
    match info.name.contains("llvmpipe") {
        true => given_threads().unwrap_or(cores.min(MOST_THREADS)),
        false => cores,
    }
}

fn cores() -> usize {
    available_parallelism().map_or(1, |cores| cores.get())
}

/// Threads to ask for on so many cores: none where the driver would make fewer, and some cores had more ranges than others.
fn threads(cores: usize) -> Option<usize> {
    Some(cores * THREADS_A_CORE).filter(|&threads| threads <= MOST_THREADS)
}

/// The number that the environment gives lavapipe, as it reads it.
fn given_threads() -> Option<usize> {
    std::env::var(VARIABLE).ok()?.trim().parse().ok().map(|threads: usize| threads.min(MOST_THREADS))
}

/// Threads that lavapipe must be able to start to work with `driver`.
fn needed(driver: usize) -> usize {
    POOLS * driver + QUEUE_THREADS
}

/// Of `startable` threads those for lavapipe, which then does nearly all of the work, and what is left for the host.
/// Without threads of its own lavapipe works in that of its queue.
fn shares(driver: usize, cores: usize, startable: usize) -> (usize, usize) {
    let left = startable.saturating_sub(QUEUE_THREADS + CACHE_THREADS + SIGNAL_THREADS);
    let driver = driver.min(left / POOLS);
    let workers = (left - POOLS * driver).min(cores);
    // One worker would only do what the thread that waits for it can do.
    (driver, if workers > 1 { workers } else { 0 })
}

/// How many of `wanted` threads can be started beside those that there are: by starting them, whoever may limit it.
fn startable(wanted: usize) -> usize {
    let gate = Mutex::new(());
    // None of them allocates memory, for which the C library would keep a piece of address space apart for each.
    let started: Vec<i32> = thread::scope(|scope| {
        let held = gate.lock().unwrap_or_else(PoisonError::into_inner);
        let wait = || {
            drop(gate.lock());
            thread_limits::thread_number()
        };
        let start = |_| thread::Builder::new().stack_size(TRIAL_STACK_BYTES).spawn_scoped(scope, wait).ok();
        let threads: Vec<_> = (0..wanted).map_while(start).collect();
        drop(held);
        threads.into_iter().map(|thread| thread.join().unwrap_or(0)).collect()
    });
    // A thread that was waited for still counts for a moment.
    let asked = Instant::now();
    while started.iter().any(|&thread| thread_limits::is_listed(thread)) && asked.elapsed() < FORGET_LIMIT {
        thread::yield_now();
    }
    started.len()
}

/// Whether this thread is the process's only one, by the list that Linux keeps of them.
fn is_only_thread() -> bool {
    fs::read_dir("/proc/self/task").is_ok_and(|threads| threads.count() == 1)
}

#[cfg(test)]
mod tests {
    use super::super::choice::tests::device;
    use super::*;

    #[test]
    fn four_threads_a_core_where_the_driver_has_as_many() {
        assert_eq!([1, 2, 4, 5, 16, 64].map(threads), [Some(4), Some(8), Some(16), None, None, None]);
    }

    #[test]
    fn the_driver_comes_first_and_is_asked_for_no_more_than_there_are() {
        for driver in [0, 1, 8, 16] {
            for cores in [1, 2, 64] {
                for startable in 0..120 {
                    let (fewer, workers) = shares(driver, cores, startable);
                    assert!(fewer <= driver && workers <= cores && workers != 1);
                    assert!(startable == 0 || needed(fewer) + workers <= startable, "{driver} {cores} {startable}");
                    assert!(fewer == driver || startable < needed(fewer + 1) + CACHE_THREADS + SIGNAL_THREADS);
                }
            }
        }
        assert_eq!(shares(8, 2, 8), (2, 0));
        assert_eq!(shares(8, 2, 22), (8, 2));
    }

    #[test]
    fn threads_can_be_started_and_are_gone_again() {
        assert_eq!((startable(0), startable(5)), (0, 5));
    }

    #[test]
    fn only_drivers_for_the_cpu_are_asked() {
        assert!(check(&device(0, "a card", DeviceKind::Discrete)).is_ok());
        assert!(check(&device(0, "llvmpipe", DeviceKind::Cpu)).is_ok(), "this machine has threads enough");
    }

    #[test]
    fn a_process_of_several_threads_keeps_its_environment() {
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let before = std::env::var_os(VARIABLE);
                assert!(!is_only_thread(), "the thread that waits for this one counts");
                assert_eq!(share_out_threads(), ThreadShares::default());
                assert_eq!(std::env::var_os(VARIABLE), before);
            });
        });
    }
}
