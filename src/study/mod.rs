//! Studies: what a choice costs in time and what it buys, measured on the user's own device.
//!
//! Comes in: scenes, a device, a folder. Goes out: raw rows in the folder (`rows`), figures read off them, and the pictures
//! that they are about. A study is a list of measurements; every measurement ends as one row, so that a study can be stopped
//! anywhere and gone on with. Repeats go through all cases of a scene before any case comes again, so that a change of the
//! machine's speed meets all alike.
//!
//! ```text
//! engine   what all studies share
//! studies  one file each: what is measured, what the rows say; published and cornell: the box by the published camera
//! page     the report of a folder
//! ```

pub mod engine;
pub mod page;
pub mod studies;

pub use engine::{Amount, Ended, Kind, Origin, Plan, Row, Rows, Study, Watch, peers, run, subprocess};
pub use studies::named;
