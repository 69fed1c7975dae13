//! What a picture file says about itself: keys and values, in order.
//!
//! Comes in: facts of a render. Goes out: EXR attributes, PNG text and lines of an HDR header. Facts of three kinds are
//! told apart: what the picture is of (the scene, and each setting that shows, but for the number of samples), what
//! else scene, settings and device determine, and what differs from run to run (times). EXR and HDR files hold no
//! times, so that equal renders are equal files.

use super::stored::Stored;

/// Ordered facts about a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    entries: Vec<Entry>,
}

#[derive(Clone, Debug, PartialEq)]
struct Entry {
    key: String,
    value: String,
    kind: Kind,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Subject,
    Fixed,
    Varying,
}

impl Metadata {
    /// No facts yet.
    pub fn new() -> Metadata {
        Metadata::default()
    }

    /// Adds a fact about what the picture is of. Two pictures that agree in all of them differ in their noise alone.
    /// `key` is as for [`Metadata::fixed`].
    pub fn subject(&mut self, key: &str, value: impl ToString) -> &mut Metadata {
        self.push(key, value.to_string(), Kind::Subject)
    }

    /// Adds a fact that is a function of scene, settings and device. `key` is ASCII, at most 31 characters, unique.
    pub fn fixed(&mut self, key: &str, value: impl ToString) -> &mut Metadata {
        self.push(key, value.to_string(), Kind::Fixed)
    }

    /// Adds a fact that may differ between two runs of the same render, such as a time.
    pub fn varying(&mut self, key: &str, value: impl ToString) -> &mut Metadata {
        self.push(key, value.to_string(), Kind::Varying)
    }

    /// The facts that two runs of the same render share, in the order they were added.
    pub fn fixed_entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries
            .iter()
            .filter(|entry| entry.kind != Kind::Varying)
            .map(|entry| (entry.key.as_str(), entry.value.as_str()))
    }

    /// Every fact, in the order they were added.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries.iter().map(|entry| (entry.key.as_str(), entry.value.as_str()))
    }

    /// Whether what a file says of itself is of the same subject.
    pub fn has_subject_of(&self, stored: &Stored) -> bool {
        let mut subject = self.entries.iter().filter(|entry| entry.kind == Kind::Subject).peekable();
        subject.peek().is_some() && subject.all(|entry| stored.get(&entry.key) == Some(&entry.value))
    }

    /// Keeps one entry per key: the last value counts. NUL ends text in these formats and is dropped.
    fn push(&mut self, key: &str, value: String, kind: Kind) -> &mut Metadata {
        let value = value.replace('\0', "");
        match self.entries.iter_mut().find(|entry| entry.key == key) {
            Some(entry) => *entry = Entry { key: key.into(), value, kind },
            None => self.entries.push(Entry { key: key.into(), value, kind }),
        }
        self
    }
}
