//! Refusals that are collected, so that a file's author learns of all of them at once.
//!
//! Comes in: results of reading its parts. Goes out: the values, and at the end one error of all that were refused.

use crate::{Error, Result};

/// What was refused so far.
#[derive(Default)]
pub(super) struct Refusals {
    kept: Vec<Error>,
    /// Refusals after the first [`KEPT`]: a file that is something else altogether has one a line.
    more: usize,
}

/// Refusals that are kept to be put in order.
const KEPT: usize = 1000;
/// Refusals that are told; of more, the number.
const TOLD: usize = 20;

impl Refusals {
    /// The value of a part that can be read.
    pub(super) fn keep<T>(&mut self, part: Result<T>) -> Option<T> {
        part.map_err(|error| self.add(error)).ok()
    }

    /// Adds a refusal, or several.
    pub(super) fn add(&mut self, error: Error) {
        let (errors, more) = match error {
            Error::Scenes { refusals, more } => (refusals, more),
            one => (vec![one], 0),
        };
        let room = KEPT.saturating_sub(self.kept.len());
        self.more += more + errors.len().saturating_sub(room);
        self.kept.extend(errors.into_iter().take(room));
    }

    /// Puts the refusals of one file into the order of its lines.
    pub(super) fn in_order_of_lines(&mut self) {
        let line = |error: &Error| if let Error::Scene { line, .. } = error { *line } else { 0 };
        self.kept.sort_by_key(line);
    }

    /// `Ok` where nothing was refused.
    pub(super) fn finish(mut self) -> Result<()> {
        match (self.kept.len(), self.more) {
            (0, _) => Ok(()),
            // The one that was kept is all there is.
            (1, 0) => self.kept.pop().map_or(Ok(()), Err),
            (kept, more) => {
                self.kept.truncate(TOLD);
                Err(Error::Scenes { refusals: self.kept, more: more + kept.saturating_sub(TOLD) })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(lines: &[usize]) -> Result<()> {
        let mut refusals = Refusals::default();
        for &line in lines {
            assert!(refusals.keep::<()>(Err(Error::scene("a", line, "wrong"))).is_none());
        }
        refusals.in_order_of_lines();
        refusals.finish()
    }

    #[test]
    fn all_are_told_and_of_many_the_number() {
        assert!(told(&[]).is_ok());
        assert!(matches!(told(&[3]), Err(Error::Scene { line: 3, .. })));
        let two = told(&[7, 2]).unwrap_err();
        assert_eq!((two.to_string().as_str(), two.exit_code()), ("a:2: wrong\na:7: wrong", 3));
        let many = told(&(1..=KEPT + 5).rev().collect::<Vec<_>>()).unwrap_err();
        assert!(many.to_string().starts_with("a:6: wrong\n"), "{many}");
        assert!(many.to_string().ends_with("a:25: wrong\nand 985 more like these"), "{many}");
        // Refusals of a part count as its own.
        let mut whole = Refusals::default();
        whole.add(many);
        whole.add(two);
        let text = whole.finish().unwrap_err().to_string();
        assert!(text.lines().count() == TOLD + 1 && text.ends_with("and 987 more like these"), "{text}");
    }
}
