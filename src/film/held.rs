//! Memory that reading a film out will take, held while it is being filled.
//!
//! Comes in: a number of bytes. Goes out: a [`Held`], which a film has. A driver takes memory when it likes, and a
//! picture that is finished and cannot be read out would be lost.

use std::sync::{Mutex, PoisonError};

use crate::Result;
use crate::memory::{Reservation, reserve};

/// Address space that is held until it is let go; a copy holds none.
#[derive(Debug, Default)]
pub(super) struct Held {
    what: String,
    bytes: u64,
    reservation: Mutex<Option<Reservation>>,
}

impl Clone for Held {
    fn clone(&self) -> Held {
        Held::default()
    }
}

impl Held {
    /// Holds `bytes` for `what`, or refuses it where they are not available.
    pub(super) fn new(what: &str, bytes: u64) -> Result<Held> {
        let reservation = Mutex::new(Some(reserve(what, bytes)?));
        Ok(Held { what: what.to_owned(), bytes, reservation })
    }

    /// Lets it go for the time of `work`, which takes as much and gives it back.
    pub(super) fn during<T>(&self, work: impl FnOnce() -> T) -> T {
        let held = self.take();
        let result = work();
        if held {
            // What was there a moment ago may be gone to another thread: then nothing is held.
            *self.reservation.lock().unwrap_or_else(PoisonError::into_inner) = reserve(&self.what, self.bytes).ok();
        }
        result
    }

    /// Lets it go for good; whether it was held.
    pub(super) fn take(&self) -> bool {
        self.reservation.lock().unwrap_or_else(PoisonError::into_inner).take().is_some()
    }
}
