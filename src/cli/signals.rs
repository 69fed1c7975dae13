//! Signals that ask to stop: the first asks politely, a second one later ends the process at once.
//!
//! Comes in: SIGINT, SIGTERM and, on Unix, SIGHUP. Goes out: the number of the signal, to be asked for. A signal that
//! the process was started to ignore (`nohup`) stays ignored. Signals that come within a second are one: a terminal
//! that is closed sends SIGHUP twice (the kernel does, and the shell), and `timeout` signals the process and then its
//! group.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
#[cfg(unix)]
use std::time::{Duration, Instant};

#[cfg(unix)]
use signal_hook::low_level;
use signal_hook::{consts, flag};
use texray::{Error, Result};

use super::process;

#[cfg(unix)]
const WATCHED: [i32; 3] = [consts::SIGINT, consts::SIGTERM, consts::SIGHUP];
#[cfg(not(unix))]
const WATCHED: [i32; 2] = [consts::SIGINT, consts::SIGTERM];

/// Signals that come within this time after the first one belong to it: nobody asks a second time so soon.
#[cfg(unix)]
const BURST: Duration = Duration::from_secs(1);

/// Bytes of the stack of the thread that waits for signals.
#[cfg(unix)]
const STACK_BYTES: usize = 64 << 10;

/// A watch on the signals; it lasts as long as the process.
#[derive(Clone)]
pub struct Signals {
    received: Arc<AtomicUsize>,
}

impl Signals {
    /// Begins to watch.
    pub fn watch() -> Result<Signals> {
        let received = Arc::new(AtomicUsize::new(0));
        let watched: Vec<i32> = WATCHED.into_iter().filter(|&signal| !process::ignores(signal)).collect();
        watch_by_thread(&watched, &received)
            .or_else(|_| watch_by_handlers(&watched, &received))
            .map_err(|error| Error::Internal(format!("signals cannot be watched: {error}")))?;
        Ok(Signals { received })
    }

    /// The signal that asked to stop, if one did.
    pub fn received(&self) -> Option<u8> {
        u8::try_from(self.received.load(Ordering::SeqCst)).ok().filter(|&signal| signal != 0)
    }
}

/// Has a thread wait for signals, which can tell the time between them: the one that renders may be waiting for the
/// driver.
#[cfg(unix)]
fn watch_by_thread(watched: &[i32], received: &Arc<AtomicUsize>) -> io::Result<()> {
    let mut signals = signal_hook::iterator::Signals::new(watched)?;
    let received = Arc::clone(received);
    let watch = move || {
        let mut first = None;
        for signal in signals.forever() {
            if first.get_or_insert_with(Instant::now).elapsed() >= BURST {
                low_level::exit(128 + signal);
            }
            // The first one is told; whether this is the first is not of interest.
            let _ = received.compare_exchange(0, signal as usize, Ordering::SeqCst, Ordering::SeqCst);
        }
    };
    std::thread::Builder::new().name("signals".into()).stack_size(STACK_BYTES).spawn(watch).map(drop)
}

#[cfg(not(unix))]
fn watch_by_thread(_: &[i32], _: &Arc<AtomicUsize>) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Where no thread can be had the handlers themselves do it. They cannot tell the time: any second signal ends the
/// process.
fn watch_by_handlers(watched: &[i32], received: &Arc<AtomicUsize>) -> io::Result<()> {
    let again = Arc::new(AtomicBool::new(false));
    for &signal in watched {
        // In this order: a first signal finds `again` unset and sets it, a second finds it set.
        flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again))?;
        flag::register(signal, Arc::clone(&again))?;
        flag::register_usize(signal, Arc::clone(received), signal as usize)?;
    }
    Ok(())
}

/// Has a write beyond the limit of file sizes (`ulimit -f`) fail, as on a full disk, where the signal that comes with
/// it would end the process: a handler that does nothing is enough.
pub fn survive_large_files() {
    #[cfg(unix)]
    // Without the handler a large file ends the process, as before.
    let _ = flag::register(consts::SIGXFSZ, Arc::new(AtomicBool::new(false)));
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// One test only: handlers belong to the process, and a second signal after a while would end it.
    #[test]
    fn a_burst_of_signals_is_told_as_one() {
        let signals = Signals::watch().unwrap();
        assert_eq!(signals.received(), None);
        for _ in 0..3 {
            low_level::raise(consts::SIGTERM).unwrap();
        }
        let start = Instant::now();
        while signals.received().is_none() && start.elapsed() < BURST {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(signals.received(), Some(15));
    }
}
