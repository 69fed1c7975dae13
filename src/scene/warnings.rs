//! What loading warns of, few lines of each kind: a million warnings are read by nobody.
//!
//! Comes in: warnings, each with its kind. Goes out: the first of every kind in the order they came, and for a kind of
//! which there are more, how many.

use std::collections::HashMap;
use std::path::Path;

use crate::quote::{self, quoted};

/// Warnings of a kind that are told one by one.
const TOLD: usize = 16;

/// The warnings of one load.
#[derive(Default)]
pub(super) struct Warnings {
    lines: Vec<String>,
    counts: HashMap<&'static str, usize>,
    /// Kinds in the order of their first warning.
    kinds: Vec<&'static str>,
}

impl Warnings {
    /// Adds a warning. `kind` names all of its kind, as "of KIND" says it.
    pub(super) fn add(&mut self, kind: &'static str, text: impl FnOnce() -> String) {
        let count = self.counts.entry(kind).or_insert(0);
        if *count == 0 {
            self.kinds.push(kind);
        }
        *count += 1;
        if *count <= TOLD {
            self.lines.push(text());
        }
    }

    /// The lines to tell.
    pub(super) fn finish(self) -> Vec<String> {
        let mut lines = self.lines;
        for kind in self.kinds {
            let count = self.counts.get(kind).copied().unwrap_or(0);
            if count > TOLD {
                lines.push(format!("{} more warnings of {kind}", count - TOLD));
            }
        }
        lines
    }
}

/// How often something was met in a file, and where first.
#[derive(Debug, Default)]
pub(super) struct Tally {
    count: usize,
    line: usize,
    word: String,
}

impl Tally {
    /// Counts one, at this line and with this word.
    pub(super) fn add(&mut self, line: usize, word: &str) {
        if self.count == 0 {
            self.line = line;
            self.word = word.to_owned();
        }
        self.count += 1;
    }

    /// Warns where there was any; `{n}` and `{word}` of the text are the number and the first word.
    pub(super) fn warn(&self, path: &Path, warnings: &mut Warnings, kind: &'static str, text: &str) {
        if self.count > 0 {
            // The word comes last: what it holds is not looked at.
            let text = text.replace("{n}", &self.count.to_string()).replace("{word}", &quoted(&self.word));
            warnings.add(kind, || format!("{}:{}: {text}", quote::path(path), self.line));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_of_a_kind_are_told_and_the_others_counted() {
        let mut warnings = Warnings::default();
        for i in 0..20 {
            warnings.add("this", || format!("this {i}"));
        }
        warnings.add("that", || "that".to_owned());
        let lines = warnings.finish();
        assert_eq!((lines.len(), lines[15].as_str(), lines[16].as_str()), (18, "this 15", "that"));
        assert_eq!(lines[17], "4 more warnings of this");
    }
}
