//! Studies: what a choice costs in time and what it buys, measured on the user's own device.
//!
//! Comes in: scenes, a device, a folder. Goes out: raw rows in the folder (`rows`), figures read off them, and the pictures
//! that they are about. A study is a list of measurements; every measurement ends as one row, so that a study can be stopped
//! anywhere and gone on with. Repeats go through all cases of a scene before any case comes again, so that a change of the
//! machine's speed meets all alike.
//!
//! ```text
//! schedule         the order of measurements, and the loop over them
//! subject          a scene under study: renders without compiling in their time, references
//! spp, bounces, …  one study each: what is measured, what the rows say
//! published        the Cornell box by the published camera
//! cornell          its picture beside what is published of it
//! rows, spread     raw figures on disk; medians and ranges of them
//! relative_error   a picture against another
//! pair             a picture under two seeds, and its bias
//! account, gallery sentences, tables and figures; pictures on disk
//! page             the report of a folder
//! peers, child     other renderers, and texray in a process of its own
//! ```

pub mod account;
pub mod bounces;
pub mod child;
pub mod convergence;
pub mod cornell;
pub mod effects;
pub mod gallery;
mod kind;
pub mod page;
pub mod pair;
pub mod peers;
pub mod precision;
pub mod published;
pub mod rows;
pub mod schedule;
pub mod speed;
pub mod spp;
pub mod spread;
pub mod subject;
pub mod thesis;
pub mod transfer;
pub mod triangles;

use std::path::PathBuf;

pub use crate::compare::relative_error;
pub use account::{Account, Table};
pub use kind::Kind;
pub use rows::{Origin, Row, Rows};
pub use schedule::{Ended, Step, run};
pub use spread::Spread;

use crate::Result;
use child::Child;
use peers::Peers;

/// Figures of one measurement, by name, with units in the names.
pub type Values = Vec<(&'static str, f64)>;

/// One study.
pub trait Study {
    /// The scenes by name, in the order of [`Step::scene`].
    fn scenes(&self) -> &[String];

    /// Name of a case.
    fn case(&self, case: usize) -> String;

    /// Every measurement, in order.
    fn schedule(&self) -> Vec<Step>;

    /// The figures of one measurement; `None` where the watch stopped it.
    fn measure(&mut self, step: Step, watch: &mut dyn Watch) -> Result<Option<Values>>;

    /// The figure of a row that matters most, for the line that reports it.
    fn headline(&self, row: &Row) -> String;
}

/// What is to be studied, and with what.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Scene files; empty: those of [`Kind::default_scenes`].
    pub scenes: Vec<PathBuf>,
    /// How much is measured.
    pub amount: Amount,
    /// Folder for rows and pictures.
    pub folder: PathBuf,
    /// The program itself, for processes of their own.
    pub child: Child,
    /// Where the peers are, if they are asked for.
    pub peers: Option<Peers>,
}

/// How much is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Amount {
    /// Figures to keep.
    #[default]
    Full,
    /// Smaller pictures, fewer repeats: less than two minutes on two cores.
    Quick,
    /// Every measurement once, of next to nothing: shows that a study runs, and no more.
    Least,
}

impl Amount {
    /// What is meant for this amount.
    fn of<T>(self, full: T, quick: T, least: T) -> T {
        match self {
            Amount::Full => full,
            Amount::Quick => quick,
            Amount::Least => least,
        }
    }
}

/// Watches a study and may stop it.
pub trait Watch {
    /// A measurement is done: how many of how many, and a line about it.
    fn measured(&mut self, done: usize, total: usize, line: &str);
    /// Something the user should know, though the study goes on.
    fn warn(&mut self, line: &str);
    /// Whether to stop. What is measured is kept.
    fn stop_requested(&self) -> bool;
}
