//! Signals that ask to stop: the first asks politely, the second ends the process at once.
//!
//! Comes in: SIGINT, SIGTERM and, on Unix, SIGHUP. Goes out: the number of the signal, to be asked for. A signal that
//! the process was started to ignore (`nohup`) stays ignored.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts;
use signal_hook::flag;
use texray::{Error, Result};

use super::process;

#[cfg(unix)]
const WATCHED: [i32; 3] = [consts::SIGINT, consts::SIGTERM, consts::SIGHUP];
#[cfg(not(unix))]
const WATCHED: [i32; 2] = [consts::SIGINT, consts::SIGTERM];

/// A watch on the signals; it lasts as long as the process.
#[derive(Clone)]
pub struct Signals {
    received: Arc<AtomicUsize>,
}

impl Signals {
    /// Begins to watch.
    pub fn watch() -> Result<Signals> {
        let (received, again) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        for signal in WATCHED.into_iter().filter(|&signal| !process::ignores(signal)) {
            // In this order: a first signal finds `again` unset and sets it, a second finds it set.
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again))
                .and_then(|_| flag::register(signal, Arc::clone(&again)))
                .and_then(|_| flag::register_usize(signal, Arc::clone(&received), signal as usize))
                .map_err(|error| Error::Internal(format!("handler of signal {signal}: {error}")))?;
        }
        Ok(Signals { received })
    }

    /// The signal that asked to stop, if one did.
    pub fn received(&self) -> Option<u8> {
        u8::try_from(self.received.load(Ordering::SeqCst)).ok().filter(|&signal| signal != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One test only: handlers belong to the process, and a second signal would end it.
    #[test]
    fn tells_which_signal_came() {
        let signals = Signals::watch().unwrap();
        assert_eq!(signals.received(), None);
        signal_hook::low_level::raise(consts::SIGTERM).unwrap();
        assert_eq!(signals.received(), Some(15));
    }
}
