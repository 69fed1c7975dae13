//! Studies: what a choice costs in time and what it buys, measured on the user's own device.
//!
//! Comes in: scenes, a device, a folder. Goes out: raw rows in the folder (`rows`), and figures read off them. A study is a
//! list of measurements; every measurement ends as one row, so that a study can be stopped anywhere and gone on with.
//! Repeats go through all cases before any case comes again, so that a change of the machine's speed meets all alike.
//!
//! ```text
//! cornell          the Cornell box beside what is published of it
//! speed            what is measured, in which order; what came out
//! peers, child     other renderers, and texray in a process of its own
//! rows, spread     raw figures on disk; medians and ranges of them
//! ```

pub mod child;
pub mod cornell;
pub mod peers;
pub mod rows;
pub mod speed;
pub mod spread;

pub use crate::compare::relative_error;
pub use rows::{Origin, Row, Rows};
pub use spread::Spread;

/// Watches a study and may stop it.
pub trait Watch {
    /// A measurement is done: how many of how many, and a line about it.
    fn measured(&mut self, done: usize, total: usize, line: &str);
    /// Something the user should know, though the study goes on.
    fn warn(&mut self, line: &str);
    /// Whether to stop. What is measured is kept.
    fn stop_requested(&self) -> bool;
}
