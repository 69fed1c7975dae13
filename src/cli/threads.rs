//! Threads of the process, shared out before any is started.
//!
//! Comes in: what the library finds can be started, and what the address space has room for. Goes out: a pool of
//! workers no larger than either, and a warning where fewer start than usual. Without a limit nothing is done here: the
//! pool starts by itself when it is first needed.

use std::thread::available_parallelism;

use texray::gpu::share_out_threads;
use texray::{Error, Result, memory};

use super::streams::say;

/// Shares them out.
pub fn share_out() -> Result<()> {
    let shares = share_out_threads();
    if let Some(warning) = shares.warning {
        say(&format!("warning: {warning}"));
    }
    let cores = available_parallelism().map_or(1, usize::from);
    let roomy = Some(memory::threads()).filter(|&threads| threads < cores);
    // `None` is no limit, not the least.
    let Some(workers) = [shares.workers, roomy].into_iter().flatten().min() else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new();
    let pool = match workers {
        0 => pool.num_threads(1).use_current_thread(),
        workers => pool.num_threads(workers),
    };
    pool.build_global().map_err(|error| Error::Limit {
        what: format!("threads of texray itself: {error}"),
        need: format!("{workers} threads"),
        have: "fewer".into(),
    })
}
