//! What the engine asks of a study.
//!
//! Comes in: a [`Step`] and who watches. Goes out: the figures of one measurement.

use super::Row;
use crate::Result;

/// Figures of one measurement, by name, with units in the names.
pub type Values = Vec<(&'static str, f64)>;

/// One measurement, by places in the study's lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Which scene.
    pub scene: usize,
    /// Which case.
    pub case: usize,
    /// Which time, from 0.
    pub repeat: u32,
}

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

/// Watches a study and may stop it.
pub trait Watch {
    /// A measurement is done: how many of how many, and a line about it.
    fn measured(&mut self, done: usize, total: usize, line: &str);
    /// Something the user should know, though the study goes on.
    fn warn(&mut self, line: &str);
    /// Whether to stop. What is measured is kept.
    fn stop_requested(&self) -> bool;
}
