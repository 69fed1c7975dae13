//! What a picture file says about itself: keys and values, in order.
//!
//! Comes in: facts of a render. Goes out: EXR attributes and PNG text. Facts of two kinds are told apart: those that
//! scene, settings and device determine, and those that differ from run to run (times). An EXR holds only the first,
//! so that equal renders are equal files.

/// Ordered facts about a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    entries: Vec<Entry>,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
    key: String,
    value: String,
    varies: bool,
}

impl Metadata {
    /// No facts yet.
    pub fn new() -> Metadata {
        Metadata::default()
    }

    /// Adds a fact that is a function of scene, settings and device. `key` is ASCII, at most 31 characters, unique.
    pub fn fixed(&mut self, key: &str, value: impl ToString) -> &mut Metadata {
        self.push(key, value.to_string(), false)
    }

    /// Adds a fact that may differ between two runs of the same render, such as a time.
    pub fn varying(&mut self, key: &str, value: impl ToString) -> &mut Metadata {
        self.push(key, value.to_string(), true)
    }

    /// The facts that two runs of the same render share, in the order they were added.
    pub fn fixed_entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries.iter().filter(|entry| !entry.varies).map(|entry| (entry.key.as_str(), entry.value.as_str()))
    }

    /// Every fact, in the order they were added.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries.iter().map(|entry| (entry.key.as_str(), entry.value.as_str()))
    }

    /// Keeps one entry a key: the last value counts. NUL ends text in both formats and is dropped.
    fn push(&mut self, key: &str, value: String, varies: bool) -> &mut Metadata {
        let value = value.replace('\0', "");
        match self.entries.iter_mut().find(|entry| entry.key == key) {
            Some(entry) => *entry = Entry { key: key.into(), value, varies },
            None => self.entries.push(Entry { key: key.into(), value, varies }),
        }
        self
    }
}
